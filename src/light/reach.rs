//! Light samples, and the rays that say whether they arrive.

use crate::math::ray::{Ray, leave};
use crate::math::{Rgb, Vec3};
use crate::shape::Surface;

/// A shadow ray and what comes along it.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit direction to the light.
    pub wi: Vec3,
    /// Radiance over the density of this sample, before visibility.
    pub radiance_over_pdf: Rgb,
    /// Density of `wi` per solid angle; infinite for a delta light.
    pub pdf: f32,
    /// The segment that must be free.
    pub shadow: Ray,
}

/// Shadow rays end this share before the light, so that its own triangle does not block them. Relative, so
/// it has no unit.
pub(super) const ALMOST: f32 = 1.0 - 1e-5;

/// The shadow ray to a light infinitely far away.
#[inline(always)]
pub(super) fn to_infinity(from: &Surface, wi: Vec3) -> Ray {
    Ray { o: leave(from.p, from.error, from.ng, wi), d: wi, tmax: f32::INFINITY }
}
