//! A clear coat: what an interface reflects by Fresnel's formula, smooth or through GGX. What is below it is its owner's
//! affair.

use super::energy::Interface;
use super::fresnel;
use super::ggx::{self, SMOOTH};
use crate::math::{Vec2, Vec3};

/// The interface of a coat, seen from outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coat {
    ior: f32,
    interface: Interface,
    /// The smooth coat's mean reflectance: asked for at every hit of a textured one.
    smooth_average: f32,
    /// GGX width; below [`SMOOTH`] it is a mirror.
    pub alpha: f32,
}

impl Coat {
    /// Of that index of refraction (one below 1 is taken as 1/`ior`) and GGX width.
    pub fn new(ior: f32, alpha: f32) -> Coat {
        let ior = ior.max(ior.recip());
        Coat { ior, interface: Interface::new(ior), smooth_average: fresnel::dielectric_average(ior), alpha }
    }

    /// η, at least 1.
    pub fn ior(&self) -> f32 {
        self.ior
    }

    /// True when its reflection is a delta.
    #[inline(always)]
    pub fn is_smooth(&self) -> bool {
        self.alpha < SMOOTH
    }

    /// The share of light from μ that is reflected.
    #[inline(always)]
    pub fn reflected(&self, mu: f32) -> f32 {
        if self.is_smooth() {
            fresnel::dielectric(mu, self.ior).0
        } else {
            self.interface.reflected(mu, self.alpha)
        }
    }

    /// Its mean over light from all around, weighted with the cosine.
    pub fn reflected_average(&self) -> f32 {
        if self.is_smooth() { self.smooth_average } else { self.interface.reflected_average(self.alpha) }
    }

    /// (f_cos, pdf) of the rough coat's reflection.
    #[inline(always)]
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> (f32, f32) {
        let h = wo + wi;
        if self.is_smooth() || wi.z <= 0.0 || h == Vec3::ZERO {
            return (0.0, 0.0);
        }
        let (m, widths) = (h.normalize(), Vec2::splat(self.alpha));
        let (lo, li) = (ggx::lambda(wo, widths), ggx::lambda(wi, widths));
        let common = ggx::d(m, widths) / (4.0 * wo.z);
        (fresnel::dielectric(wo.dot(m), self.ior).0 * common / (1.0 + lo + li), common / (1.0 + lo))
    }

    /// A direction with [`Coat::eval`]'s density; it may lie below the horizon.
    #[inline(always)]
    pub fn sample(&self, wo: Vec3, u: [f32; 2]) -> Vec3 {
        let m = ggx::sample_visible_normal(wo, Vec2::splat(self.alpha), u);
        m * (2.0 * wo.dot(m)) - wo
    }
}
