//! A clear coat over a diffuse base: plastic, varnish, glazed clay.
//!
//! What the coat reflects follows Fresnel's formula, smooth or through GGX. The rest, T(μ) = 1 − E(μ), enters,
//! scatters in the base, and leaves through the coat again or is reflected back into the base:
//! f = T(o)·T(i)·ρ/(π·η²·(1 − ρ'·F_in)), where F_in = 1 − T_avg/η² is the coat's mean reflectance from inside. With
//! ρ' = ρ the base colours the light each time (`nonlinear`), with ρ' = 1 once, so that ρ is the colour that is seen
//! (the two forms of Mitsuba's `plastic`). Both are reciprocal, and white where ρ is 1: what single scattering off the
//! rough coat loses goes to the base.

use super::coat::Coat;
use super::{Delta, Parameter, Sample, Scatter, View, reflect};
use crate::math::warp::{cosine_hemisphere, cosine_hemisphere_pdf};
use crate::math::{Rgb, Vec3};

/// A coated diffuse reflector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plastic {
    reflectance: Rgb,
    coat: Coat,
    nonlinear: bool,
    /// ρ/(η²·(1 − ρ'·F_in)).
    base: Rgb,
    /// The base's albedo for light that has entered.
    inner: f32,
}

impl Plastic {
    /// ρ of the base in [0, 1] per channel, the coat's index of refraction (1.5 is usual; one below 1 is taken as
    /// 1/`ior`), and its GGX width.
    pub fn new(reflectance: Rgb, ior: f32, alpha: f32) -> Plastic {
        let mut plastic = Plastic {
            reflectance,
            coat: Coat::new(ior, alpha),
            nonlinear: false,
            base: Rgb::ZERO,
            inner: 0.0,
        };
        plastic.balance();
        plastic
    }

    /// The same with or without the base's colour taken at every reflection under the coat.
    pub fn with_nonlinear(mut self, nonlinear: bool) -> Plastic {
        self.nonlinear = nonlinear;
        self.balance();
        self
    }

    /// The base's reflectance.
    pub fn albedo(&self) -> Rgb {
        self.reflectance
    }

    fn balance(&mut self) {
        let average = 1.0 - self.coat.reflected_average();
        // η²·(1 − ρ'·F_in) = η²·(1 − ρ') + ρ'·T_avg.
        let again = if self.nonlinear { self.reflectance } else { Rgb::ONE };
        let kept = (Rgb::ONE - again) * (self.coat.ior() * self.coat.ior()) + again * average.max(1e-6);
        self.base = self.reflectance / kept;
        self.inner = self.base.max_element() * average;
    }

    /// The share of samples that go to the coat, which reflects `e_o`.
    #[inline(always)]
    fn coat_share(&self, e_o: f32) -> f32 {
        let inner = (1.0 - e_o) * self.inner;
        let share = e_o / (e_o + inner).max(1e-6);
        if inner == 0.0 { 1.0 } else { share.clamp(0.05, 0.95) }
    }
}

impl Scatter for Plastic {
    fn eval(&self, view: &View, wi: Vec3) -> (Rgb, f32) {
        let wo = view.wo;
        if wi.z <= 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let (e_o, e_i) = (self.coat.reflected(wo.z), self.coat.reflected(wi.z));
        let share = self.coat_share(e_o);
        let cos_pdf = cosine_hemisphere_pdf(wi.z);
        let base = self.base * ((1.0 - e_o) * (1.0 - e_i) * cos_pdf);
        let (coat, coat_pdf) = self.coat.eval(wo, wi);
        (base + Rgb::splat(coat), (1.0 - share) * cos_pdf + share * coat_pdf)
    }

    fn sample(&self, view: &View, u: [f32; 2], lobe: f32) -> Option<Sample> {
        let wo = view.wo;
        let e_o = self.coat.reflected(wo.z);
        let share = self.coat_share(e_o);
        let wi = if lobe >= share {
            cosine_hemisphere(u)
        } else if self.coat.is_smooth() {
            let weight = Rgb::splat(e_o / share);
            return Some(Sample { wi: reflect(wo), weight, pdf: f32::INFINITY });
        } else {
            self.coat.sample(wo, u)
        };
        if wi.z <= 0.0 {
            return None;
        }
        self.towards(view, wi)
    }

    #[inline(always)]
    fn is_delta(&self) -> bool {
        self.coat.is_smooth() && self.inner == 0.0
    }

    fn deltas(&self, view: &View) -> [Option<Delta>; 2] {
        let weight = || Rgb::splat(self.coat.reflected(view.wo.z));
        [self.coat.is_smooth().then(|| Delta { wi: reflect(view.wo), weight: weight() }), None]
    }

    fn set(&mut self, parameter: Parameter, value: Rgb) -> bool {
        let value = parameter.clamp(value);
        match parameter {
            Parameter::Reflectance => self.reflectance = value,
            Parameter::Roughness => self.coat.alpha = value.x * value.x,
            Parameter::Alpha => self.coat.alpha = value.x,
            Parameter::Ior => self.coat = Coat::new(value.x, self.coat.alpha),
            _ => return false,
        }
        self.balance();
        true
    }
}
