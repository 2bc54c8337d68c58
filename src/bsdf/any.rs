//! A model whose kind is only known at run time, as integrators take it that are not compiled per model.

use super::{Bsdf, Delta, Parameter, Sample, Scatter, View};
use crate::math::{Rgb, Vec3};

macro_rules! of_model {
    ($bsdf:expr, $model:ident => $what:expr) => {
        match $bsdf {
            Bsdf::Diffuse($model) => $what,
            Bsdf::Mirror($model) => $what,
            Bsdf::Conductor($model) => $what,
            Bsdf::Phong($model) => $what,
            Bsdf::Dielectric($model) => $what,
            Bsdf::Translucent($model) => $what,
            Bsdf::OrenNayar($model) => $what,
            Bsdf::Plastic($model) => $what,
            Bsdf::Principled($model) => $what,
        }
    };
}

impl Scatter for Bsdf {
    #[inline(always)]
    fn eval(&self, view: &View, wi: Vec3) -> (Rgb, f32) {
        of_model!(self, model => model.eval(view, wi))
    }

    #[inline(always)]
    fn sample(&self, view: &View, u: [f32; 2], lobe: f32) -> Option<Sample> {
        of_model!(self, model => model.sample(view, u, lobe))
    }

    #[inline(always)]
    fn is_delta(&self) -> bool {
        of_model!(self, model => model.is_delta())
    }

    #[inline(always)]
    fn deltas(&self, view: &View) -> [Option<Delta>; 2] {
        of_model!(self, model => model.deltas(view))
    }

    #[inline(always)]
    fn transmits(&self) -> bool {
        of_model!(self, model => model.transmits())
    }

    #[inline(always)]
    fn set(&mut self, parameter: Parameter, value: Rgb) -> bool {
        of_model!(self, model => model.set(parameter, value))
    }
}
