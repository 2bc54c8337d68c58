//! Every model against the laws that all obey: samples follow the density, weights are f_cos/pdf, energy does
//! not grow, light may be sent back the way it came.

use super::fresnel::{METALS, Reflectance};
use super::*;
use std::f64::consts::TAU;

/// A model with its name; the registry's names must all occur here.
fn models() -> Vec<(&'static str, Box<dyn Scatter>)> {
    let gold = METALS.iter().find(|m| m.0 == "gold").unwrap();
    let index = Reflectance::Index { eta: gold.1.into(), k: gold.2.into() };
    let white = Reflectance::Constant(Rgb::ONE);
    let phong = |d: f32, s: f32, n: f32| Box::new(Phong::new(Rgb::splat(d), Rgb::splat(s), n));
    vec![
        ("diffuse", Box::new(Diffuse { reflectance: Rgb::splat(0.7) })),
        ("mirror", Box::new(Mirror { reflectance: Rgb::splat(0.9) })),
        ("conductor", Box::new(Conductor::new(white, 0.09, false))),
        ("conductor", Box::new(Conductor::new(index, 0.3, false))),
        ("conductor", Box::new(Conductor::new(white, 0.8, true))),
        ("conductor", Box::new(Conductor::new(index, 0.0, true))),
        ("phong", phong(0.3, 0.5, 20.0)),
        ("phong", phong(0.0, 1.0, 5.0)),
        ("phong", phong(0.9, 0.6, 0.0)),
        ("dielectric", Box::new(Dielectric { ior: 1.5, tint: Rgb::ONE })),
        ("translucent", Box::new(Translucent::new(Rgb::splat(0.3), Rgb::splat(0.6)))),
        ("translucent", Box::new(Translucent::new(Rgb::ZERO, Rgb::ONE))),
    ]
}

fn view(degrees: f32) -> View {
    let (s, c) = degrees.to_radians().sin_cos();
    View { wo: Vec3::new(s, 0.0, c), outside: true }
}

/// Well-spread points of the unit cube (the generalised golden ratio; Roberts 2018).
fn point(i: u32) -> ([f32; 2], f32) {
    let at = |a: f64| ((0.5 + a * f64::from(i + 1)).fract() as f32).min(0.999_999_9);
    ([at(0.819_172_513_396_164_4), at(0.671_043_606_703_789_2)], at(0.549_700_477_901_970_3))
}

#[test]
fn every_registered_model_is_tested() {
    for (name, _) in Bsdf::NAMES {
        assert!(models().iter().any(|m| m.0 == *name), "{name} is in no test");
    }
}

/// Rows of cos θ and columns of φ: cells of equal solid angle of the sphere.
const ROWS: usize = 48;
const COLUMNS: usize = 32;

fn cell(wi: Vec3) -> usize {
    let row = (((wi.z + 1.0) * 0.5 * ROWS as f32) as usize).min(ROWS - 1);
    let turn = (f64::from(wi.y).atan2(f64::from(wi.x)) / TAU).rem_euclid(1.0);
    row * COLUMNS + ((turn * COLUMNS as f64) as usize).min(COLUMNS - 1)
}

/// The density's mass in every cell, by a midpoint grid within it.
fn masses(model: &dyn Scatter, view: &View) -> Vec<f64> {
    let fine = 24;
    let mut masses = vec![0.0; ROWS * COLUMNS];
    for (i, mass) in masses.iter_mut().enumerate() {
        let (row, column) = (i / COLUMNS, i % COLUMNS);
        for a in 0..fine {
            for b in 0..fine {
                let z = 2.0 * (row as f64 + (a as f64 + 0.5) / f64::from(fine)) / ROWS as f64 - 1.0;
                let phi = TAU * (column as f64 + (b as f64 + 0.5) / f64::from(fine)) / COLUMNS as f64;
                let r = (1.0 - z * z).sqrt();
                let wi = Vec3::new((r * phi.cos()) as f32, (r * phi.sin()) as f32, z as f32);
                *mass += f64::from(model.eval(view, wi).1);
            }
        }
        *mass *= 2.0 * TAU / (ROWS * COLUMNS) as f64 / f64::from(fine * fine);
    }
    masses
}

/// χ² of counts against masses, normalised to a standard normal deviate (Wilson and Hilferty 1931); cells
/// expecting fewer than 5 are pooled.
fn deviate(counts: &[u32], masses: &[f64], samples: f64) -> f64 {
    let (mut chi2, mut cells, mut pool) = (0.0, 0.0, (0.0, 0.0));
    for (&count, mass) in counts.iter().zip(masses) {
        let expected = mass * samples;
        if expected < 5.0 {
            pool = (pool.0 + f64::from(count), pool.1 + expected);
        } else {
            chi2 += (f64::from(count) - expected).powi(2) / expected;
            cells += 1.0;
        }
    }
    if pool.1 >= 5.0 {
        chi2 += (pool.0 - pool.1).powi(2) / pool.1;
        cells += 1.0;
    }
    let k: f64 = f64::max(cells - 1.0, 1.0);
    ((chi2 / k).cbrt() - (1.0 - 2.0 / (9.0 * k))) / (2.0 / (9.0 * k)).sqrt()
}

/// Independent uniform numbers, as the χ² statistic wants them.
fn random(i: u32) -> ([f32; 2], f32) {
    let hash = |x: u32| {
        let mut x = x.wrapping_mul(0x9e37_79b9) ^ 0x85eb_ca6b;
        for _ in 0..3 {
            x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
            x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
        }
        (x >> 8) as f32 / 16_777_216.0
    };
    ([hash(3 * i), hash(3 * i + 1)], hash(3 * i + 2))
}

#[test]
fn samples_follow_the_density() {
    let samples = 1_000_000;
    for (name, model) in models().iter().filter(|m| !m.1.is_delta()) {
        for degrees in [0.0, 40.0, 75.0] {
            let view = view(degrees);
            let masses = masses(model.as_ref(), &view);
            let total: f64 = masses.iter().sum();
            assert!(total <= 1.003, "{name} at {degrees}°: the density integrates to {total}");
            let mut counts = vec![0u32; ROWS * COLUMNS];
            for i in 0..samples {
                let (u, lobe) = random(i);
                if let Some(s) = model.sample(&view, u, lobe) {
                    let sound = s.pdf > 0.0 && (s.wi.z > 0.0 || model.transmits());
                    assert!(sound, "{name}: a sample where the density is zero");
                    counts[cell(s.wi)] += 1;
                }
            }
            let z = deviate(&counts, &masses, f64::from(samples));
            assert!(z < 6.0, "{name} at {degrees}°: χ² deviates by {z} σ");
            let wrong: Vec<f64> = masses.iter().map(|m| m * 1.02).collect();
            let z = deviate(&counts, &wrong, f64::from(samples));
            assert!(z > 6.0, "{name} at {degrees}°: the test would accept a density 2 % too high ({z} σ)");
        }
    }
}

#[test]
fn weights_are_f_cos_over_pdf() {
    for (name, model) in models().iter().filter(|m| !m.1.is_delta()) {
        for degrees in [0.0, 30.0, 85.0] {
            let view = view(degrees);
            for i in 0..2000 {
                let (u, lobe) = point(i);
                let Some(s) = model.sample(&view, u, lobe) else { continue };
                let (f_cos, pdf) = model.eval(&view, s.wi);
                assert!((pdf / s.pdf - 1.0).abs() < 1e-3, "{name}: {pdf} and {}", s.pdf);
                assert!((s.weight * s.pdf - f_cos).length() <= 1e-3 * f_cos.length() + 1e-6, "{name}");
                assert!((s.wi.length() - 1.0).abs() < 1e-5, "{name}");
            }
        }
    }
}

/// Integrators that follow every delta see what those see that choose one by chance.
#[test]
fn deltas_are_the_mean_of_samples() {
    for (name, model) in models() {
        for degrees in [0.0, 40.0, 80.0] {
            let view = view(degrees);
            let deltas: Vec<Delta> = model.deltas(&view).into_iter().flatten().collect();
            assert_eq!(!deltas.is_empty(), model.is_delta(), "{name}");
            for delta in &deltas {
                let n = 1 << 16;
                let one = |i: u32| {
                    let sample = model.sample(&view, [0.5; 2], (i as f32 + 0.5) / n as f32).unwrap();
                    if sample.wi == delta.wi { f64::from(sample.weight.y) } else { 0.0 }
                };
                let mean = (0..n).map(one).sum::<f64>() / f64::from(n);
                assert!((mean - f64::from(delta.weight.y)).abs() < 1e-4, "{name} at {degrees}°: {mean}");
            }
        }
    }
}

/// The mean weight is the albedo.
fn albedo(model: &dyn Scatter, view: &View) -> f64 {
    let n = 1 << 18;
    let one = |i: u32| {
        let (u, lobe) = random(i);
        model.sample(view, u, lobe).map_or(0.0, |s| f64::from(s.weight.max_element()))
    };
    (0..n).map(one).sum::<f64>() / f64::from(n)
}

#[test]
fn no_model_makes_energy() {
    for (name, model) in models() {
        for degrees in [0.0, 20.0, 45.0, 70.0, 85.0, 89.0] {
            let a = albedo(model.as_ref(), &view(degrees));
            // Inside the table's resolution; a dielectric squeezes radiance by η² where it refracts.
            assert!(a <= 1.01, "{name} at {degrees}°: albedo {a}");
        }
    }
}

#[test]
fn compensation_gives_everything_back() {
    for alpha in [0.05, 0.2, 0.5, 1.0] {
        let metal = Conductor::new(Reflectance::Constant(Rgb::ONE), alpha, true);
        for degrees in [0.0, 30.0, 60.0, 80.0] {
            let a = albedo(&metal, &view(degrees));
            assert!((a - 1.0).abs() < 0.01, "α {alpha} at {degrees}°: {a}");
        }
    }
    let rough = Conductor::new(Reflectance::Constant(Rgb::ONE), 1.0, false);
    assert!(albedo(&rough, &view(0.0)) < 0.75, "without it a rough metal is dark");
}

#[test]
fn light_may_go_back_the_way_it_came() {
    for (name, model) in models().iter().filter(|m| !m.1.is_delta()) {
        for i in 0..500 {
            let ([a, b], c) = point(i);
            let a_dir = crate::math::warp::cosine_hemisphere([a, b]);
            let b_dir = crate::math::warp::cosine_hemisphere([c, a]);
            let f = |wo: Vec3, wi: Vec3| model.eval(&View { wo, outside: true }, wi).0 / wi.z;
            // Through the sheet: seen from the other side the local z turns round.
            let through = |wo: Vec3, wi: Vec3| model.eval(&View { wo, outside: true }, -wi).0 / wi.z;
            assert_eq!(through(a_dir, a_dir) != Rgb::ZERO, model.transmits(), "{name}");
            let (there, back) = (f(a_dir, b_dir), f(b_dir, a_dir));
            assert!((there - back).length() <= 2e-3 * there.length() + 1e-6, "{name}: {there} and {back}");
        }
    }
}

/// O22: Phong's lobe alone under a constant sky.
#[test]
fn phong_has_its_closed_form() {
    for (n, row) in
        [(10.0, [1.0, 0.866_029, 0.504_736, 0.228_056]), (100.0, [1.0, 0.866_025, 0.5, 0.175_233])]
    {
        let phong = Phong::new(Rgb::ZERO, Rgb::ONE, n);
        for (degrees, exact) in [0.0, 30.0, 60.0, 80.0].into_iter().zip(row) {
            let a = albedo(&phong, &view(degrees));
            assert!((a - exact).abs() < 4e-3, "n {n} at {degrees}°: {a} not {exact}");
        }
    }
}

/// O19: Fresnel's reflectance of glass.
#[test]
fn glass_reflects_as_fresnel_says() {
    let rows = [
        (0.0, 0.04),
        (30.0, 0.041_523),
        (45.0, 0.050_240),
        (60.0, 0.089_187),
        (75.0, 0.253_061),
        (85.0, 0.612_800),
    ];
    for (degrees, exact) in rows {
        let (r, _) = fresnel::dielectric((degrees as f32).to_radians().cos(), 1.5);
        assert!((r - exact as f32).abs() < 2e-5, "{degrees}°: {r}");
    }
    // From inside, beyond the critical angle, everything.
    assert_eq!(fresnel::dielectric(0.5, 1.0 / 1.5).0, 1.0);
}

/// What refracts into a slab and out of it again has lost nothing to η², and goes on in the same direction.
#[test]
fn a_slab_of_glass_shifts_but_does_not_turn() {
    let glass = Dielectric { ior: 1.5, tint: Rgb::ONE };
    let outside = view(50.0);
    let entered = glass.sample(&outside, [0.5; 2], 0.999).unwrap();
    assert!(entered.wi.z < 0.0);
    // The second boundary is met from inside; the viewer's direction there is back along the ray.
    let inside = View { wo: -entered.wi, outside: false };
    let left = glass.sample(&inside, [0.5; 2], 0.999).unwrap();
    assert!((left.wi + outside.wo).length() < 1e-6, "{} {}", left.wi, outside.wo);
    assert!((entered.weight * left.weight - Rgb::ONE).length() < 1e-6);
}

#[test]
fn metals_have_their_colours() {
    let at = |name: &str| {
        let m = METALS.iter().find(|m| m.0 == name).unwrap();
        Reflectance::Index { eta: m.1.into(), k: m.2.into() }.at(1.0)
    };
    let (gold, silver) = (at("gold"), at("silver"));
    assert!(gold.x > 0.9 && gold.z < 0.5 && gold.x > gold.y && gold.y > gold.z, "{gold}");
    assert!(silver.min_element() > 0.85, "{silver}");
    let grazing = Reflectance::Index { eta: Rgb::splat(0.2), k: Rgb::splat(3.0) }.at(0.0);
    assert!((grazing - Rgb::ONE).length() < 1e-5);
}

/// What a texture sets at a hit is what the file would have set, and comes out as it went in.
#[test]
fn a_parameter_set_later_is_as_one_given_at_once() {
    let gray = Rgb::splat;
    let white = Reflectance::Constant(Rgb::ONE);
    let mut metal = Conductor::new(Reflectance::Constant(gray(0.2)), 0.0, true);
    assert!(metal.set(Parameter::Roughness, gray(0.5)) && metal.set(Parameter::Reflectance, Rgb::ONE));
    assert_eq!(metal, Conductor::new(white, 0.25, true));
    let mut phong = Phong::new(gray(0.9), gray(0.9), 3.0);
    assert!(phong.set(Parameter::Diffuse, gray(0.1)) && phong.set(Parameter::Specular, gray(0.2)));
    assert_eq!(phong, Phong::new(gray(0.1), gray(0.2), 3.0));
    let mut sheet = Translucent::new(gray(0.9), gray(0.9));
    assert!(sheet.set(Parameter::Transmittance, gray(0.05)));
    assert_eq!(sheet, Translucent::new(gray(0.9), gray(0.05)));
    let mut clay = Bsdf::Diffuse(Diffuse { reflectance: gray(0.5) });
    assert!(!clay.set(Parameter::Exponent, gray(1.0)) && !clay.set(Parameter::Opacity, gray(0.5)));
    assert!(clay.set(Parameter::Reflectance, gray(f32::NAN)));
    assert_eq!(clay, Bsdf::Diffuse(Diffuse { reflectance: Rgb::ZERO }));
}
