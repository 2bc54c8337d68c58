//! The watertight triangle test of Woop, Benthin and Wald 2013 ("Watertight ray/triangle intersection", JCGT
//! 2(1)), four triangles at a time.
//!
//! The ray is made the z axis of a sheared frame by `x' = x − (d_x/d_z)·z`, `y' = y − (d_y/d_z)·z`. A vertex is
//! transformed from its own coordinates alone, so neighbours that share it see the same rounded point, and
//! the three edge functions (`U = C_x·B_y − C_y·B_x`, …) tell on which side of each projected edge the ray
//! passes. Neighbours evaluate a shared edge with exactly opposite signs, hence no ray slips between them.
//!
//! In f32, an edge function has the right sign or is 0: rounding is monotone, so a·b > c·d implies
//! fl(a·b) ≥ fl(c·d). f32 alone therefore sorts out what is certainly missed ([`Block::candidates`]), and f64, where
//! the products of two f32 are exact, decides the others: signs are exact, a ray through an edge or vertex (a
//! function of exactly 0) hits, and neither tiny nor huge scales leave the range.
//!
//! This file has the plain form, which the compiler vectorises as it can; [`super::avx`] the same operations as
//! intrinsics. No operation is fused or reordered in either, so they give the same bits.

use super::meeting::Meeting;
use super::node::{max, min};
use super::ray::Prepared;
use crate::math::Vec3;
use crate::math::isa::Set;

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

/// What one ray meets of a block: a bit for each triangle, and their distances (scaled, see [`Prepared`]).
pub type Met = (u32, [f32; BLOCK]);

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
    #[inline(always)]
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

    /// The triangles that the ray of lane `i` meets on `tmin ..= tmax`, edges and both sides included.
    #[inline(always)]
    pub fn meet<S: Set>(&self, rays: &Prepared, i: usize, tmax: f32) -> Met {
        let mut candidates = self.candidates(rays, i);
        let (mut met, mut t) = (0, [0.0; BLOCK]);
        while candidates != 0 {
            let lane = candidates.trailing_zeros() as usize;
            candidates &= candidates - 1;
            if let Some(hit) = self.hit::<S>(lane, rays, i, tmax) {
                met |= 1 << lane;
                t[lane] = hit;
            }
        }
        (met, t)
    }

    /// One bit for each triangle that the ray's line may meet: those whose edge functions have no two
    /// opposite signs in f32.
    #[inline(always)]
    fn candidates(&self, rays: &Prepared, i: usize) -> u32 {
        let [kx, ky, kz] = [0, 1, 2].map(|k| rays.axes[k][i] as usize);
        let [ox, oy, oz] = [0, 1, 2].map(|k| rays.origin[k][i]);
        let (sx, sy) = (rays.shear[0][i], rays.shear[1][i]);
        let mut x = [[0.0f32; BLOCK]; 3];
        let mut y = [[0.0f32; BLOCK]; 3];
        for corner in 0..3 {
            let planes = &self.corners[corner];
            let (px, py, pz) = (&planes[kx], &planes[ky], &planes[kz]);
            for i in 0..BLOCK {
                let z = pz[i] - oz;
                x[corner][i] = (px[i] - ox) - sx * z;
                y[corner][i] = (py[i] - oy) - sy * z;
            }
        }
        let mut found = [0; BLOCK];
        for i in 0..BLOCK {
            let u = x[2][i] * y[1][i] - y[2][i] * x[1][i];
            let v = x[0][i] * y[2][i] - y[0][i] * x[2][i];
            let w = x[1][i] * y[0][i] - y[1][i] * x[0][i];
            let (least, most) = (min(min(u, v), w), max(max(u, v), w));
            found[i] = if (least >= 0.0) | (most <= 0.0) { 1 << i } else { 0 };
        }
        found.iter().sum()
    }

    /// The exact answer for a candidate: its distance on `tmin ..= tmax`.
    fn hit<S: Set>(&self, lane: usize, rays: &Prepared, i: usize, tmax: f32) -> Option<f32> {
        let met = Meeting::of::<S>(self.triangle_at(lane).map(|p| p.to_array()), rays, i);
        (met.is && met.t <= tmax).then_some(met.t)
    }
}
