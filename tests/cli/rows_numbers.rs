//! Rows N of the table of failures: what is not a number, what is too bright, what is too thin.

use super::universal::{Run, engines};
use super::{drt, folder};
use drt::film::Image;
use std::fs;
use std::path::Path;

/// Renders `input` to a picture and its statistics; not one sample may be invalid, nor one ray.
fn sound(dir: &Path, input: &str, more: &[&str], engine: &[&str]) -> (Image, Vec<u8>) {
    let words = [&[input, "--size", "24x16", "-o", "n.exr", "--stats", "n.json"], more, engine].concat();
    Run::new(dir, &words).check().expect(0, &[]);
    let stats: serde_json::Value = serde_json::from_slice(&fs::read(dir.join("n.json")).unwrap()).unwrap();
    for key in ["invalid_samples", "rejected_rays"] {
        assert_eq!(stats[key].as_u64(), Some(0), "{key} of {words:?}");
    }
    let image = drt::load::picture::read(&dir.join("n.exr")).unwrap().image;
    let bad = image.rgb_pixels().iter().flatten().filter(|v| !v.is_finite() || **v < 0.0).count();
    assert_eq!(bad, 0, "{words:?}");
    (image, fs::read(dir.join("n.exr")).unwrap())
}

/// Materials at and beyond every limit that MTL lets people write.
#[test]
fn n2_extreme_materials_give_no_invalid_sample() {
    let folder = folder();
    let dir = folder.path();
    let bodies = [
        "Kd 1 1 1\nKs 1 1 1\nNs 1e9\nillum 2",
        "Kd nan 0 0\nKs inf 1 1\nNs nan",
        "Kd -1 1e30 0.5\nKe 1e9 1e9 1e9",
        "illum 3\nKs 1 1 1\nNs 0",
        "illum 7\nNi 0\nd 2\nTf 9 9 9",
        "illum 5\nNi 1\nKs 1e-38 1e-45 1",
        "Pm 1\nPr 0\nKd 1 1 1",
        "Ke 1e-40 0 0\nKd 1e-40 0 0",
    ];
    for engine in engines() {
        for body in bodies {
            fs::write(dir.join("m.mtl"), format!("newmtl a\n{body}\n")).unwrap();
            let mesh = fs::read_to_string(dir.join("t.obj")).unwrap();
            fs::write(dir.join("m.obj"), format!("mtllib m.mtl\nusemtl a\n{mesh}")).unwrap();
            sound(dir, "m.obj", &["--spp", "4", "--ground", "--max-depth", "64"], &engine);
        }
    }
}

/// Beyond Embree's range a render is refused before it is wrong; our own BVH takes all that the reader takes.
#[test]
fn n1_what_embree_cannot_compute_with_is_refused() {
    let folder = folder();
    let dir = folder.path();
    let mesh = |size: &str| format!("v 0 0 0\nv {size} 0 0\nv 0 {size} 0\nf 1 2 3\n");
    for (size, in_range) in [("1e12", true), ("1e15", false), ("9e17", false)] {
        fs::write(dir.join("large.obj"), mesh(size)).unwrap();
        for backend in drt::accel::Backend::ALL {
            let words = ["large.obj", "--spp", "1", "--size", "16x16", "--backend", backend.name()];
            let ended = Run::new(dir, &words).check();
            match in_range || backend.name() == "bvh" {
                true => ended.expect(0, &[]),
                false => ended.expect(1, &["--backend bvh"]),
            };
        }
    }
}

/// A lamp of radiance 10⁶ is that bright in the picture, and the mean does not depend on the samples: nothing is
/// clamped.
#[test]
fn n3_nothing_is_clamped() {
    let folder = folder();
    let dir = folder.path();
    let scene = "[camera]\nposition = [0, 0, 4]\nlook_at = [0, 0, 0]\n[[mesh]]\nfile = \"t.obj\"\n\
                 [[light]]\ntype = \"sphere\"\ncenter = [0.9, 0.9, 0.9]\nradius = 0.1\nradiance = 1e6\n";
    fs::write(dir.join("lamp.toml"), scene).unwrap();
    for engine in engines() {
        let brightest = |image: &Image| image.rgb_pixels().iter().map(|p| p[1]).fold(0.0, f32::max);
        let (image, _) = sound(dir, "lamp.toml", &["--max-depth", "0", "--spp", "1"], &engine);
        assert_eq!(brightest(&image), 1e6);
        // What the lamp shines on, far brighter than 1, without the lamp itself.
        let mean = |spp: &str| {
            let (image, _) = sound(dir, "lamp.toml", &["--spp", spp, "--crop", "13,5,3,3"], &engine);
            let pixels = image.rgb_pixels();
            pixels.iter().map(|p| f64::from(p[1])).sum::<f64>() / pixels.len() as f64
        };
        let (few, many) = (mean("16"), mean("1024"));
        assert!(many > 1e3, "{many}");
        assert!((few / many - 1.0).abs() < 0.1, "{few} with few samples, {many} with many");
        // Unless it is asked for, which the picture tells.
        let seen = &["--max-depth", "0", "--spp", "1", "--clamp", "4.5"];
        let (image, bytes) = sound(dir, "lamp.toml", seen, &engine);
        assert_eq!(brightest(&image), 4.5);
        let says = br#""clamp":4.5"#;
        assert!(bytes.windows(says.len()).any(|part| part == says), "the settings do not say it");
    }
    for wrong in ["0", "-1", "nan", "much"] {
        drt(dir, &["lamp.toml", "--clamp", wrong]).expect(2, &["--clamp"]);
    }
}

/// A fan of needles a million times as long as wide, and a body of denormal coordinates: finite, and the same bytes
/// on any number of threads (a thread that flushes denormals to zero would show).
#[test]
fn n4_needles_and_denormals() {
    let folder = folder();
    let dir = folder.path();
    let mut fan = String::from("v 0 0 0\n");
    for i in 0..200 {
        let a = f64::from(i) * 0.01;
        fan += &format!("v {} {} 0\n", a.cos(), a.sin());
        fan += &format!("v {} {} 1e-6\n", (a + 1e-6).cos(), (a + 1e-6).sin());
        fan += &format!("f 1 {} {}\n", 2 * i + 2, 2 * i + 3);
    }
    let tiny =
        fs::read_to_string(dir.join("t.obj")).unwrap().replace(" 1 ", " 1e-40 ").replace(" 1\n", " 1e-40\n");
    let tiny = tiny.replace("v 1e-40", "v 1e-39");
    let mixed = format!(
        "{}v 1e-40 2e-41 0\nv 0.5 1e-42 1e-45\nf 1 5 6\nf 2 5 6\n",
        fs::read_to_string(dir.join("t.obj")).unwrap()
    );
    for (name, text) in [("fan.obj", &fan), ("mixed.obj", &mixed)] {
        fs::write(dir.join(name), text).unwrap();
        for backend in drt::accel::Backend::ALL {
            let on = |threads| {
                sound(
                    dir,
                    name,
                    &["--spp", "4", "--ground"],
                    &["--backend", backend.name(), "--threads", threads],
                )
                .1
            };
            let one = on("1");
            assert!(one == on("2") && one == on("5"), "{name} on {}", backend.name());
        }
    }
    // So small that it may be no body at all: whatever is said, it is said on every number of threads.
    fs::write(dir.join("tiny.obj"), tiny).unwrap();
    for engine in engines() {
        Run::new(dir, &super::universal::tiny(&["tiny.obj", "-o", "tiny.exr"], &engine)).check();
    }
}
