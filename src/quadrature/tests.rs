use super::*;
use crate::converge::fit;

const D: f64 = 2.0;

/// A rule as the tests see it: N and the numbers to use.
type Rule<'a> = &'a dyn Fn(usize, &mut dyn FnMut() -> f64) -> Estimate;
/// An integrand, its integral, and a density.
type Case<'a> = (&'a dyn Fn(f64) -> f64, f64, &'a dyn Density);

fn smooth(x: f64) -> f64 {
    libm::exp(-x)
}
const SMOOTH: f64 = 0.864_664_716_763_387_3;

/// 1, and from D/3 on 3. Powers of two never put an edge there.
fn step(x: f64) -> f64 {
    if x < D / 3.0 { 1.0 } else { 3.0 }
}
const STEP: f64 = 14.0 / 3.0;

const PEAK_AT: f64 = 1.3;
const PEAK_SIGMA: f64 = 0.02;

fn peak(x: f64) -> f64 {
    let z = (x - PEAK_AT) / PEAK_SIGMA;
    libm::exp(-0.5 * z * z)
}

fn peak_exact() -> f64 {
    PEAK_SIGMA * (2.0 * std::f64::consts::PI).sqrt()
}

/// Root mean square error of `rule` with `n` points over `seeds` seeds.
fn rmse(exact: f64, n: usize, seeds: u64, rule: Rule<'_>) -> f64 {
    let square = |seed| {
        let error = rule(n, &mut numbers(seed, n as u64)).value - exact;
        error * error
    };
    ((0..seeds).map(square).sum::<f64>() / seeds as f64).sqrt()
}

/// The slope of log error against log N over N = 4 … 1024.
fn slope(exact: f64, seeds: u64, rule: Rule<'_>) -> f64 {
    let points = (1..=5).map(|k| 1 << (2 * k)).map(|n| (n as f64, rmse(exact, n, seeds, rule)));
    fit::slope(&points.collect::<Vec<_>>()).expect("a slope").value
}

#[track_caller]
fn near(value: f64, expected: f64, tolerance: f64) {
    assert!((value - expected).abs() <= tolerance, "{value} is not {expected} ± {tolerance}");
}

#[test]
fn grids_are_the_sums_of_the_notes() {
    // By hand: f = x² over [0, 2], N = 4: Δ = ½; midpoints ¼, ¾, 5/4, 7/4; left edges 0, ½, 1, 3/2.
    let square = |x: f64| x * x;
    assert_eq!(midpoints(square, 2.0, 4).unwrap().value, 0.5 * (1.0 + 9.0 + 25.0 + 49.0) / 16.0);
    assert_eq!(left_edges(square, 2.0, 4).unwrap().value, 0.5 * (0.0 + 0.25 + 1.0 + 2.25));
    let regions = Regions::from_sizes(&[0.5, 1.5]).unwrap();
    assert_eq!(nonuniform(square, &regions).value, 0.25 * 0.25 * 0.5 + 1.25 * 1.25 * 1.5);
    assert_eq!(midpoints(square, 2.0, 4).unwrap().standard_error, None);
    assert_eq!(midpoints(square, 2.0, 4).unwrap().evaluations, 4);
}

#[test]
fn slopes_on_a_smooth_integrand() {
    near(slope(SMOOTH, 1, &|n, _| midpoints(smooth, D, n).unwrap()), -2.0, 0.01);
    near(slope(SMOOTH, 1, &|n, _| left_edges(smooth, D, n).unwrap()), -1.0, 0.03);
    near(slope(SMOOTH, 400, &|n, r| monte_carlo(smooth, D, n, r).unwrap()), -0.5, 0.03);
    near(slope(SMOOTH, 400, &|n, r| stratified(smooth, D, n, 1, r).unwrap()), -1.5, 0.03);
    near(slope(SMOOTH, 400, &|n, r| stratified(smooth, D, n / 2, 2, r).unwrap()), -1.5, 0.03);
    let line = PiecewiseLinear::new(&[(0.0, 1.0), (D, 0.15)]).unwrap();
    let regions = |n| Regions::equal_shares(&line, n).unwrap();
    near(slope(SMOOTH, 1, &|n, _| nonuniform(smooth, &regions(n))), -2.0, 0.06);
    near(slope(SMOOTH, 400, &|n, r| nonuniform_random(smooth, &regions(n), 1, r).unwrap()), -1.5, 0.06);
    near(slope(SMOOTH, 400, &|n, r| importance(smooth, &line, n, r).unwrap()), -0.5, 0.03);
}

#[test]
fn slopes_on_a_step() {
    near(slope(STEP, 1, &|n, _| midpoints(step, D, n).unwrap()), -1.0, 0.01);
    near(slope(STEP, 400, &|n, r| monte_carlo(step, D, n, r).unwrap()), -0.5, 0.03);
    near(slope(STEP, 400, &|n, r| stratified(step, D, n, 1, r).unwrap()), -1.0, 0.03);
}

/// On a narrow peak a Gaussian where it is expected is worth many points (13.8); on a flat function it is a loss.
#[test]
fn a_gaussian_wins_on_a_peak_and_loses_on_a_constant() {
    let gaussian = Gaussian::new(D, 1.31, 0.06).unwrap();
    let simple = |n: usize, r: &mut dyn FnMut() -> f64| monte_carlo(peak, D, n, r).unwrap();
    let drawn = |n: usize, r: &mut dyn FnMut() -> f64| importance(peak, &gaussian, n, r).unwrap();
    let (without, with) = (rmse(peak_exact(), 256, 400, &simple), rmse(peak_exact(), 256, 400, &drawn));
    assert!(with < 0.3 * without, "{with} against {without}");
    near(slope(peak_exact(), 400, &simple), -0.5, 0.06);
    near(slope(peak_exact(), 400, &drawn), -0.5, 0.03);
    let simple = |n: usize, r: &mut dyn FnMut() -> f64| monte_carlo(|_| 1.0, D, n, r).unwrap();
    let wide = Gaussian::new(D, 1.0, 0.5).unwrap();
    let drawn = |n: usize, r: &mut dyn FnMut() -> f64| importance(|_| 1.0, &wide, n, r).unwrap();
    assert!(rmse(D, 256, 100, &simple) < 1e-14 && rmse(D, 256, 100, &drawn) > 0.01);
    near(rmse(D, 1024, 400, &drawn) / rmse(D, 64, 400, &drawn), 0.25, 0.06);
}

#[test]
fn the_perfect_density_has_no_variance() {
    let steps = [(0.0, 1.0), (D / 3.0, 1.0), (D / 3.0, 3.0), (D, 3.0)];
    let cases: [Case<'_>; 3] = [
        (&smooth, SMOOTH, &Exponential::new(D, 1.0).unwrap()),
        (&step, STEP, &PiecewiseLinear::new(&steps).unwrap()),
        (&peak, peak_exact(), &Gaussian::new(D, PEAK_AT, PEAK_SIGMA).unwrap()),
    ];
    for (f, exact, density) in cases {
        for n in [1, 7, 1000] {
            let estimate = importance(f, density, n, numbers(3, n as u64)).unwrap();
            near(estimate.value, exact, 1e-13 * exact);
            assert!(estimate.standard_error.is_none_or(|error| error < 1e-13), "{estimate:?}");
        }
    }
}

/// 13.8: with p = 1/D importance sampling "reduces to Simple Monte Carlo", here to the last bit.
#[test]
fn a_uniform_density_is_simple_monte_carlo_bit_for_bit() {
    for d in [D, 3.0, 0.1, std::f64::consts::PI] {
        for n in [1, 2, 17, 1000] {
            let uniform = Uniform::new(d).unwrap();
            let simple = monte_carlo(smooth, d, n, numbers(5, 9)).unwrap();
            assert_eq!(importance(smooth, &uniform, n, numbers(5, 9)).unwrap(), simple);
        }
    }
}

/// The standard error is the standard deviation that is seen over many seeds.
#[test]
fn standard_errors_are_true() {
    let regions = Regions::from_sizes(&[0.2, 0.3, 0.5, 1.0]).unwrap();
    let rules: [Rule<'_>; 4] = [
        &|n, r| monte_carlo(smooth, D, n, r).unwrap(),
        &|n, r| importance(smooth, &Gaussian::new(D, 0.5, 1.0).unwrap(), n, r).unwrap(),
        &|n, r| stratified(smooth, D, n / 4, 4, r).unwrap(),
        &|n, r| nonuniform_random(smooth, &regions, n / 4, r).unwrap(),
    ];
    for rule in rules {
        let squares = |seed| rule(64, &mut numbers(seed, 0)).standard_error.unwrap().powi(2);
        let said = ((0..2000).map(squares).sum::<f64>() / 2000.0).sqrt();
        near(said / rmse(SMOOTH, 64, 2000, rule), 1.0, 0.06);
    }
    assert_eq!(monte_carlo(smooth, D, 1, numbers(0, 0)).unwrap().standard_error, None);
    assert_eq!(stratified(smooth, D, 8, 1, numbers(0, 0)).unwrap().standard_error, None);
    assert_eq!(nonuniform_random(smooth, &regions, 1, numbers(0, 0)).unwrap().standard_error, None);
}

/// Density and inverse belong together: the density's integral up to `inverse(u)` is `u`.
#[test]
fn densities_and_inverses_agree() {
    let densities: [&dyn Density; 6] = [
        &Uniform::new(D).unwrap(),
        &Gaussian::new(D, 0.4, 0.3).unwrap(),
        &Gaussian::new(D, D, 5.0).unwrap(),
        &Exponential::new(D, 1.7).unwrap(),
        &PiecewiseLinear::new(&[(0.0, 0.0), (0.5, 2.0), (0.5, 1.0), (1.0, 1.0), (1.5, 0.0), (D, 4.0)])
            .unwrap(),
        &PiecewiseLinear::new(&[(0.0, 3.0), (D, 0.0)]).unwrap(),
    ];
    for (i, density) in densities.into_iter().enumerate() {
        assert_eq!((density.inverse(0.0), density.inverse(1.0)), (0.0, D), "{i}");
        for k in 0..=16 {
            let u = f64::from(k) / 16.0;
            let x = density.inverse(u);
            let below = if x > 0.0 { midpoints(|x| density.pdf(x), x, 40_000).unwrap().value } else { 0.0 };
            near(below, u, 1e-4);
            if density.pdf(x) > 0.0 {
                near(density.pdf(x) * density.reciprocal(x), 1.0, 1e-15);
            }
        }
    }
}

/// Φ⁻¹ in the tails, against Φ itself.
#[test]
fn a_narrow_gaussian_keeps_its_tails() {
    let gaussian = Gaussian::new(1.0, 0.5, 0.01).unwrap();
    for u in [1e-15, 1e-9, 0.001, 0.499_999, 0.5, 0.75, 1.0 - 1e-9] {
        let z = (gaussian.inverse(u) - 0.5) / 0.01;
        let back = 0.5 * libm::erfc(-z * std::f64::consts::FRAC_1_SQRT_2);
        near(back / u, 1.0, 1e-12);
    }
}

#[test]
fn what_cannot_be_is_an_error() {
    let r = || 0.5;
    let regions = Regions::from_sizes(&[1.0, 1.0]).unwrap();
    for d in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(midpoints(smooth, d, 4).is_err() && monte_carlo(smooth, d, 4, r).is_err());
        assert!(stratified(smooth, d, 4, 1, r).is_err() && Uniform::new(d).is_err());
        assert!(Gaussian::new(d, 0.0, 1.0).is_err() && Exponential::new(d, 1.0).is_err());
    }
    assert!(midpoints(smooth, D, 0).is_err() && left_edges(smooth, D, 0).is_err());
    assert!(monte_carlo(smooth, D, 0, r).is_err());
    assert!(stratified(smooth, D, 0, 1, r).is_err() && stratified(smooth, D, 1, 0, r).is_err());
    assert!(nonuniform_random(smooth, &regions, 0, r).is_err());
    assert!(importance(smooth, &Uniform::new(D).unwrap(), 0, r).is_err());
    for sizes in [&[][..], &[1.0, 0.0], &[-1.0], &[f64::NAN], &[1.0, f64::INFINITY]] {
        assert!(Regions::from_sizes(sizes).is_err(), "{sizes:?}");
    }
    assert!(Regions::from_edges(vec![0.5, 1.0]).is_err());
    let message = Regions::from_sizes(&[1.0, 0.0, 2.0]).unwrap_err().to_string();
    assert_eq!(message, "region 2 of 3 is empty");
    // A million regions of a Gaussian that has room for fewer numbers.
    assert!(Regions::equal_shares(&Gaussian::new(1e9, 5e8, 1e-7).unwrap(), 1 << 20).is_err());
    assert!(Gaussian::new(D, 3.0, 1.0).is_err() && Gaussian::new(D, 1.0, 0.0).is_err());
    for knots in [
        &[][..],
        &[(0.0, 1.0)],
        &[(0.1, 1.0), (1.0, 1.0)],
        &[(0.0, -1.0), (1.0, 2.0)],
        &[(0.0, 0.0), (1.0, 0.0)],
    ] {
        assert!(PiecewiseLinear::new(knots).is_err(), "{knots:?}");
    }
}
