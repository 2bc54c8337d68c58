//! Every model against the laws that all obey: samples follow the density, weights are f_cos/pdf, energy does
//! not grow, light may be sent back the way it came.

mod density;
mod energy;
mod lanes;

use super::fresnel::Reflectance;
use super::metals::METALS;
use super::principled::Look;
use super::*;
use crate::math::chi_square::random;

/// A model under test.
struct Model {
    name: &'static str,
    /// For messages.
    what: String,
    bsdf: Box<dyn Scatter + Sync>,
    /// Index of the body behind the surface, which squeezes radiance by η²; 1 for sheets and what is opaque.
    ior: f32,
    /// Sends the same from a to b as from b to a.
    reciprocal: bool,
}

/// Roughnesses that every model with facets is tested at.
const ROUGHNESSES: [f32; 5] = [0.0, 0.001, 0.05, 0.3, 1.0];

/// Every registered model, where it has facets at [`ROUGHNESSES`].
fn models() -> Vec<Model> {
    models_of(&ROUGHNESSES)
}

/// Every registered model, where it has facets at every one of those; the registry's names must all occur here.
fn models_of(roughnesses: &[f32]) -> Vec<Model> {
    let mut all = Vec::new();
    let mut add = |name, what: &str, bsdf: Box<dyn Scatter + Sync>| {
        all.push(Model { name, what: format!("{name} {what}"), bsdf, ior: 1.0, reciprocal: true });
    };
    let phong = |d: f32, s: f32, n: f32| Box::new(Phong::new(Rgb::splat(d), Rgb::splat(s), n));
    add("diffuse", "", Box::new(Diffuse { reflectance: Rgb::splat(0.7) }));
    add("mirror", "", Box::new(Mirror { reflectance: Rgb::splat(0.9) }));
    add("phong", "with highlight", phong(0.3, 0.5, 20.0));
    add("phong", "without base", phong(0.0, 1.0, 5.0));
    add("phong", "wide", phong(0.9, 0.6, 0.0));
    add("translucent", "both ways", Box::new(Translucent::new(Rgb::splat(0.3), Rgb::splat(0.6))));
    add("translucent", "through alone", Box::new(Translucent::new(Rgb::ZERO, Rgb::ONE)));
    add("conductor", "α 0.8", Box::new(Conductor::new(Reflectance::Constant(Rgb::ONE), 0.8, true)));
    for &roughness in roughnesses {
        rough_models(roughness, &mut all);
    }
    all
}

fn rough_models(roughness: f32, all: &mut Vec<Model>) {
    let alpha = roughness * roughness;
    let mut add = |name, what: &str, bsdf: Box<dyn Scatter + Sync>, ior| {
        let what = format!("{name} {what} of roughness {roughness}");
        all.push(Model { name, what, bsdf, ior, reciprocal: true });
    };
    let gold = METALS.iter().find(|m| m.0 == "gold").unwrap();
    let index = Reflectance::Index { eta: gold.1.into(), k: gold.2.into() };
    let white = Reflectance::Constant(Rgb::ONE);
    add("conductor", "gold", Box::new(Conductor::new(index, alpha, false)), 1.0);
    add("conductor", "white", Box::new(Conductor::new(white, alpha, true)), 1.0);
    let mut grey = Conductor::new(Reflectance::Constant(Rgb::splat(0.7)), alpha, false);
    grey.set(Parameter::Anisotropy, Rgb::splat(0.4));
    add("conductor", "single scattering, brushed", Box::new(grey), 1.0);
    for grain in [0.8, -0.5] {
        let mut metal = Conductor::new(white, alpha, true);
        metal.set(Parameter::Anisotropy, Rgb::splat(grain));
        add("conductor", &format!("grain {grain}"), Box::new(metal), 1.0);
    }
    let glass = |ior: f32| Dielectric::new(ior, Rgb::ONE).rough(alpha, true);
    let single = glass(1.5).with_compensation(false);
    add("dielectric", "body", Box::new(glass(1.5)), 1.5);
    add("dielectric", "dense body", Box::new(glass(2.4)), 2.4);
    add("dielectric", "bubble", Box::new(glass(0.75)), 0.75);
    add("dielectric", "no index", Box::new(glass(1.0)), 1.0);
    add("dielectric", "body, single scattering", Box::new(single), 1.5);
    add("dielectric", "thin", Box::new(glass(1.5).thin(true)), 1.0);
    add("oren-nayar", "", Box::new(OrenNayar::new(Rgb::splat(0.8), roughness)), 1.0);
    add("oren-nayar", "white", Box::new(OrenNayar::new(Rgb::ONE, roughness)), 1.0);
    let plastic = |rho: f32| Plastic::new(Rgb::splat(rho), 1.5, alpha);
    add("plastic", "gray", Box::new(plastic(0.4).with_nonlinear(true)), 1.0);
    add("plastic", "white", Box::new(plastic(1.0)), 1.0);
    add("plastic", "black", Box::new(plastic(0.0)), 1.0);
    for (what, look) in looks(roughness) {
        let ior = if look.transmission > 0.0 { look.ior } else { 1.0 };
        add("principled", what, Box::new(Principled::new(look)), ior);
    }
}

/// Principled materials that use every part.
fn looks(roughness: f32) -> [(&'static str, Look); 7] {
    let plain = Look { base_color: Rgb::ONE, roughness, ..Look::default() };
    [
        ("white", plain),
        ("metal", Look { metallic: 1.0, anisotropy: 0.7, ..plain }),
        ("glass", Look { transmission: 1.0, ..plain }),
        ("half of each", Look { metallic: 0.3, transmission: 0.5, specular: 0.9, ..plain }),
        ("coated", Look { coat: 1.0, coat_roughness: 0.001, metallic: 0.5, ..plain }),
        ("cloth", Look { sheen: 1.0, sheen_roughness: 0.3, specular: 0.0, ..plain }),
        (
            "everything",
            Look { metallic: 0.3, transmission: 0.3, coat: 0.5, coat_roughness: 0.4, sheen: 0.5, ..plain },
        ),
    ]
}

fn view(degrees: f32) -> View {
    let (s, c) = degrees.to_radians().sin_cos();
    View { wo: Vec3::new(s, 0.0, c), outside: true }
}

/// The sides from which a model is seen.
fn sides(model: &Model) -> &'static [bool] {
    if model.ior == 1.0 { &[true] } else { &[true, false] }
}

/// Well-spread points of the unit cube (the generalised golden ratio; Roberts 2018).
fn point(i: u32) -> ([f32; 2], f32) {
    let at = |a: f64| ((0.5 + a * f64::from(i + 1)).fract() as f32).min(0.999_999_9);
    ([at(0.819_172_513_396_164_4), at(0.671_043_606_703_789_2)], at(0.549_700_477_901_970_3))
}

#[test]
fn every_registered_model_is_tested() {
    for (name, _) in Bsdf::NAMES {
        assert!(models().iter().any(|m| m.name == *name), "{name} is in no test");
    }
}

/// Integrators that follow every delta see what those see that choose one by chance.
#[test]
fn deltas_are_the_mean_of_samples() {
    for Model { what: name, bsdf: model, .. } in models() {
        for degrees in [0.0, 40.0, 80.0] {
            let view = view(degrees);
            let deltas: Vec<Delta> = model.deltas(&view).into_iter().flatten().collect();
            assert!(!deltas.is_empty() || !model.is_delta(), "{name}");
            for delta in &deltas {
                let n = 1 << 16;
                let one = |i: u32| {
                    let sample = model.sample(&view, [0.5; 2], (i as f32 + 0.5) / n as f32);
                    let hit = sample.filter(|s| s.wi == delta.wi && s.pdf == f32::INFINITY);
                    hit.map_or(0.0, |s| f64::from(s.weight.y))
                };
                let mean = (0..n).map(one).sum::<f64>() / f64::from(n);
                assert!((mean - f64::from(delta.weight.y)).abs() < 1e-4, "{name} at {degrees}°: {mean}");
            }
        }
    }
}

#[test]
fn light_may_go_back_the_way_it_came() {
    for Model { what: name, bsdf: model, ior, .. } in
        models().iter().filter(|m| !m.bsdf.is_delta() && m.reciprocal)
    {
        for i in 0..500 {
            let ([a, b], c) = point(i);
            let a_dir = crate::math::warp::cosine_hemisphere([a, b]);
            let b_dir = crate::math::warp::cosine_hemisphere([c, a]);
            let f = |wo: Vec3, wi: Vec3| model.eval(&View { wo, outside: true }, wi).0 / wi.z;
            let same = |a: Rgb, b: Rgb| (a - b).length() <= 2e-3 * a.length() + 1e-5;
            let (there, back) = (f(a_dir, b_dir), f(b_dir, a_dir));
            assert!(same(there, back), "{name}: {there} and {back}");
            // Through it: seen from the other side the local z turns round, and radiance is squeezed by η².
            let flip = |w: Vec3| Vec3::new(w.x, w.y, -w.z);
            let through = |wo, wi: Vec3, outside| model.eval(&View { wo, outside }, flip(wi)).0 / wi.z;
            let (there, back) = (through(a_dir, b_dir, true), through(b_dir, a_dir, *ior == 1.0));
            assert!(same(there * (ior * ior), back), "{name}: {there} and {back} through");
            assert!(model.transmits() || there == Rgb::ZERO, "{name} lets light through");
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
    let glass = Dielectric::new(1.5, Rgb::ONE);
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
