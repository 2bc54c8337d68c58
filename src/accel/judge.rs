//! Two backends, one ray, two answers: who is right?
//!
//! f32 backends may differ where the geometry leaves them a choice, and nowhere else. All tolerances are
//! lengths, multiples of ε·W with ε = 2⁻²³ and W the largest absolute coordinate of the ray's origin and the
//! triangle: differences of coordinates are rounded in units of ε·W whatever happens afterwards, so a
//! backend sees each vertex displaced by a few ε·W, across the ray as well as along it. A displacement p of the plane
//! changes t·|d| by p/cos, cos the cosine between ray and normal; hence distances are compared as |Δt|·|d|·cos. (A
//! bare relative tolerance on t would have to be 3.5·10⁻⁴ to admit grazing hits.)

mod border;
mod tally;

use border::goes_on;
pub use tally::{Disagreement, KEPT, Tally};

use super::brute::{Brute, Measure, Ray64};
use super::{Checked, Hits, LANES, MISS, Rays};
use crate::math::DVec3;
use crate::shape::Mesh;
use std::sync::Arc;

/// |Δt|·|d|·cos between two sound answers on one triangle, in ε·W: 5.8 was the largest that half a million
/// rays showed between Embree and a hierarchy of single-precision Möller–Trumbore tests.
pub const PLANE: f64 = 8.0;

/// How far across the ray an edge may be displaced, in ε·W: an offset from the origin is at most 2·W and its
/// two sheared components carry up to 6·2⁻²⁴ of it each, √2·6 ε·W together; twice that for two backends.
pub const ACROSS: f64 = 16.0;

/// What an edge that runs along the ray adds. A backend that takes the side of an edge e from d·(e × s), s the sum of its
/// ends' offsets from the ray's origin (Plücker coordinates; Embree's robust test), rounds each product by up to
/// 2⁻²⁴·|e|·|s|, √2·ε·|d|·|e|·|s| together, where the exact value is 2·|d|·|e⊥|·inset, e⊥ the edge as the ray sees it:
/// in units of length, that is this times ε·|v|·|e|/|e⊥|, v the farther end's offset. At right angles it is covered by
/// [`ACROSS`]; an edge at a degree to the ray may well seem displaced by a hundred ε·W.
const ALONG: f64 = std::f64::consts::SQRT_2;

/// One backend's hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Answer {
    /// Distance in multiples of the direction.
    pub t: f32,
    /// Barycentric weight of the second corner.
    pub u: f32,
    /// Barycentric weight of the third corner.
    pub v: f32,
    /// Mesh.
    pub mesh: u32,
    /// Triangle.
    pub triangle: u32,
}

impl Answer {
    /// One lane of a chunk; `None` for a miss.
    pub fn of(hits: &Hits, lane: usize) -> Option<Answer> {
        (hits.mesh[lane] != MISS).then(|| Answer {
            t: hits.t[lane],
            u: hits.u[lane],
            v: hits.v[lane],
            mesh: hits.mesh[lane],
            triangle: hits.triangle[lane],
        })
    }
}

/// What a pair of answers amounts to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// The same triangle at the same place, or both miss.
    Same,
    /// Two triangles at one distance, or a hit within rounding of an end of the interval.
    Tie,
    /// The ray passes a border of the surface within rounding; one backend saw it inside, the other outside.
    Edge,
    /// The ray runs along the triangle: within rounding of its plane over its whole size.
    Graze,
    /// One of the two is wrong.
    Real,
}

/// Judges answers about one list of meshes. Costs a few hundred operations a ray.
pub struct Judge {
    meshes: Vec<Arc<Mesh>>,
    brute: Option<Brute>,
}

/// What f64 says about a triangle that a ray passes, and how far f32 may see it displaced.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Seen {
    pub(crate) measure: Measure,
    /// ε·W.
    pub(crate) unit: f64,
    /// How far the plane may be displaced, in multiples of [`PLANE`]: ε·W, or ε·L²/h for a triangle of length L
    /// and height h. The latter is what rounding does to the plane of a needle where a backend takes t from
    /// the normal: a cross product of edges is rounded by ε·L², which tilts a normal of length L·h by ε·L/h.
    plane: f64,
    pub(crate) diameter: f64,
    /// Diameter over the least height that the ray sees. A displacement p of an edge across the ray changes
    /// barycentrics by p/height, which moves the point they stand for by up to p·diameter/height.
    pub(crate) aspect: f64,
    /// Distance of the nearest corner from the ray's line.
    pub(crate) corner: f64,
    /// How far across the ray an edge may be displaced: [`ACROSS`] ε·W, or more where one runs along the ray
    /// ([`ALONG`]).
    pub(crate) reach: f64,
}

impl Seen {
    /// Measures a triangle; `None` where the ray runs within its plane, or it has no area.
    pub(crate) fn of(ray: &Ray64, corners: [DVec3; 3]) -> Option<Seen> {
        let measure = Measure::exactly(ray, corners)?;
        let [a, b, c] = corners;
        let largest = [ray.o, a, b, c].iter().map(|p| p.abs().max_element()).fold(0.0, f64::max);
        let diameter = (b - a).length().max((c - b).length()).max((a - c).length());
        let unit = f32::EPSILON as f64 * largest;
        let height = (b - a).cross(c - a).length() / diameter;
        let plane = unit.max(f32::EPSILON as f64 * diameter * diameter / height);
        let aspect = diameter / (height * measure.cos);
        let off = |p: DVec3| (p - ray.o).cross(ray.d).length() / ray.d.length();
        let corner = off(a).min(off(b)).min(off(c));
        let farthest = [a, b, c].iter().map(|p| p.distance(ray.o)).fold(0.0, f64::max);
        // |e|/|e⊥| of the edge most along the ray.
        let lean = |e: DVec3| e.length() * ray.d.length() / e.cross(ray.d).length();
        let lean = lean(b - a).max(lean(c - b)).max(lean(a - c));
        let reach = (ACROSS * unit).max(ALONG * f64::from(f32::EPSILON) * farthest * lean);
        Some(Seen { measure, unit, plane, diameter, aspect, corner, reach })
    }

    pub(crate) fn grazes(&self) -> bool {
        self.measure.cos * self.diameter <= ACROSS * self.unit
    }

    /// By how much t (in units of length along the ray) is uncertain.
    pub(crate) fn blur(&self) -> f64 {
        PLANE * self.plane / self.measure.cos
    }

    pub(crate) fn at_border(&self) -> bool {
        self.measure.inset.abs() <= self.reach
    }

    pub(crate) fn outside(&self) -> bool {
        self.measure.inset < -self.reach
    }

    /// At its border only because an edge runs along the ray.
    pub(crate) fn leans(&self) -> bool {
        self.at_border() && self.measure.inset.abs() > ACROSS * self.unit
    }

    /// Within rounding of the interval's start or end.
    pub(crate) fn at_an_end(&self, ray: &Ray64) -> bool {
        let near = |end: f64| (self.measure.t - end).abs() * ray.d.length() <= self.blur();
        near(ray.tmin) || near(ray.tmax)
    }
}

/// An answer with what f64 says about the triangle it names.
pub(crate) struct Claim {
    answer: Answer,
    pub(crate) seen: Seen,
}

impl Judge {
    /// A judge that looks only at the triangles named. A leak through a closed surface's edge and the
    /// border of an open surface look the same to it: both are [`Verdict::Edge`].
    pub fn new(meshes: &[Arc<Mesh>]) -> Judge {
        Judge { meshes: meshes.to_vec(), brute: None }
    }

    /// A judge that tells a leak from a border, at the cost of some tens of looks at all triangles for every
    /// disagreement at an edge.
    pub fn thorough(meshes: &[Arc<Mesh>]) -> Judge {
        Judge { meshes: meshes.to_vec(), brute: Some(Brute::new(meshes)) }
    }

    /// Judges all active lanes of a chunk.
    pub fn compare(&self, rays: Checked<'_>, first: &Hits, second: &Hits, tally: &mut Tally) {
        for lane in (0..LANES).filter(|&lane| rays.active() >> lane & 1 == 1) {
            let (a, b) = (Answer::of(first, lane), Answer::of(second, lane));
            let verdict = self.verdict(rays.rays(), lane, a, b);
            let r = rays.rays();
            let (o, d, tmin, tmax) = (r.o(lane), r.d(lane), r.tmin[lane], r.tmax[lane]);
            tally.add(verdict, Disagreement { o, d, tmin, tmax, first: a, second: b });
        }
    }

    /// Judges one lane's two answers.
    pub fn verdict(&self, rays: &Rays, lane: usize, a: Option<Answer>, b: Option<Answer>) -> Verdict {
        let ray = Ray64::of(rays, lane);
        match (a, b) {
            (None, None) => Verdict::Same,
            (Some(a), None) | (None, Some(a)) => match self.claim(&ray, a) {
                Ok(claim) => self.against_miss(&ray, &claim),
                Err(verdict) => verdict,
            },
            (Some(a), Some(b)) => match (self.claim(&ray, a), self.claim(&ray, b)) {
                (Ok(a), Ok(b))
                    if (a.answer.mesh, a.answer.triangle) == (b.answer.mesh, b.answer.triangle) =>
                {
                    same_triangle(&ray, &a, &b)
                }
                (Ok(a), Ok(b)) => self.two_triangles(&ray, &a, &b),
                (Err(Verdict::Real), _) | (_, Err(Verdict::Real)) => Verdict::Real,
                (Err(verdict), _) | (_, Err(verdict)) => verdict,
            },
        }
    }

    /// Measures an answer. An answer that is wrong on its own, whatever the other says, is an error: a triangle
    /// that does not exist or is clearly missed, a point (u, v) that is not on the ray, a distance that is not
    /// the triangle's.
    pub(crate) fn claim(&self, ray: &Ray64, answer: Answer) -> Result<Claim, Verdict> {
        let corners = self.corners(&answer).ok_or(Verdict::Real)?;
        let [a, b, c] = corners;
        let seen = Seen::of(ray, corners).ok_or(Verdict::Graze)?;
        if seen.grazes() {
            return Err(Verdict::Graze);
        }
        let (u, v) = (answer.u as f64, answer.v as f64);
        let point = a * (1.0 - u - v) + b * u + c * v;
        let off = (point - ray.o).cross(ray.d).length() / ray.d.length();
        let along = (answer.t as f64 - seen.measure.t).abs() * ray.d.length();
        let wrong =
            seen.outside() || off > ACROSS * seen.unit * (1.0 + seen.aspect) || along > 2.0 * seen.blur();
        if wrong { Err(Verdict::Real) } else { Ok(Claim { answer, seen }) }
    }

    /// One says hit, the other miss.
    fn against_miss(&self, ray: &Ray64, hit: &Claim) -> Verdict {
        if hit.seen.at_an_end(ray) {
            return Verdict::Tie;
        }
        self.passed_by(ray, hit, f64::INFINITY)
    }

    fn two_triangles(&self, ray: &Ray64, a: &Claim, b: &Claim) -> Verdict {
        let (near, far) = if a.seen.measure.t <= b.seen.measure.t { (a, b) } else { (b, a) };
        let apart = (far.seen.measure.t - near.seen.measure.t) * ray.d.length();
        if apart <= near.seen.blur() + far.seen.blur() || near.seen.at_an_end(ray) {
            return Verdict::Tie;
        }
        self.passed_by(ray, near, (near.seen.measure.t + far.seen.measure.t) * 0.5)
    }

    /// The hit that the other backend did not see, though nothing before `beyond` hid it. Legitimate only
    /// where the surface has a border: if it goes on beyond its edges there, and rays displaced to all sides meet
    /// it, the other ray slipped through a crack.
    fn passed_by(&self, ray: &Ray64, hit: &Claim, beyond: f64) -> Verdict {
        if !hit.seen.at_border() {
            return Verdict::Real;
        }
        let Some(brute) = &self.brute else { return Verdict::Edge };
        let side = ray.d.normalize().any_orthonormal_vector();
        let other = side.cross(ray.d).normalize();
        let radius = 2.0 * ACROSS * hit.seen.unit;
        let surrounded = (0..8).all(|i| {
            let (sin, cos) = libm::sincos(f64::from(i) * std::f64::consts::FRAC_PI_4 + 0.2);
            let o = ray.o + (side * cos + other * sin) * radius;
            brute.any(&Ray64 { o, tmax: ray.tmax.min(beyond), ..*ray })
        });
        let is_leak = surrounded
            && self.corners(&hit.answer).is_some_and(|c| goes_on(&self.meshes, ray, c, hit.seen.reach));
        if is_leak { Verdict::Real } else { Verdict::Edge }
    }

    fn corners(&self, answer: &Answer) -> Option<[DVec3; 3]> {
        let mesh = self.meshes.get(answer.mesh as usize)?;
        let triangle = answer.triangle as usize;
        (triangle < mesh.indices.len()).then(|| mesh.triangle(triangle).map(|p| p.as_dvec3()))
    }
}

fn same_triangle(ray: &Ray64, a: &Claim, b: &Claim) -> Verdict {
    let apart = (a.answer.t as f64 - b.answer.t as f64).abs() * ray.d.length();
    if apart <= a.seen.blur() { Verdict::Same } else { Verdict::Real }
}
