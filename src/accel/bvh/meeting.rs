//! Where a ray meets one triangle: the f64 half of the test in [`super::triangle`], for any lane and triangle.

use super::node::{enlarge, max, min};
use super::ray::{Prepared, pick};
use super::tree::{Place, Tree};
use crate::accel::settle::is_in_doubt;
use crate::accel::{LANES, Mask, Rays};
use crate::math::Vec3;
use crate::math::isa::{Set, fused};

/// Where a ray meets a triangle, exactly.
#[derive(Clone, Copy, Debug)]
pub struct Meeting {
    /// It does, behind `tmin`. Otherwise the rest means nothing.
    pub is: bool,
    /// Distance, scaled.
    pub t: f32,
    /// Weight of the second corner.
    pub u: f32,
    /// Weight of the third corner.
    pub v: f32,
}

impl Meeting {
    /// The ray of lane `i` and any triangle.
    #[inline(always)]
    pub fn of<S: Set>([a, b, c]: [[f32; 3]; 3], rays: &Prepared, i: usize) -> Meeting {
        let (near, far) = box_interval::<S>(a, b, c, rays, i);
        let crossing = cross(frame(a, rays, i), frame(b, rays, i), frame(c, rays, i), rays.inverse_z[i]);
        crossing.clamped(near, far, rays.tmin[i])
    }

    // The boxes of all nodes above hold this one, and slab distances are monotone in the planes. So with t
    // inside the triangle's own slabs, no node above is entered later than t, and neither the tree nor
    // the order of traversal can change which hit wins. The margins should leave nothing to do here: t is
    // the z of a point of the triangle, whatever the angle. This makes it certain without their analysis.
    #[inline(always)]
    fn clamped(mut self, near: f32, far: f32, tmin: f32) -> Meeting {
        self.t = max(min(self.t, far), near);
        self.is &= (near <= far) & (tmin <= self.t);
        self
    }
}

/// A corner in the sheared frame. f32, in the same operations as `candidates`: the frame's rounded points are the
/// triangle.
#[inline(always)]
fn frame(p: [f32; 3], rays: &Prepared, i: usize) -> [f32; 3] {
    let z = pick(rays.axes[2][i], p) - rays.origin[2][i];
    let x = (pick(rays.axes[0][i], p) - rays.origin[0][i]) - rays.shear[0][i] * z;
    let y = (pick(rays.axes[1][i], p) - rays.origin[1][i]) - rays.shear[1][i] * z;
    [x, y, z]
}

/// Where the z axis meets the triangle.
#[inline(always)]
fn cross(a: [f32; 3], b: [f32; 3], c: [f32; 3], inverse_z: f64) -> Meeting {
    let [ax, ay, az] = [a[0] as f64, a[1] as f64, a[2] as f64];
    let [bx, by, bz] = [b[0] as f64, b[1] as f64, b[2] as f64];
    let [cx, cy, cz] = [c[0] as f64, c[1] as f64, c[2] as f64];
    let u = cx * by - cy * bx;
    let v = ax * cy - ay * cx;
    let w = bx * ay - by * ax;
    let inside = !(((u < 0.0) | (v < 0.0) | (w < 0.0)) & ((u > 0.0) | (v > 0.0) | (w > 0.0)));
    // Zero when seen edge-on. With one sign in all three, the sum is 0 only if each is.
    let det = u + v + w;
    let inverse = 1.0 / det;
    Meeting {
        is: inside & (det != 0.0),
        t: ((u * az + v * bz + w * cz) * inverse * inverse_z) as f32,
        u: (v * inverse) as f32,
        v: (w * inverse) as f32,
    }
}

/// Where the ray enters and leaves the triangle's own box, enlarged and computed as a node's.
#[inline(always)]
fn box_interval<S: Set>(a: [f32; 3], b: [f32; 3], c: [f32; 3], rays: &Prepared, i: usize) -> (f32, f32) {
    let least = |k: usize| min(min(a[k], b[k]), c[k]);
    let most = |k: usize| max(max(a[k], b[k]), c[k]);
    let (lo, hi) = enlarge([least(0), least(1), least(2)], [most(0), most(1), most(2)]);
    let slab = |k: usize| {
        let forwards = rays.near_side[k][i] == 0;
        let (first, last) = (if forwards { lo[k] } else { hi[k] }, if forwards { hi[k] } else { lo[k] });
        let inverse = rays.inverse[k][i];
        (fused::<S>(first, inverse, -rays.near_start[k][i]), fused::<S>(last, inverse, -rays.far_start[k][i]))
    };
    let ((x0, x1), (y0, y1), (z0, z1)) = (slab(0), slab(1), slab(2));
    (max(max(x0, y0), z0), min(min(x1, y1), z1))
}

/// A triangle for each lane of a chunk.
pub struct Meetings {
    /// 1 where [`Meeting::is`], and not behind the end of the interval; else 0.
    pub is: [u32; LANES],
    /// As [`Meeting::t`].
    pub t: [f32; LANES],
    /// As [`Meeting::u`].
    pub u: [f32; LANES],
    /// As [`Meeting::v`].
    pub v: [f32; LANES],
    /// The corners, by axis.
    corners: [[[f32; LANES]; 3]; 3],
}

impl Meetings {
    /// No ray meets anything.
    pub const NONE: Meetings = Meetings {
        is: [0; LANES],
        t: [0.0; LANES],
        u: [0.0; LANES],
        v: [0.0; LANES],
        corners: [[[0.0; LANES]; 3]; 3],
    };

    /// Which of those in `hit` are to be settled (`accel/settle.rs`).
    #[inline(always)]
    pub fn in_doubt(&self, source: &Rays, hit: Mask) -> Mask {
        let [a, b, c] = &self.corners;
        let mut in_doubt = [0u32; LANES];
        for (i, in_doubt) in in_doubt.iter_mut().enumerate() {
            let corners = [at(a, i), at(b, i), at(c, i)].map(Vec3::from_array);
            *in_doubt = is_in_doubt(source.o(i), source.d(i), [self.u[i], self.v[i]], corners) as u32;
        }
        (0..LANES).fold(0, |mask, i| mask | (in_doubt[i] as Mask) << i) & hit
    }

    /// The ray of each lane and the triangle at its place.
    #[inline(always)]
    pub fn of<S: Set>(tree: &Tree<'_>, places: &[Place; LANES], rays: &Prepared) -> Meetings {
        let zero = [0.0f32; LANES];
        let mut corners = [[zero; 3]; 3];
        if !tree.blocks.is_empty() {
            for (i, place) in places.iter().enumerate() {
                let block = &tree.blocks[place.block()];
                for (to, from) in corners.iter_mut().zip(&block.corners) {
                    for (to, from) in to.iter_mut().zip(from) {
                        to[i] = from[place.lane()];
                    }
                }
            }
        }
        let mut framed = [[zero; 3]; 3];
        let (mut near, mut far) = (zero, zero);
        let [a, b, c] = &corners;
        // Three loops without a branch, each small enough to be vectorised.
        for i in 0..LANES {
            (near[i], far[i]) = box_interval::<S>(at(a, i), at(b, i), at(c, i), rays, i);
        }
        for (framed, corner) in framed.iter_mut().zip(&corners) {
            let [x, y, z] = framed;
            for i in 0..LANES {
                [x[i], y[i], z[i]] = frame(at(corner, i), rays, i);
            }
        }
        let [a, b, c] = &framed;
        let mut all = Meetings { is: [0; LANES], t: zero, u: zero, v: zero, corners };
        for i in 0..LANES {
            let m = cross(at(a, i), at(b, i), at(c, i), rays.inverse_z[i]);
            let m = m.clamped(near[i], far[i], rays.tmin[i]);
            all.is[i] = (m.is & (m.t <= rays.tmax[i])) as u32;
            (all.t[i], all.u[i], all.v[i]) = (m.t, m.u, m.v);
        }
        all
    }
}

#[inline(always)]
fn at([x, y, z]: &[[f32; LANES]; 3], i: usize) -> [f32; 3] {
    [x[i], y[i], z[i]]
}
