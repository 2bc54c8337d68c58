//! Densities on [0, D] to draw points from (13.8): the density and the inverse of its distribution side by side.

use super::check_domain;
use crate::error::{Error, Result};
use std::f64::consts::{FRAC_1_SQRT_2, PI};

/// A probability density p on [0, D].
pub trait Density {
    /// p(x) for x in [0, D].
    fn pdf(&self, x: f64) -> f64;

    /// 1/p(x); its own function because 1/(1/D) need not be D in floating point.
    fn reciprocal(&self, x: f64) -> f64 {
        1.0 / self.pdf(x)
    }

    /// The x below which the share `u` in [0, 1] of the probability lies; 0 for 0 and D for 1.
    fn inverse(&self, u: f64) -> f64;
}

/// p = 1/D, with which (20) is simple Monte Carlo (10).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Uniform {
    d: f64,
}

impl Uniform {
    /// Uniform over [0, `d`].
    ///
    /// # Errors
    /// No domain.
    pub fn new(d: f64) -> Result<Uniform> {
        check_domain(d)?;
        Ok(Uniform { d })
    }
}

impl Density for Uniform {
    fn pdf(&self, _x: f64) -> f64 {
        1.0 / self.d
    }

    fn reciprocal(&self, _x: f64) -> f64 {
        self.d
    }

    fn inverse(&self, u: f64) -> f64 {
        self.d * u
    }
}

/// A Gaussian around the place that is expected to contribute most (13.8), cut off at 0 and D.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaussian {
    d: f64,
    centre: f64,
    sigma: f64,
    /// Normal distribution below 0 and above D, in units of σ from the centre.
    outside: (f64, f64),
}

impl Gaussian {
    /// A Gaussian of standard deviation `sigma` around `centre` in [0, `d`].
    ///
    /// # Errors
    /// No domain, a centre outside it, or a σ that is not positive.
    pub fn new(d: f64, centre: f64, sigma: f64) -> Result<Gaussian> {
        check_domain(d)?;
        if !(0.0..=d).contains(&centre) {
            return Err(Error::new(format!("the Gaussian's centre {centre} lies outside [0, {d}]")));
        }
        if !(sigma.is_finite() && sigma > 0.0) {
            return Err(Error::new(format!("the Gaussian's σ must be positive, not {sigma}")));
        }
        let outside = (normal_below(-centre / sigma), normal_below((centre - d) / sigma));
        Ok(Gaussian { d, centre, sigma, outside })
    }
}

impl Density for Gaussian {
    fn pdf(&self, x: f64) -> f64 {
        let z = (x - self.centre) / self.sigma;
        let inside = 1.0 - self.outside.0 - self.outside.1;
        libm::exp(-0.5 * z * z) / (self.sigma * (2.0 * PI).sqrt() * inside)
    }

    fn inverse(&self, u: f64) -> f64 {
        // The ends are known; through the tails they would be infinitely far away.
        if u <= 0.0 || u >= 1.0 {
            return if u <= 0.0 { 0.0 } else { self.d };
        }
        let (below, above) = self.outside;
        let inside = 1.0 - below - above;
        // Each half from its own tail: near 1 a probability has few digits left.
        let (low, high) = (below + u * inside, above + (1.0 - u) * inside);
        let z = if low <= high { normal_quantile(low) } else { -normal_quantile(high) };
        (self.centre + self.sigma * z).clamp(0.0, self.d)
    }
}

/// The standard normal distribution function Φ(z).
fn normal_below(z: f64) -> f64 {
    0.5 * libm::erfc(-z * FRAC_1_SQRT_2)
}

/// Φ⁻¹(p) for p in (0, ½]: Abramowitz and Stegun's 26.2.23, good to 4.5e-4, and two of Halley's steps, each of
/// which triples the number of good digits.
fn normal_quantile(p: f64) -> f64 {
    let p = p.max(f64::MIN_POSITIVE);
    let t = (-2.0 * libm::log(p)).sqrt();
    let ratio = ((0.010_328 * t + 0.802_853) * t + 2.515_517)
        / (((0.001_308 * t + 0.189_269) * t + 1.432_788) * t + 1.0);
    let mut z = ratio - t;
    for _ in 0..2 {
        let newton = (normal_below(z) - p) * (2.0 * PI).sqrt() * libm::exp(0.5 * z * z);
        z -= newton / (1.0 + 0.5 * z * newton);
    }
    z
}

/// p ∝ e^(−r·x): the perfect density for an exponential integrand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exponential {
    d: f64,
    rate: f64,
    /// 1 − e^(−r·D).
    mass: f64,
}

impl Exponential {
    /// Falling with `rate` r > 0 over [0, `d`].
    ///
    /// # Errors
    /// No domain, or a rate that is not positive.
    pub fn new(d: f64, rate: f64) -> Result<Exponential> {
        check_domain(d)?;
        if !(rate.is_finite() && rate > 0.0) {
            return Err(Error::new(format!("the exponential's rate must be positive, not {rate}")));
        }
        Ok(Exponential { d, rate, mass: -libm::expm1(-rate * d) })
    }
}

impl Density for Exponential {
    fn pdf(&self, x: f64) -> f64 {
        self.rate * libm::exp(-self.rate * x) / self.mass
    }

    fn inverse(&self, u: f64) -> f64 {
        if u >= 1.0 {
            return self.d;
        }
        (-libm::log1p(-u * self.mass) / self.rate).clamp(0.0, self.d)
    }
}

/// A density given at some places, straight between them; two knots at one place make a step.
#[derive(Clone, Debug, PartialEq)]
pub struct PiecewiseLinear {
    /// (x, p(x)), normalised.
    knots: Vec<(f64, f64)>,
    /// The probability up to each knot; 0 at the first, 1 at the last.
    below: Vec<f64>,
}

impl PiecewiseLinear {
    /// Through `knots` (x, weight), with x from 0 to D in rising order and weights of any scale.
    ///
    /// # Errors
    /// Places out of order or not from 0 on, a weight below zero, or weights that are all zero.
    pub fn new(knots: &[(f64, f64)]) -> Result<PiecewiseLinear> {
        let ordered = knots.windows(2).all(|pair| pair[0].0 <= pair[1].0);
        let finite = knots.iter().all(|(x, weight)| x.is_finite() && weight.is_finite() && *weight >= 0.0);
        if !(ordered && finite && knots.first().is_some_and(|first| first.0 == 0.0)) {
            return Err(Error::new("knots must rise from 0, with weights that are not negative"));
        }
        let area = |pair: &[(f64, f64)]| 0.5 * (pair[0].1 + pair[1].1) * (pair[1].0 - pair[0].0);
        let total: f64 = knots.windows(2).map(area).sum();
        if !(total.is_finite() && total > 0.0) {
            return Err(Error::new("the weights between the knots add up to nothing"));
        }
        let mut below = vec![0.0];
        let mut sum = 0.0;
        for pair in knots.windows(2) {
            sum += area(pair);
            below.push(sum / total);
        }
        Ok(PiecewiseLinear { knots: knots.iter().map(|(x, weight)| (*x, weight / total)).collect(), below })
    }

    /// The two knots around piece `i`.
    fn piece(&self, i: usize) -> [(f64, f64); 2] {
        let i = i.clamp(1, self.knots.len() - 1);
        [self.knots[i - 1], self.knots[i]]
    }
}

impl Density for PiecewiseLinear {
    fn pdf(&self, x: f64) -> f64 {
        let [(x0, p0), (x1, p1)] = self.piece(self.knots.partition_point(|knot| knot.0 <= x));
        if x1 > x0 { p0 + (p1 - p0) * ((x - x0) / (x1 - x0)) } else { p1 }
    }

    fn inverse(&self, u: f64) -> f64 {
        // The ends by themselves: where the density is 0 the distribution's inverse has a jump.
        if u <= 0.0 || u >= 1.0 {
            return if u <= 0.0 { 0.0 } else { self.knots.last().map_or(0.0, |knot| knot.0) };
        }
        let i = self.below.partition_point(|share| *share <= u);
        let [(x0, p0), (x1, p1)] = self.piece(i);
        let width = x1 - x0;
        let rest = u - self.below[i.clamp(1, self.knots.len() - 1) - 1];
        // p0·s + (p1 − p0)·s²/(2·width) = rest, solved without subtracting like from like.
        let root = (p0 * p0 + 2.0 * (p1 - p0) / width * rest).max(0.0).sqrt();
        let s = if p0 + root > 0.0 { 2.0 * rest / (p0 + root) } else { 0.0 };
        x0 + s.clamp(0.0, width)
    }
}
