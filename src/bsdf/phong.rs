//! Phong's model in the form that keeps energy: f = ρd/π + ρs·(n+2)/(2π)·cosⁿα, α the angle between wi and the
//! mirror direction of wo (Lafortune and Willems 1994).

use super::{Parameter, Sample, Scatter, View, reflect};
use crate::math::approx::sin_cos_turn;
use crate::math::warp::{cosine_hemisphere, cosine_hemisphere_pdf};
use crate::math::{Frame, Rgb, Vec3};
use std::f32::consts::{FRAC_1_PI, TAU};

/// A diffuse base with a highlight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phong {
    diffuse: Rgb,
    specular: Rgb,
    exponent: f32,
    /// ρd and ρs as they were given.
    stated: [Rgb; 2],
    /// The share of samples that go to the diffuse base.
    diffuse_share: f32,
}

impl Phong {
    /// ρd, ρs (each in [0, 1] per channel) and n ≥ 0. Energy-limited: where ρd + ρs exceeds 1 in some channel,
    /// both are scaled down so that it is 1 there, which bounds the albedo at every angle.
    pub fn new(diffuse: Rgb, specular: Rgb, exponent: f32) -> Phong {
        let stated = [diffuse, specular];
        let scale = 1.0 / (diffuse + specular).max_element().max(1.0);
        let (diffuse, specular) = (diffuse * scale, specular * scale);
        let (d, s) = (diffuse.max_element(), specular.max_element());
        let diffuse_share = if d + s > 0.0 { d / (d + s) } else { 1.0 };
        Phong { diffuse, specular, exponent, stated, diffuse_share }
    }

    /// ρd + ρs after the limit.
    pub fn albedo(&self) -> Rgb {
        self.diffuse + self.specular
    }

    /// cosⁿα, zero beyond 90° (where 0⁰ would make it 1).
    #[inline(always)]
    fn lobe(&self, wo: Vec3, wi: Vec3) -> f32 {
        let cos = reflect(wo).dot(wi);
        if cos > 0.0 { libm::powf(cos.min(1.0), self.exponent) } else { 0.0 }
    }
}

impl Scatter for Phong {
    #[inline(always)]
    fn eval(&self, view: &View, wi: Vec3) -> (Rgb, f32) {
        if wi.z <= 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let lobe = self.lobe(view.wo, wi);
        let f = self.diffuse * FRAC_1_PI + self.specular * ((self.exponent + 2.0) / TAU * lobe);
        let lobe_pdf = (self.exponent + 1.0) / TAU * lobe;
        let pdf = self.diffuse_share * cosine_hemisphere_pdf(wi.z) + (1.0 - self.diffuse_share) * lobe_pdf;
        (f * wi.z, pdf)
    }

    #[inline(always)]
    fn sample(&self, view: &View, u: [f32; 2], lobe: f32) -> Option<Sample> {
        let wi = if lobe < self.diffuse_share {
            cosine_hemisphere(u)
        } else {
            // Density (n+1)/(2π)·cosⁿα around the mirror direction: cos α = (1−u)^(1/(n+1)).
            let cos = libm::powf(1.0 - u[0], 1.0 / (self.exponent + 1.0));
            let sin = (1.0 - cos * cos).max(0.0).sqrt();
            let (s, c) = sin_cos_turn(u[1]);
            Frame::new(reflect(view.wo)).to_world(Vec3::new(sin * c, sin * s, cos))
        };
        if wi.z <= 0.0 {
            return None; // this part of the lobe lies below the horizon
        }
        self.towards(view, wi)
    }

    #[inline(always)]
    fn is_delta(&self) -> bool {
        false
    }

    #[inline(always)]
    fn set(&mut self, parameter: Parameter, value: Rgb) -> bool {
        let value = parameter.clamp(value);
        match parameter {
            Parameter::Diffuse => *self = Phong::new(value, self.stated[1], self.exponent),
            Parameter::Specular => *self = Phong::new(self.stated[0], value, self.exponent),
            Parameter::Exponent => self.exponent = value.x,
            _ => return false,
        }
        true
    }
}
