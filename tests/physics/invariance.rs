//! What must not change the picture, bit for bit; and what must.

use crate::harness::{Stage, cube, on_every_backend, stage, torus};
use drt::film::{Aov, Image};
use drt::output::{Format, Options, encode};
use drt::scene::SamplerKind;

const ROOM: &str = "[camera]\nposition = [2.1, 1.7, 4.0]\nlook_at = [0, 0, 0]\nfov = 40\n\
    [render]\nspp = 20\nmax_depth = 5\n[[mesh]]\nfile = \"torus.obj\"\nmaterial = \"metal\"\n\
    [[mesh]]\nfile = \"cube.obj\"\nmaterial = \"lamp\"\ntransform = { scale = 0.25, translate = [0, 1.5, 0] }\n\
    [materials.metal]\ntype = \"conductor\"\nreflectance = [0.9, 0.6, 0.3]\nroughness = 0.4\n\
    [materials.lamp]\ntype = \"diffuse\"\nreflectance = 0.3\nemission = [EMIT, EMIT, EMIT]\n\
    [[light]]\ntype = \"environment\"\nradiance = SKY\n";

fn room(backend: drt::accel::Backend, emission: f32, sky: f32, set: &[&str]) -> Stage {
    let toml = ROOM.replace("EMIT", &emission.to_string()).replace("SKY", &sky.to_string());
    stage(&toml, &[("torus.obj", torus(60, 40)), ("cube.obj", cube())], backend, set)
}

fn bytes(image: &Image) -> Vec<u8> {
    encode(image, Format::Exr, &Options::default()).unwrap()
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    on_every_backend(|backend| {
        for size in ["film.size=[300,200]", "film.size=[64,64]"] {
            let on = |threads: usize| {
                let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
                pool.install(|| {
                    let stage = room(backend, 4.0, 0.5, &[size, "render.spp=18"]);
                    bytes(&stage.render(|s| s.aovs = Aov::ALL.to_vec()).0)
                })
            };
            let one = on(1);
            assert!(one == on(2) && one == on(5), "{size} on {}", backend.name());
        }
        // The pixels, not the bytes: those hold the seed itself.
        let small = room(backend, 4.0, 0.5, &["film.size=[64,64]"]);
        for sampler in [SamplerKind::Sobol, SamplerKind::Stratified, SamplerKind::Random] {
            let seed = |seed: u64| small.render(|s| (s.seed, s.sampler) = (seed, sampler)).0.rgb_pixels();
            let first = seed(0);
            assert!(first != seed(1) && first != seed(1 << 32), "{sampler:?} ignores the seed");
        }
    });
}

#[test]
fn a_crop_shows_the_full_pictures_pixels() {
    on_every_backend(|backend| {
        let stage = room(backend, 4.0, 0.5, &["film.size=[100,70]"]);
        let (full, _) = stage.render(|_| ());
        let (crop, _) = stage.render(|s| s.crop = Some([13, 22, 41, 30]));
        assert_eq!((crop.width, crop.height, crop.offset, crop.full_size), (41, 30, [13, 22], [100, 70]));
        for y in 0..30 {
            for x in 0..41 {
                let (a, b) = (crop.rgb(y * 41 + x), full.rgb((y + 22) * 100 + x + 13));
                assert_eq!(a, b, "pixel {x}, {y}");
            }
        }
    });
}

/// Emission times a power of two is the same picture times that power, to the last bit.
#[test]
fn emission_scales_the_picture_exactly() {
    on_every_backend(|backend| {
        let (dim, _) = room(backend, 4.0, 0.5, &["film.size=[60,40]"]).render(|_| ());
        let (bright, _) = room(backend, 4.0 * 1024.0, 0.5 * 1024.0, &["film.size=[60,40]"]).render(|_| ());
        for (a, b) in dim.rgb_pixels().iter().zip(bright.rgb_pixels()) {
            assert_eq!(a.map(|v| v * 1024.0), b);
        }
    });
}

/// The whole scene, camera included, times a power of two: the same picture, to the last bit. An absolute
/// epsilon anywhere would show.
#[test]
fn the_scale_of_the_world_does_not_matter() {
    on_every_backend(|backend| {
        let at = |factor: f64| {
            let toml = ROOM
                .replace("EMIT", "4")
                .replace("SKY", "0.5")
                .replace(
                    "[2.1, 1.7, 4.0]",
                    &format!("[{}, {}, {}]", 2.125 * factor, 1.75 * factor, 4.0 * factor),
                )
                .replace(
                    "scale = 0.25, translate = [0, 1.5, 0]",
                    &format!("scale = {}, translate = [0, {}, 0]", 0.25 * factor, 1.5 * factor),
                )
                .replace(
                    "material = \"metal\"",
                    &format!("material = \"metal\"\ntransform = {{ scale = {factor} }}"),
                );
            let files = [("torus.obj", torus(60, 40)), ("cube.obj", cube())];
            stage(&toml, &files, backend, &["film.size=[60,40]"]).render(|_| ()).0.rgb_pixels()
        };
        let unit = at(1.0);
        for factor in [1024.0, 1.0 / 1024.0, 1048576.0, 1.0 / 1048576.0] {
            assert_eq!(unit, at(factor), "times {factor} on {}", backend.name());
        }
    });
}

/// A sample is 3.5·(4, 2, 1) in the lamp and (1, 2, 4)/8 in the sky: the clamp scales the one to its limit, hue and all,
/// and leaves the other alone; a limit above both changes no bit.
#[test]
fn n3_a_clamp_scales_bright_samples_and_no_others() {
    let toml = "[camera]\nposition = [0, 0, 9]\nlook_at = [0, 0, 0]\n[film]\nsize = [24, 24]\n[render]\nspp = 4\n\
                [[mesh]]\nfile = \"cube.obj\"\nmaterial = \"lamp\"\n\
                [materials.lamp]\ntype = \"diffuse\"\nreflectance = 0.0\nemission = [14, 7, 3.5]\n\
                [[light]]\ntype = \"environment\"\nradiance = [0.125, 0.25, 0.5]\n";
    on_every_backend(|backend| {
        let at =
            |set: &[&str]| stage(toml, &[("cube.obj", cube())], backend, set).render(|_| ()).0.rgb_pixels();
        let plain = at(&[]);
        assert_eq!(plain, at(&["film.clamp=14"]));
        let clamped = at(&["film.clamp=2"]);
        for (lamp, sky) in [(276, 0), (300, 23)] {
            assert_eq!((plain[lamp], plain[sky]), ([14.0, 7.0, 3.5], [0.125, 0.25, 0.5]));
            assert_eq!((clamped[lamp], clamped[sky]), ([2.0, 1.0, 0.5], [0.125, 0.25, 0.5]));
        }
    });
}

/// First hits agree between the backends wherever no two triangles tie.
#[test]
fn backends_see_the_same_first_hits() {
    let layers = |backend| {
        let stage = room(backend, 4.0, 0.5, &["film.size=[200,140]", "render.spp=1"]);
        let (image, _) = stage.render(|s| s.aovs = vec![Aov::Depth, Aov::Ids]);
        image.f32_channel("depth.Z").unwrap().to_vec()
    };
    let all: Vec<Vec<f32>> = drt::accel::Backend::ALL.iter().map(|&b| layers(b)).collect();
    for other in &all[1..] {
        for (a, b) in all[0].iter().zip(other) {
            assert!(a == b || (a - b).abs() <= 1e-4 * a.abs(), "{a} and {b}");
        }
    }
}
