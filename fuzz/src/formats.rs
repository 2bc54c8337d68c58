//! Meshes in the other formats, loaded as for a render: whatever the bytes are, what comes of them is sound.

use drt::load::open::Reach;
use drt::load::{self, Format, Loaded, Opening, Options};
use std::path::Path;

/// The bytes are a PLY, with `p.pfm` beside it.
pub fn ply(bytes: &[u8]) {
    let folder = super::Folder::new();
    folder.write("p.pfm", super::PICTURE);
    load(&folder.write("a.ply", bytes), "ply");
}

/// The bytes are an STL.
pub fn stl(bytes: &[u8]) {
    let folder = super::Folder::new();
    load(&folder.write("a.stl", bytes), "stl");
}

/// The bytes are a `.glb`, or the text of a `.gltf` up to the first NUL and behind it the `b.bin` beside it.
pub fn gltf(bytes: &[u8]) {
    let folder = super::Folder::new();
    let nul = bytes.iter().position(|byte| *byte == 0).filter(|_| !bytes.starts_with(b"glTF"));
    let (text, beside) = bytes.split_at(nul.unwrap_or(bytes.len()));
    folder.write("b.bin", beside.get(1..).unwrap_or_default());
    folder.write("p.pfm", super::PICTURE);
    load(&folder.write("a.gltf", text), "gltf");
}

/// The bytes are an OBJ, packed in either way: no more comes out than may.
pub fn unpack(bytes: &[u8]) {
    let folder = super::Folder::new();
    if let Some(loaded) = load(&folder.write("a.gz", bytes), "obj") {
        // A triangle takes more than a byte of text.
        assert!(loaded.triangles < MOST_UNPACKED, "{} triangles", loaded.triangles);
    }
}

const MOST_UNPACKED: u64 = 1 << 18;

fn load(input: &Path, format: &str) -> Option<Loaded> {
    let format = Some(Format::named(format).expect("a format"));
    let opening = Opening { format, max_unpacked: Some(MOST_UNPACKED) };
    let reach = Reach::folder_of(input).expect("the folder");
    let options = Options { opening, reach, max_texture_bytes: 1 << 24, ..Options::default() };
    match load::scene(input, options) {
        Ok(loaded) => {
            let scene = &loaded.scene;
            for mesh in scene.meshes.iter().chain(&scene.instances.meshes) {
                super::sound(mesh, scene.materials.len());
            }
            assert!(scene.camera.position.is_finite() && scene.camera.look_at.is_finite());
            Some(loaded)
        }
        Err(error) => {
            assert!(!error.to_string().contains('\n'), "{error}");
            None
        }
    }
}
