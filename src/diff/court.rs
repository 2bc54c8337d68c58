//! Two answers to one ray: do they agree, and if not, does the geometry leave the choice?
//!
//! An answer *stands* unless f64 refutes it: the triangle that it names must be met within rounding at the distance
//! stated, on the interval, and no triangle may clearly be in front of it; a miss stands where no triangle is clearly
//! met. "Clearly" and "within rounding" are the tolerances of [`crate::accel::judge`], some 10⁸ times what f64 can
//! tell, so that f64's own rounding decides nothing. An answer that does not stand makes a disagreement real. Of two
//! that stand, the [`Class`] says what they could not agree about; where none fits, it is real as well.

use super::class::{Class, Finding};
use super::scan::{Near, Scan};
use crate::accel::Rays;
use crate::accel::brute::{Outline, Ray64};
use crate::accel::judge::{ACROSS, Answer, Judge, Seen, Verdict};
use crate::accel::settle::FARTHEST;
use crate::math::DVec3;
use crate::shape::Mesh;
use std::f64::consts::FRAC_PI_4;
use std::sync::Arc;

/// How far across the ray, in ε·W, the point of a settled hit may lie: settling moves the ray by up to [`FARTHEST`]
/// roundings of an offset, which is at most 2·W.
const REACH: f64 = 2.0 * FARTHEST + ACROSS;

/// Judges answers about one list of meshes.
pub struct Court {
    judge: Judge,
    scan: Scan,
    meshes: Vec<Arc<Mesh>>,
}

impl Court {
    /// A court over `meshes`.
    pub fn new(meshes: &[Arc<Mesh>]) -> Court {
        Court { judge: Judge::new(meshes), scan: Scan::new(meshes), meshes: meshes.to_vec() }
    }

    pub(super) fn scan(&self) -> &Scan {
        &self.scan
    }

    /// What f64 itself says: the nearest triangle met.
    pub fn truth(&self, ray: &Ray64) -> Option<Answer> {
        let met = |n: &&Near| {
            let m = n.seen.measure;
            m.inset >= 0.0 && ray.tmin <= m.t && m.t <= ray.tmax
        };
        let near = self.scan.near(ray);
        near.iter().find(met).map(|n| {
            let m = n.seen.measure;
            Answer { t: m.t as f32, u: m.u as f32, v: m.v as f32, mesh: n.mesh, triangle: n.triangle }
        })
    }

    /// Judges two closest hits; `None` where they agree.
    pub fn closest(&self, rays: &Rays, lane: usize, pair: [Option<Answer>; 2]) -> Option<Finding> {
        let [a, b] = pair;
        if a == b {
            return None;
        }
        let verdict = self.judge.verdict(rays, lane, a, b);
        if verdict == Verdict::Same || (verdict == Verdict::Graze && is_nearly_equal(a, b)) {
            return None;
        }
        let ray = Ray64::of(rays, lane);
        let near = self.scan.near(&ray);
        let wrong = pair.map(|answer| !self.stands(&ray, answer, &near));
        if wrong != [false; 2] {
            return Some(Finding { class: Class::Real, leak: false, wrong });
        }
        let mut named: Vec<Option<Seen>> =
            pair.iter().flatten().map(|answer| self.seen(&ray, *answer)).collect();
        named.sort_by(|x, y| distance(x).total_cmp(&distance(y)));
        Some(self.name(&ray, &named))
    }

    /// Judges two answers to the question whether anything is in the way; `None` where they agree.
    pub fn blocked(&self, rays: &Rays, lane: usize, pair: [bool; 2]) -> Option<Finding> {
        if pair[0] == pair[1] {
            return None;
        }
        let ray = Ray64::of(rays, lane);
        let best = |near: &[Near]| {
            let reasons = near.iter().filter(|n| n.seen.grazes() || is_on_interval(&ray, &n.seen));
            reasons.max_by(|x, y| x.seen.measure.inset.total_cmp(&y.seen.measure.inset)).copied()
        };
        let near = self.scan.near(&ray);
        let is_clear = near.iter().any(|n| is_clear(&ray, &n.seen));
        // What is seen nearly edge-on is met from farther away.
        match best(&near).or_else(|| best(&self.scan.around(&ray))) {
            Some(best) if !is_clear => Some(self.name(&ray, &[Some(best.seen)])),
            _ => Some(Finding { class: Class::Real, leak: false, wrong: pair.map(|says| says != is_clear) }),
        }
    }

    /// False where f64 refutes the answer.
    fn stands(&self, ray: &Ray64, answer: Option<Answer>, near: &[Near]) -> bool {
        let Some(answer) = answer else { return !near.iter().any(|n| is_clear(ray, &n.seen)) };
        let length = ray.d.length();
        let (t, blur) = match self.judge.claim(ray, answer) {
            Err(Verdict::Real) => match self.settled(ray, answer) {
                Some(seen) => (f64::from(answer.t), REACH * seen.unit / (seen.measure.cos * length)),
                None => return false,
            },
            Err(_) if !self.is_met_edge_on(ray, answer) => return false,
            Err(_) => (f64::from(answer.t), self.size(answer) / length),
            Ok(claim) if !is_on_interval(ray, &claim.seen) => return false,
            Ok(claim) => (claim.seen.measure.t, claim.seen.blur() / length),
        };
        let is_before = |n: &Near| n.seen.measure.t + n.seen.blur() / length < t - blur;
        !near.iter().any(|n| is_clear(ray, &n.seen) && is_before(n))
    }

    /// False when the triangle, seen edge-on, is passed in its own plane, or lies elsewhere than at t or off the interval.
    fn is_met_edge_on(&self, ray: &Ray64, answer: Answer) -> bool {
        let Some(corners) = self.corners(answer) else { return false };
        let outline = Outline::of(ray, corners);
        let largest = corners.iter().fold(ray.o.abs(), |w, p| w.max(p.abs())).max_element();
        let slack = ACROSS * f64::from(f32::EPSILON) * largest;
        let (t, along) = (f64::from(answer.t), slack / ray.d.length());
        outline.away <= slack
            && (outline.first - along..=outline.last + along).contains(&t)
            && (ray.tmin - along..=ray.tmax + along).contains(&t)
    }

    /// The triangle of a hit at its border that was settled along a ray moved across by up to [`REACH`]: the point stated
    /// is one of the triangle, and t is the distance to it.
    fn settled(&self, ray: &Ray64, answer: Answer) -> Option<Seen> {
        let [a, b, c] = self.corners(answer)?;
        let seen = Seen::of(ray, [a, b, c])?;
        let (u, v) = (f64::from(answer.u), f64::from(answer.v));
        let offset = a * (1.0 - u - v) + b * u + c * v - ray.o;
        let (length, reach) = (ray.d.length(), REACH * seen.unit);
        let across = offset.cross(ray.d).length() / length;
        let along = (offset.dot(ray.d) / length - f64::from(answer.t) * length).abs();
        let is_inside = u.min(v).min(1.0 - u - v) * seen.diameter >= -ACROSS * seen.unit * seen.aspect;
        let fits = seen.measure.inset.abs() <= reach && across <= reach && along <= ACROSS * seen.unit;
        (fits && is_inside).then_some(seen)
    }

    /// The triangle of an answer; `None` where the ray runs along it.
    fn seen(&self, ray: &Ray64, answer: Answer) -> Option<Seen> {
        Seen::of(ray, self.corners(answer)?).filter(|seen| !seen.grazes())
    }

    fn corners(&self, answer: Answer) -> Option<[DVec3; 3]> {
        let mesh = self.meshes.get(answer.mesh as usize)?;
        let triangle = answer.triangle as usize;
        (triangle < mesh.indices.len()).then(|| mesh.triangle(triangle).map(|p| p.as_dvec3()))
    }

    fn size(&self, answer: Answer) -> f64 {
        self.corners(answer).map_or(0.0, |[a, b, c]| a.distance(b).max(b.distance(c)).max(c.distance(a)))
    }

    /// What two answers that stand disagree about; `named` are the triangles that they name, by distance.
    fn name(&self, ray: &Ray64, named: &[Option<Seen>]) -> Finding {
        let [nearest, ..] = named else {
            return Finding { class: Class::Real, leak: false, wrong: [false; 2] };
        };
        let all = || named.iter().flatten();
        let is_tie = match (nearest, named.get(1)) {
            (Some(a), Some(Some(b))) => {
                (b.measure.t - a.measure.t) * ray.d.length() <= a.blur() + b.blur() || a.at_an_end(ray)
            }
            (Some(a), _) => a.at_an_end(ray),
            (None, _) => false,
        };
        let runs_along = |seen: &Seen| seen.grazes() || seen.leans() && !is_tie;
        let class = if named.iter().any(|seen| seen.is_none_or(|seen| runs_along(&seen))) {
            Class::Graze
        } else if all().any(|seen| seen.diameter <= 2.0 * ACROSS * seen.unit * seen.aspect) {
            Class::Sliver
        } else if all().any(|seen| seen.corner <= 2.0 * ACROSS * seen.unit) {
            Class::Vertex
        } else if all().any(Seen::at_border) {
            Class::Edge
        } else if is_tie {
            Class::Tie
        } else {
            Class::Real
        };
        let leak = !is_tie && nearest.is_some_and(|near| self.is_surrounded(ray, &near, named.get(1)));
        Finding { class, leak, wrong: [false; 2] }
    }

    /// True when rays displaced to all sides meet a surface before the farther hit: the other ray slipped through.
    fn is_surrounded(&self, ray: &Ray64, near: &Seen, far: Option<&Option<Seen>>) -> bool {
        let beyond = far.map_or(f64::INFINITY, |far| (near.measure.t + distance(far)) * 0.5);
        let side = ray.d.normalize().any_orthonormal_vector();
        let other = side.cross(ray.d).normalize();
        let radius = 2.0 * ACROSS * near.unit;
        (0..8).all(|i| {
            let (sin, cos) = libm::sincos(f64::from(i) * FRAC_PI_4 + 0.2);
            let o = ray.o + (side * cos + other * sin) * radius;
            self.scan.any(&Ray64 { o, tmax: ray.tmax.min(beyond), ..*ray })
        })
    }
}

/// The same triangle seen edge-on, and t equal within a few roundings.
fn is_nearly_equal(a: Option<Answer>, b: Option<Answer>) -> bool {
    let (Some(a), Some(b)) = (a, b) else { return false };
    (a.mesh, a.triangle) == (b.mesh, b.triangle) && (a.t - b.t).abs() <= 4.0 * f32::EPSILON * a.t.abs()
}

fn distance(seen: &Option<Seen>) -> f64 {
    seen.map_or(f64::NEG_INFINITY, |seen| seen.measure.t)
}

/// Within rounding of an interval's ends, or between them.
fn is_on_interval(ray: &Ray64, seen: &Seen) -> bool {
    (ray.tmin <= seen.measure.t && seen.measure.t <= ray.tmax) || seen.at_an_end(ray)
}

/// Met without any doubt.
fn is_clear(ray: &Ray64, seen: &Seen) -> bool {
    let inside = seen.measure.inset > seen.reach && !seen.grazes();
    inside && ray.tmin <= seen.measure.t && seen.measure.t <= ray.tmax && !seen.at_an_end(ray)
}
