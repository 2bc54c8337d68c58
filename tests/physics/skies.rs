//! Pictures as environments and daylight, against closed forms and against what the library says that a sky is.

use crate::harness::{Stage, obj, on_every_backend, stage_with};
use drt::accel::Backend;
use drt::film::Image;
use drt::light::Light;
use drt::math::{DVec3, Vec3};
use drt::output;
use std::f64::consts::PI;

/// A diffuse square of 2 metres around the origin with normal `n` and ρ = .5, seen at its middle from its front.
fn facing(n: DVec3, rest: &str) -> (String, Vec<(&'static str, String)>) {
    let n = n.normalize();
    let (a, b) = n.any_orthonormal_pair();
    let eye = n * 0.5 + a * 0.3;
    let toml = format!(
        "[camera]\ntype = \"orthographic\"\nposition = [{}, {}, {}]\nlook_at = [0, 0, 0]\nup = [{}, {}, {}]\n\
         height = 1e-4\n[film]\nsize = [8, 8]\n[render]\nspp = 64\nmax_depth = 1\n[[mesh]]\nfile = \"square.obj\"\n\
         material = \"grey\"\n[materials.grey]\ntype = \"diffuse\"\nreflectance = 0.5\n{rest}",
        eye.x, eye.y, eye.z, b.x, b.y, b.z
    );
    let corner = |s: f64, t: f64| (a * s + b * t).to_array();
    let square = vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
    (toml, vec![("square.obj", obj(&[square]))])
}

/// An environment file of `size` texels: `f` by unit direction at the texels' middles.
fn map(size: [u32; 2], f: impl Fn(DVec3) -> [f32; 3]) -> Image {
    let [width, height] = size;
    let texel = |i: u32| {
        let phi = 2.0 * PI * (f64::from(i % width) + 0.5) / f64::from(width);
        let theta = PI * (f64::from(i / width) + 0.5) / f64::from(height);
        f(DVec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos()))
    };
    Image::from_rgb(width, height, &(0..width * height).map(texel).collect::<Vec<_>>(), String::new())
}

const SKY: &str = "[[light]]\ntype = \"environment\"\nfile = \"sky.exr\"\n";

fn under(n: DVec3, sky: &Image, light: &str, backend: Backend, set: &[&str]) -> Stage {
    let (toml, files) = facing(n, light);
    let write = |folder: &std::path::Path| {
        let name = if light.contains("sky.hdr") { "sky.hdr" } else { "sky.exr" };
        output::write(&folder.join(name), sky, &output::Options::default()).unwrap();
    };
    stage_with(&toml, &files, write, backend, set)
}

/// L = 1 + .9·d·a sends E = π + (2π/3)·.9·a·n to a plane with normal n: where the map's directions lie is seen in every
/// axis, by every way to sample it.
#[test]
fn a_gradient_lights_planes_as_its_integral_says() {
    let a = DVec3::new(0.6, 0.64, -0.48);
    let sky = map([256, 128], |d| [(1.0 + 0.9 * d.dot(a)) as f32; 3]);
    on_every_backend(|backend| {
        for n in [DVec3::X, DVec3::Y, DVec3::Z, -a, DVec3::new(-1.0, 0.2, 0.5)] {
            let exact = 0.5 * (1.0 + 0.6 * a.dot(n.normalize()));
            for lights in ["mis", "light", "bsdf"] {
                under(n, &sky, SKY, backend, &[&format!("render.lights={lights}"), "render.spp=256"])
                    .statistics()
                    .expect(&format!("{n} {lights}"), exact, 2e-4);
            }
        }
        // What came from +x comes from −z after a quarter turn, counter-clockwise seen from above.
        let turned = DVec3::new(a.z, a.y, -a.x);
        let light = format!("{SKY}rotate = 90\nscale = 3\n");
        under(DVec3::Z, &sky, &light, backend, &["render.spp=256"]).statistics().expect(
            "turned",
            1.5 * (1.0 + 0.6 * turned.z),
            2e-4,
        );
        // With +z up, the map's zenith goes there; its +z, the front, looks to −y.
        let up = DVec3::new(a.x, -a.z, a.y);
        let light = format!("{SKY}up = [0, 0, 1]\n");
        under(DVec3::Z, &sky, &light, backend, &["render.spp=256"]).statistics().expect(
            "z up",
            0.5 * (1.0 + 0.6 * up.z),
            2e-4,
        );
        under(-DVec3::Y, &sky, &light, backend, &["render.spp=256"]).statistics().expect(
            "front",
            0.5 * (1.0 - 0.6 * up.y),
            2e-4,
        );
    });
}

/// A constant map is a constant environment: the same picture, bit for bit.
#[test]
fn a_constant_map_is_the_constant_environment() {
    let sky = map([7, 3], |_| [1.0; 3]);
    on_every_backend(|backend| {
        let constant = "[[light]]\ntype = \"environment\"\nradiance = 1\n";
        let pixels = |light: &str| under(DVec3::Y, &sky, light, backend, &[]).render(|_| ()).0.rgb_pixels();
        assert_eq!(pixels(SKY), pixels(constant));
        assert_eq!(pixels(SKY), vec![[0.5; 3]; 64]);
    });
}

/// A sun of one texel: ∫ of its tent over the sphere, L·2π²/(W·H)·sin θ·cos θ, is found by light samples, and a highest
/// value of 1e12 stays a number.
#[test]
fn one_bright_texel_lights_a_plane() {
    on_every_backend(|backend| {
        for l in [1e3f32, 1e12] {
            let (theta, phi) = (PI * 11.5 / 64.0, 2.0 * PI * 0.5 / 128.0);
            let to = DVec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos());
            let sky = map([128, 64], |d| [if d.distance(to) < 1e-6 { l } else { 0.0 }; 3]);
            let exact = 0.5 / PI * f64::from(l) * 2.0 * PI * PI / (128.0 * 64.0) * theta.sin() * theta.cos();
            under(DVec3::Y, &sky, SKY, backend, &["render.spp=256"])
                .statistics()
                .expect("texel", exact, 2e-3);
        }
    });
}

/// Row B8 of the table of failures: what a file holds that no radiance can be is repaired; a black map is black.
#[test]
fn odd_maps_are_repaired() {
    let odd = |i: usize| [f32::NAN, f32::INFINITY, -5.0, 1e30, 2.0][i % 5];
    let texels: Vec<[f32; 3]> = (0..32).map(|i| [odd(i), 1.0, odd(i + 2)]).collect();
    let cases = [
        (Image::from_rgb(8, 4, &texels, String::new()), 0.5),
        (Image::from_rgb(8, 4, &[[0.0; 3]; 32], String::new()), 0.0),
        (Image::from_rgb(8, 4, &[[-1.0; 3]; 32], String::new()), 0.0),
        (Image::from_rgb(1, 1, &[[1.0; 3]], String::new()), 0.5),
    ];
    on_every_backend(|backend| {
        for (sky, green) in &cases {
            for lights in ["mis", "light"] {
                let stage = under(
                    DVec3::Y,
                    sky,
                    SKY,
                    backend,
                    &[&format!("render.lights={lights}"), "render.spp=256"],
                );
                let mean = stage.statistics().mean;
                assert!((mean - green).abs() < 0.02, "{mean} is not {green}");
            }
        }
    });
}

/// Radiance files have 8 bits of mantissa, and the same convention.
#[test]
fn radiance_files_are_skies_too() {
    let sky = map([64, 32], |d| [if d.y > 0.0 { 4.0 } else { 0.0 }; 3]);
    let light = SKY.replace("sky.exr", "sky.hdr");
    on_every_backend(|backend| {
        under(DVec3::Y, &sky, &light, backend, &["render.spp=256"]).statistics().expect("above", 2.0, 1e-3);
    });
}

/// The irradiance of daylight is the integral of its sky and its sun, which the library tells direction by direction;
/// the sun's disc holds its irradiance, and it stands where the file says.
#[test]
fn daylight_adds_up() {
    let light = "[[light]]\ntype = \"sun-sky\"\nelevation = 30\nazimuth = 60\nturbidity = 3\nscale = 0.01\n";
    let sky = map([1, 1], |_| [1.0; 3]);
    on_every_backend(|backend| {
        for (lights, n) in [("mis", DVec3::Y), ("light", DVec3::Y), ("mis", DVec3::new(1.0, 0.0, -0.5))] {
            let stage =
                under(n, &sky, light, backend, &[&format!("render.lights={lights}"), "render.spp=256"]);
            let n = n.normalize();
            let mut exact = 0.0;
            for one in &stage.scene.lights {
                match one {
                    Light::Environment(environment) => {
                        let steps = 1000;
                        for i in 0..steps * steps {
                            let (z, turn) =
                                ((f64::from(i % steps) + 0.5) / f64::from(steps), f64::from(i / steps));
                            let phi = 2.0 * PI * (turn + 0.5) / f64::from(steps);
                            let (a, b) = n.any_orthonormal_pair();
                            let sin = (1.0 - z * z).sqrt();
                            let d = n * z + (a * phi.cos() + b * phi.sin()) * sin;
                            let le = environment.le(d.as_vec3()).y;
                            exact += f64::from(le) * z * 2.0 * PI / f64::from(steps * steps);
                        }
                    }
                    Light::Sun(sun) => {
                        let azimuth = 60f64.to_radians();
                        let e = 30f64.to_radians();
                        let to = DVec3::new(azimuth.sin() * e.cos(), e.sin(), -azimuth.cos() * e.cos());
                        assert!((sun.direction.as_dvec3() - to).length() < 1e-6, "{}", sun.direction);
                        exact += f64::from(sun.irradiance().y) * to.dot(n).max(0.0);
                    }
                    other => panic!("{other:?}"),
                }
            }
            stage.statistics().expect(&format!("daylight {n} {lights}"), 0.5 / PI * exact, 1e-3);
        }
    });
}

/// A picture of the sun: its disc is π·sin²·L of irradiance wide, no more and no less.
#[test]
fn the_sun_is_seen_in_its_size() {
    let light = "[[light]]\ntype = \"sun-sky\"\ndirection = [0.3, -0.5, 0.2]\n";
    let to = -Vec3::new(0.3, -0.5, 0.2).normalize();
    let toml = format!(
        "[camera]\nposition = [0, 0, 0]\nlook_at = [{}, {}, {}]\nfov = 1\n[film]\nsize = [64, 64]\n[render]\nspp = 64\n{light}",
        to.x, to.y, to.z
    );
    let stage = stage_with(&toml, &[], |_| (), Backend::ALL[0], &[]);
    let sun = stage
        .scene
        .lights
        .iter()
        .find_map(|l| if let Light::Sun(sun) = l { Some(*sun) } else { None })
        .unwrap();
    let green = stage.render(|_| ()).0.f32_channel("G").unwrap().to_vec();
    let side = 2.0 * 0.5f64.to_radians().tan() / 64.0;
    let total: f64 = green.iter().map(|v| f64::from(*v) * side * side).sum();
    let corner = f64::from(green[0]) * side * side * 4096.0;
    assert!(((total - corner) / f64::from(sun.irradiance().y) - 1.0).abs() < 0.02, "{total}");
    assert_eq!(green[32 * 64 + 32].max(green[0] * 100.0), green[32 * 64 + 32], "the disc is in the middle");
}
