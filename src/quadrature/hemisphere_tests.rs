use super::*;

/// A well-spread point of the unit square.
fn u(i: u32) -> [f32; 2] {
    [0.754_877_7, 0.569_840_3].map(|a: f64| ((0.5 + a * f64::from(i + 1)).fract() as f32).min(0.999_999_9))
}

/// Σ f(d_k)·cos θ·Δω_k.
fn sum(rule: HemisphereRule, cells: Cells, f: impl Fn(Vec3) -> f64) -> f64 {
    let fan = Fan::new(rule, cells).unwrap();
    let term = |k: u32| {
        let (wi, solid_angle) = fan.direction(k, u(k));
        assert!((wi.length() - 1.0).abs() < 1e-6 && wi.z >= 0.0 && solid_angle >= 0.0);
        f(wi) * f64::from(wi.z) * f64::from(solid_angle)
    };
    (0..fan.count()).map(term).sum()
}

/// All rules with all parameters.
fn rules() -> Vec<HemisphereRule> {
    use HemisphereRule::*;
    let mut rules = vec![Uniform, UniformCorner, Importance];
    for (_, _, measure) in Measure::TABLE.iter().copied() {
        rules.extend([Random { measure }, Sobol { measure }]);
        rules.extend([1, 3].map(|per_cell| Stratified { measure, per_cell }));
    }
    rules.extend([0, 1, 3].map(|per_cell| Nonuniform { per_cell }));
    rules
}

#[test]
fn every_registered_rule_is_tested() {
    for (name, _, _) in HemisphereRule::TABLE {
        assert!(rules().iter().any(|r| r.name() == *name), "{name}");
    }
}

/// The table at the end of the list of exact answers: a constant environment under M rings, over π.
#[test]
fn grids_on_a_constant_have_their_closed_forms() {
    for (m, midpoints, edges) in
        [(4, 1.026_172, 0.948_059), (8, 1.006_455, 0.987_116), (16, 1.001_608, 0.996_785)]
    {
        for phi in [1, 5, 32] {
            let cells = Cells { theta: m, phi };
            let x = PI / (2.0 * f64::from(m));
            let (uniform, corner) = (
                sum(HemisphereRule::Uniform, cells, |_| 1.0) / PI,
                sum(HemisphereRule::UniformCorner, cells, |_| 1.0) / PI,
            );
            assert!((uniform - x / x.sin()).abs() < 3e-7 && (uniform - midpoints).abs() < 6e-7, "{uniform}");
            assert!((corner - x / x.tan()).abs() < 3e-7 && (corner - edges).abs() < 6e-7, "{corner}");
            let equal = sum(HemisphereRule::Nonuniform { per_cell: 0 }, cells, |_| 1.0) / PI;
            assert!((equal - 1.0).abs() < 3e-7, "{equal}");
        }
    }
}

/// Every rule has the integral as its limit: 1 + x + y²z against ∫(1 + x + y²z)·cos θ dω = π + 2π/15.
#[test]
fn every_rule_converges() {
    let exact = PI + 2.0 * PI / 15.0;
    for rule in rules() {
        let f = |d: Vec3| 1.0 + f64::from(d.x) + f64::from(d.y * d.y * d.z);
        let value = sum(rule, Cells { theta: 100, phi: 200 }, f);
        assert!((value - exact).abs() < 4e-3 * exact, "{rule:?}: {value}, not {exact}");
    }
}

/// Eq. (2) with φ = 0 along y, (16) and (17) from the left edges.
#[test]
fn directions_follow_equation_2() {
    let fan = Fan::new(HemisphereRule::UniformCorner, Cells { theta: 3, phi: 4 }).unwrap();
    let (pole, size) = fan.direction(0, [0.0; 2]);
    assert_eq!((pole, size), (Vec3::Z, 0.0));
    let (first, size) = fan.direction(4, [0.0; 2]);
    assert!((first - Vec3::new(0.0, 0.5, 0.75f32.sqrt())).length() < 1e-7, "{first}");
    assert!((size - 0.5 * (PI / 6.0 * PI / 2.0) as f32).abs() < 1e-7);
    let (quarter, _) = fan.direction(5, [0.0; 2]);
    assert!((quarter - Vec3::new(0.5, 0.0, 0.75f32.sqrt())).length() < 1e-7, "{quarter}");
}

/// Jittered rules put J directions into every cell.
#[test]
fn cells_get_their_directions() {
    for (_, _, measure) in Measure::TABLE.iter().copied() {
        let cells = Cells { theta: 3, phi: 5 };
        let fan = Fan::new(HemisphereRule::Stratified { measure, per_cell: 2 }, cells).unwrap();
        let mut counts = [0; 15];
        for k in 0..fan.count() {
            let (d, _) = fan.direction(k, u(k));
            let along = match measure {
                Measure::Angles => d.z.acos() / (0.5 * PI as f32),
                Measure::SolidAngle => 1.0 - d.z,
                Measure::Projected => 1.0 - d.z * d.z,
            };
            let turn = (f64::from(d.x).atan2(f64::from(d.y)) / TAU).rem_euclid(1.0);
            counts[5 * (along * 3.0) as usize + (turn * 5.0) as usize] += 1;
        }
        assert_eq!(counts, [2; 15], "{measure:?}");
    }
}

#[test]
fn numbers_become_cells() {
    let of = |n: u32| (Cells::of(n).theta, Cells::of(n).phi);
    assert_eq!([1, 2, 7, 8, 12, 16, 64].map(of), [(1, 1), (1, 2), (1, 7), (2, 4), (3, 4), (4, 4), (8, 8)]);
    assert!(Fan::new(HemisphereRule::Uniform, Cells { theta: 0, phi: 4 }).is_err());
    assert!(Fan::new(HemisphereRule::Random { measure: Measure::Angles }, Cells::of(1 << 17)).is_err());
}
