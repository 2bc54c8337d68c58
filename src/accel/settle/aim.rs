//! The ray moved inside a triangle, so far that f64 has no doubt about it.

use super::{FARTHEST, rounding};
use crate::accel::brute::{Measure, Ray64};
use crate::math::DVec3;

/// How far inside, in roundings, the ray is moved: far beyond what f64 makes of the same offsets (2⁻²⁸), far below
/// what f32 can tell. The next smaller one where the corner is too sharp for the one before.
const INSIDE: [f64; 3] = [1.0 / (1 << 6) as f64, 1.0 / (1 << 12) as f64, 1.0 / (1 << 18) as f64];

/// A ray moved inside a triangle. It starts there and not at the eye, so that what is compared is small.
pub(super) struct Aimed {
    pub ray: Ray64,
    /// Where the original ray has arrived at that start.
    pub t: f64,
}

/// The ray moved, at the triangle, to [`INSIDE`] of all three edges, or as far inside as takes it no farther away
/// than [`FARTHEST`]: at grazing incidence a corner looks like the tip of a needle.
pub(super) fn aim_inside(ray: &Ray64, corners: &[DVec3; 3]) -> Option<Aimed> {
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
