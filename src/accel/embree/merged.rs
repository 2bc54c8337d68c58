//! All meshes in one geometry, for the low build quality.
//!
//! Embree's low quality builds a tree a geometry and joins them under a top level in the order in which
//! threads finish: which of two triangles at the same distance is found would be a matter of luck, and rays
//! enter all trees whose boxes overlap. One geometry has neither trouble. It costs a copy of positions and
//! indices (12 bytes a vertex and a triangle) and a search for the mesh's name a hit.

use super::scene::Buffers;
use super::shared::sound;
use crate::accel::{Hits, LANES, MISS, Mask};
use crate::error::{Error, Result};
use crate::memory::reserve;
use crate::shape::{Mesh, Positions};
use std::sync::Arc;

/// The joined buffers.
pub(super) struct Merged {
    positions: Positions,
    indices: Vec<[u32; 3]>,
    /// Index of each mesh's first triangle in `indices`, and their number at the end.
    first: Vec<u32>,
    /// The longest edge of each mesh.
    longest: Vec<f32>,
}

impl Merged {
    /// True where there is something to join, and the joined buffers stay inside Embree's limits (where not,
    /// the meshes are built one by one).
    pub(super) fn pays(meshes: &[Arc<Mesh>]) -> bool {
        let with_triangles = meshes.iter().filter(|m| !m.indices.is_empty()).count();
        let sum = |count: fn(&Mesh) -> usize| meshes.iter().map(|m| count(m) as u64).sum::<u64>();
        let limits = super::check_limits(0, sum(|m| m.positions.len()), sum(|m| m.indices.len()));
        with_triangles > 1 && limits.is_ok()
    }

    pub(super) fn new(meshes: &[Arc<Mesh>]) -> Result<Self> {
        let vertices: usize = meshes.iter().map(|m| m.positions.len()).sum();
        let triangles: usize = meshes.iter().map(|m| m.indices.len()).sum();
        let (mut positions, mut indices, mut first) = (Vec::new(), Vec::new(), Vec::new());
        let mut longest = vec![0.0; meshes.len()];
        let room = reserve(&mut positions, vertices + Positions::PADDING)
            .and_then(|()| reserve(&mut indices, triangles))
            .and_then(|()| reserve(&mut first, meshes.len() + 1));
        room.map_err(|_| {
            Error::new(format!("not enough memory to join {triangles} triangles for a low build"))
        })?;
        for (mesh, longest) in meshes.iter().zip(&mut longest) {
            let base = positions.len() as u32;
            first.push(indices.len() as u32);
            indices
                .extend(mesh.indices.iter().map(|&corners| sound(&mesh.positions, corners, base, longest)));
            positions.extend_from_slice(&mesh.positions);
        }
        first.push(indices.len() as u32);
        Ok(Merged { positions: Positions::new(positions), indices, first, longest })
    }

    pub(super) fn buffers(&self) -> Buffers<'_> {
        Buffers::new(&self.positions, &self.indices)
    }

    /// The longest edge of each mesh.
    pub(super) fn longest(&self) -> Vec<f32> {
        self.longest.clone()
    }

    pub(super) fn bytes(&self) -> usize {
        (self.positions.len() + self.indices.len()) * 12 + self.first.len() * 4
    }

    /// Turns numbers of joined triangles into (mesh, triangle) for the active lanes that hit.
    #[inline]
    pub(super) fn name_hits(&self, active: Mask, hits: &mut Hits) {
        for lane in 0..LANES {
            if active >> lane & 1 == 1 && hits.mesh[lane] != MISS {
                [hits.mesh[lane], hits.triangle[lane]] = self.name(hits.triangle[lane]);
            }
        }
    }

    /// Mesh and triangle of a joined triangle.
    #[inline]
    pub(super) fn name(&self, joined: u32) -> [u32; 2] {
        // The last mesh that starts at or before it; of empty ones at the same place the last.
        let mesh = self.first.partition_point(|&f| f <= joined) - 1;
        [mesh as u32, joined - self.first[mesh]]
    }
}
