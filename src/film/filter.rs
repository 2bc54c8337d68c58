//! Pixel filters, sampled by importance: a sample's place is drawn from the filter's magnitude, so each counts
//! the same, up to its sign, and touches one pixel (the notes' aside in 13.1, and eq. 20).

use crate::error::{Error, Result, unknown_word_advice};

/// A pixel filter: a product of two equal 1-D functions, centred on the pixel; lengths in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// The pixel's own square: eq. (6) and (11) of the notes.
    Box {
        /// Half the side; 0.5 is the pixel.
        radius: f32,
    },
    /// A tent: falls linearly from the centre.
    Tent {
        /// Where it reaches zero.
        radius: f32,
    },
    /// A Gaussian, cut off at `radius`.
    Gaussian {
        /// Standard deviation.
        sigma: f32,
        /// Where it is cut off.
        radius: f32,
    },
    /// Mitchell and Netravali 1988: sharpens with negative lobes.
    Mitchell {
        /// Half the side of the support.
        radius: f32,
        /// Blur.
        b: f32,
        /// Ringing.
        c: f32,
    },
    /// The four-term window of Blackman and Harris: smooth, nearly a Gaussian that ends.
    BlackmanHarris {
        /// Half the side of the support.
        radius: f32,
    },
}

impl Filter {
    /// Every filter's name in scene files, with what it is.
    pub const NAMES: &'static [(&'static str, &'static str)] = &[
        ("box", "the pixel's own square; radius 0.5"),
        ("tent", "a linear fall to zero at radius 1"),
        ("gaussian", "sigma 0.5, cut off at radius 1.5"),
        ("mitchell", "sharpening, radius 2, b = c = 1/3"),
        ("blackman-harris", "a smooth window of radius 1.5"),
    ];

    /// The filter of that name with its usual parameters.
    pub fn from_name(name: &str) -> Result<Filter> {
        match name {
            "box" => Ok(Filter::Box { radius: 0.5 }),
            "tent" => Ok(Filter::Tent { radius: 1.0 }),
            "gaussian" => Ok(Filter::Gaussian { sigma: 0.5, radius: 1.5 }),
            "mitchell" => Ok(Filter::Mitchell { radius: 2.0, b: 1.0 / 3.0, c: 1.0 / 3.0 }),
            "blackman-harris" => Ok(Filter::BlackmanHarris { radius: 1.5 }),
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
            Filter::Tent { .. } => "tent",
            Filter::Gaussian { .. } => "gaussian",
            Filter::Mitchell { .. } => "mitchell",
            Filter::BlackmanHarris { .. } => "blackman-harris",
        }
    }

    /// The filter's parameters by name, as in scene files.
    pub fn parameters(&self) -> Vec<(&'static str, f32)> {
        match *self {
            Filter::Box { radius } | Filter::Tent { radius } | Filter::BlackmanHarris { radius } => {
                vec![("radius", radius)]
            }
            Filter::Gaussian { sigma, radius } => vec![("sigma", sigma), ("radius", radius)],
            Filter::Mitchell { radius, b, c } => vec![("radius", radius), ("b", b), ("c", c)],
        }
    }

    /// The unnormalised 1-D profile at distance `x`.
    pub fn profile(&self, x: f64) -> f64 {
        let radius = f64::from(self.radius());
        if x.abs() > radius {
            return 0.0;
        }
        match *self {
            Filter::Box { .. } => 1.0,
            Filter::Tent { .. } => 1.0 - x.abs() / radius,
            Filter::Gaussian { sigma, .. } => libm::exp(-0.5 * (x / f64::from(sigma)).powi(2)),
            Filter::Mitchell { b, c, .. } => mitchell(2.0 * x.abs() / radius, f64::from(b), f64::from(c)),
            Filter::BlackmanHarris { .. } => {
                let turn = std::f64::consts::PI * (x / radius + 1.0);
                0.35875 - 0.48829 * libm::cos(turn) + 0.14128 * libm::cos(2.0 * turn)
                    - 0.01168 * libm::cos(3.0 * turn)
            }
        }
    }

    /// Half the side of the support.
    pub fn radius(&self) -> f32 {
        match *self {
            Filter::Box { radius }
            | Filter::Tent { radius }
            | Filter::Gaussian { radius, .. }
            | Filter::Mitchell { radius, .. }
            | Filter::BlackmanHarris { radius } => radius,
        }
    }
}

/// The cubic of Mitchell and Netravali for a support of [−2, 2].
fn mitchell(x: f64, b: f64, c: f64) -> f64 {
    let cubic = if x < 1.0 {
        (12.0 - 9.0 * b - 6.0 * c) * x.powi(3) + (-18.0 + 12.0 * b + 6.0 * c) * x.powi(2) + (6.0 - 2.0 * b)
    } else {
        (-b - 6.0 * c) * x.powi(3)
            + (6.0 * b + 30.0 * c) * x.powi(2)
            + (-12.0 * b - 48.0 * c) * x
            + (8.0 * b + 24.0 * c)
    };
    cubic / 6.0
}

/// Draws offsets from the pixel's centre with the density of the filter's magnitude.
#[derive(Clone, Debug)]
pub struct FilterSampler {
    filter: Filter,
    radius: f32,
    /// ∫|f|/∫f in one dimension, the weight of every sample up to its sign; 1 for filters without one.
    weight: f32,
    /// Support over ∫f in one dimension.
    width_over_integral: f64,
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
            return FilterSampler {
                filter,
                radius,
                weight: 1.0,
                width_over_integral: 1.0,
                inverse: Vec::new(),
            };
        }
        // Trapezoid sums on a fine grid, then the grid point (interpolated) of each equal share.
        let n = 16 * Self::STEPS;
        let x = |i: usize| f64::from(radius) * (2.0 * i as f64 / n as f64 - 1.0);
        let mut sums = vec![0.0f64; n + 1];
        for i in 0..n {
            sums[i + 1] = sums[i] + 0.5 * (filter.profile(x(i)).abs() + filter.profile(x(i + 1)).abs());
        }
        let total = sums[n];
        let signed: f64 = (0..n).map(|i| 0.5 * (filter.profile(x(i)) + filter.profile(x(i + 1)))).sum();
        // Exactly 1 where there is no sign, so that constant pictures stay exact.
        let weight = if total - signed <= 1e-9 * total { 1.0 } else { (total / signed) as f32 };
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
        // The sums are in units of a step.
        let width_over_integral = n as f64 / signed;
        FilterSampler { filter, radius, weight, width_over_integral, inverse: inverse.collect() }
    }

    /// True when samples have signs, so that pixels divide by the sum of weights.
    #[inline(always)]
    pub fn is_signed(&self) -> bool {
        self.weight != 1.0
    }

    /// The weight of a sample at 1-D offset `x`; the mean weight is 1.
    #[inline]
    pub fn weight(&self, x: f32) -> f32 {
        if self.filter.profile(f64::from(x)) < 0.0 { -self.weight } else { self.weight }
    }

    /// Half the side of the support.
    #[inline(always)]
    pub fn radius(&self) -> f32 {
        self.radius
    }

    /// The filter at 1-D offset `x` over its mean over the support: the weight of a point placed without regard
    /// to the filter.
    #[inline]
    pub fn density(&self, x: f32) -> f32 {
        if self.is_box() {
            return 1.0;
        }
        (self.filter.profile(f64::from(x)) * self.width_over_integral) as f32
    }

    /// True of the box, whose offsets are [`FilterSampler::linear`].
    #[inline(always)]
    pub fn is_box(&self) -> bool {
        self.inverse.is_empty()
    }

    /// `u` in [0, 1) over the support.
    #[inline(always)]
    pub fn linear(&self, u: f32) -> f32 {
        (2.0 * u - 1.0) * self.radius
    }

    /// The 1-D offset for `u` in [0, 1).
    #[inline(always)]
    pub fn offset(&self, u: f32) -> f32 {
        if self.is_box() {
            return self.linear(u);
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

    /// Weighted moments of drawn offsets against the same moments of the profile, by quadrature.
    #[test]
    fn offsets_have_the_moments_of_every_filter() {
        for (name, _) in Filter::NAMES {
            let filter = Filter::from_name(name).unwrap();
            let sampler = FilterSampler::new(filter);
            let n = 200_000;
            let r = f64::from(filter.radius());
            let at = |i: usize| r * (2.0 * (i as f64 + 0.5) / n as f64 - 1.0);
            let mass: f64 = (0..n).map(|i| filter.profile(at(i))).sum();
            for power in [0, 1, 2, 4] {
                let exact: f64 =
                    (0..n).map(|i| filter.profile(at(i)) * at(i).powi(power)).sum::<f64>() / mass;
                let one = |i: usize| {
                    let x = sampler.offset((i as f32 + 0.5) / n as f32);
                    f64::from(sampler.weight(x)) * f64::from(x).powi(power)
                };
                let drawn = (0..n).map(one).sum::<f64>() / n as f64;
                assert!(
                    (exact - drawn).abs() < 5e-4 * r.powi(power),
                    "{name}, moment {power}: {drawn} not {exact}"
                );
            }
        }
    }

    #[test]
    fn only_mitchell_has_a_sign() {
        for (name, _) in Filter::NAMES {
            assert_eq!(FilterSampler::new(Filter::from_name(name).unwrap()).is_signed(), *name == "mitchell");
        }
    }
}
