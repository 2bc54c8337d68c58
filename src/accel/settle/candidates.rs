//! Triangles around a hit, and which of them is the hit instead.

use super::aim::Aimed;
use super::beside::is_edge_on;
use super::{FARTHEST, ROUNDINGS, Triangles, rounding};
use crate::accel::brute::{Measure, Ray64};
use crate::math::DVec3;

/// How many roundings outside a triangle a ray may pass that a backend takes to meet it, with one to spare.
const MISSED: f64 = 5.0;

/// A triangle that may be the hit.
#[derive(Clone, Copy)]
pub(super) struct Candidate {
    pub ids: [u32; 2],
    pub corners: [DVec3; 3],
}

/// What the hit is found to be.
pub(super) struct Found {
    pub candidate: Candidate,
    pub t: f64,
    pub u: f64,
    pub v: f64,
}

impl Found {
    pub fn new(candidate: Candidate, t: f64, at: &Measure) -> Found {
        Found { candidate, t, u: at.u, v: at.v }
    }
}

/// The triangles that come into a cube.
pub(super) struct Around {
    point: DVec3,
    radius: f64,
    triangles: Vec<Candidate>,
}

impl Around {
    /// Within the cube nothing is left out; what is met behind it may be hidden by what does not come into it.
    fn holds(&self, p: DVec3) -> bool {
        (p - self.point).abs().max_element() <= self.radius
    }
}

/// The triangles around the point `uv` of a triangle: as far along the ray as an edge can be that the ray passes
/// within rounding, but never farther than the triangle is long.
pub(super) fn around(triangles: &impl Triangles, ray: &Ray64, corners: &[DVec3; 3], uv: [f32; 2]) -> Around {
    let [a, b, c] = *corners;
    let longest = (b - a).length().max((c - b).length()).max((a - c).length());
    let across = 2.0 * ROUNDINGS * rounding(ray, corners);
    let along = Measure::of(ray, *corners).map_or(longest, |m| (across / m.cos).min(longest));
    // Not o + t·d: seen edge-on, t may lie far from the triangle.
    let [u, v] = uv.map(|w| f64::from(w.clamp(0.0, 1.0)));
    let scale = 1.0 / (u + v).max(1.0);
    let point = a + ((b - a) * u + (c - a) * v) * scale;
    // Who is met is within this of the ray, up to the hit: a ray that was moved, or a hit of another triangle.
    let reach = |corners: &[DVec3; 3]| 2.0 * FARTHEST * rounding(ray, corners);
    let own_reach = reach(corners);
    // The query's centre is rounded to f32.
    let radius = along + across + 2.0 * f64::from(f32::EPSILON) * point.abs().max_element();
    let mut found = Vec::new();
    triangles.around(point.as_vec3(), radius as f32, &mut |ids, corners| {
        // Which others share a leaf, and of which parts of a triangle the tree keeps boxes, is the tree's affair;
        // the answer is not. One that comes twice is no other triangle.
        let corners = corners.map(|p| p.as_dvec3());
        // Along a large triangle the cube is as large, and the ray passes most of what is in it.
        if comes_near(ray, &corners, own_reach.max(reach(&corners)))
            && meets_cube(corners.map(|p| p - point), radius)
        {
            found.push(Candidate { ids, corners });
        }
    });
    Around { point, radius, triangles: found }
}

/// The triangle that the ray passes farthest inside of, where that is not `found`. What lies behind a triangle that is
/// met without doubt is none: where `found` is seen edge-on, `around` reaches as far as it is long.
pub(super) fn best_met(ray: &Ray64, found: &Candidate, around: &Around) -> Option<Found> {
    let margin = |other: &Candidate| MISSED * rounding(ray, &other.corners);
    let on_ray = |other: &Candidate| {
        // Where its plane is met is not where it is.
        let m = Measure::of(ray, other.corners).filter(|m| !is_edge_on(ray, &other.corners, m.cos))?;
        let on = ray.tmin <= m.t && m.t <= ray.tmax && m.inset >= -margin(other);
        let on = on && around.holds(ray.o + ray.d * m.t);
        on.then_some((*other, m))
    };
    let met: Vec<(Candidate, Measure)> = around.triangles.iter().filter_map(on_ray).collect();
    let sure = met.iter().filter(|(other, m)| m.inset > margin(other)).map(|(_, m)| m.t);
    let end = sure.fold(f64::INFINITY, f64::min);
    let order = |x: &(Candidate, Measure), y: &(Candidate, Measure)| {
        x.1.inset.total_cmp(&y.1.inset).then(y.0.ids.cmp(&x.0.ids))
    };
    let best = met.into_iter().filter(|(_, m)| m.t <= end).max_by(order)?;
    (best.0.ids != found.ids).then(|| Found::new(best.0, best.1.t, &best.1))
}

/// The nearest triangle in front of `found`, if there is one; of equally near ones that with the lowest ids, so
/// that the order in which a backend lists them does not matter.
///
/// The moved ray says which one it is. Where the ray itself meets that one, it says where: a wall that ends on a floor
/// hands its hit to the floor, on which the two rays can be far apart.
pub(super) fn hiding(ray: &Ray64, aimed: &Aimed, found: &Candidate, around: &Around) -> Option<Found> {
    let moved = &aimed.ray;
    let own = Measure::of(moved, found.corners)?;
    let met = |other: &Candidate| {
        let m = Measure::of(moved, other.corners)?;
        let hides = m.inset >= 0.0 && moved.tmin <= m.t && m.t <= moved.tmax && m.t < own.t;
        if !hides || starts_in_plane(ray, &other.corners) {
            return None;
        }
        let there = match Measure::of(ray, other.corners).filter(|m| m.inset >= 0.0) {
            // Rounded as the interval's ends are.
            Some(m) => {
                let t = f64::from(m.t as f32);
                (ray.tmin <= t && t <= ray.tmax).then(|| Found::new(*other, t, &m))?
            }
            None => Found::new(*other, aimed.t + m.t, &m),
        };
        Some((m.t, there))
    };
    let order = |x: &(f64, Found), y: &(f64, Found)| {
        x.0.total_cmp(&y.0).then(x.1.candidate.ids.cmp(&y.1.candidate.ids))
    };
    let nearest =
        around.triangles.iter().filter(|other| other.ids != found.ids).filter_map(met).min_by(order)?;
    Some(nearest.1)
}

/// Whether a ray starts in the plane of a triangle. A moved one, which starts there too, meets that plane nowhere else: a
/// triangle around the start is met at the start, and hides nothing of what lies on.
fn starts_in_plane(ray: &Ray64, corners: &[DVec3; 3]) -> bool {
    let [a, b, c] = *corners;
    let n = (b - a).cross(c - a);
    n.dot(ray.o - a).abs() <= rounding(ray, corners) * n.length()
}

/// Whether the ray's line comes within `reach` of a triangle's box: seen along the ray, that is a hexagon, passed outside
/// of one of its three pairs of sides or not at all.
fn comes_near(ray: &Ray64, [a, b, c]: &[DVec3; 3], reach: f64) -> bool {
    let (low, high) = (a.min(*b).min(*c), a.max(*b).max(*c));
    let (off, half) = (((low + high) * 0.5 - ray.o).cross(ray.d).abs(), (high - low) * 0.5 + reach);
    let d = ray.d.abs();
    off.x <= half.y * d.z + half.z * d.y
        && off.y <= half.z * d.x + half.x * d.z
        && off.z <= half.x * d.y + half.y * d.x
}

/// Whether a triangle reaches into the cube of that half side around the origin: it does when none of the axes that
/// can part the two does (the cube's, the triangle's normal, and the products of their edges).
fn meets_cube([a, b, c]: [DVec3; 3], half: f64) -> bool {
    let parts = |axis: DVec3| {
        let (x, y, z) = (axis.dot(a), axis.dot(b), axis.dot(c));
        let reach = half * axis.abs().element_sum();
        x.min(y).min(z) > reach || x.max(y).max(z) < -reach
    };
    let edges = [b - a, c - b, a - c];
    let sides = [DVec3::X, DVec3::Y, DVec3::Z];
    let products = || sides.iter().any(|s| edges.iter().any(|e| parts(s.cross(*e))));
    !(sides.into_iter().any(parts) || parts(edges[0].cross(edges[1])) || products())
}
