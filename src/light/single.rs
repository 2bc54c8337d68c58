//! One direction to one light of no extent, or to a sphere.

use super::{Directional, LightSample, Sphere, Spot, reach};
use crate::math::ray::{Ray, leave};
use crate::math::{Rgb, Vec3};
use crate::shape::Surface;

/// The notes' hint in 13.7 (no grid of directions can meet a point): its own term, I/d², with the intensity I along the
/// light's way.
#[inline(always)]
pub fn sample_point(
    from: &Surface,
    position: Vec3,
    chance: f32,
    intensity: impl FnOnce(Vec3) -> Rgb,
) -> Option<LightSample> {
    let to = position - from.p;
    let distance_squared = to.length_squared();
    if distance_squared <= 0.0 {
        return None;
    }
    let wi = to * (1.0 / distance_squared.sqrt());
    let intensity = intensity(-wi);
    if intensity == Rgb::ZERO {
        return None;
    }
    let start = leave(from.p, from.error, from.ng, wi);
    let shadow = Ray { o: start, d: position - start, tmax: 1.0 };
    let radiance_over_pdf = intensity / (distance_squared * chance);
    Some(LightSample { wi, radiance_over_pdf, pdf: f32::INFINITY, shadow })
}

#[inline(always)]
pub fn sample_spot(from: &Surface, spot: &Spot, chance: f32) -> Option<LightSample> {
    sample_point(from, spot.position, chance, |way| spot.intensity_at(way.dot(spot.direction)))
}

/// Parallel light: its irradiance is that of a plane facing it, so f_cos alone weighs it.
#[inline(always)]
pub fn sample_directional(from: &Surface, light: &Directional, chance: f32) -> LightSample {
    let wi = -light.direction;
    let shadow = reach::to_infinity(from, wi);
    LightSample { wi, radiance_over_pdf: light.irradiance / chance, pdf: f32::INFINITY, shadow }
}

#[inline(always)]
pub fn sample_sphere(from: &Surface, sphere: &Sphere, chance: f32, u: [f32; 2]) -> Option<LightSample> {
    let (wi, pdf, t) = sphere.sample(from.p, u)?;
    let pdf = pdf * chance;
    let start = leave(from.p, from.error, from.ng, wi);
    let shadow = Ray { o: start, d: from.p + wi * t - start, tmax: reach::ALMOST };
    Some(LightSample { wi, radiance_over_pdf: sphere.radiance / pdf, pdf, shadow })
}
