//! A scene of a few triangles: all rays of a chunk against every triangle, without a tree.
//!
//! A room has some tens of triangles. A tree over them leaves out half, one ray at a time; sixteen lanes test all of
//! them in less. The test is a filter in f32: the triangle's plane gives t, and two affine functions the weights u, v
//! of the point there, each with a bound of its error (u = 2⁻²⁴, the roundings of the constants included). What
//! may be hit is kept by its least possible distance, and the exact test of [`super::triangle`] decides: the
//! nearest candidate of all lanes at once, and the few others one by one where they may be as near. So the answers are
//! bit for bit the tree's.
//!
//! **Bounds.** Let D be the largest |p − o| along an axis, p any corner of the scene, |d|∞ < 2, and n the plane's normal with
//! |n|₁ = 1. The numerator of t = n·(a − o)/n·d is off by at most 5u·D (the difference, n, the products and sums), the
//! denominator by 8u, so t by 5u·D/|n·d| + |t|·9u/|n·d| as long as that is small against t, and else the triangle is a
//! candidate anyway ([`GRAZING`]). The exact test takes a corner to be within 6u·D of where it is ([`super::node`]),
//! which moves t by 6u·D/|n·d| again. It is important to be no more careful than that: a ray that leaves a
//! surface starts 32u·|o| above it, and its own triangle should not be a candidate. The weights m·p + k are off
//! by |m|₁·(2δ + 16u·W), W the largest of |o|, |t·d| and the scene's coordinates; nothing is won by being strict there.

use super::meeting::Meetings;
use super::ray::Prepared;
use super::traverse::each;
use super::tree::{Found, Place, Tree, rank};
use super::triangle::Block;
use crate::accel::{LANES, Mask, Rays};
use crate::math::isa::{Isa, Set};
use crate::math::{Aabb, DVec3, Vec3};

/// Up to how many triangles this is faster than the tree.
pub const FEW: usize = 64;

/// 2⁻²⁴.
const U: f32 = f32::EPSILON / 2.0;

/// Below this |n·d|, nothing is said about t.
const GRAZING: f32 = 256.0 * U;

/// What the filter knows of a triangle.
#[derive(Clone, Copy, Debug)]
struct Filter {
    /// Normal of the plane, |n|₁ = 1, and a corner.
    n: Vec3,
    a: Vec3,
    /// u = m·p + k, and v.
    u: (Vec3, f32),
    v: (Vec3, f32),
    /// The largest |m|₁ of u, v and 1 − u − v.
    slope: f32,
    place: Place,
}

/// The triangles of a small scene.
pub struct Few {
    filters: Vec<Filter>,
    bounds: Aabb,
    /// Largest absolute coordinate.
    reach: f32,
}

/// The parts of the bounds that belong to a ray alone.
struct Scales {
    /// 12u·D.
    far: [f32; LANES],
    /// 32u·(|o| + |p|).
    near: [f32; LANES],
}

#[derive(Clone, Copy)]
struct Scale {
    far: f32,
    near: f32,
}

impl Scales {
    #[inline(always)]
    fn at(&self, i: usize) -> Scale {
        Scale { far: self.far[i], near: self.near[i] }
    }
}

/// In the key of a candidate: the bits of its number.
const NUMBER: u32 = FEW as u32 - 1;

/// The two nearest candidates of each lane: bits of the least distance, rounded down, with the triangle's number in
/// [`NUMBER`]; all ones where there is none.
struct Nearest {
    first: [u32; LANES],
    second: [u32; LANES],
}

impl Few {
    /// `None` when there are too many, or one so thin that f32 cannot hold its filter.
    pub fn new(blocks: &[Block]) -> Option<Few> {
        let mut few = Few { filters: Vec::new(), bounds: Aabb::EMPTY, reach: 0.0 };
        if blocks.len() > FEW {
            return None;
        }
        let mut seen = Vec::new();
        for (index, block) in blocks.iter().enumerate() {
            for lane in (0..block.mesh.len()).filter(|&lane| block.mesh[lane] != u32::MAX) {
                // A triangle that was split in space is in several leaves.
                if seen.contains(&block.ids(lane)) {
                    continue;
                }
                seen.push(block.ids(lane));
                let corners = block.triangle_at(lane);
                few.filters.push(Filter::new(corners, Place::new(index, lane))?);
                few.bounds = corners.iter().fold(few.bounds, |b, p| b.grow(*p));
            }
        }
        few.reach = few.bounds.min.abs().max(few.bounds.max.abs()).max_element();
        // Beyond the first, nearly everything would be in doubt; beyond the second, products may leave the range.
        let sharp = few.filters.iter().all(|f| f.slope * few.reach < 1e4);
        (few.filters.len() <= FEW && sharp && few.reach < 1e12).then_some(few)
    }

    /// The closest hits of the live rays, as [`Tree::closest`].
    #[inline(always)]
    pub fn closest<S: Set>(&self, tree: &Tree<'_>, source: &Rays, rays: &Prepared) -> Found {
        let nearest = self.nearest::<S>(source, rays);
        let place = |key: u32| match key {
            u32::MAX => Place::default(),
            key => self.filters[(key & NUMBER) as usize].place,
        };
        let mut found = Found { hit: 0, place: nearest.first.map(place) };
        let meetings = Meetings::of(tree, &found.place, rays);
        let mut again = 0;
        for i in 0..LANES {
            let hit = (meetings.is[i] == 1) & (nearest.first[i] != u32::MAX);
            // Whatever else may be hit is farther. (Where the first is a miss, nothing else may be hit.)
            let second = nearest.second[i];
            let sure = second == u32::MAX || hit && second & !NUMBER > meetings.t[i].to_bits();
            found.hit |= (hit as Mask) << i;
            again |= (!sure as Mask) << i;
        }
        found.hit &= rays.live;
        each(again & rays.live, |i| {
            let place = tree.closest_of_all(rays, i);
            found.hit = found.hit & !(1 << i) | (place.is_some() as Mask) << i;
            found.place[i] = place.unwrap_or_default();
        });
        found
    }

    /// The live rays that hit anything.
    #[inline(always)]
    pub fn occluded<S: Set>(&self, tree: &Tree<'_>, source: &Rays, rays: &Prepared) -> Mask {
        let (sure, maybe) = self.any::<S>(source, rays);
        let mut hit = sure & rays.live;
        each(maybe & !sure & rays.live, |i| hit |= (tree.closest_of_all(rays, i).is_some() as Mask) << i);
        hit
    }

    #[inline(always)]
    fn nearest<S: Set>(&self, source: &Rays, rays: &Prepared) -> Nearest {
        let scales = self.scales(source, rays);
        let mut first = [u32::MAX; LANES];
        let mut second = [u32::MAX; LANES];
        for (number, filter) in self.filters.iter().enumerate() {
            for i in 0..LANES {
                let m = filter.measure::<S>(source.o(i), rays, i, scales.at(i));
                // Not negative, so that its bits are in its order; the lowest give way to the triangle's number.
                let least = if m.least > 0.0 { m.least } else { 0.0 };
                let key = least.to_bits() & !NUMBER | number as u32;
                let key = if m.may_be { key } else { u32::MAX };
                second[i] = second[i].min(first[i].max(key));
                first[i] = first[i].min(key);
            }
        }
        Nearest { first, second }
    }

    #[inline(always)]
    fn scales(&self, source: &Rays, rays: &Prepared) -> Scales {
        let (lo, hi) = (self.bounds.min, self.bounds.max);
        let mut scales = Scales { far: [0.0; LANES], near: [0.0; LANES] };
        for i in 0..LANES {
            let farthest = |lo: f32, hi: f32, o: f32| if hi - o > o - lo { hi - o } else { o - lo };
            let x = farthest(lo.x, hi.x, source.ox[i]);
            let y = farthest(lo.y, hi.y, source.oy[i]);
            let z = farthest(lo.z, hi.z, source.oz[i]);
            let far = if x > y { x } else { y };
            let far = if far > z { far } else { z };
            scales.far[i] = far * (12.0 * U);
            scales.near[i] = (rays.reach[i] + self.reach) * (32.0 * U);
        }
        scales
    }

    /// The lanes that certainly hit something, and those that may.
    #[inline(always)]
    fn any<S: Set>(&self, source: &Rays, rays: &Prepared) -> (Mask, Mask) {
        let scales = self.scales(source, rays);
        let (mut sure, mut maybe) = ([0u32; LANES], [0u32; LANES]);
        for filter in &self.filters {
            for i in 0..LANES {
                let m = filter.measure::<S>(source.o(i), rays, i, scales.at(i));
                sure[i] |= m.is as u32;
                maybe[i] |= m.may_be as u32;
            }
        }
        let bits = |lanes: [u32; LANES]| (0..LANES).fold(0, |mask, i| mask | (lanes[i] as Mask) << i);
        (bits(sure), bits(maybe))
    }
}

/// What is known about a ray and a triangle.
struct Measured {
    /// It may be hit.
    may_be: bool,
    /// It is hit.
    is: bool,
    /// The least distance that it may have.
    least: f32,
}

impl Filter {
    fn new(corners: [Vec3; 3], place: Place) -> Option<Filter> {
        let [a, b, c] = corners.map(|p| p.as_dvec3());
        let (e, f) = (b - a, c - a);
        let n = e.cross(f);
        // u = (p − a)·(f × n)/(e·(f × n)) and so on: the dual basis of e and f in the plane.
        let (mu, mv) = (f.cross(n), n.cross(e));
        let (mu, mv) = (mu / e.dot(mu), mv / f.dot(mv));
        let n = n / one_norm(n);
        let slope = one_norm(mu).max(one_norm(mv)).max(one_norm(mu + mv));
        let sound = n.is_finite() && slope < 1e12;
        sound.then(|| Filter {
            n: n.as_vec3(),
            a: a.as_vec3(),
            u: (mu.as_vec3(), -mu.dot(a) as f32),
            v: (mv.as_vec3(), -mv.dot(a) as f32),
            slope: slope as f32,
            place,
        })
    }

    #[inline(always)]
    fn measure<S: Set>(&self, o: Vec3, rays: &Prepared, i: usize, scale: Scale) -> Measured {
        let d = Vec3::new(rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]);
        let along = dot::<S>(self.n, d, 0.0);
        let inverse = 1.0 / along;
        let from = Vec3::new(self.a.x - o.x, self.a.y - o.y, self.a.z - o.z);
        let t = dot::<S>(self.n, from, 0.0) * inverse;
        let p = Vec3::new(add::<S>(d.x, t, o.x), add::<S>(d.y, t, o.y), add::<S>(d.z, t, o.z));
        let off = add::<S>(t.abs(), 16.0 * U, scale.far) * inverse.abs();
        let (u, v) = (dot::<S>(self.u.0, p, self.u.1), dot::<S>(self.v.0, p, self.v.1));
        let uv = 1.0 - u - v;
        let inside = if u < v { u } else { v };
        let inside = if inside < uv { inside } else { uv };
        let w = add::<S>(t.abs(), 64.0 * U, scale.near);
        let doubt = add::<S>(self.slope, add::<S>(2.0, off, w), 16.0 * U);
        let clear = along.abs() > GRAZING;
        let (least, most) = (t - off, t + off);
        let on = (inside >= -doubt) & (most >= rays.tmin[i]) & (least <= rays.tmax[i]);
        let within = (inside >= doubt) & (least >= rays.tmin[i]) & (most <= rays.tmax[i]);
        Measured { may_be: on | !clear, is: within & clear, least: if clear { least } else { 0.0 } }
    }
}

fn one_norm(v: DVec3) -> f64 {
    let v = v.abs();
    v.x + v.y + v.z
}

/// a·b + c, fused where that is one instruction.
#[inline(always)]
fn add<S: Set>(a: f32, b: f32, c: f32) -> f32 {
    if matches!(S::ISA, Isa::Baseline) { a * b + c } else { a.mul_add(b, c) }
}

#[inline(always)]
fn dot<S: Set>(a: Vec3, b: Vec3, c: f32) -> f32 {
    add::<S>(a.x, b.x, add::<S>(a.y, b.y, add::<S>(a.z, b.z, c)))
}

impl Tree<'_> {
    /// The closest hit of one ray among all triangles, without the nodes.
    #[cold]
    fn closest_of_all(&self, rays: &Prepared, i: usize) -> Option<Place> {
        let mut best = (rays.tmax[i], u64::MAX, None);
        for (index, block) in self.blocks.iter().enumerate() {
            let (mut met, t) = block.meet(rays, i, best.0);
            while met != 0 {
                let lane = met.trailing_zeros() as usize;
                met &= met - 1;
                let id = rank(block.ids(lane));
                if (t[lane], id) < (best.0, best.1) {
                    best = (t[lane], id, Some(Place::new(index, lane)));
                }
            }
        }
        best.2
    }
}
