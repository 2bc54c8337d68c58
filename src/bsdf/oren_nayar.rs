//! Rough matte surfaces: Oren and Nayar's law in the form of Fujii with the energy of interreflection given back
//! (Portsmouth, Kutz and Hill 2024, "EON"): reciprocal, with a known albedo, and white where ρ is 1.

use super::{Parameter, Sample, Scatter, View};
use crate::math::approx::sin_cos_turn;
use crate::math::warp::{cosine_hemisphere, cosine_hemisphere_pdf};
use crate::math::{Rgb, Vec3};
use std::f32::consts::{FRAC_1_PI, TAU};

/// A rough diffuse reflector.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OrenNayar {
    reflectance: Rgb,
    roughness: f32,
    /// A_F = 1/(1 + (½ − 2/(3π))·r), which makes single scattering lose the right share.
    scale: f32,
    /// The interreflection's colour over 1 − E_avg.
    multiple: Rgb,
}

impl OrenNayar {
    /// `reflectance` in [0, 1] per channel, `roughness` from 0 (Lambert's law) to 1.
    pub fn new(reflectance: Rgb, roughness: f32) -> OrenNayar {
        let scale = 1.0 / (1.0 + (0.5 - 2.0 / 3.0 * FRAC_1_PI) * roughness);
        let average = scale * (1.0 + (2.0 / 3.0 - 28.0 / 15.0 * FRAC_1_PI) * roughness);
        // ρ²·E_avg/(1 − ρ(1 − E_avg)): what meets the surface twice or more, as of GGX's facets.
        let lost = 1.0 - average;
        let colour = reflectance * reflectance * average / (Rgb::ONE - reflectance * lost);
        OrenNayar { reflectance, roughness, scale, multiple: colour / lost.max(1e-6) }
    }

    /// ρ.
    pub fn albedo(&self) -> Rgb {
        self.reflectance
    }

    /// E(μ), the directional albedo of single scattering for ρ = 1:
    /// A_F·(1 + r/π·(sinθ(θ − sinθcosθ) + ⅔(tanθ(1 − sin³θ) − sinθ))).
    fn directional(&self, mu: f32) -> f32 {
        let mu = mu.clamp(0.0, 1.0);
        let s = (1.0 - mu * mu).sqrt();
        // tanθ(1 − sin³θ) without its 0/0 at the horizon: 1 − s = μ²/(1 + s).
        let tangent = s * mu * (1.0 + s + s * s) / (1.0 + s);
        let g = s * (libm::acosf(mu) - s * mu) + 2.0 / 3.0 * (tangent - s);
        self.scale * (1.0 + self.roughness * FRAC_1_PI * g)
    }

    /// The share of uniform samples: the cosine alone meets the horizon, where a rough surface seen from there is
    /// brightest, too seldom.
    #[inline(always)]
    fn uniform_share(&self, mu: f32) -> f32 {
        0.4 * self.roughness * (1.0 - mu)
    }
}

impl Scatter for OrenNayar {
    fn eval(&self, view: &View, wi: Vec3) -> (Rgb, f32) {
        let wo = view.wo;
        if wi.z <= 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        // s = sinθo·sinθi·cos(φo − φi); Fujii divides it by the larger cosine where it is positive.
        let s = wo.x * wi.x + wo.y * wi.y;
        let s = if s > 0.0 { s / wo.z.max(wi.z) } else { s };
        let single = self.reflectance * (self.scale * (1.0 + self.roughness * s));
        let lost = (1.0 - self.directional(wo.z)) * (1.0 - self.directional(wi.z));
        let cos_pdf = cosine_hemisphere_pdf(wi.z);
        let uniform = self.uniform_share(wo.z);
        ((single + self.multiple * lost.max(0.0)) * cos_pdf, (1.0 - uniform) * cos_pdf + uniform / TAU)
    }

    fn sample(&self, view: &View, u: [f32; 2], lobe: f32) -> Option<Sample> {
        let wi = if lobe < self.uniform_share(view.wo.z) {
            let z = 1.0 - u[0];
            let r = (1.0 - z * z).max(0.0).sqrt();
            let (sin, cos) = sin_cos_turn(u[1]);
            Vec3::new(r * cos, r * sin, z)
        } else {
            cosine_hemisphere(u)
        };
        let (f_cos, pdf) = self.eval(view, wi);
        (pdf > 0.0).then(|| Sample { wi, weight: f_cos / pdf, pdf })
    }

    #[inline(always)]
    fn is_delta(&self) -> bool {
        false
    }

    fn set(&mut self, parameter: Parameter, value: Rgb) -> bool {
        let value = parameter.clamp(value);
        match parameter {
            Parameter::Reflectance => *self = OrenNayar::new(value, self.roughness),
            Parameter::Roughness => *self = OrenNayar::new(self.reflectance, value.x),
            _ => return false,
        }
        true
    }
}
