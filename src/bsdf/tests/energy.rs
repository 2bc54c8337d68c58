//! Furnaces: nothing sends back more light than it gets, and what should send back all of it does.

use super::*;
use rayon::prelude::*;

/// The share of light that is sent back or passes, seen from `view`, with its standard error: the mean weight, radiance
/// behind a body being η² times what it is in front. Eight randomly shifted sets of well-spread numbers.
fn measured(model: &Model, view: &View) -> [f64; 2] {
    let (sets, n) = (8, 4096);
    let eta = if view.outside { model.ior } else { 1.0 / model.ior };
    let weight = |s: Sample| s.weight.max_element() * if s.wi.z < 0.0 { eta * eta } else { 1.0 };
    let set = |k: u32| {
        let ([a, b], c) = random(k);
        let one = |i: u32| {
            let ([x, y], z) = point(i);
            let shifted = |x: f32, by: f32| (x + by).fract().min(0.999_999_9);
            let sample = model.bsdf.sample(view, [shifted(x, a), shifted(y, b)], shifted(z, c));
            sample.map_or(0.0, |s| f64::from(weight(s)))
        };
        (0..n).map(one).sum::<f64>() / f64::from(n)
    };
    let means: Vec<f64> = (0..sets).map(set).collect();
    let mean = means.iter().sum::<f64>() / f64::from(sets);
    let spread = means.iter().map(|m| (m - mean).powi(2)).sum::<f64>();
    [mean, (spread / f64::from(sets * (sets - 1))).sqrt()]
}

fn albedo(model: &Model, view: &View) -> f64 {
    measured(model, view)[0]
}

const ANGLES: [f32; 10] = [0.0, 20.0, 45.0, 60.0, 70.0, 80.0, 85.0, 87.0, 89.0, 89.8];
/// Between and at the nodes of tables.
const WIDTHS: [f32; 15] = [0.0, 0.02, 0.05, 0.1, 0.15, 0.2, 0.27, 0.33, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0];

/// Every model and view where `wrong` says that the albedo and its standard error are. Views are from all around.
fn all_wrong(all: &[Model], wrong: impl Fn([f64; 2], &Model, bool) -> bool + Sync) -> Vec<String> {
    let one = |model: &Model| {
        let mut found = Vec::new();
        for &outside in sides(model) {
            for (i, degrees) in ANGLES.into_iter().enumerate() {
                let (s, c) = (1.3 * i as f32).sin_cos();
                let wo = view(degrees).wo;
                let view = View { outside, wo: Vec3::new(wo.x * c, wo.x * s, wo.z) };
                let [a, error] = measured(model, &view);
                if wrong([a, error], model, outside) {
                    found.push(format!("{} at {degrees}°, outside {outside}: {a} ± {error}", model.what));
                }
            }
        }
        found
    };
    all.par_iter().flat_map(one).collect()
}

/// The mean weight is 1 at most, within six standard errors and what f32 rounds.
#[test]
fn no_model_makes_energy() {
    let models: Vec<Model> = models_of(&WIDTHS).into_iter().chain(faint_bodies()).collect();
    let wrong = all_wrong(&models, |[a, error], _, _| a > 1.0 + 6.0 * error + 2e-5);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Bodies that hardly bend light, whose tables are coarse; too narrow for quadratures of their densities.
fn faint_bodies() -> Vec<Model> {
    let of = |ior: f32, roughness: f32| {
        let bsdf = Box::new(Dielectric::new(ior, Rgb::ONE).rough(roughness * roughness, true));
        let what = format!("dielectric of index {ior} and roughness {roughness}");
        Model { name: "dielectric", what, bsdf, ior, reciprocal: true }
    };
    [0.98, 1.005, 1.1].into_iter().flat_map(|ior| WIDTHS.map(|roughness| of(ior, roughness))).collect()
}

/// Models that send everything on.
fn white(model: &Model) -> bool {
    let clear = model.name == "dielectric" && !model.what.contains("single");
    let looks = ["principled white", "principled glass"].iter().any(|w| model.what.starts_with(w));
    clear
        || looks
        || (model.what.contains(" white") && model.name != "principled")
        || model.what.contains("grain")
}

#[test]
fn what_is_white_gives_everything_back() {
    let count = models().iter().filter(|m| white(m)).count();
    assert_eq!(count, 5 * (1 + 2 + 5 + 1 + 1 + 2), "white models at every roughness");
    // Tables err to the dark side; brushed metals' are coarse.
    let allowed = |model: &Model| if model.what.contains("grain") { 0.02 } else { 0.008 };
    let white: Vec<Model> = models().into_iter().filter(white).collect();
    let wrong = all_wrong(&white, |[a, error], model, _| a < 1.0 - allowed(model) - 6.0 * error);
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn without_compensation_rough_surfaces_are_darker() {
    let white = Reflectance::Constant(Rgb::ONE);
    let metal = Conductor::new(white, 1.0, false);
    let glass = Dielectric::new(1.5, Rgb::ONE).rough(1.0, false);
    for (what, bsdf, ior, below) in [
        ("metal", Box::new(metal) as Box<dyn Scatter + Sync>, 1.0, 0.75),
        ("glass", Box::new(glass), 1.5, 0.93),
    ] {
        let model = Model { name: what, what: what.into(), bsdf, ior, reciprocal: true };
        let a = albedo(&model, &view(0.0));
        assert!(a < below, "{what}: {a}");
    }
}

/// Oren and Nayar's albedo for ρ = 0.8 by quadrature of `eval`, against the sampled one and E_ss + E_ms by hand.
#[test]
fn rough_matte_surfaces_have_their_known_albedo() {
    for roughness in [0.3, 1.0] {
        let model = OrenNayar::new(Rgb::splat(0.8), roughness);
        for degrees in [0.0f32, 40.0, 80.0] {
            let view = view(degrees);
            let (rows, columns) = (200, 200);
            let mut sum = 0.0;
            for i in 0..rows {
                for j in 0..columns {
                    let z = (i as f32 + 0.5) / rows as f32;
                    let phi = std::f32::consts::TAU * (j as f32 + 0.5) / columns as f32;
                    let r = (1.0 - z * z).sqrt();
                    sum += f64::from(model.eval(&view, Vec3::new(r * phi.cos(), r * phi.sin(), z)).0.x);
                }
            }
            let a = sum * std::f64::consts::TAU / f64::from(rows * columns);
            // E = ρ·E1 + ρ²·Ē(1 − E1)/(1 − ρ(1 − Ē)), E1 and Ē the single-scattering albedos for ρ = 1.
            let r = f64::from(roughness);
            let af = 1.0 / (1.0 + r * (0.5 - 2.0 / (3.0 * std::f64::consts::PI)));
            let theta = f64::from(degrees).to_radians();
            let (s, c) = theta.sin_cos();
            let g = s * (theta - s * c) + 2.0 / 3.0 * (s / c * (1.0 - s.powi(3)) - s);
            let e1 = af * (1.0 + r / std::f64::consts::PI * g);
            let mean = af * (1.0 + r * (2.0 / 3.0 - 28.0 / (15.0 * std::f64::consts::PI)));
            let exact = 0.8 * e1 + 0.64 * mean * (1.0 - e1) / (1.0 - 0.8 * (1.0 - mean));
            assert!((a - exact).abs() < 1e-3, "roughness {roughness} at {degrees}°: {a}, not {exact}");
        }
    }
}

/// O22: Phong's lobe alone under a constant sky.
#[test]
fn phong_has_its_closed_form() {
    for (n, row) in
        [(10.0, [1.0, 0.866_029, 0.504_736, 0.228_056]), (100.0, [1.0, 0.866_025, 0.5, 0.175_233])]
    {
        let bsdf = Box::new(Phong::new(Rgb::ZERO, Rgb::ONE, n));
        let phong = Model { name: "phong", what: "phong".into(), bsdf, ior: 1.0, reciprocal: true };
        for (degrees, exact) in [0.0, 30.0, 60.0, 80.0].into_iter().zip(row) {
            let a = albedo(&phong, &view(degrees));
            assert!((a - exact).abs() < 4e-3, "n {n} at {degrees}°: {a} not {exact}");
        }
    }
}
