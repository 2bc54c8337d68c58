//! Metals: GGX microfacets that reflect with a constant or a measured reflectance.

use super::energy::{energy, grain_energy};
use super::fresnel::Reflectance;
use super::ggx::{self, SMOOTH};
use super::{Delta, Parameter, Sample, Scatter, View, reflect};
use crate::math::warp::{cosine_hemisphere, cosine_hemisphere_pdf};
use crate::math::{Rgb, Vec2, Vec3};

/// A metal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conductor {
    reflectance: Reflectance,
    /// The reflectance's average over the hemisphere.
    average: Rgb,
    alpha: f32,
    anisotropy: f32,
    /// α along x and y.
    widths: Vec2,
    /// Give back the energy that light scattered more than once between facets carries.
    compensate: bool,
    /// The multiple-scattering lobe's colour over 1 − E_avg (Kulla and Conty 2017).
    multiple: Rgb,
}

impl Conductor {
    /// A metal with GGX width `alpha` = roughness², 0 (a mirror) to 1. `compensate` adds the light that
    /// single scattering loses, so that a perfectly reflecting metal reflects everything.
    pub fn new(reflectance: Reflectance, alpha: f32, compensate: bool) -> Conductor {
        let average = reflectance.average();
        let (anisotropy, widths, multiple) = (0.0, Vec2::splat(alpha), Rgb::ZERO);
        let mut metal = Conductor { reflectance, average, alpha, anisotropy, widths, compensate, multiple };
        metal.balance();
        metal
    }

    /// The metal with another reflectance.
    pub fn with_reflectance(mut self, reflectance: Reflectance) -> Conductor {
        (self.reflectance, self.average) = (reflectance, reflectance.average());
        self.balance();
        self
    }

    /// The metal with or without compensation.
    pub fn with_compensation(mut self, compensate: bool) -> Conductor {
        self.compensate = compensate;
        self.balance();
        self
    }

    /// Sets what depends on the other numbers.
    #[inline(always)]
    fn balance(&mut self) {
        self.widths = ggx::widths(self.alpha, self.anisotropy);
        if self.compensates() {
            let e = if self.anisotropy == 0.0 {
                energy().average(self.alpha)
            } else {
                grain_energy().average(self.widths)
            };
            let f = self.average;
            // F_ms = F²·E_avg / (1 − F·(1 − E_avg)): light that was scattered twice or more.
            self.multiple = f * f * e / ((Rgb::ONE - f * (1.0 - e)) * (1.0 - e).max(1e-6));
        }
    }

    /// The share of light that one scattering keeps on a white metal.
    #[inline(always)]
    fn kept(&self, w: Vec3) -> f32 {
        if self.anisotropy == 0.0 {
            energy().directional(w.z, self.alpha)
        } else {
            grain_energy().directional(w, self.widths)
        }
    }

    /// GGX α.
    pub fn alpha(&self) -> f32 {
        self.alpha
    }

    /// True when it looks different from different sides.
    pub fn is_brushed(&self) -> bool {
        self.anisotropy != 0.0
    }

    /// True when a second lobe gives multiple scattering back.
    pub fn compensates(&self) -> bool {
        self.compensate && self.alpha >= SMOOTH
    }

    /// Average reflectance.
    pub fn albedo(&self) -> Rgb {
        self.average
    }

    /// The share of samples that go to the microfacet lobe.
    #[inline(always)]
    fn single_share(&self, e_o: f32) -> f32 {
        if self.compensates() { e_o.clamp(0.1, 1.0) } else { 1.0 }
    }

    /// (f_cos, pdf) of the microfacet lobe alone.
    #[inline(always)]
    fn single(&self, wo: Vec3, wi: Vec3) -> (Rgb, f32) {
        if wi.z <= 0.0 || wo + wi == Vec3::ZERO {
            return (Rgb::ZERO, 0.0);
        }
        let (m, shape, pdf) = self.facets(wo, wi);
        (self.reflectance.at(wo.dot(m)) * shape, pdf)
    }

    /// The half vector of two directions in front of the surface, f_cos without the reflectance, and pdf.
    #[inline(always)]
    fn facets(&self, wo: Vec3, wi: Vec3) -> (Vec3, f32, f32) {
        let m = (wo + wi).normalize();
        let d = ggx::d(m, self.widths);
        let (lo, li) = (ggx::lambda(wo, self.widths), ggx::lambda(wi, self.widths));
        // f·cos θi = F·D·G2/(4 cos θo); the visible-normal density of wi is D·G1/(4 cos θo).
        let common = d / (4.0 * wo.z);
        (m, common / (1.0 + lo + li), common / (1.0 + lo))
    }
}

impl Scatter for Conductor {
    #[inline(always)]
    fn is_small(&self) -> bool {
        let constant = matches!(self.reflectance, Reflectance::Constant(_));
        constant & !self.compensate & (self.alpha >= SMOOTH)
    }

    #[inline(always)]
    fn eval_small(&self, view: &View, wi: Vec3) -> (Rgb, f32) {
        let (_, shape, pdf) = self.facets(view.wo, wi);
        let some = (wi.z > 0.0) & (pdf >= 0.0);
        // The average of a constant is the constant.
        (if some { self.average * shape } else { Rgb::ZERO }, if some { pdf } else { 0.0 })
    }

    #[inline(always)]
    fn sample_small(&self, view: &View, u: [f32; 2]) -> (Sample, bool) {
        let m = ggx::sample_visible_normal(view.wo, self.widths, u);
        let wi = m * (2.0 * view.wo.dot(m)) - view.wo;
        let (_, shape, pdf) = self.facets(view.wo, wi);
        let sample = Sample { wi, weight: self.average * shape / pdf, pdf };
        (sample, (wi.z > 0.0) & (pdf > 0.0) & pdf.is_finite())
    }

    #[inline(always)]
    fn eval(&self, view: &View, wi: Vec3) -> (Rgb, f32) {
        let wo = view.wo;
        if self.alpha < SMOOTH || wi.z <= 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let (single, single_pdf) = self.single(wo, wi);
        if !self.compensates() {
            return (single, single_pdf);
        }
        let (e_o, e_i) = (self.kept(wo), self.kept(wi));
        let cos_pdf = cosine_hemisphere_pdf(wi.z);
        let multiple = self.multiple * ((1.0 - e_o) * (1.0 - e_i) * cos_pdf);
        let share = self.single_share(e_o);
        (single + multiple, share * single_pdf + (1.0 - share) * cos_pdf)
    }

    #[inline(always)]
    fn sample(&self, view: &View, u: [f32; 2], lobe: f32) -> Option<Sample> {
        let wo = view.wo;
        if self.alpha < SMOOTH {
            let weight = self.reflectance.at(wo.z);
            return Some(Sample { wi: reflect(wo), weight, pdf: f32::INFINITY });
        }
        let single = !self.compensates() || lobe < self.single_share(self.kept(wo));
        let wi = if single {
            let m = ggx::sample_visible_normal(wo, self.widths, u);
            m * (2.0 * wo.dot(m)) - wo
        } else {
            cosine_hemisphere(u)
        };
        if wi.z <= 0.0 {
            return None;
        }
        self.towards(view, wi)
    }

    #[inline(always)]
    fn is_delta(&self) -> bool {
        self.alpha < SMOOTH
    }

    #[inline(always)]
    fn deltas(&self, view: &View) -> [Option<Delta>; 2] {
        let mirror = || Delta { wi: reflect(view.wo), weight: self.reflectance.at(view.wo.z) };
        [self.is_delta().then(mirror), None]
    }

    #[inline(always)]
    fn set(&mut self, parameter: Parameter, value: Rgb) -> bool {
        let value = parameter.clamp(value);
        match parameter {
            Parameter::Reflectance => {
                self.reflectance = Reflectance::Constant(value);
                self.average = value;
            }
            Parameter::Roughness => self.alpha = value.x * value.x,
            Parameter::Alpha => self.alpha = value.x,
            Parameter::Anisotropy => self.anisotropy = value.x,
            _ => return false,
        }
        self.balance();
        true
    }
}
