//! Scene files: read or refused; what is read can be rendered with.

use drt::load;

const MESH: &[u8] = b"mtllib m.mtl\nusemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n";

/// The bytes are the file; beside it are `t.obj`, `m.mtl` and `p.pfm`.
pub fn run(text: &[u8]) {
    reads(text);
}

/// As [`run`]; true where the file is not refused.
pub fn reads(text: &[u8]) -> bool {
    let loaded = super::Folder::with("scene_toml", "s.toml", |folder| {
        folder.write("t.obj", MESH);
        folder.write("m.mtl", b"newmtl a\nKd 0.5 0.5 0.5\nmap_Kd p.pfm\n");
        folder.write("p.pfm", super::PICTURE);
        folder.write("s.toml", text);
        load::scene(&folder.input, folder.options())
    });
    let loaded = match loaded {
        Ok(loaded) => loaded,
        Err(error) => {
            assert!(!error.to_string().contains('\n'), "{error}");
            return false;
        }
    };
    let (scene, settings) = (&loaded.scene, &loaded.settings);
    for mesh in &scene.meshes {
        super::sound(mesh, scene.materials.len());
    }
    assert!(settings.size.iter().all(|side| *side > 0) && settings.spp > 0);
    assert!(scene.camera.position.is_finite() && scene.camera.look_at.is_finite());
    true
}
