//! Which of two triangles a ray at their common edge meets.
//!
//! Embree accepts a hit a few units of rounding beyond an edge, so that no ray slips through. At a silhouette
//! a ray from outside a closed body can so meet the front triangle and the back triangle behind the same edge
//! at distances that differ by less than their rounding, and be given the back one: a path would go on inside
//! the body. A hit that close to an edge is therefore settled by a second ray, aimed a little further into the
//! triangle that was found. What hides that part of the triangle, if anything does, is what the first ray meets.

use crate::accel::brute::{Measure, Ray64};
use crate::accel::{Hits, MISS, Rays};
use crate::math::DVec3;
use crate::shape::Mesh;
use std::sync::Arc;

/// Beyond this barycentric distance from all edges a hit needs no second look.
const NEAR: f32 = 0.03;

/// Hits nearer to an edge than this many roundings of the largest coordinate are settled (Embree's own
/// tolerance and its rounding of the edge functions are about three).
const ROUNDINGS: f64 = 16.0 * f32::EPSILON as f64;

/// True when lane `lane` hit a triangle near one of its edges.
#[inline(always)]
pub(super) fn is_near_an_edge(hits: &Hits, lane: usize) -> bool {
    let (u, v) = (hits.u[lane], hits.v[lane]);
    hits.mesh[lane] != MISS && u.min(v).min(1.0 - u - v) < NEAR
}

/// Settles lane `lane`, which [`is_near_an_edge`]. `trace`: the closest hit of lane 0 of a chunk.
#[cold]
pub(super) fn settle(
    meshes: &[Arc<Mesh>],
    rays: &Rays,
    lane: usize,
    hits: &mut Hits,
    trace: impl Fn(&Rays) -> Option<Hits>,
) {
    let ray = Ray64::of(rays, lane);
    let corners = |mesh: u32, triangle: u32| {
        meshes.get(mesh as usize).map(|m| m.triangle(triangle as usize).map(|p| p.as_dvec3()))
    };
    let Some(found) = corners(hits.mesh[lane], hits.triangle[lane]) else { return };
    let Some(measure) = Measure::of(&ray, found) else { return };
    let tolerance = ROUNDINGS * largest(&ray, &found);
    if measure.inset > tolerance {
        return;
    }
    // Aimed too far inside, the second ray can meet a neighbour of the triangle in question, which the first
    // ray does not meet at all; so it comes nearer until the answer fits.
    for tolerances in [4.0, 2.0, 1.0, 0.5] {
        let Some(second) = aim_inside(&ray, &found, &measure, tolerances * tolerance) else { return };
        let Some(other) = trace(&second) else { return };
        let ids = (other.mesh[0], other.triangle[0]);
        if ids.0 == MISS || ids == (hits.mesh[lane], hits.triangle[lane]) {
            return;
        }
        // The first ray's own answer on that triangle, if it is there at all.
        let Some(corners) = corners(ids.0, ids.1) else { return };
        let Some(m) = Measure::of(&ray, corners) else { continue };
        let meets = m.inset >= -ROUNDINGS * largest(&ray, &corners);
        if meets && m.t >= ray.tmin && m.t <= ray.tmax {
            (hits.mesh[lane], hits.triangle[lane]) = ids;
            (hits.t[lane], hits.u[lane], hits.v[lane]) = (m.t as f32, m.u as f32, m.v as f32);
            return;
        }
    }
}

/// The largest magnitude among the coordinates that a distance is rounded against.
fn largest(ray: &Ray64, corners: &[DVec3; 3]) -> f64 {
    corners.iter().fold(ray.o.abs().max_element(), |w, p| w.max(p.abs().max_element()))
}

/// A ray to the point that lies `inset` (seen across the ray) further from the nearest edge into the triangle,
/// or half way to the opposite corner where that is nearer.
fn aim_inside(ray: &Ray64, corners: &[DVec3; 3], measure: &Measure, inset: f64) -> Option<Rays> {
    let point = ray.o + ray.d * measure.t;
    // Distance of the two lines, as in `Measure`; the nearest edge decides.
    let across = |k: usize| {
        let edge = corners[(k + 1) % 3] - corners[k];
        let normal = ray.d.cross(edge).try_normalize()?;
        Some((k, normal, (corners[k] - ray.o).dot(normal).abs()))
    };
    let (k, normal, _) = (0..3).filter_map(across).min_by(|a, b| a.2.total_cmp(&b.2))?;
    let edge = (corners[(k + 1) % 3] - corners[k]).try_normalize()?;
    let to_opposite = corners[(k + 2) % 3] - corners[k];
    let height = to_opposite - edge * to_opposite.dot(edge);
    let inward = height.try_normalize()?;
    let step = (inset / inward.dot(normal).abs()).min(0.5 * height.length());
    let d = point + inward * step - ray.o;
    // The same interval in multiples of the new direction, whose length ends at the triangle.
    let scale = measure.t;
    let mut second = Rays::default();
    second.set(0, ray.o.as_vec3(), d.as_vec3(), (ray.tmin / scale) as f32, (ray.tmax / scale) as f32);
    (scale > 0.0).then_some(second)
}
