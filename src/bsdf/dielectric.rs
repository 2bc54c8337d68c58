//! A smooth boundary between air and a clear dielectric.

use super::fresnel;
use super::{Delta, Parameter, Sample, Scatter, View, reflect};
use crate::math::{Rgb, Vec3};

/// Clear glass, water, diamond: reflects by Fresnel's formula and refracts the rest by Snell's law. The body
/// is on the side that `ng` points away from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// Index of refraction of the inside relative to the outside, > 0; 1.5 is window glass.
    pub ior: f32,
    /// What is left of the light that passes the boundary, per channel in [0, 1].
    pub tint: Rgb,
}

impl Scatter for Dielectric {
    #[inline(always)]
    fn eval(&self, _view: &View, _wi: Vec3) -> (Rgb, f32) {
        (Rgb::ZERO, 0.0)
    }

    #[inline(always)]
    fn sample(&self, view: &View, _u: [f32; 2], lobe: f32) -> Option<Sample> {
        let (reflectance, refracted) = self.split(view);
        if lobe < reflectance {
            return Some(Sample { wi: reflect(view.wo), weight: Rgb::ONE, pdf: f32::INFINITY });
        }
        Some(Sample { wi: refracted.wi, weight: refracted.weight, pdf: f32::INFINITY })
    }

    #[inline(always)]
    fn is_delta(&self) -> bool {
        true
    }

    #[inline(always)]
    fn deltas(&self, view: &View) -> [Option<Delta>; 2] {
        let (reflectance, refracted) = self.split(view);
        let reflected = Delta { wi: reflect(view.wo), weight: Rgb::splat(reflectance) };
        let through = Delta { weight: refracted.weight * (1.0 - reflectance), ..refracted };
        [Some(reflected), (reflectance < 1.0).then_some(through)]
    }

    #[inline(always)]
    fn set(&mut self, parameter: Parameter, value: Rgb) -> bool {
        let value = parameter.clamp(value);
        match parameter {
            Parameter::Ior => self.ior = value.x,
            Parameter::Tint => self.tint = value,
            _ => return false,
        }
        true
    }
}

impl Dielectric {
    /// Fresnel's reflectance, and the refracted direction with its weight where light is refracted at all.
    #[inline(always)]
    fn split(&self, view: &View) -> (f32, Delta) {
        let eta = if view.outside { self.ior } else { 1.0 / self.ior };
        let (reflectance, cos_t) = fresnel::dielectric(view.wo.z, eta);
        let wi = Vec3::new(-view.wo.x / eta, -view.wo.y / eta, -cos_t).normalize();
        // Radiance is spread over a solid angle that changes by η² (pbrt 4th ed., 9.5.2).
        (reflectance, Delta { wi, weight: self.tint / (eta * eta) })
    }
}
