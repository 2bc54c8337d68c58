//! What is evaluated for all lanes at once is what each of them is by itself.

use super::*;

/// Models that say they are small: their functions without branches give the others' bits, also edge-on, along the
/// mirror's direction and behind the surface.
#[test]
fn small_models_are_the_same_without_branches() {
    let mut small = Vec::new();
    for Model { name, what, bsdf: model, .. } in models() {
        if !model.is_small() {
            continue;
        }
        small.push(name);
        let mut absorbed = 0;
        for i in 0..4000 {
            let ([a, b], c) = point(i);
            let z = if i % 4 == 0 { 1e-3 * c } else { c };
            let r = (1.0 - z * z).sqrt();
            let (s, t) = (std::f32::consts::TAU * a).sin_cos();
            let view = View { wo: Vec3::new(r * s, r * t, z), outside: i % 3 == 0 };
            let u = random(i).0;
            let sample = model.sample(&view, u, b);
            let (all_at_once, some) = model.sample_small(&view, u);
            let parts =
                |s: &Sample| [s.wi.to_array(), s.weight.to_array(), [s.pdf; 3]].map(|v| v.map(f32::to_bits));
            assert_eq!(sample.is_some(), some, "{what}: {view:?} {u:?}");
            assert!(sample.is_none_or(|s| parts(&s) == parts(&all_at_once)), "{what}: {view:?} {u:?}");
            absorbed += u32::from(!some);
            let wis = [Vec3::new(-r * s, -r * t, z), Vec3::new(s, t, 0.0), -view.wo, all_at_once.wi, Vec3::Z];
            for wi in wis {
                assert_eq!(model.eval(&view, wi), model.eval_small(&view, wi), "{what}: {view:?} {wi}");
            }
        }
        assert!(name == "diffuse" || absorbed > 0, "{what} sends nothing below the horizon");
    }
    small.dedup();
    assert_eq!(small, ["diffuse", "conductor"]);
}

/// A metal is small with one reflectance, no table and some width.
#[test]
fn metals_are_small_where_nothing_is_looked_up() {
    let white = Reflectance::Constant(Rgb::ONE);
    let is_small = |metal: &Conductor| metal.is_small();
    assert!(is_small(&Conductor::new(white, 0.2, false)));
    assert!(!is_small(&Conductor::new(white, 0.2, true)) && !is_small(&Conductor::new(white, 0.0, false)));
    assert!(!is_small(&Conductor::new(Reflectance::Schlick(Rgb::splat(0.5)), 0.2, false)));
}
