//! O1–O6: environments and closed meshes, where every leaked ray shows.

use crate::harness::{SKY, cube, on_every_backend, sphere, stage, torus};
use drt::film::Image;

const OUTSIDE: &str = "[camera]\nposition = [2.1, 1.7, 4.0]\nlook_at = [0.0, 0.0, 0.0]\nfov = 40\n";
const INSIDE: &str = "[camera]\nposition = [0.13, 0.21, 0.08]\nlook_at = [0.5, 0.1, -1.0]\nfov = 90\n";

fn object(film: &str, camera: &str, depth: u32, material: &str, light: &str) -> String {
    format!(
        "{camera}[film]\nsize = {film}\n[render]\nspp = 16\nmax_depth = {depth}\n\
         [[mesh]]\nfile = \"m.obj\"\nmaterial = \"m\"\n[materials.m]\ntype = \"diffuse\"\n{material}\n{light}"
    )
}

fn pixels(image: &Image) -> Vec<f32> {
    ["R", "G", "B"].iter().flat_map(|c| image.f32_channel(c).unwrap().to_vec()).collect()
}

#[test]
fn o1_an_empty_environment_is_exactly_one() {
    on_every_backend(|backend| {
        let toml = format!("{OUTSIDE}[film]\nsize = [33, 21]\n[render]\nspp = 5\n{SKY}");
        let (image, _) = stage(&toml, &[], backend, &[]).render(|_| ());
        assert!(pixels(&image).iter().all(|v| *v == 1.0));
    });
}

/// A convex body under a constant environment shows its reflectance, noiseless.
#[test]
fn o2_a_convex_body_shows_its_reflectance() {
    on_every_backend(|backend| {
        for rho in [0.18f32, 0.5, 0.8, 1.0] {
            let material = format!("reflectance = {rho}");
            let toml = object("[48, 32]", OUTSIDE, 16, &material, SKY);
            let stage = stage(&toml, &[("m.obj", cube())], backend, &[]);
            let (image, _) = stage.render(|s| s.aovs = vec![drt::film::Aov::Depth]);
            let depth = image.f32_channel("depth.Z").unwrap();
            let centre = 16 * 48 + 24;
            assert!(depth[centre].is_finite() && depth[0].is_infinite());
            let green = image.f32_channel("G").unwrap();
            assert!((green[centre] - rho).abs() <= rho * 2e-7, "ρ {rho}: {}", green[centre]);
            assert!(green.iter().all(|v| *v <= 1.0 && *v >= rho * 0.999_999));
        }
    });
}

/// A white body in a white furnace vanishes: a ray that leaks into it never comes out and leaves a dark pixel.
#[test]
fn o3_a_white_closed_body_vanishes() {
    on_every_backend(|backend| {
        for (name, mesh) in [("torus", torus(160, 90)), ("cube", cube()), ("sphere", sphere(60, 90))] {
            let toml = object("[96, 64]", OUTSIDE, 1000, "reflectance = 1.0", SKY);
            let (image, stats) = stage(&toml, &[("m.obj", mesh)], backend, &[]).render(|_| ());
            assert!(stats.bounce_rays > 5_000, "{name}: the camera misses the body");
            assert!(pixels(&image).iter().all(|v| *v == 1.0), "{name}: not everywhere 1");
        }
    });
}

/// Inside a closed body that emits 1 and reflects ρ: 1/(1−ρ).
#[test]
fn o4_the_inside_of_an_emitting_body_is_a_geometric_series() {
    on_every_backend(|backend| {
        for (rho, exact) in [(0.5, 2.0), (0.8, 5.0)] {
            for (name, mesh) in [("cube", cube()), ("sphere", sphere(40, 60))] {
                let material = format!("reflectance = {rho}\nemission = 1.0");
                let toml = object("[8, 8]", INSIDE, 1000, &material, "");
                stage(&toml, &[("m.obj", mesh)], backend, &["render.spp=64"]).statistics().expect(
                    &format!("O4 {name} ρ {rho}"),
                    exact,
                    0.0,
                );
            }
        }
    });
}

#[test]
fn o5_each_scattering_event_adds_its_term() {
    on_every_backend(|backend| {
        for (depth, exact) in [(0, 1.0), (1, 1.8), (2, 2.44), (3, 2.952)] {
            let toml = object("[8, 8]", INSIDE, depth, "reflectance = 0.8\nemission = 1.0", "");
            stage(&toml, &[("m.obj", cube())], backend, &["render.spp=64"]).statistics().expect(
                &format!("O5 depth {depth}"),
                exact,
                0.0,
            );
        }
    });
}

/// A point light of intensity π at the centre of a sphere with ρ = .5: direct .5, in all 1.
#[test]
fn o6_a_point_in_a_sphere() {
    let light = "[[light]]\ntype = \"point\"\nposition = [0, 0, 0]\nintensity = 3.14159265358979\n";
    on_every_backend(|backend| {
        for (depth, exact) in [(1, 0.5), (1000, 1.0)] {
            let toml = object("[8, 8]", INSIDE, depth, "reflectance = 0.5", light);
            stage(&toml, &[("m.obj", sphere(100, 120))], backend, &["render.spp=64"]).statistics().expect(
                &format!("O6 depth {depth}"),
                exact,
                1e-3,
            );
        }
    });
}

/// Every strategy has the same mean: BSDF samples alone or with light samples; with and without roulette; with
/// any sampler and filter; whatever the number of samples. (Light samples alone are tested on lamps: inside a
/// body that shines all over, 1/d² makes their variance infinite.)
#[test]
fn means_do_not_depend_on_how_they_are_sampled() {
    on_every_backend(|backend| {
        // Without roulette every path goes on to the end: 2⁻⁴⁰ is nothing.
        let toml = object("[8, 8]", INSIDE, 40, "reflectance = 0.5\nemission = 1.0", "");
        for set in [
            "render.lights=mis",
            "render.lights=bsdf",
            "render.roulette=false",
            "render.split=1",
            "render.split=5",
            "render.sampler=random",
            "render.sampler=stratified",
            "film.filter=gaussian",
            "film.filter=mitchell",
        ] {
            stage(&toml, &[("m.obj", cube())], backend, &["render.spp=96", set])
                .statistics()
                .expect(set, 2.0, 0.0);
        }
        for spp in [1, 4, 17] {
            let size = "film.size=[32,32]";
            stage(&toml, &[("m.obj", cube())], backend, &[&format!("render.spp={spp}"), size])
                .statistics()
                .expect(&format!("{spp} spp"), 2.0, 0.0);
        }
    });
}
