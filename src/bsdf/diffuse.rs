//! Lambert's law: f = ρ/π.

use super::{Parameter, Sample, Scatter, View};
use crate::math::warp::{cosine_hemisphere, cosine_hemisphere_pdf};
use crate::math::{Rgb, Vec3};
use std::f32::consts::FRAC_1_PI;

/// A diffuse reflector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Diffuse {
    /// ρ, the share of light sent back, per channel in [0, 1].
    pub reflectance: Rgb,
}

impl Scatter for Diffuse {
    #[inline(always)]
    fn is_small(&self) -> bool {
        true
    }

    #[inline(always)]
    fn eval(&self, _view: &View, wi: Vec3) -> (Rgb, f32) {
        // Zero behind the surface: light does not pass.
        let pdf = cosine_hemisphere_pdf(wi.z);
        (self.reflectance * pdf, pdf)
    }

    #[inline(always)]
    fn sample(&self, _view: &View, u: [f32; 2], _lobe: f32) -> Option<Sample> {
        let wi = cosine_hemisphere(u);
        // f·cos/pdf = (ρ/π)·cos/(cos/π): importance sampling (eq. 20) leaves ρ alone.
        Some(Sample { wi, weight: self.reflectance, pdf: wi.z * FRAC_1_PI })
    }

    #[inline(always)]
    fn is_delta(&self) -> bool {
        false
    }

    #[inline(always)]
    fn set(&mut self, parameter: Parameter, value: Rgb) -> bool {
        let value = parameter.clamp(value);
        match parameter {
            Parameter::Reflectance => self.reflectance = value,
            _ => return false,
        }
        true
    }
}
