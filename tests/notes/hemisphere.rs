//! A diffuse point under light that is known exactly: 13.5–13.8, eq. (15)–(20).

use crate::harness::{Stage, obj, on_every_backend, stage};
use drt::accel::Backend;
use drt::math::DVec3;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A floor of reflectance ½ seen from above near the origin, and `light`.
pub fn floor(light: &str, backend: Backend, files: &[(&str, String)], set: &[&str]) -> Stage {
    let toml = format!(
        "[camera]\ntype = \"orthographic\"\nheight = 1e-4\nposition = [0, 0.5, 0]\nlook_at = [0, 0, 0]\nup = [0, 0, -1]\n\
         [film]\nsize = [4, 4]\n[render]\nspp = 1\nmax_depth = 1\n\
         [[mesh]]\nfile = \"floor.obj\"\nmaterial = \"m\"\n[materials.m]\ntype = \"diffuse\"\nreflectance = 0.5\n{light}"
    );
    let square = [[-9.0, 0.0, 9.0], [9.0, 0.0, 9.0], [9.0, 0.0, -9.0], [-9.0, 0.0, -9.0]];
    let mut all = vec![("floor.obj", obj(&[square.to_vec()]))];
    all.extend(files.iter().cloned());
    stage(&toml, &all, backend, set)
}

pub fn rule(text: &str) -> String {
    format!("render.integrator={{ type = \"distribution\", {text} }}")
}

const SKY: &str = "[[light]]\ntype = \"environment\"\nradiance = 1.0\n";
const LAMP: &str =
    "[[mesh]]\nfile = \"lamp.obj\"\nmaterial = \"l\"\n[materials.l]\nreflectance = 0\nemission = 1\n";

/// The square of O7, one metre up.
fn lamp() -> (&'static str, String) {
    ("lamp.obj", obj(&[vec![[-0.5, 1.0, -0.5], [0.5, 1.0, -0.5], [0.5, 1.0, 0.5], [-0.5, 1.0, 0.5]]]))
}

/// Every pixel, which must be one value.
#[track_caller]
fn value(stage: &Stage) -> f64 {
    let (image, _) = stage.render(|_| ());
    let green = image.f32_channel("G").unwrap();
    assert!(green.iter().all(|v| *v == green[0]), "pixels differ: {green:?}");
    f64::from(green[0])
}

/// The rules that have no bias, as scene files write them, with N = 16.
pub const UNBIASED: [&str; 12] = [
    "rule = \"random\", directions = [16]",
    "rule = \"random\", measure = \"solid-angle\", directions = [16]",
    "rule = \"random\", measure = \"projected\", directions = [16]",
    "rule = \"stratified\", directions = [[2, 8]]",
    "rule = \"stratified\", per_cell = 3, directions = [[2, 3]]",
    "rule = \"stratified\", measure = \"solid-angle\", directions = [16]",
    "rule = \"nonuniform\", per_cell = 1, directions = [[4, 4]]",
    "rule = \"nonuniform\", per_cell = 2, directions = [[3, 3]]",
    "rule = \"importance\", directions = [16]",
    "rule = \"sobol\", directions = [16]",
    "rule = \"sobol\", measure = \"solid-angle\", directions = [16]",
    "rule = \"sobol\", measure = \"projected\", directions = [[4, 4]]",
];

/// The table at the end of the list of exact answers, to six digits.
#[test]
fn grids_under_a_constant_sky() {
    on_every_backend(|backend| {
        let table = [(4, 1.026_172, 0.948_059), (8, 1.006_455, 0.987_116), (16, 1.001_608, 0.996_785)];
        for (m, midpoints, edges) in table {
            for (name, exact) in [("uniform", midpoints), ("uniform-corner", edges), ("nonuniform", 1.0)] {
                let set = rule(&format!("rule = \"{name}\", directions = [[{m}, 7]]"));
                let shown = value(&floor(SKY, backend, &[], &[&set])) / 0.5;
                assert!((shown - exact).abs() < 6e-7, "{name}, M = {m}: {shown} not {exact}");
            }
        }
    });
}

/// Under a lamp a grid gives what its points that see the lamp add up to; eq. (18) by hand.
#[test]
fn grids_under_a_square_lamp() {
    on_every_backend(|backend| {
        for (m, n) in [(16, 24), (9, 7), (40, 80)] {
            for (name, shift) in [("uniform", 0.5), ("uniform-corner", 0.0)] {
                let set = rule(&format!("rule = \"{name}\", directions = [[{m}, {n}]]"));
                let shown = value(&floor(LAMP, backend, &[lamp()], &[&set]));
                let by_hand = grid_by_hand(m, n, shift);
                assert!((shown - by_hand).abs() < 2e-6, "{name} {m}×{n}: {shown} not {by_hand}");
            }
        }
        let set = rule("rule = \"uniform\", directions = [[256, 256]]");
        // So many directions that pixels see the lamp's edge differently.
        let (image, _) = floor(LAMP, backend, &[lamp()], &[&set]).render(|_| ());
        let shown = f64::from(image.f32_channel("G").unwrap()[5]);
        assert!((shown - 0.119_728_2).abs() < 5e-4, "the limit: {shown}");
    });
}

/// Σ (ρ/π)·cos θ·sin θ·Δθ·Δφ over the directions of eq. (2), (16), (17) that meet the lamp.
fn grid_by_hand(m: u32, n: u32, shift: f64) -> f64 {
    let (d_theta, d_phi) = (FRAC_PI_2 / f64::from(m), TAU / f64::from(n));
    let mut sum = 0.0;
    for i in 0..m {
        for j in 0..n {
            let (theta, phi) = ((f64::from(i) + shift) * d_theta, (f64::from(j) + shift) * d_phi);
            // Duff et al.'s frame about the normal (0, 1, 0): s = (1, 0, 0), t = (0, 0, −1).
            let d = DVec3::new(theta.sin() * phi.sin(), theta.cos(), -theta.sin() * phi.cos());
            let hit = d / d.y;
            if hit.x.abs() < 0.5 && hit.z.abs() < 0.5 {
                sum += 0.5 / PI * theta.cos() * theta.sin() * d_theta * d_phi;
            }
        }
    }
    sum
}

/// Rules without bias have the exact answer as their mean, under the sky and under the lamp.
#[test]
fn means_of_unbiased_rules_are_exact() {
    on_every_backend(|backend| {
        for text in UNBIASED {
            let sky = floor(SKY, backend, &[], &[&rule(text), "render.spp=64"]);
            sky.statistics().expect(&format!("sky, {text}"), 0.5, 0.0);
            let lit = floor(LAMP, backend, &[lamp()], &[&rule(text), "render.spp=512"]);
            lit.statistics().expect(&format!("lamp, {text}"), 0.119_728_2, 1e-6);
        }
    });
}

/// Importance sampling by either density alone, or by both.
#[test]
fn importance_by_bsdf_by_light_and_by_both() {
    on_every_backend(|backend| {
        for lights in ["mis", "light", "bsdf"] {
            let lights = format!("render.lights={lights}");
            let set = [&rule("rule = \"importance\", directions = [8]"), lights.as_str(), "render.spp=512"];
            floor(LAMP, backend, &[lamp()], &set).statistics().expect(&lights, 0.119_728_2, 1e-6);
        }
    });
}

/// 13.7's hint: a point or parallel light is a term of its own, exact whatever the rule.
#[test]
fn delta_lights_have_their_own_term() {
    let point = "[[light]]\ntype = \"point\"\nposition = [0, 2, 0]\nintensity = 1\n";
    let two = format!("{point}[[light]]\ntype = \"directional\"\ndirection = [0, -1, 0]\nirradiance = 2\n");
    on_every_backend(|backend| {
        for name in ["uniform", "uniform-corner", "random", "stratified", "nonuniform", "importance", "sobol"]
        {
            for (light, exact) in [(point, 0.039_788_7), (two.as_str(), 0.039_788_7 + 1.0 / PI)] {
                let set = rule(&format!("rule = \"{name}\", directions = [[2, 3]]"));
                let (image, stats) = floor(light, backend, &[], &[&set]).render(|_| ());
                let shown = f64::from(image.f32_channel("G").unwrap()[5]);
                assert!((shown - exact).abs() < 1e-6, "{name}: {shown} not {exact}");
                assert_eq!(stats.shadow_rays, if exact < 0.1 { 16 } else { 32 }, "{name}");
            }
        }
    });
}

/// A sheet that passes light: the lower hemisphere by the same rule.
#[test]
fn transmission_uses_the_lower_hemisphere() {
    on_every_backend(|backend| {
        let sheet = "materials.m={ type = \"translucent\", reflectance = 0.25, transmittance = 0.5 }";
        for text in UNBIASED {
            let stage = floor(SKY, backend, &[], &[sheet, &rule(text), "render.spp=64"]);
            stage.statistics().expect(text, 0.75, 0.0);
        }
        let set = rule("rule = \"uniform\", directions = [[4, 4]]");
        let shown = value(&floor(SKY, backend, &[], &[sheet, &set]));
        assert!((shown / 0.75 - 1.026_172).abs() < 6e-7, "{shown}");
    });
}
