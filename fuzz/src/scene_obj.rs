//! An OBJ with its library and a picture, loaded as for a render and rendered: no value that is no radiance.

use drt::accel::Backend;
use drt::load;
use drt::render::{self, Hooks};

/// The bytes up to the first NUL are `a.obj`, up to the second `m.mtl`, the rest `p.png`.
pub fn run(data: &[u8]) {
    let mut parts = data.splitn(3, |byte| *byte == 0);
    let loaded = super::Folder::with("scene_obj", "a.obj", |folder| {
        for name in ["a.obj", "m.mtl", "p.png"] {
            folder.write(name, parts.next().unwrap_or_default());
        }
        load::scene(&folder.input, folder.options())
    });
    let Ok(mut loaded) = loaded else { return };
    let scene = &loaded.scene;
    for mesh in &scene.meshes {
        super::sound(mesh, scene.materials.len());
    }
    if scene.triangles() > 1000 {
        return;
    }
    let settings = &mut loaded.settings;
    (settings.size, settings.spp, settings.max_depth) = ([4, 4], 1, 3);
    settings.backend = Backend::Bvh;
    let hooks = Hooks::NONE;
    let accel = render::build(scene, settings, None, &hooks).expect("a hierarchy");
    let rendering = render::render(scene, settings, &*accel, None, &hooks).expect("a picture");
    assert_eq!(rendering.stats.invalid_samples, 0, "a sample is no radiance");
    let pixels = rendering.image.rgb_pixels();
    assert!(pixels.iter().flatten().all(|x| x.is_finite() && *x >= 0.0), "{pixels:?}");
}
