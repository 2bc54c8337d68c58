//! Which of two triangles a ray at their common edge meets.
//!
//! A backend that computes in f32 accepts a hit a few units of rounding beyond an edge, so that no ray slips
//! through, and takes hits that are closer to each other than their rounding in any order. At a silhouette a ray
//! from outside a closed body can so meet the front triangle and the back triangle behind the same edge and be
//! given the back one: a path would go on inside the body. (And one from inside could leave through the edge.)
//!
//! A hit within rounding of an edge is therefore looked at once more, in f64 and among all triangles around it:
//! the ray is moved just so far inside the triangle that f64 has no doubt about it, a fraction of f32's own
//! rounding, and what hides the triangle there, if anything does, is the hit. That triangle may have an edge
//! nearby as well, so it is asked the same, until the answer stays. In f64 neighbours compute their common
//! edge with exactly opposite signs (as the judge's do), so along the moved ray the surface is closed, and a ray
//! from outside meets the side that looks outside. Nothing is assumed of the meshes: where no triangle hides
//! the one that was found, and at every border of an open surface, the hit stays what it was, to the bit.

use super::brute::{Measure, Ray64};
use super::{Hits, LANES, MISS, Mask, Rays};
use crate::math::{DVec3, Vec3};

/// Hits nearer to an edge than this many roundings of the corners' largest offset from the ray's origin are
/// looked at again. Backends' edge functions are off by up to about four; the rest is for the order of two
/// triangles that meet at an acute angle, whose distances from the ray's origin differ by less than the inset.
const ROUNDINGS: f64 = 16.0;

/// How far inside, in roundings, the ray is moved: far beyond what f64 makes of the same offsets (2⁻²⁸), far below
/// what f32 can tell. The next smaller one where the corner is too sharp for the one before.
const INSIDE: [f64; 3] = [1.0 / (1 << 6) as f64, 1.0 / (1 << 12) as f64, 1.0 / (1 << 18) as f64];

/// How far, in roundings, the ray may be moved for that.
pub(crate) const FARTHEST: f64 = 64.0;

/// How many roundings outside a triangle a ray may pass that a backend takes to meet it, with one to spare.
const MISSED: f64 = 5.0;

/// What a backend tells of its triangles. Neither function may panic.
pub(super) trait Triangles {
    /// The corners of the triangle that `lane` hit.
    fn hit(&self, hits: &Hits, lane: usize) -> [Vec3; 3];

    /// Calls `each` with mesh, triangle and corners of at least all triangles whose boxes come within `radius`
    /// of `point`.
    fn around(&self, point: Vec3, radius: f32, each: &mut dyn FnMut([u32; 2], [Vec3; 3]));
}

/// Settles the hits of a chunk.
#[inline(always)]
pub(super) fn settle(triangles: &impl Triangles, rays: &Rays, active: Mask, hits: &mut Hits) {
    for lane in 0..LANES {
        if active >> lane & 1 == 1 && hits.mesh[lane] != MISS {
            let corners = triangles.hit(hits, lane);
            if is_in_doubt(rays, hits, lane, corners) {
                settle_one(triangles, rays, lane, corners, hits);
            }
        }
    }
}

/// True when the hit lies within [`ROUNDINGS`] of an edge, seen along the ray. A parallelogram's area is edge times
/// height, so the distance from an edge is the opposite corner's weight times the area over the edge; the
/// longest edge errs on the side of doubt.
#[inline(always)]
fn is_in_doubt(rays: &Rays, hits: &Hits, lane: usize, corners: [Vec3; 3]) -> bool {
    let (o, d) = (rays.o(lane), rays.d(lane));
    let [a, b, c] = corners.map(|p| p - o);
    let (e, f) = (b - a, c - a);
    let area = d.dot(e.cross(f)).abs();
    let longest = e.length_squared().max(f.length_squared()).max((c - b).length_squared());
    let largest = a.abs().max(b.abs()).max(c.abs()).max_element();
    let (u, v) = (hits.u[lane], hits.v[lane]);
    let least = u.min(v).min(1.0 - u - v).max(0.0);
    // Not `<=` turned round: what overflows to NaN is in doubt.
    let clear =
        least * area > ROUNDINGS as f32 * f32::EPSILON * largest * (longest * d.length_squared()).sqrt();
    !clear
}

/// A triangle that may be the hit.
#[derive(Clone, Copy)]
struct Candidate {
    ids: [u32; 2],
    corners: [DVec3; 3],
}

/// A ray moved inside a triangle. It starts there and not at the eye, so that what is compared is small.
struct Aimed {
    ray: Ray64,
    /// Where the original ray has arrived at that start.
    t: f64,
}

#[cold]
fn settle_one(triangles: &impl Triangles, rays: &Rays, lane: usize, corners: [Vec3; 3], hits: &mut Hits) {
    let ray = Ray64::of(rays, lane);
    let ids = [hits.mesh[lane], hits.triangle[lane]];
    let mut found = Candidate { ids, corners: corners.map(|p| p.as_dvec3()) };
    // A front, a sliver or two at the silhouette, a back; more than three rounds have not been seen.
    for _ in 0..8 {
        let around = around(triangles, &ray, &found.corners, [hits.u[lane], hits.v[lane]]);
        found = match aim_inside(&ray, &found.corners) {
            Some(aimed) => {
                let Some((nearest, m)) = hiding(&aimed, &found, &around) else { return };
                (hits.t[lane], hits.u[lane], hits.v[lane]) = ((aimed.t + m.t) as f32, m.u as f32, m.v as f32);
                [hits.mesh[lane], hits.triangle[lane]] = nearest.ids;
                nearest
            }
            // The ray does not come near enough to where this one is wide enough: another does better.
            None => {
                let Some((better, m)) = best_met(&ray, &found, &around) else { return };
                (hits.t[lane], hits.u[lane], hits.v[lane]) = (m.t as f32, m.u as f32, m.v as f32);
                [hits.mesh[lane], hits.triangle[lane]] = better.ids;
                better
            }
        };
    }
}

/// The triangle that the ray passes farthest inside of, where that is not `found`. What lies behind a triangle that is
/// met without doubt is none: where `found` is seen edge-on, `around` reaches as far as it is long.
fn best_met(ray: &Ray64, found: &Candidate, around: &[Candidate]) -> Option<(Candidate, Measure)> {
    let margin = |other: &Candidate| MISSED * rounding(ray, &other.corners);
    let on_ray = |other: &Candidate| {
        let m = Measure::of(ray, other.corners)?;
        let on = ray.tmin <= m.t && m.t <= ray.tmax && m.inset >= -margin(other);
        on.then_some((*other, m))
    };
    let met: Vec<(Candidate, Measure)> = around.iter().filter_map(on_ray).collect();
    let sure = met.iter().filter(|(other, m)| m.inset > margin(other)).map(|(_, m)| m.t);
    let end = sure.fold(f64::INFINITY, f64::min);
    let order = |x: &(Candidate, Measure), y: &(Candidate, Measure)| {
        x.1.inset.total_cmp(&y.1.inset).then(y.0.ids.cmp(&x.0.ids))
    };
    let best = met.into_iter().filter(|(_, m)| m.t <= end).max_by(order)?;
    (best.0.ids != found.ids).then_some(best)
}

/// The triangles around the point `uv` of a triangle: as far along the ray as an edge can be that the ray passes
/// within rounding, but never farther than the triangle is long.
fn around(triangles: &impl Triangles, ray: &Ray64, corners: &[DVec3; 3], uv: [f32; 2]) -> Vec<Candidate> {
    let [a, b, c] = *corners;
    let longest = (b - a).length().max((c - b).length()).max((a - c).length());
    let across = 2.0 * ROUNDINGS * rounding(ray, corners);
    let along = Measure::of(ray, *corners).map_or(longest, |m| (across / m.cos).min(longest));
    // Not o + t·d: seen edge-on, t may lie far from the triangle.
    let [u, v] = uv.map(|w| f64::from(w.clamp(0.0, 1.0)));
    let scale = 1.0 / (u + v).max(1.0);
    let point = a + ((b - a) * u + (c - a) * v) * scale;
    // The query's centre is rounded to f32.
    let radius = along + across + 2.0 * f64::from(f32::EPSILON) * point.abs().max_element();
    let mut found = Vec::new();
    triangles.around(point.as_vec3(), radius as f32, &mut |ids, corners| {
        // Which others share a leaf, and of which parts of a triangle the tree keeps boxes, is the tree's affair;
        // the answer is not.
        let corners = corners.map(|p| p.as_dvec3());
        let is_new = !found.iter().any(|c: &Candidate| c.ids == ids);
        if is_new && meets_cube(corners.map(|p| p - point), radius) {
            found.push(Candidate { ids, corners });
        }
    });
    found
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

/// One rounding of the largest offset of the corners from the ray's origin.
fn rounding(ray: &Ray64, corners: &[DVec3; 3]) -> f64 {
    let largest = corners.iter().fold(DVec3::ZERO, |w, p| w.max((*p - ray.o).abs()));
    f64::from(f32::EPSILON) * largest.max_element()
}

/// The ray moved, at the triangle, to [`INSIDE`] of all three edges, or as far inside as takes it no farther away
/// than [`FARTHEST`]: at grazing incidence a corner looks like the tip of a needle.
fn aim_inside(ray: &Ray64, corners: &[DVec3; 3]) -> Option<Aimed> {
    let m = Measure::of(ray, *corners)?;
    let unit = rounding(ray, corners);
    let start = ray.o + ray.d * m.t;
    let check = |moved: DVec3, inside: f64| {
        // Across the ray only, so that it still takes t to get there.
        let moved = moved - ray.d * (moved.dot(ray.d) / ray.d.length_squared());
        let (o, d) = (start + moved, ray.d + moved / m.t);
        let aimed = Ray64 { o, d, tmin: ray.tmin - m.t, tmax: ray.tmax - m.t };
        let fits = m.t > 0.0 && moved.length() <= FARTHEST * unit;
        (fits && Measure::of(&aimed, *corners)?.inset >= 0.5 * inside).then_some(Aimed { ray: aimed, t: m.t })
    };
    INSIDE.into_iter().map(|inside| inside * unit).find_map(|inside| {
        check(from_edge(ray, corners, start, inside)?, inside)
            .or_else(|| check(from_corner(ray, corners, &m, inside) - start, inside))
    })
}

/// The shortest way from `start` to `inside` of the nearest edge, or of the one most missed.
fn from_edge(ray: &Ray64, corners: &[DVec3; 3], start: DVec3, inside: f64) -> Option<DVec3> {
    let [a, b, c] = *corners;
    let side = ray.d.dot((b - a).cross(c - a)).signum();
    let way = |(from, to): (DVec3, DVec3)| {
        // n × edge points inwards; d stands for n, so that the way is across the ray.
        let inwards = (ray.d.cross(to - from) * side).try_normalize()?;
        Some(inwards * (inside - (start - from).dot(inwards)).max(0.0))
    };
    [(a, b), (b, c), (c, a)].into_iter().filter_map(way).max_by(|x, y| x.length().total_cmp(&y.length()))
}

/// The point of the triangle that is `inside` of two edges, or of the one edge that is nearer than that.
fn from_corner(ray: &Ray64, corners: &[DVec3; 3], m: &Measure, inside: f64) -> DVec3 {
    let [a, b, c] = *corners;
    let area = ray.d.dot((b - a).cross(c - a)).abs();
    let mut weights = [1.0 - m.u - m.v, m.u, m.v];
    let largest = (0..3).fold(0, |l, k| if weights[k] > weights[l] { k } else { l });
    // Area over opposite edge is a corner's height: what the weight 1 stands for.
    for (k, edge) in [c - b, a - c, b - a].into_iter().enumerate().filter(|(k, _)| *k != largest) {
        weights[k] = weights[k].max(inside * ray.d.cross(edge).length() / area);
    }
    weights[largest] = 1.0 - weights[(largest + 1) % 3] - weights[(largest + 2) % 3];
    a * weights[0] + b * weights[1] + c * weights[2]
}

/// The nearest triangle in front of `found`, if there is one; of equally near ones that with the lowest ids, so
/// that the order in which a backend lists them does not matter.
fn hiding(aimed: &Aimed, found: &Candidate, around: &[Candidate]) -> Option<(Candidate, Measure)> {
    let ray = &aimed.ray;
    let own = Measure::of(ray, found.corners)?;
    let met = |other: &Candidate| {
        let m = Measure::of(ray, other.corners)?;
        let hides = m.inset >= 0.0 && ray.tmin <= m.t && m.t <= ray.tmax && m.t < own.t;
        hides.then_some((*other, m))
    };
    let order = |x: &(Candidate, Measure), y: &(Candidate, Measure)| {
        x.1.t.total_cmp(&y.1.t).then(x.0.ids.cmp(&y.0.ids))
    };
    around.iter().filter(|other| other.ids != found.ids).filter_map(met).min_by(order)
}
