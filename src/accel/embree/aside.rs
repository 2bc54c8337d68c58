//! A few triangles beside large meshes, kept out of Embree's tree.
//!
//! A scan stands on a ground, a part in front of a wall, and many rays that leave the ground pass the scan by. Here the few
//! triangles are met by our own test of a few ([`crate::accel::bvh`]), and only rays that meet the box around the large meshes, before what they hit of the few, are Embree's; of two hits
//! the nearer counts, and at the same distance the mesh of the lower index. The two triangles of the ground are not in
//! the way of the tree of the others either, which in low quality sorts triangles by where they are and does
//! not look at how large they are; and a single large mesh need not be joined with them in a copy there.
//!
//! Two tests that round differently do not close the seam between two meshes. So triangles are set aside only where
//! none of their open edges, those that not exactly two of them have, comes near that box.

use crate::accel::bvh::{Bvh, Slabs};
use crate::accel::{BuildOptions, Checked, Hits, Intersector, Mask};
use crate::error::Result;
use crate::math::{Aabb, Vec3};
use crate::shape::Mesh;
use rayon::prelude::*;
use std::sync::Arc;

/// All small meshes together have up to so many triangles.
const MOST: usize = 16;

/// The large meshes have at least so many; with fewer it was not tried.
const LARGE: usize = 1 << 12;

/// The triangles that Embree does not see.
pub(super) struct Aside {
    bvh: Bvh,
    /// Around those that it sees.
    others: Slabs,
}

impl Aside {
    /// The large meshes, and what is kept aside; each mesh keeps its index, and is empty where it is left out.
    pub(super) fn split(
        meshes: &[Arc<Mesh>],
        options: &BuildOptions<'_>,
    ) -> Result<Option<(Vec<Arc<Mesh>>, Aside)>> {
        let is_small = |mesh: &Arc<Mesh>| mesh.indices.len() <= MOST;
        let sum = |small: bool| -> usize {
            meshes.iter().filter(|m| is_small(m) == small).map(|m| m.indices.len()).sum()
        };
        let in_range = |m: &Arc<Mesh>| m.indices.iter().flatten().all(|&i| (i as usize) < m.positions.len());
        let are_sound = meshes.iter().filter(|m| is_small(m)).all(in_range);
        if !(1..=MOST).contains(&sum(true)) || sum(false) < LARGE || !are_sound {
            return Ok(None);
        }
        let empty = Arc::new(Mesh::new(Vec::new(), Vec::new()));
        let only = |small: bool| -> Vec<Arc<Mesh>> {
            meshes.iter().map(|m| if is_small(m) == small { m } else { &empty }.clone()).collect()
        };
        let (small, large) = (only(true), only(false));
        let bounds = around(&large);
        if open_edges(&small).iter().any(|&edge| comes_near(edge, &bounds)) {
            return Ok(None);
        }
        let bvh = Bvh::build(&small, &BuildOptions { progress: &|_| true, ..*options })?;
        if bvh.is_empty() {
            return Ok(None);
        }
        Ok(Some((large, Aside { bvh, others: Slabs::around(&bounds) })))
    }

    /// The closest hits of the active lanes. Returns which of them are to be settled, and which rays are Embree's as well.
    #[inline]
    pub(super) fn closest(&self, rays: Checked<'_>, hits: &mut Hits) -> [Mask; 2] {
        self.bvh.closest_beside(&self.others, rays, hits)
    }

    /// The active lanes that hit anything, and which of the rest are Embree's as well.
    #[inline]
    pub(super) fn occluded(&self, rays: Checked<'_>) -> [Mask; 2] {
        self.bvh.occluded_beside(&self.others, rays)
    }

    /// Bytes of the structure over what is set aside.
    pub(super) fn bytes(&self) -> usize {
        self.bvh.bytes()
    }

    /// Calls `each` with mesh, triangle and corners of what comes within `radius` of `point`.
    pub(super) fn around(&self, point: Vec3, radius: f32, each: &mut dyn FnMut([u32; 2], [Vec3; 3])) {
        self.bvh.around(point, radius, each);
    }
}

/// A box around all vertices, whether or not a triangle has them.
fn around(meshes: &[Arc<Mesh>]) -> Aabb {
    // What is no number belongs to no triangle that can be hit, and would make the box forget what it held.
    let grow = |bounds: Aabb, p: &[f32; 3]| match p.iter().any(|x| x.is_nan()) {
        true => bounds,
        false => bounds.grow(Vec3::from(*p)),
    };
    let of = |mesh: &Arc<Mesh>| {
        let chunks = mesh.positions.par_chunks(1 << 14).map(|chunk| chunk.iter().fold(Aabb::EMPTY, grow));
        chunks.reduce(|| Aabb::EMPTY, |a, b| a.union(b))
    };
    meshes.iter().map(of).fold(Aabb::EMPTY, Aabb::union)
}

/// The edges that not exactly two triangles of `meshes`, which are few, have between the same two points. (One triangle
/// that is listed twice closes nothing.)
fn open_edges(meshes: &[Arc<Mesh>]) -> Vec<[Vec3; 2]> {
    let triangles = meshes.iter().flat_map(|m| (0..m.indices.len()).map(|i| m.triangle(i)));
    // With the corner opposite to each.
    let edges: Vec<_> = triangles.flat_map(|[a, b, c]| [([a, b], c), ([b, c], a), ([c, a], b)]).collect();
    let is_closed = |[a, b]: [Vec3; 2]| {
        let mut opposite = edges.iter().filter(|(e, _)| *e == [a, b] || *e == [b, a]).map(|(_, c)| *c);
        matches!((opposite.next(), opposite.next(), opposite.next()), (Some(c), Some(d), None) if c != d)
    };
    edges.iter().map(|(e, _)| *e).filter(|e| !is_closed(*e)).collect()
}

/// Whether a segment comes into a box that is enlarged by far more than what anything is rounded by.
fn comes_near([a, b]: [Vec3; 2], bounds: &Aabb) -> bool {
    let reach = [a, b, bounds.min, bounds.max].iter().fold(Vec3::ZERO, |w, p| w.max(p.abs()));
    let margin = 1e-4 * reach.max_element();
    let (mut from, mut to) = (0.0f32, 1.0f32);
    for k in 0..3 {
        let (lo, hi, d) = (bounds.min[k] - margin, bounds.max[k] + margin, b[k] - a[k]);
        if d == 0.0 {
            if a[k] < lo || a[k] > hi {
                return false;
            }
        } else {
            let (x, y) = ((lo - a[k]) / d, (hi - a[k]) / d);
            (from, to) = (from.max(x.min(y)), to.min(x.max(y)));
        }
    }
    from <= to
}
