//! What a ray may hit of a triangle, in f32 and with bounds of the errors.
//!
//! With u = 2⁻²⁴, let D be the largest |p − o| along an axis, p any corner of the scene, |d|∞ < 2, and n the plane's normal with
//! |n|₁ = 1. The numerator of t = n·(a − o)/n·d is off by at most 5u·D (the difference, n, the products and sums), the
//! denominator by 8u, so t by 5u·D/|n·d| + |t|·9u/|n·d| as long as that is small against t, and else the triangle is a
//! candidate anyway ([`GRAZING`]). The exact test takes a corner to be within 6u·D of where it is ([`super::node`]),
//! which moves t by 6u·D/|n·d| again. It is important to be no more careful than that: a ray that leaves a
//! surface starts 32u·|o| above it, and its own triangle should not be a candidate. The weights m·p + k are off
//! by |m|₁·(2δ + 16u·W), W the largest of |o|, |t·d| and the scene's coordinates; nothing is won by being strict there.

use super::ray::Prepared;
use super::tree::Place;
use crate::accel::{LANES, Rays};
use crate::math::isa::{Set, fused};
use crate::math::{Aabb, DVec3, Vec3};

/// 2⁻²⁴.
const U: f32 = f32::EPSILON / 2.0;

/// Below this |n·d|, nothing is said about t.
const GRAZING: f32 = 256.0 * U;

/// The plane of a triangle, or of several with the same one.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    /// Its normal, |n|₁ = 1, the first component that is not 0 positive.
    n: Vec3,
    /// A corner of all of its triangles.
    a: Vec3,
}

/// What the filter knows of a triangle in its plane.
#[derive(Clone, Copy, Debug)]
pub struct Filter {
    /// u = m·p + k, and v.
    u: (Vec3, f32),
    v: (Vec3, f32),
    /// The largest |m|₁ of u, v and 1 − u − v.
    pub slope: f32,
    /// Where the triangle is kept.
    pub place: Place,
}

/// The parts of the bounds that belong to a ray alone.
pub struct Scales {
    /// 12u·D.
    far: [f32; LANES],
    /// 32u·(|o| + |p|).
    near: [f32; LANES],
}

impl Scales {
    /// Of rays in a scene with that box.
    #[inline(always)]
    pub fn of(bounds: &Aabb, source: &Rays, rays: &Prepared) -> Scales {
        let (lo, hi, reach) = (bounds.min, bounds.max, reach(bounds));
        let mut scales = Scales { far: [0.0; LANES], near: [0.0; LANES] };
        for i in 0..LANES {
            let farthest = |lo: f32, hi: f32, o: f32| if hi - o > o - lo { hi - o } else { o - lo };
            let x = farthest(lo.x, hi.x, source.ox[i]);
            let y = farthest(lo.y, hi.y, source.oy[i]);
            let z = farthest(lo.z, hi.z, source.oz[i]);
            let far = if x > y { x } else { y };
            let far = if far > z { far } else { z };
            scales.far[i] = far * (12.0 * U);
            scales.near[i] = (rays.reach[i] + reach) * (32.0 * U);
        }
        scales
    }
}

/// Where the rays of a chunk pass a plane; conditions are 0 or 1.
pub struct Passage {
    point: [[f32; LANES]; 3],
    /// What the weights are off by, over the slope.
    off: [f32; LANES],
    /// The least distance that it may have; 0 where nothing is said about it.
    pub least: [f32; LANES],
    /// It may lie between the ray's ends; it does.
    between: [u32; LANES],
    surely_between: [u32; LANES],
    /// Nothing is said.
    grazing: [u32; LANES],
}

/// What is known about a ray and a triangle.
pub struct Measured {
    /// It may be hit.
    pub may_be: u32,
    /// It is hit.
    pub is: u32,
}

impl Plane {
    /// Of the triangle with those corners; `None` for one so thin that f32 cannot hold it.
    pub fn of([a, b, c]: [Vec3; 3]) -> Option<Plane> {
        let [e, f] = [b, c].map(|p| p.as_dvec3() - a.as_dvec3());
        let n = e.cross(f);
        let n = n / one_norm(n);
        let first = n.to_array().into_iter().find(|x| *x != 0.0)?;
        n.is_finite().then(|| Plane { n: (n * first.signum()).as_vec3(), a })
    }

    /// Whether the triangle with those corners and its plane `other` is in this plane, as far as f32 can tell either's
    /// error from the other's.
    pub fn holds(&self, corners: [Vec3; 3], other: &Plane) -> bool {
        self.n == other.n && corners.contains(&self.a)
    }

    /// Where the rays, which start where `source` says, pass it.
    #[inline(always)]
    pub fn pass<S: Set>(&self, source: &Rays, rays: &Prepared, scales: &Scales) -> Passage {
        let (zeros, none) = ([0.0; LANES], [0; LANES]);
        let mut passage = Passage {
            point: [zeros; 3],
            off: zeros,
            least: zeros,
            between: none,
            surely_between: none,
            grazing: none,
        };
        for i in 0..LANES {
            let o = source.o(i);
            let d = Vec3::new(rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]);
            let along = dot::<S>(self.n, d, 0.0);
            let inverse = 1.0 / along;
            let from = Vec3::new(self.a.x - o.x, self.a.y - o.y, self.a.z - o.z);
            let t = dot::<S>(self.n, from, 0.0) * inverse;
            passage.point[0][i] = fused::<S>(d.x, t, o.x);
            passage.point[1][i] = fused::<S>(d.y, t, o.y);
            passage.point[2][i] = fused::<S>(d.z, t, o.z);
            let off = fused::<S>(t.abs(), 16.0 * U, scales.far[i]) * inverse.abs();
            passage.off[i] = fused::<S>(2.0, off, fused::<S>(t.abs(), 64.0 * U, scales.near[i]));
            let clear = along.abs() > GRAZING;
            let (least, most) = (t - off, t + off);
            passage.least[i] = if clear { least } else { 0.0 };
            passage.between[i] = ((most >= rays.tmin[i]) & (least <= rays.tmax[i])) as u32;
            passage.surely_between[i] = ((least >= rays.tmin[i]) & (most <= rays.tmax[i]) & clear) as u32;
            passage.grazing[i] = !clear as u32;
        }
        passage
    }
}

impl Filter {
    /// `None` for one so thin that f32 cannot hold its filter.
    pub fn new(corners: [Vec3; 3], place: Place) -> Option<Filter> {
        let [a, b, c] = corners.map(|p| p.as_dvec3());
        let (e, f) = (b - a, c - a);
        let n = e.cross(f);
        // u = (p − a)·(f × n)/(e·(f × n)) and so on: the dual basis of e and f in the plane.
        let (mu, mv) = (f.cross(n), n.cross(e));
        let (mu, mv) = (mu / e.dot(mu), mv / f.dot(mv));
        let slope = one_norm(mu).max(one_norm(mv)).max(one_norm(mu + mv));
        (slope < 1e12).then(|| Filter {
            u: (mu.as_vec3(), -mu.dot(a) as f32),
            v: (mv.as_vec3(), -mv.dot(a) as f32),
            slope: slope as f32,
            place,
        })
    }

    /// The ray of lane `i`, which passes the plane of the triangle there.
    #[inline(always)]
    pub fn measure<S: Set>(&self, passage: &Passage, i: usize) -> Measured {
        let p = Vec3::new(passage.point[0][i], passage.point[1][i], passage.point[2][i]);
        let (u, v) = (dot::<S>(self.u.0, p, self.u.1), dot::<S>(self.v.0, p, self.v.1));
        let uv = 1.0 - u - v;
        let inside = if u < v { u } else { v };
        let inside = if inside < uv { inside } else { uv };
        let doubt = fused::<S>(self.slope, passage.off[i], 16.0 * U);
        Measured {
            may_be: (inside >= -doubt) as u32 & passage.between[i] | passage.grazing[i],
            is: (inside >= doubt) as u32 & passage.surely_between[i],
        }
    }
}

/// Largest absolute coordinate in a box.
pub fn reach(bounds: &Aabb) -> f32 {
    bounds.min.abs().max(bounds.max.abs()).max_element()
}

fn one_norm(v: DVec3) -> f64 {
    let v = v.abs();
    v.x + v.y + v.z
}

#[inline(always)]
fn dot<S: Set>(a: Vec3, b: Vec3, c: f32) -> f32 {
    fused::<S>(a.x, b.x, fused::<S>(a.y, b.y, fused::<S>(a.z, b.z, c)))
}
