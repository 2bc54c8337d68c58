//! What is fuzzed: a module a target, each with a function `run` of bytes that panics where drt breaks a promise.
//!
//! `tests/cli/replay.rs` includes this file and runs the same functions on the seeds and on all that was ever found, on
//! stable Rust.

pub mod bvh;
pub mod checkpoint;
pub mod formats;
pub mod mtl;
pub mod obj;
pub mod picture;
pub mod scene_obj;
pub mod scene_toml;

use drt::accel::LARGEST;
use drt::load::Options;
use drt::load::open::Reach;
use drt::memory::{Left, Limit};
use drt::shape::{Attribute, FaceMaterials, Mesh, NO_INDEX};
use std::cell::RefCell;
use std::collections::HashMap;
use std::fs::File;
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

/// A target: the bytes it is given decide what it does.
pub type Target = fn(&[u8]);

/// Every target by name.
pub const TARGETS: [(&str, Target); 11] = [
    ("obj", obj::run),
    ("mtl", mtl::run),
    ("scene_obj", scene_obj::run),
    ("scene_toml", scene_toml::run),
    ("picture", picture::run),
    ("ply", formats::ply),
    ("stl", formats::stl),
    ("gltf", formats::gltf),
    ("unpack", formats::unpack),
    ("checkpoint", checkpoint::run),
    ("bvh", bvh::run),
];

/// Makes the calling thread the only one of the pool: handing over to another takes longer than most runs.
pub fn alone() {
    // It fails where there is a pool already, which is as right.
    let _ = rayon::ThreadPoolBuilder::new().num_threads(1).use_current_thread().build_global();
}

/// A picture of one white pixel.
const PICTURE: &[u8] = b"PF\n1 1\n-1\n\0\0\x80\x3f\0\0\x80\x3f\0\0\x80\x3f";

/// Fails unless `mesh` keeps the promises of [`Mesh`]; `materials`: how many there are.
fn sound(mesh: &Mesh, materials: usize) {
    let vertices = mesh.positions.len();
    assert!(mesh.indices.iter().flatten().all(|i| (*i as usize) < vertices), "an index is out of range");
    assert!(mesh.positions.iter().flatten().all(|x| x.abs() <= LARGEST), "a position is out of range");
    if let Some(normals) = &mesh.normals {
        sound_attribute(mesh, normals, |n| n.iter().all(|x| x.is_finite()));
    }
    if let Some(uvs) = &mesh.uvs {
        sound_attribute(mesh, uvs, |uv| uv.iter().all(|x| x.is_finite()));
    }
    match &mesh.materials {
        FaceMaterials::Uniform(id) => assert!((*id as usize) < materials.max(1)),
        FaceMaterials::PerFace(ids) => {
            assert_eq!(ids.len(), mesh.indices.len());
            assert!(ids.iter().all(|id| (*id as usize) < materials.max(1)), "a material is out of range");
        }
    }
}

fn sound_attribute<T>(mesh: &Mesh, attribute: &Attribute<T>, is_finite: impl Fn(&T) -> bool) {
    let count = attribute.values.len();
    assert!(attribute.values.iter().all(is_finite), "an attribute is not finite");
    match &attribute.indices {
        // There may be fewer than positions, where no triangle has the others.
        None => {
            let in_range = |i: &u32| (*i as usize) < count;
            assert!(mesh.indices.iter().flatten().all(in_range), "a corner has no value");
        }
        Some(indices) => {
            assert_eq!(indices.len(), mesh.indices.len());
            let in_range = |i: &u32| *i == NO_INDEX || (*i as usize) < count;
            assert!(indices.iter().flatten().all(in_range), "an attribute's index is out of range");
        }
    }
}

/// A folder of one thread and one target, in memory where there is such a place; gone with the thread that made it.
///
/// It and its files stay from one execution to the next, since making them takes longer than most readers do.
struct Folder {
    path: PathBuf,
    files: HashMap<&'static str, (File, Vec<u8>)>,
    /// What the file `input` in it may name.
    reach: Reach,
    input: PathBuf,
}

impl Folder {
    fn new(target: &str, input: &str) -> Folder {
        let memory = Path::new("/dev/shm");
        let parent = if memory.is_dir() { memory.to_path_buf() } else { std::env::temp_dir() };
        static NEXT: AtomicUsize = AtomicUsize::new(0);
        let number = NEXT.fetch_add(1, Ordering::Relaxed);
        let path = parent.join(format!("drt-fuzz-{}-{number}-{target}", std::process::id()));
        std::fs::create_dir_all(&path).expect("a folder");
        let input = path.join(input);
        let reach = Reach::folder_of(&input).expect("the folder");
        Folder { path, files: HashMap::new(), reach, input }
    }

    /// Calls `run` with the folder of `target`, whose input is called `input`.
    fn with<R>(target: &'static str, input: &str, run: impl FnOnce(&mut Folder) -> R) -> R {
        thread_local! {
            static FOLDERS: RefCell<HashMap<&'static str, Folder>> = RefCell::default();
        }
        FOLDERS.with_borrow_mut(|all| run(all.entry(target).or_insert_with(|| Folder::new(target, input))))
    }

    /// Gives the file `name` those bytes.
    fn write(&mut self, name: &'static str, bytes: &[u8]) {
        let (file, written) = self
            .files
            .entry(name)
            .or_insert_with(|| (File::create(self.path.join(name)).expect("a file"), Vec::new()));
        if written != bytes {
            file.write_all_at(bytes, 0).expect("written");
            file.set_len(bytes.len() as u64).expect("cut");
            written.clear();
            written.extend_from_slice(bytes);
        }
    }

    /// How a scene of this folder is loaded. The same memory is left to every execution, so that all fare alike.
    fn options(&self) -> Options<'static> {
        let memory = || Some(Left { bytes: 4 << 30, limit: Limit::Machine });
        Options { reach: self.reach.clone(), max_texture_bytes: 1 << 24, memory, ..Options::default() }
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What is left is a small folder in memory.
        let _ = std::fs::remove_dir_all(&self.path);
    }
}
