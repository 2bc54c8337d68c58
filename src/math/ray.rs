//! Rays, and where a ray that leaves a surface starts.

use super::Vec3;

/// A ray `o + t·d`, `0 ≤ t ≤ tmax`.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// Origin.
    pub o: Vec3,
    /// Direction; unit for rays that extend a path, not for shadow rays to a point.
    pub d: Vec3,
    /// End of the interval in multiples of `d`.
    pub tmax: f32,
}

/// `p` moved off its surface, to the side of `ng` that `towards` points to, by its error bound `error`
/// (every component of `p` is within `error` of the true point; see [`crate::shape::Surface`]).
///
/// The bound is isotropic, so the plane through the true point is left behind when the shift along the unit
/// normal is `error·(|nx|+|ny|+|nz|)` (pbrt 4th ed., 6.8.6). No constant is involved: the shift scales with
/// the coordinates.
#[inline(always)]
pub fn leave(p: Vec3, error: f32, ng: Vec3, towards: Vec3) -> Vec3 {
    let shift = error * (ng.x.abs() + ng.y.abs() + ng.z.abs());
    p + ng * shift.copysign(ng.dot(towards))
}
