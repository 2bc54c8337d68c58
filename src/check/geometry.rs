//! Sizes of a mesh, and normals that contradict it: one look at every triangle.

use super::topology::CHUNK;
use crate::math::{DVec3, Vec3};
use crate::shape::Mesh;
use rayon::prelude::*;

/// What one look at every triangle shows, in the mesh's own coordinates.
#[derive(Clone, Debug)]
pub(super) struct Sizes {
    /// Smallest and largest coordinates of the triangles' corners.
    pub min: DVec3,
    pub max: DVec3,
    /// Sum of the triangles' areas.
    pub area: f64,
    /// Sum of the triple products of the edges from one point to each triangle's corners: six times the signed
    /// volume inside if the triangles are closed.
    pub six_volumes: f64,
    /// Triangles all of whose corners' normals point to the back.
    pub flipped: u64,
    /// The first of those.
    pub first_flipped: Vec<u32>,
}

impl Sizes {
    const NONE: Sizes = Sizes {
        min: DVec3::INFINITY,
        max: DVec3::NEG_INFINITY,
        area: 0.0,
        six_volumes: 0.0,
        flipped: 0,
        first_flipped: Vec::new(),
    };

    /// Adds the sums of later triangles.
    fn and(mut self, later: Sizes, kept: usize) -> Sizes {
        let room = kept.saturating_sub(self.first_flipped.len());
        self.first_flipped.extend(later.first_flipped.into_iter().take(room));
        Sizes {
            min: self.min.min(later.min),
            max: self.max.max(later.max),
            area: self.area + later.area,
            six_volumes: self.six_volumes + later.six_volumes,
            flipped: self.flipped + later.flipped,
            first_flipped: self.first_flipped,
        }
    }
}

/// Measures `mesh`; keeps the first `kept` triangles with flipped normals. Sums are taken chunk by chunk, in
/// order, so that they do not depend on the threads.
pub(super) fn measure(mesh: &Mesh, kept: usize) -> Sizes {
    let count = mesh.indices.len();
    // Volumes are taken against a point of the mesh: less cancels there than at a far origin.
    let apex = if count == 0 { DVec3::ZERO } else { mesh.triangle(0)[0].as_dvec3() };
    let chunks: Vec<Sizes> = (0..count.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let mut sizes = Sizes::NONE;
            for triangle in chunk * CHUNK..count.min((chunk + 1) * CHUNK) {
                add(&mut sizes, mesh, triangle, apex, kept);
            }
            sizes
        })
        .collect();
    chunks.into_iter().fold(Sizes::NONE, |sum, sizes| sum.and(sizes, kept))
}

fn add(sizes: &mut Sizes, mesh: &Mesh, triangle: usize, apex: DVec3, kept: usize) {
    let corners = mesh.triangle(triangle);
    let [a, b, c] = corners.map(|p| p.as_dvec3());
    sizes.min = sizes.min.min(a).min(b).min(c);
    sizes.max = sizes.max.max(a).max(b).max(c);
    let normal = (b - a).cross(c - a);
    sizes.area += 0.5 * normal.length();
    sizes.six_volumes += (a - apex).dot((b - apex).cross(c - apex));
    let normals = mesh.normals.as_ref().zip(mesh.indices.get(triangle));
    let shading = normals.and_then(|(normals, indices)| normals.corners(triangle, *indices));
    let is_behind = |n: [f32; 3]| Vec3::from(n).as_dvec3().dot(normal) < 0.0;
    if shading.is_some_and(|shading| shading.into_iter().all(is_behind)) {
        sizes.flipped += 1;
        if sizes.first_flipped.len() < kept {
            sizes.first_flipped.push(triangle as u32);
        }
    }
}
