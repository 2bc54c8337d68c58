//! Meshes in the other formats, loaded as for a render: whatever the bytes are, what comes of them is sound.

use super::Folder;
use drt::load::{self, Format, Loaded, Opening, Options};

/// The bytes are a PLY, with `p.pfm` beside it.
pub fn ply(bytes: &[u8]) {
    load("ply", "a.ply", &[("a.ply", bytes), ("p.pfm", super::PICTURE)], "ply");
}

/// The bytes are an STL.
pub fn stl(bytes: &[u8]) {
    load("stl", "a.stl", &[("a.stl", bytes)], "stl");
}

/// The bytes are a `.glb`, or the text of a `.gltf` up to the first NUL and behind it the `b.bin` beside it.
pub fn gltf(bytes: &[u8]) {
    let nul = bytes.iter().position(|byte| *byte == 0).filter(|_| !bytes.starts_with(b"glTF"));
    let (text, beside) = bytes.split_at(nul.unwrap_or(bytes.len()));
    let beside = beside.get(1..).unwrap_or_default();
    load("gltf", "a.gltf", &[("a.gltf", text), ("b.bin", beside), ("p.pfm", super::PICTURE)], "gltf");
}

/// The bytes are an OBJ, packed in either way: no more comes out than may.
pub fn unpack(bytes: &[u8]) {
    if let Some(loaded) = load("unpack", "a.gz", &[("a.gz", bytes)], "obj") {
        // A triangle takes more than a byte of text.
        assert!(loaded.triangles < MOST_UNPACKED, "{} triangles", loaded.triangles);
    }
}

const MOST_UNPACKED: u64 = 1 << 18;

/// Loads `input` of those files.
fn load(target: &'static str, input: &str, files: &[(&'static str, &[u8])], format: &str) -> Option<Loaded> {
    let format = Some(Format::named(format).expect("a format"));
    let opening = Opening { format, max_unpacked: Some(MOST_UNPACKED) };
    let loaded = Folder::with(target, input, |folder| {
        files.iter().for_each(|(name, bytes)| folder.write(name, bytes));
        load::scene(&folder.input, Options { opening, ..folder.options() })
    });
    match loaded {
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
