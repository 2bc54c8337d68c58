//! The watertight triangle test of Woop, Benthin and Wald 2013 ("Watertight ray/triangle intersection", JCGT
//! 2(1)), four triangles at a time.
//!
//! The ray is made the z axis of a sheared frame by `x' = x − (d_x/d_z)·z`, `y' = y − (d_y/d_z)·z`. A vertex is
//! transformed from its own coordinates alone, so neighbours that share it see the same rounded point, and
//! the three edge functions (`U = C_x·B_y − C_y·B_x`, …) tell on which side of each projected edge the ray
//! passes. Neighbours evaluate a shared edge with exactly opposite signs, hence no ray slips between them.
//!
//! In f32, an edge function has the right sign or is 0: rounding is monotone, so a·b > c·d implies
//! fl(a·b) ≥ fl(c·d). [`Block::candidates`] therefore sorts out with f32 alone what is certainly missed, and
//! [`Block::hit`] decides the few others in f64, where the products of two f32 are exact: signs are exact, a
//! ray through an edge or vertex (a function of exactly 0) hits, and neither tiny nor huge scales leave the
//! range.

use super::node::{enlarge, max, min};
use super::ray::{Ray, SlabRay};
use crate::math::Vec3;

/// Triangles of a block.
pub const BLOCK: usize = 4;

/// Four triangles, structure of arrays, 176 bytes.
#[derive(Clone, Debug)]
#[repr(C, align(16))]
pub struct Block {
    /// Corner, then axis, then triangle. Unused lanes hold NaN, which fails every comparison.
    pub corners: [[[f32; BLOCK]; 3]; 3],
    /// Mesh ids.
    pub mesh: [u32; BLOCK],
    /// Triangle ids.
    pub triangle: [u32; BLOCK],
}

/// A hit; `t` as in [`Ray`], scaled.
#[derive(Clone, Copy, Debug)]
pub struct Hit {
    /// Distance.
    pub t: f32,
    /// Weight of the second corner.
    pub u: f32,
    /// Weight of the third corner.
    pub v: f32,
    /// Mesh id in the upper half, triangle id in the lower: the order in which ties are broken.
    pub id: u64,
}

impl Block {
    /// A block without triangles.
    pub const EMPTY: Block =
        Block { corners: [[[f32::NAN; BLOCK]; 3]; 3], mesh: [u32::MAX; BLOCK], triangle: [u32::MAX; BLOCK] };

    /// Puts a triangle into a lane.
    pub fn set(&mut self, lane: usize, corners: [[f32; 3]; 3], mesh: u32, triangle: u32) {
        for (corner, point) in corners.iter().enumerate() {
            for (axis, x) in point.iter().enumerate() {
                self.corners[corner][axis][lane] = *x;
            }
        }
        self.mesh[lane] = mesh;
        self.triangle[lane] = triangle;
    }

    /// Mesh and triangle in a lane.
    pub fn ids(&self, lane: usize) -> [u32; 2] {
        [self.mesh[lane % BLOCK], self.triangle[lane % BLOCK]]
    }

    /// The corners of the triangle in a lane.
    #[inline(always)]
    pub fn triangle_at(&self, lane: usize) -> [Vec3; 3] {
        let lane = lane % BLOCK;
        [0, 1, 2].map(|corner| {
            let [x, y, z] = &self.corners[corner];
            Vec3::new(x[lane], y[lane], z[lane])
        })
    }

    /// One bit for each triangle that the ray's line may meet: those whose edge functions have no two
    /// opposite signs in f32.
    #[inline(always)]
    pub fn candidates(&self, ray: &Ray) -> u32 {
        let [kx, ky, kz] = ray.axes;
        let mut x = [[0.0f32; BLOCK]; 3];
        let mut y = [[0.0f32; BLOCK]; 3];
        for corner in 0..3 {
            let planes = &self.corners[corner];
            let (px, py, pz) = (&planes[kx], &planes[ky], &planes[kz]);
            for i in 0..BLOCK {
                let z = pz[i] - ray.origin[2];
                x[corner][i] = (px[i] - ray.origin[0]) - ray.shear[0] * z;
                y[corner][i] = (py[i] - ray.origin[1]) - ray.shear[1] * z;
            }
        }
        let mut least = [0.0f32; BLOCK];
        let mut most = [0.0f32; BLOCK];
        for i in 0..BLOCK {
            let u = x[2][i] * y[1][i] - y[2][i] * x[1][i];
            let v = x[0][i] * y[2][i] - y[0][i] * x[2][i];
            let w = x[1][i] * y[0][i] - y[1][i] * x[0][i];
            least[i] = min(min(u, v), w);
            most[i] = max(max(u, v), w);
        }
        let mut found = [0; BLOCK];
        for i in 0..BLOCK {
            found[i] = if (least[i] >= 0.0) | (most[i] <= 0.0) { 1 << i } else { 0 };
        }
        found.iter().sum()
    }

    /// The exact answer for a candidate: the hit on `ray.tmin ..= tmax`, edges and both sides included. Scalar
    /// and rare, so it stays out of the kernels' loops and their registers.
    #[inline(never)]
    pub fn hit(&self, lane: usize, ray: &Ray, tmax: f32) -> Option<Hit> {
        let lane = lane % BLOCK;
        let [kx, ky, kz] = ray.axes;
        let (mut x, mut y, mut z) = ([0.0f64; 3], [0.0f64; 3], [0.0f64; 3]);
        for corner in 0..3 {
            let planes = &self.corners[corner];
            // f32, in the same operations as `candidates`: the frame's rounded points are the triangle.
            let pz = planes[kz][lane] - ray.origin[2];
            x[corner] = ((planes[kx][lane] - ray.origin[0]) - ray.shear[0] * pz) as f64;
            y[corner] = ((planes[ky][lane] - ray.origin[1]) - ray.shear[1] * pz) as f64;
            z[corner] = pz as f64;
        }
        let u = x[2] * y[1] - y[2] * x[1];
        let v = x[0] * y[2] - y[0] * x[2];
        let w = x[1] * y[0] - y[1] * x[0];
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        // Seen edge-on. With one sign in all three, the sum is 0 only if each is.
        let det = u + v + w;
        if det == 0.0 {
            return None;
        }
        let inverse = 1.0 / det;
        let t = ((u * z[0] + v * z[1] + w * z[2]) * inverse * ray.inverse_z) as f32;
        let (near, far) = self.box_interval(lane, &ray.slab);
        // The boxes of all nodes above hold this one, and slab distances are monotone in the planes. So with t
        // inside the triangle's own slabs, no node above is entered later than t, and neither the tree nor
        // the order of traversal can change which hit wins. The margins should leave nothing to do here: t is
        // the z of a point of the triangle, whatever the angle. This makes it certain without their analysis.
        let t = max(min(t, far), near);
        let inside = near <= far && ray.tmin <= t && t <= tmax;
        inside.then(|| Hit {
            t,
            u: (v * inverse) as f32,
            v: (w * inverse) as f32,
            id: (self.mesh[lane] as u64) << 32 | self.triangle[lane] as u64,
        })
    }

    /// Where the ray enters and leaves the triangle's own box, enlarged and computed as a node's.
    #[inline(always)]
    fn box_interval(&self, lane: usize, slab: &SlabRay) -> (f32, f32) {
        let [a, b, c] = &self.corners;
        let axes = [0, 1, 2];
        let lo = axes.map(|k| min(min(a[k][lane], b[k][lane]), c[k][lane]));
        let hi = axes.map(|k| max(max(a[k][lane], b[k][lane]), c[k][lane]));
        let (lo, hi) = enlarge(lo, hi);
        let (mut near, mut far) = (f32::NEG_INFINITY, f32::INFINITY);
        for k in axes {
            let (first, last) = if slab.near_side[k] == 0 { (lo[k], hi[k]) } else { (hi[k], lo[k]) };
            near = max(near, (first - slab.near_origin[k]) * slab.inverse[k]);
            far = min(far, (last - slab.far_origin[k]) * slab.inverse[k]);
        }
        (near, far)
    }
}
