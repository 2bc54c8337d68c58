//! A perfect mirror.

use super::{Delta, Parameter, Sample, Scatter, View, reflect};
use crate::math::{Rgb, Vec3};

/// A perfect mirror with constant reflectance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    /// The share of light sent back, per channel in [0, 1], at every angle.
    pub reflectance: Rgb,
}

impl Scatter for Mirror {
    #[inline(always)]
    fn eval(&self, _view: &View, _wi: Vec3) -> (Rgb, f32) {
        (Rgb::ZERO, 0.0)
    }

    #[inline(always)]
    fn sample(&self, view: &View, _u: [f32; 2], _lobe: f32) -> Option<Sample> {
        Some(Sample { wi: reflect(view.wo), weight: self.reflectance, pdf: f32::INFINITY })
    }

    #[inline(always)]
    fn is_delta(&self) -> bool {
        true
    }

    #[inline(always)]
    fn deltas(&self, view: &View) -> [Option<Delta>; 2] {
        [Some(Delta { wi: reflect(view.wo), weight: self.reflectance }), None]
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
