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
//!
//! A triangle seen edge-on is a matter of its own: Embree's distance to it may be anything, and hide what the ray clearly
//! meets before. [`beside`] asks again, past such a triangle.

mod aim;
mod beside;
mod candidates;

#[cfg(feature = "embree")]
use super::MISS;
use super::brute::Ray64;
use super::{Hits, Mask, Rays, lanes_of};
use crate::math::{DVec3, Vec3};
use aim::aim_inside;
use beside::look_beside;
use candidates::{Candidate, Found, around, best_met, hiding};

/// Hits nearer to an edge than this many roundings of the corners' largest offset from the ray's origin are
/// looked at again. Backends' edge functions are off by up to about four; the rest is for the order of two
/// triangles that meet at an acute angle, whose distances from the ray's origin differ by less than the inset.
const ROUNDINGS: f64 = 16.0;

/// How far, in roundings, a ray may be moved to get inside a triangle.
pub(crate) const FARTHEST: f64 = 64.0;

/// What a backend tells of its triangles. No function may panic.
pub(super) trait Triangles {
    /// The corners of the triangle that `lane` hit.
    fn hit(&self, hits: &Hits, lane: usize) -> [Vec3; 3];

    /// Calls `each` with mesh, triangle and corners of at least all triangles whose boxes come within `radius`
    /// of `point`.
    fn around(&self, point: Vec3, radius: f32, each: &mut dyn FnMut([u32; 2], [Vec3; 3]));

    /// The closest hits, not settled, of other rays. `None` from a backend that keeps the distance to a triangle within
    /// the triangle's box, however it is seen: nothing can be hidden by it then that [`Triangles::around`] does not find.
    fn ask(&self, _rays: &Rays, _active: Mask) -> Option<Hits> {
        None
    }
}

/// Settles the hits of a chunk that are [`in_doubt`].
#[inline(always)]
pub(super) fn settle(triangles: &impl Triangles, rays: &Rays, in_doubt: Mask, hits: &mut Hits) {
    for lane in lanes_of(in_doubt) {
        settle_one(triangles, rays, lane, hits);
    }
}

/// The hits of the active lanes that are in doubt. (Our own BVH asks where it has the corners.)
#[cfg(feature = "embree")]
#[inline(always)]
pub(super) fn in_doubt(triangles: &impl Triangles, rays: &Rays, active: Mask, hits: &Hits) -> Mask {
    let is = |lane: usize| {
        let corners = triangles.hit(hits, lane);
        is_in_doubt(rays.o(lane), rays.d(lane), [hits.u[lane], hits.v[lane]], corners)
    };
    let hit = lanes_of(active).filter(|&lane| hits.mesh[lane] != MISS);
    hit.fold(0, |mask, lane| mask | (is(lane) as Mask) << lane)
}

/// True when a hit with the weights u, v lies within [`ROUNDINGS`] of an edge, seen along the ray. A parallelogram's area
/// is edge times height, so the distance from an edge is the opposite corner's weight times the area over the edge; the
/// longest edge errs on the side of doubt. The same bits wherever it is compiled: no operation is fused.
#[inline(always)]
pub(super) fn is_in_doubt(o: Vec3, d: Vec3, [u, v]: [f32; 2], corners: [Vec3; 3]) -> bool {
    let [a, b, c] = corners.map(|p| p - o);
    let (e, f) = (b - a, c - a);
    let area = d.dot(e.cross(f)).abs();
    let longest = e.length_squared().max(f.length_squared()).max((c - b).length_squared());
    let largest = a.abs().max(b.abs()).max(c.abs()).max_element();
    let least = u.min(v).min(1.0 - u - v).max(0.0);
    // Not `<=` turned round: what overflows to NaN is in doubt.
    let clear =
        least * area > ROUNDINGS as f32 * f32::EPSILON * largest * (longest * d.length_squared()).sqrt();
    !clear
}

#[cold]
fn settle_one(triangles: &impl Triangles, rays: &Rays, lane: usize, hits: &mut Hits) {
    let ray = Ray64::of(rays, lane);
    let ids = [hits.mesh[lane], hits.triangle[lane]];
    let first = Candidate { ids, corners: triangles.hit(hits, lane).map(|p| p.as_dvec3()) };
    let mut of = first;
    // A front, a sliver or two at the silhouette, a back; more than three rounds have not been seen.
    for _ in 0..8 {
        let around = around(triangles, &ray, &of.corners, [hits.u[lane], hits.v[lane]]);
        let better = match aim_inside(&ray, &of.corners) {
            Some(aimed) => hiding(&ray, &aimed, &of, &around),
            // The ray does not come near enough to where this one is wide enough: another does better.
            None => best_met(&ray, &of, &around),
        };
        let Some(better) = better else { break };
        write(&better, lane, hits);
        of = better.candidate;
    }
    look_beside(triangles, rays, lane, [&first, &of], hits);
}

fn write(found: &Found, lane: usize, hits: &mut Hits) {
    (hits.t[lane], hits.u[lane], hits.v[lane]) = (found.t as f32, found.u as f32, found.v as f32);
    [hits.mesh[lane], hits.triangle[lane]] = found.candidate.ids;
}

/// One rounding of the largest offset of the corners from the ray's origin.
fn rounding(ray: &Ray64, corners: &[DVec3; 3]) -> f64 {
    let largest = corners.iter().fold(DVec3::ZERO, |w, p| w.max((*p - ray.o).abs()));
    f64::from(f32::EPSILON) * largest.max_element()
}
