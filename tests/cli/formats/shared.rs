//! A mesh that nodes of a glTF document show in several places.

use super::picture;
use super::ring::Ring;
use drt::load::{self, Options};
use std::fs;
use tempfile::TempDir;

/// A document that shows a mesh in several places, mirrored, stretched, turned and flattened: it is the same picture
/// whether the mesh is kept once or copied, as is what a scene file does with the document.
#[test]
fn a_mesh_that_gltf_nodes_repeat_is_kept_once() {
    let folder = TempDir::new().unwrap();
    let dir = folder.path();
    let (text, data) = Ring::new().gltf(true, Some("d.bin"));
    fs::write(dir.join("d.bin"), data).unwrap();
    let text = String::from_utf8(text).unwrap();
    let one = "\"nodes\": [{ \"mesh\": 0 }], \"scenes\": [{ \"nodes\": [0] }]";
    let many = "\"nodes\": [
        { \"mesh\": 0, \"translation\": [-3, 0, 0] },
        { \"mesh\": 0, \"scale\": [-1, 1, 1], \"translation\": [0, 0.5, 0] },
        { \"translation\": [3, 0, 0], \"rotation\": [0.6, 0, 0, 0.8], \"children\": [3] },
        { \"mesh\": 0, \"scale\": [1, 2, 0.5] },
        { \"mesh\": 0, \"scale\": [1, 0, 1], \"translation\": [0, -1, 2] }], \"scenes\": [{ \"nodes\": [0, 1, 2, 4] }]";
    assert!(text.contains(one));
    fs::write(dir.join("a.gltf"), text.replace(one, many)).unwrap();
    for (more, places) in [
        ("", 4),
        ("transform = { scale = 0.5, rotate = { axis = [0, 0, 1], angle = 20 } }\nmaterial = \"red\"\n", 4),
        (
            "motion = [{ time = 0 }, { time = 1, translate = [0, 1, 0], rotate = { axis = [0, 1, 0], angle = 30 } }]\n",
            4,
        ),
        ("instances = [{ translate = [0, 2, 0] }, { translate = [0, -2, 0], material = \"red\" }]\n", 8),
    ] {
        let picture = |instance: bool| {
            let scene = format!(
                "[camera]\nposition = [2, 5, 9]\nlook_at = [0, 0, 0]\nfov = 50\nshutter = [0.5, 0.5]\n\
                 [render]\nmax_depth = 3\n[[mesh]]\nfile = \"a.gltf\"\ninstance = {instance}\n{more}\
                 [materials.red]\ntype = \"diffuse\"\nreflectance = [0.8, 0.1, 0.1]\n\
                 [[light]]\ntype = \"environment\"\n[[light]]\ntype = \"directional\"\ndirection = [1, -2, -1]\nirradiance = 3\n"
            );
            fs::write(dir.join("s.toml"), scene).unwrap();
            picture(dir, "s.toml");
            let image = drt::load::picture::read(&dir.join("out.exr")).unwrap().image;
            (load::scene(&dir.join("s.toml"), Options::default()).unwrap(), image.rgb_pixels())
        };
        let ((kept, once), (copied, each)) = (picture(true), picture(false));
        // Three places, and what is flattened: that is the mesh that every file has.
        assert_eq!(kept.scene.instances.places.len(), places, "{more}");
        assert_eq!(kept.triangles, copied.triangles, "{more}");
        let all = |l: &load::Loaded| {
            let instances = &l.scene.instances;
            let of = |mesh: &drt::shape::Mesh| mesh.indices.len();
            l.scene.meshes.iter().map(|m| of(m)).sum::<usize>()
                + instances.meshes.iter().map(|m| of(m)).sum::<usize>()
        };
        assert!(all(&kept) < all(&copied), "{more}: {} {}", all(&kept), all(&copied));
        let differ =
            once.iter().zip(&each).filter(|(a, b)| (0..3).any(|c| (a[c] - b[c]).abs() > 1e-3 + 0.01 * b[c]));
        let differ = differ.count();
        // Corners are rounded in other places, and a few samples go other ways.
        assert!(differ < once.len() / 25, "{more}: {differ} of {} pixels differ", once.len());
        let mean =
            |image: &[[f32; 3]]| image.iter().map(|p| f64::from(p[1])).sum::<f64>() / image.len() as f64;
        let ratio = mean(&once) / mean(&each);
        assert!((ratio - 1.0).abs() < 5e-4, "{more}: {ratio} of the brightness");
        assert!(once.iter().any(|p| p[0] > 1.1), "{more}: nothing is lit by the sun");
    }
    // Where all could be kept once, one place is that mesh.
    let all = many
        .replace(",\n        { \"mesh\": 0, \"scale\": [1, 0, 1], \"translation\": [0, -1, 2] }", "")
        .replace(", 4]", "]");
    fs::write(dir.join("a.gltf"), text.replace(one, &all)).unwrap();
    fs::write(dir.join("s.toml"), "[[mesh]]\nfile = \"a.gltf\"\ninstance = true\n").unwrap();
    let loaded = load::scene(&dir.join("s.toml"), Options::default()).unwrap();
    assert_eq!((loaded.scene.instances.places.len(), loaded.triangles), (3, 3 * 192));
    // Few triangles are copied unless it is asked for.
    let bare = load::scene(&dir.join("a.gltf"), Options::default()).unwrap();
    assert_eq!((bare.scene.instances.places.len(), bare.triangles), (0, 3 * 192));
}
