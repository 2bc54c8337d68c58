//! Which hits need a closer look, from what Embree has just said: without a look at the triangle, which costs a
//! cache miss or four.
//!
//! `settle` doubts a hit when  least weight · area ≤ 16·ε·W·L·|d|  with the area |d·(e×f)| of the parallelogram
//! across the ray, L the longest edge and W the corners' largest offset from the ray's origin. Embree's hit comes with
//! its weights and with e×f, so the left side is known but for rounding (at most 8·ε·W·L·|d| times the least weight,
//! which is at most ⅓). On the right, the longest edge of the whole mesh stands for L, and t·max|dᵢ| + L for W. What t is
//! off by grows as the triangle is seen edge-on, but area shrinks with it: where the left side is three margins, it is at
//! most L/5. So no hit is passed over that `settle` would look at (for a reason other than its own overflow), and most of
//! the others are spared it.

use crate::accel::{Hits, LANES, MISS, Mask, Rays};
use crate::math::Vec3;
use crate::math::soa::mask;

/// |d·(e×f)| of each lane's hit.
pub(super) type Areas = [f32; LANES];

/// The sixteen roundings of `settle`, a fifth more for t and three for the left side.
const ROUNDINGS: f32 = 24.0 * f32::EPSILON;

/// The length of a triangle's longest edge.
#[inline]
pub(super) fn longest_edge([a, b, c]: [Vec3; 3]) -> f32 {
    (b - a).length_squared().max((c - b).length_squared()).max((a - c).length_squared()).sqrt()
}

/// The active lanes that hit something and are not clear of all edges; `longest` holds a length a mesh.
#[inline(always)]
pub(super) fn doubtful(rays: &Rays, active: Mask, hits: &Hits, areas: &Areas, longest: &[f32]) -> Mask {
    let mut lengths = [0.0; LANES];
    for (lane, length) in lengths.iter_mut().enumerate() {
        // A miss has no mesh.
        if let Some(longest) = longest.get(hits.mesh[lane] as usize) {
            *length = *longest;
        }
    }
    let mut doubtful = [false; LANES];
    for lane in 0..LANES {
        // Rounded up.
        let (u, v, length) = (hits.u[lane], hits.v[lane], lengths[lane] * (1.0 + 4.0 * f32::EPSILON));
        let least = u.min(v).min(1.0 - u - v).max(0.0);
        let [x, y, z] = [rays.dx[lane], rays.dy[lane], rays.dz[lane]];
        let (d, largest) = ((x * x + y * y + z * z).sqrt(), x.abs().max(y.abs()).max(z.abs()));
        let inside = least * areas[lane];
        let margin = ROUNDINGS * d * (hits.t[lane] * largest + length) * length;
        // What overflowed or lost its digits says nothing.
        let clear = (inside > margin) & (inside < f32::INFINITY) & (margin >= f32::MIN_POSITIVE);
        doubtful[lane] = !clear & (hits.mesh[lane] != MISS);
    }
    mask(&doubtful) & active
}
