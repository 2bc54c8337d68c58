//! The notes' rules of integration over [0, D], as formulas that can be called; those for the hemisphere are in
//! [`hemisphere`].
//!
//! S = ∫₀ᴰ f(x) dx (7) is estimated by S_N from N evaluations of f (8). Every rule here takes the integrand, says
//! what it needs besides, and returns an [`Estimate`]; what is random comes from a closure that gives numbers in
//! [0, 1), so that a test or a figure can use the same numbers twice. Everything is f64.
//!
//! | rule | in the notes | error falls as (smooth f) |
//! |---|---|---|
//! | [`midpoints`] | (8) | N⁻² |
//! | [`left_edges`] | (12), (13) in one dimension | N⁻¹ |
//! | [`monte_carlo`] | (10) | N^−½ |
//! | [`stratified`] | 13.6 | N^−3⁄2, with a step in f: N⁻¹ |
//! | [`nonuniform`] | (19) | N⁻² |
//! | [`nonuniform_random`] | 13.7, J points in each of (19)'s regions | N^−3⁄2 |
//! | [`importance`] | (20) | N^−½, times a factor that the density decides; 0 for the perfect one |

mod density;
mod fan;
pub mod hemisphere;
mod one_d;
mod regions;
#[cfg(test)]
mod tests;

pub use density::{Density, Exponential, Gaussian, PiecewiseLinear, Uniform};
pub use one_d::{importance, left_edges, midpoints, monte_carlo, nonuniform, nonuniform_random, stratified};
pub use regions::Regions;

use crate::error::{Error, Result};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// What a rule says of an integral.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// S_N.
    pub value: f64,
    /// The estimated standard deviation of `value` over other random numbers. `None` for rules without any and
    /// where it is not defined: one point, or one point a region.
    pub standard_error: Option<f64>,
    /// How often the integrand was evaluated; in a ray tracer each time costs a ray.
    pub evaluations: u64,
}

/// Refuses a domain [0, D] that is none.
pub(crate) fn check_domain(d: f64) -> Result<()> {
    if d.is_finite() && d > 0.0 {
        return Ok(());
    }
    Err(Error::new(format!("the domain [0, {d}] has no length")))
}

/// Refuses a count of nothing.
pub(crate) fn check_count(what: &str, n: usize) -> Result<()> {
    if n > 0 { Ok(()) } else { Err(Error::new(format!("at least one {what} is needed"))) }
}

/// Independent numbers in [0, 1) with 53 bits, a function of `seed` and `stream` alone.
pub fn numbers(seed: u64, stream: u64) -> impl FnMut() -> f64 {
    let mut key = [0; 32];
    key[..8].copy_from_slice(&seed.to_le_bytes());
    key[8..16].copy_from_slice(&stream.to_le_bytes());
    let mut rng = ChaCha8Rng::from_seed(key);
    move || (rng.next_u64() >> 11) as f64 * (1.0 / 9_007_199_254_740_992.0)
}
