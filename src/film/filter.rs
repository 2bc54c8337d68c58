//! Pixel filters, sampled by importance: a sample's place is drawn from the filter itself, so each counts
//! the same and touches one pixel (the notes' aside in 13.1, and eq. 20).

use crate::error::{Error, Result, unknown_word_advice};

/// A pixel filter: a product of two equal 1-D functions, centred on the pixel; lengths in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// The pixel's own square: eq. (6) and (11) of the notes.
    Box {
        /// Half the side; 0.5 is the pixel.
        radius: f32,
    },
    /// A Gaussian, cut off at `radius`.
    Gaussian {
        /// Standard deviation.
        sigma: f32,
        /// Where it is cut off.
        radius: f32,
    },
}

impl Filter {
    /// Every filter's name in scene files, with what it is.
    pub const NAMES: &'static [(&'static str, &'static str)] = &[
        ("box", "the pixel's own square; radius 0.5"),
        ("gaussian", "sigma 0.5, cut off at radius 1.5"),
    ];

    /// The filter of that name with its usual parameters.
    pub fn from_name(name: &str) -> Result<Filter> {
        match name {
            "box" => Ok(Filter::Box { radius: 0.5 }),
            "gaussian" => Ok(Filter::Gaussian { sigma: 0.5, radius: 1.5 }),
            _ => {
                let known: Vec<&str> = Self::NAMES.iter().map(|n| n.0).collect();
                Err(Error::usage(format!("unknown filter \"{name}\""))
                    .advise(unknown_word_advice(name, &known)))
            }
        }
    }

    /// The filter's name.
    pub fn name(&self) -> &'static str {
        match self {
            Filter::Box { .. } => "box",
            Filter::Gaussian { .. } => "gaussian",
        }
    }

    /// The unnormalised 1-D profile at distance `x`.
    pub fn profile(&self, x: f64) -> f64 {
        match *self {
            Filter::Box { radius } => f64::from(u8::from(x.abs() <= f64::from(radius))),
            Filter::Gaussian { sigma, radius } if x.abs() <= f64::from(radius) => {
                libm::exp(-0.5 * (x / f64::from(sigma)).powi(2))
            }
            Filter::Gaussian { .. } => 0.0,
        }
    }

    /// Half the side of the support.
    pub fn radius(&self) -> f32 {
        match *self {
            Filter::Box { radius } | Filter::Gaussian { radius, .. } => radius,
        }
    }
}

/// Draws offsets from the pixel's centre with the filter's density.
#[derive(Clone, Debug)]
pub struct FilterSampler {
    radius: f32,
    /// The inverse of the 1-D cumulative distribution at equal steps; empty for the box, which is linear.
    inverse: Vec<f32>,
}

impl FilterSampler {
    /// Steps of the inverse; linear between them, which keeps the moments to some 1e-7.
    const STEPS: usize = 2048;

    /// Tabulates `filter`.
    pub fn new(filter: Filter) -> FilterSampler {
        let radius = filter.radius();
        if let Filter::Box { .. } = filter {
            return FilterSampler { radius, inverse: Vec::new() };
        }
        // Trapezoid sums on a fine grid, then the grid point (interpolated) of each equal share.
        let n = 16 * Self::STEPS;
        let x = |i: usize| f64::from(radius) * (2.0 * i as f64 / n as f64 - 1.0);
        let mut sums = vec![0.0f64; n + 1];
        for i in 0..n {
            sums[i + 1] = sums[i] + 0.5 * (filter.profile(x(i)) + filter.profile(x(i + 1)));
        }
        let total = sums[n];
        let mut at = 0;
        let inverse = (0..=Self::STEPS).map(|k| {
            let target = total * k as f64 / Self::STEPS as f64;
            while at + 1 < n && sums[at + 1] < target {
                at += 1;
            }
            let step = sums[at + 1] - sums[at];
            let t = if step > 0.0 { ((target - sums[at]) / step).clamp(0.0, 1.0) } else { 0.0 };
            (x(at) + (x(at + 1) - x(at)) * t) as f32
        });
        FilterSampler { radius, inverse: inverse.collect() }
    }

    /// The 1-D offset for `u` in [0, 1).
    #[inline(always)]
    pub fn offset(&self, u: f32) -> f32 {
        if self.inverse.is_empty() {
            return (2.0 * u - 1.0) * self.radius;
        }
        let x = u * Self::STEPS as f32;
        let i = (x as usize).min(Self::STEPS - 1);
        let (a, b) = (self.inverse[i], self.inverse[i + 1]);
        a + (b - a) * (x - i as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Moments of drawn offsets against the same moments of the profile, by quadrature.
    #[test]
    fn offsets_have_the_moments_of_every_filter() {
        for (name, _) in Filter::NAMES {
            let filter = Filter::from_name(name).unwrap();
            let sampler = FilterSampler::new(filter);
            let n = 200_000;
            let r = f64::from(filter.radius());
            let at = |i: usize| r * (2.0 * (i as f64 + 0.5) / f64::from(n) - 1.0);
            let mass: f64 = (0..n as usize).map(|i| filter.profile(at(i))).sum();
            for power in [1, 2, 4] {
                let exact: f64 =
                    (0..n as usize).map(|i| filter.profile(at(i)) * at(i).powi(power)).sum::<f64>() / mass;
                let drawn: f64 = (0..n)
                    .map(|i| f64::from(sampler.offset((i as f32 + 0.5) / n as f32)).powi(power))
                    .sum::<f64>()
                    / f64::from(n);
                assert!((exact - drawn).abs() < 2e-6, "{name}, moment {power}: {drawn} not {exact}");
            }
        }
    }
}
