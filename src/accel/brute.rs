//! The f64 judge.
use crate::math::Vec3;

/// True when the triangle has area: f64 differences and products of f32 numbers, so that exactly collinear or
/// repeated corners give exactly 0 (as long as coordinates are within 2²⁹ of each other).
pub fn has_area(corners: [Vec3; 3]) -> bool {
    let [a, b, c] = corners.map(|p| p.as_dvec3());
    (b - a).cross(c - a) != crate::math::DVec3::ZERO
}
