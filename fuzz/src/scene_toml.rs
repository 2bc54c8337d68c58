//! Scene files: read or refused; what is read can be rendered with.

use drt::load::open::Reach;
use drt::load::{self, Options};

const MESH: &[u8] = b"mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n";

/// The bytes are the file; beside it are `t.obj`, `m.mtl` and `p.pfm`.
pub fn run(text: &[u8]) {
    let folder = super::Folder::new();
    folder.write("t.obj", MESH);
    folder.write("m.mtl", b"newmtl a\nKd 0.5 0.5 0.5\nmap_Kd p.pfm\n");
    folder.write("p.pfm", super::PICTURE);
    let input = folder.write("s.toml", text);
    let reach = Reach::folder_of(&input).expect("the folder");
    let loaded = match load::scene(&input, Options { reach, ..Options::default() }) {
        Ok(loaded) => loaded,
        Err(error) => {
            assert!(!error.to_string().contains('\n'), "{error}");
            return;
        }
    };
    let (scene, settings) = (&loaded.scene, &loaded.settings);
    for mesh in &scene.meshes {
        super::sound(mesh, scene.materials.len());
    }
    assert!(settings.size.iter().all(|side| *side > 0) && settings.spp > 0);
    assert!(scene.camera.position.is_finite() && scene.camera.look_at.is_finite());
}
