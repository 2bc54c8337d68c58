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
use drt::shape::{Attribute, FaceMaterials, Mesh, NO_INDEX};
use std::path::{Path, PathBuf};

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

/// A folder of this process, in memory where there is such a place; gone when it is dropped.
struct Folder(PathBuf);

impl Folder {
    fn new() -> Folder {
        let memory = Path::new("/dev/shm");
        let parent = if memory.is_dir() { memory.to_path_buf() } else { std::env::temp_dir() };
        let folder = parent.join(format!("drt-fuzz-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        Folder(folder)
    }

    /// Writes the file `name` and returns its path.
    fn write(&self, name: &str, bytes: &[u8]) -> PathBuf {
        let path = self.0.join(name);
        std::fs::write(&path, bytes).expect("written");
        path
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // What is left is a small folder in memory.
        let _ = std::fs::remove_dir_all(&self.0);
    }
}
