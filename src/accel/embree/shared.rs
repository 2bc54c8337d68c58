//! A geometry a mesh, on the mesh's own buffers.

use super::doubt::longest_edge;
use super::scene::Buffers;
use crate::accel::brute::has_area;
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::memory;
use crate::shape::{Mesh, Positions};
use rayon::prelude::*;
use std::sync::Arc;

/// Embree leaves a triangle out when an index is out of range.
const LEFT_OUT: [u32; 3] = [u32::MAX; 3];

/// The corners' indices for Embree, moved by `base`; [`LEFT_OUT`] for a triangle that must not be hit.
///
/// Embree's test hits triangles without area: the cross product of parallel edges is not zero in f32 once a
/// multiplication is fused or rounded, and the "hit" may be far from the sliver.
///
/// Raises `longest` to the length of the triangle's longest edge.
#[inline]
pub(super) fn sound(positions: &Positions, corners: [u32; 3], base: u32, longest: &mut f32) -> [u32; 3] {
    let [a, b, c] = corners.map(|i| positions.get(i as usize).map(|&p| Vec3::from(p)));
    match (a, b, c) {
        (Some(a), Some(b), Some(c)) if has_area([a, b, c]) => {
            *longest = longest.max(longest_edge([a, b, c]));
            corners.map(|i| i + base)
        }
        _ => LEFT_OUT,
    }
}

/// The meshes, in order.
pub(super) struct Shared(Vec<Part>);

struct Part {
    mesh: Arc<Mesh>,
    /// Instead of the mesh's own, where some of its triangles are left out.
    indices: Option<Vec<[u32; 3]>>,
    /// The longest edge.
    longest: f32,
}

impl Shared {
    pub(super) fn new(meshes: &[Arc<Mesh>]) -> Result<Self> {
        let part = |mesh: &Arc<Mesh>| {
            let (indices, longest) = without_flat(mesh)?;
            Ok(Part { mesh: mesh.clone(), indices, longest })
        };
        Ok(Shared(meshes.iter().map(part).collect::<Result<_>>()?))
    }

    /// The buffers, in order.
    pub(super) fn buffers(&self) -> impl Iterator<Item = Buffers<'_>> {
        self.0.iter().map(|Part { mesh, indices, .. }| {
            Buffers::new(&mesh.positions, indices.as_deref().unwrap_or(&mesh.indices))
        })
    }

    /// The longest edge of each mesh.
    pub(super) fn longest(&self) -> Vec<f32> {
        self.0.iter().map(|part| part.longest).collect()
    }

    /// Bytes of the copies.
    pub(super) fn bytes(&self) -> usize {
        self.0.iter().flat_map(|part| &part.indices).map(|own| own.len() * 12).sum()
    }
}

/// The indices, `None` when every triangle of the mesh may be hit, and the longest edge.
fn without_flat(mesh: &Mesh) -> Result<(Option<Vec<[u32; 3]>>, f32)> {
    let look = |chunk: &[[u32; 3]]| {
        let (mut changed, mut longest) = (false, 0.0);
        for &corners in chunk {
            changed |= sound(&mesh.positions, corners, 0, &mut longest) != corners;
        }
        (changed, longest)
    };
    let (changed, mut longest) = mesh
        .indices
        .par_chunks(1 << 14)
        .map(look)
        .reduce(|| (false, 0.0), |(a, l), (b, m)| (a | b, l.max(m)));
    if !changed {
        return Ok((None, longest));
    }
    let mut own = Vec::new();
    memory::reserve(&mut own, mesh.indices.len())
        .map_err(|_| Error::new(format!("not enough memory for {} triangles", mesh.indices.len())))?;
    own.extend(mesh.indices.iter().map(|&corners| sound(&mesh.positions, corners, 0, &mut longest)));
    Ok((Some(own), longest))
}
