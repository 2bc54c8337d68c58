//! A thin sheet that scatters light to both sides: paper, leaves, cloth.

use super::{Parameter, Sample, Scatter, View};
use crate::math::warp::{cosine_hemisphere, cosine_hemisphere_pdf};
use crate::math::{Rgb, Vec3, luminance};
use std::f32::consts::FRAC_1_PI;

/// Lambert's law on both sides: a share of the light comes back from the lit side, another leaves the other side,
/// each with the same radiance in all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Translucent {
    reflectance: Rgb,
    transmittance: Rgb,
    /// The two as they were given.
    stated: [Rgb; 2],
    /// Probability with which a sample is reflected.
    reflected: f32,
}

impl Translucent {
    /// Shares per channel in [0, 1]; where the two exceed 1 together, both are scaled down to it.
    pub fn new(reflectance: Rgb, transmittance: Rgb) -> Translucent {
        let stated = [reflectance, transmittance];
        let scale = (reflectance + transmittance).max(Rgb::ONE).recip();
        let (reflectance, transmittance) = (reflectance * scale, transmittance * scale);
        let (r, t) = (luminance(reflectance), luminance(transmittance));
        // A channel may be reflected though luminance hardly sees it.
        let reflected = if r + t > 0.0 { (r / (r + t)).clamp(0.05, 0.95) } else { 0.5 };
        let only = |a: Rgb, b: Rgb| a != Rgb::ZERO && b == Rgb::ZERO;
        let reflected = match (only(reflectance, transmittance), only(transmittance, reflectance)) {
            (true, _) => 1.0,
            (_, true) => 0.0,
            _ => reflected,
        };
        Translucent { reflectance, transmittance, stated, reflected }
    }

    /// The share of light that is not absorbed.
    pub fn albedo(&self) -> Rgb {
        self.reflectance + self.transmittance
    }
}

impl Scatter for Translucent {
    #[inline(always)]
    fn eval(&self, _view: &View, wi: Vec3) -> (Rgb, f32) {
        let (share, chance) = if wi.z > 0.0 {
            (self.reflectance, self.reflected)
        } else {
            (self.transmittance, 1.0 - self.reflected)
        };
        (share * (wi.z.abs() * FRAC_1_PI), chance * cosine_hemisphere_pdf(wi.z.abs()))
    }

    #[inline(always)]
    fn sample(&self, _view: &View, u: [f32; 2], lobe: f32) -> Option<Sample> {
        let wi = cosine_hemisphere(u);
        let (wi, share, chance) = if lobe < self.reflected {
            (wi, self.reflectance, self.reflected)
        } else {
            (Vec3::new(wi.x, wi.y, -wi.z), self.transmittance, 1.0 - self.reflected)
        };
        let pdf = chance * cosine_hemisphere_pdf(wi.z.abs());
        (pdf > 0.0).then(|| Sample { wi, weight: share / chance, pdf })
    }

    #[inline(always)]
    fn is_delta(&self) -> bool {
        false
    }

    #[inline(always)]
    fn transmits(&self) -> bool {
        true
    }

    #[inline(always)]
    fn set(&mut self, parameter: Parameter, value: Rgb) -> bool {
        let value = parameter.clamp(value);
        match parameter {
            Parameter::Reflectance => *self = Translucent::new(value, self.stated[1]),
            Parameter::Transmittance => *self = Translucent::new(self.stated[0], value),
            _ => return false,
        }
        true
    }
}
