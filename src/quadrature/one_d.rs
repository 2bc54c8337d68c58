//! The rules themselves.

use super::{Density, Estimate, Regions, check_count, check_domain};
use crate::error::Result;

/// N uniformly spaced points in the middle of their intervals: (8), S_N = D/N Σ f(x_i).
///
/// # Errors
/// No point, or no domain.
pub fn midpoints(f: impl FnMut(f64) -> f64, d: f64, n: usize) -> Result<Estimate> {
    grid(f, d, n, 0.5)
}

/// The same at the intervals' left ends, as (12) and (13) space them: x_m = (m − 1)·Δ. For a smooth f the error
/// is one order worse, (f(0) − f(D))·Δ/2.
///
/// # Errors
/// No point, or no domain.
pub fn left_edges(f: impl FnMut(f64) -> f64, d: f64, n: usize) -> Result<Estimate> {
    grid(f, d, n, 0.0)
}

fn grid(mut f: impl FnMut(f64) -> f64, d: f64, n: usize, offset: f64) -> Result<Estimate> {
    check_domain(d)?;
    check_count("point", n)?;
    let width = d / n as f64;
    let sum: f64 = (0..n).map(|i| f((i as f64 + offset) * width)).sum();
    Ok(Estimate { value: width * sum, standard_error: None, evaluations: n as u64 })
}

/// N independent points, uniform over [0, D]: simple Monte Carlo (10). D stands inside the sum, so that this is
/// (20) with p = 1/D to the last bit.
///
/// # Errors
/// No point, or no domain.
pub fn monte_carlo(
    mut f: impl FnMut(f64) -> f64,
    d: f64,
    n: usize,
    mut random: impl FnMut() -> f64,
) -> Result<Estimate> {
    check_domain(d)?;
    check_count("point", n)?;
    Ok(mean(n, || d * f(d * random())))
}

/// N independent points from a density p: importance sampling (20), S_N = 1/N Σ f(x_i)/p(x_i).
///
/// # Errors
/// No point.
pub fn importance(
    mut f: impl FnMut(f64) -> f64,
    density: &(impl Density + ?Sized),
    n: usize,
    mut random: impl FnMut() -> f64,
) -> Result<Estimate> {
    check_count("point", n)?;
    Ok(mean(n, || {
        let x = density.inverse(random());
        let weight = density.reciprocal(x);
        // An end of the domain where p is 0 may come up by rounding; it has no probability and counts nothing.
        if weight.is_finite() { weight * f(x) } else { 0.0 }
    }))
}

/// K regions of equal size with J random points in each: stratified sampling (13.6).
///
/// # Errors
/// No region, no point in it, or no domain.
pub fn stratified(
    f: impl FnMut(f64) -> f64,
    d: f64,
    regions: usize,
    per_region: usize,
    random: impl FnMut() -> f64,
) -> Result<Estimate> {
    check_domain(d)?;
    check_count("region", regions)?;
    let size = d / regions as f64;
    in_regions(f, (0..regions).map(|i| (i as f64 * size, size)), per_region, random)
}

/// One point in the middle of each region of size d_i: (19), S_N = Σ f(x_i)·d_i.
pub fn nonuniform(mut f: impl FnMut(f64) -> f64, regions: &Regions) -> Estimate {
    let value = regions.iter().map(|(low, size)| f(low + 0.5 * size) * size).sum();
    Estimate { value, standard_error: None, evaluations: regions.len() as u64 }
}

/// J random points in each region of size d_i (13.7): (19) with the mean of the J values for f(x_i).
///
/// # Errors
/// No point in a region.
pub fn nonuniform_random(
    f: impl FnMut(f64) -> f64,
    regions: &Regions,
    per_region: usize,
    random: impl FnMut() -> f64,
) -> Result<Estimate> {
    in_regions(f, regions.iter(), per_region, random)
}

/// Regions are independent, so their variances add up: Var S = Σ d_i²·s_i²/J, with s_i² known from J ≥ 2 on.
fn in_regions(
    mut f: impl FnMut(f64) -> f64,
    regions: impl Iterator<Item = (f64, f64)>,
    per_region: usize,
    mut random: impl FnMut() -> f64,
) -> Result<Estimate> {
    check_count("point in a region", per_region)?;
    let (mut value, mut variance, mut evaluations) = (0.0, Some(0.0), 0);
    for (low, size) in regions {
        let region = mean(per_region, || size * f(low + size * random()));
        value += region.value;
        variance = variance.zip(region.standard_error).map(|(sum, error)| sum + error * error);
        evaluations += region.evaluations;
    }
    Ok(Estimate { value, standard_error: variance.map(f64::sqrt), evaluations })
}

/// The mean of `n` ≥ 1 values with its standard error, in one pass (Welford 1962), so that a variance of nothing
/// comes out as nothing.
fn mean(n: usize, mut value: impl FnMut() -> f64) -> Estimate {
    let (mut mean, mut squares) = (0.0, 0.0);
    for i in 1..=n {
        let value = value();
        let before = value - mean;
        mean += before / i as f64;
        squares += before * (value - mean);
    }
    let count = n as f64;
    let standard_error = (n >= 2).then(|| (squares / (count - 1.0) / count).sqrt());
    Estimate { value: mean, standard_error, evaluations: n as u64 }
}
