//! What a ray meets that runs along a triangle: asked again, a little to either side.
//!
//! Seen edge-on, a triangle is met where its plane is, and that is anywhere: the sum of the edge functions, by which
//! the distance is divided, is rounding alone. Embree's robust test takes such hits at distances far from the triangle,
//! and even of triangles that the ray passes far away in their own plane; what the ray clearly meets beyond that
//! distance is lost, and no list of triangles around the hit brings it back. Two rays, parallel to the first and just so
//! far to either side of the triangle's plane that no rounding takes them to meet it, do: both meet what is clearly met.

use super::candidates::{Candidate, Found};
use super::{Triangles, write};
use crate::accel::brute::{Measure, Outline, Ray64};
use crate::accel::{Hits, MISS, Mask, Rays};
use crate::math::DVec3;

/// How far to the side, in ε·W as in [`crate::accel::judge`]: a backend's five roundings are passed, and the judge's
/// sixteen, within which either answer is right, are not.
const ASIDE: f64 = 8.0;

/// How many ε·W there are, across the ray, from one end of a triangle to the other where it is seen edge-on, and
/// how many it may be passed by to be met.
const EDGE_ON: f64 = 16.0;

/// How often it is asked again behind neighbours that are seen edge-on: a strip of tiny triangles has as many in a row.
const AGAIN: usize = 64;

/// Puts things right where the backend's hit was `first`, and that is seen edge-on. The hit is `last` by now: it goes if it
/// is seen edge-on as well and not met, and what lies in front of it beside `first` takes its place.
pub(super) fn look_beside(
    triangles: &impl Triangles,
    rays: &Rays,
    lane: usize,
    [first, last]: [&Candidate; 2],
    hits: &mut Hits,
) {
    let ray = Ray64::of(rays, lane);
    let [a, b, c] = first.corners;
    let Some(normal) = (b - a).cross(c - a).try_normalize() else { return };
    if !is_edge_on(&ray, &first.corners, normal.dot(ray.d).abs() / ray.d.length()) {
        return;
    }
    const BOTH: Mask = 0b11;
    let mut pair = Rays::default();
    for (i, side) in [ASIDE, -ASIDE].into_iter().enumerate() {
        let o = ray.o + normal * (side * unit(&ray, &first.corners));
        pair.set(i, o.as_vec3(), rays.d(lane), rays.tmin[lane], rays.tmax[lane]);
    }
    let Some(mut answers) = triangles.ask(&pair, BOTH) else { return };
    // A neighbour no larger than the step aside may be seen edge-on as well, and met: on behind it.
    for _ in 0..AGAIN {
        let ends = [0, 1].map(|i| end_of_edge_on(triangles, &ray, &answers, i));
        if ends == [None; 2] {
            break;
        }
        for (i, end) in ends.into_iter().enumerate() {
            // The hit may be said to be anywhere, and nothing else is met before it.
            let behind = |end: f64| (end as f32).max(answers.t[i]).max(pair.tmin[i]).next_up();
            pair.tmin[i] = end.map_or(pair.tmin[i], behind);
        }
        let Some(next) = triangles.ask(&pair, BOTH) else { break };
        answers = next;
    }
    let hit_of = |i: usize| (answers.mesh[i] != MISS).then(|| met(triangles, &ray, &answers, i)).flatten();
    // What the ray itself clearly meets goes first: it cannot be denied.
    let order = |x: &(bool, Found), y: &(bool, Found)| {
        let nearer = x.1.t.total_cmp(&y.1.t).then(x.1.candidate.ids.cmp(&y.1.candidate.ids));
        y.0.cmp(&x.0).then(nearer)
    };
    let beside = (0..2).filter_map(hit_of).min_by(order).map(|(_, found)| found);
    let t = place(&ray, &last.corners, f64::from(hits.t[lane]));
    match (t, beside) {
        (Some(t), Some(beside)) if beside.t < t => write(&beside, lane, hits),
        (Some(t), _) => hits.t[lane] = t as f32,
        (None, Some(beside)) => write(&beside, lane, hits),
        (None, None) => {
            (hits.t[lane], hits.mesh[lane], hits.triangle[lane]) = (f32::INFINITY, MISS, MISS);
        }
    }
}

/// Where the ray meets a triangle that it is said to meet at `t`: if it is seen edge-on, within its outline, if at all.
fn place(ray: &Ray64, corners: &[DVec3; 3], t: f64) -> Option<f64> {
    let [a, b, c] = *corners;
    let cos = (b - a).cross(c - a).normalize_or_zero().dot(ray.d).abs() / ray.d.length();
    if !is_edge_on(ray, corners, cos) {
        return Some(t);
    }
    let outline = Outline::of(ray, *corners);
    let (first, last) = (outline.first.max(ray.tmin), outline.last.min(ray.tmax));
    (outline.away <= EDGE_ON * unit(ray, corners) && first <= last).then(|| t.max(first).min(last))
}

/// Where a triangle ends along the ray that a ray beside it hit, and that is seen edge-on.
fn end_of_edge_on(triangles: &impl Triangles, ray: &Ray64, hits: &Hits, i: usize) -> Option<f64> {
    if hits.mesh[i] == MISS {
        return None;
    }
    let corners = triangles.hit(hits, i).map(|p| p.as_dvec3());
    let cos = Measure::of(ray, corners).map_or(0.0, |m| m.cos);
    is_edge_on(ray, &corners, cos).then(|| Outline::of(ray, corners).last).filter(|end| end.abs() < 1e18)
}

/// Where the ray itself meets what a ray beside it hit, and whether it does so clearly.
fn met(triangles: &impl Triangles, ray: &Ray64, hits: &Hits, i: usize) -> Option<(bool, Found)> {
    let corners = triangles.hit(hits, i).map(|p| p.as_dvec3());
    let m = Measure::of(ray, corners)?;
    let slack = EDGE_ON * unit(ray, &corners);
    if is_edge_on(ray, &corners, m.cos) || m.inset < -slack {
        return None;
    }
    let u = m.u.clamp(0.0, 1.0);
    let at = Measure { u, v: m.v.max(0.0).min(1.0 - u), ..m };
    let candidate = Candidate { ids: [hits.mesh[i], hits.triangle[i]], corners };
    Some((m.inset > slack, Found::new(candidate, m.t.max(ray.tmin).min(ray.tmax), &at)))
}

/// ε·W.
fn unit(ray: &Ray64, corners: &[DVec3; 3]) -> f64 {
    let largest = corners.iter().fold(ray.o.abs(), |w, p| w.max(p.abs()));
    f64::from(f32::EPSILON) * largest.max_element()
}

/// `cos`: of ray and normal.
pub(super) fn is_edge_on(ray: &Ray64, corners: &[DVec3; 3], cos: f64) -> bool {
    let [a, b, c] = *corners;
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    cos * longest <= EDGE_ON * unit(ray, corners)
}
