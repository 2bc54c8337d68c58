//! The box around an instance, as rays with f32's rounding need it.

use crate::math::{Aabb, Vec3};
use crate::shape::Instance;

/// What a box is enlarged by on all sides, relative to its coordinates: eight roundings, where a ray's transform, its
/// box test and the backend's own errors take less than four together.
pub const MARGIN: f32 = 16.0 * f32::EPSILON;

/// The box around `place` of a mesh with the box `mesh` while the shutter is open; empty where the mesh is.
///
/// A backend finds a triangle for rays that pass it by a rounding of the *mesh's* coordinates, which can be much larger
/// than those of the scene, so the mesh's box grows before it is moved.
pub fn around(place: &Instance, mesh: &Aabb, shutter: [f64; 2]) -> Aabb {
    if mesh.is_empty() {
        return Aabb::EMPTY;
    }
    let slack = Vec3::splat(MARGIN * mesh.min.abs().max(mesh.max.abs()).max_element());
    let swept = place.bounds(&Aabb { min: mesh.min - slack, max: mesh.max + slack }, shutter);
    let (min, max) = (swept.min.as_vec3(), swept.max.as_vec3());
    let slack = Vec3::splat(MARGIN * min.abs().max(max.abs()).max_element());
    Aabb { min: min - slack, max: max + slack }
}
