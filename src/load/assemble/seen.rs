//! What a camera that frames the scene is to see, and what a ground lies under.

use crate::shape::{Bounds64, Instance, Instances, Mesh};
use std::sync::Arc;

/// Corners that are looked at one by one to frame the scene; beyond, boxes stand for the instances.
const MOST_FRAMED: usize = 20_000_000;

/// Everything that a camera is to see at `time`, as triangles at rest: instances as copies, or as boxes where that would
/// be too much work.
pub fn seen(meshes: &[Arc<Mesh>], instances: &Instances, time: f64) -> Vec<Arc<Mesh>> {
    let corners = |i: &Instance| instances.meshes.get(i.mesh as usize).map_or(0, |m| m.indices.len() * 3);
    let all = instances.places.iter().map(corners).fold(0, usize::saturating_add);
    let shape = |mesh: &Mesh| {
        let whole = || Mesh::new(mesh.positions.to_vec(), mesh.indices.clone());
        if all <= MOST_FRAMED { whole() } else { corners_of(mesh) }
    };
    let shapes: Vec<Mesh> = instances.meshes.iter().map(|mesh| shape(mesh)).collect();
    let moved = |i: &Instance| shapes.get(i.mesh as usize).map(|s| Arc::new(s.placed(&i.transform(time))));
    meshes.iter().cloned().chain(instances.places.iter().filter_map(moved)).collect()
}

/// A mesh through the eight corners of a mesh's box.
fn corners_of(mesh: &Mesh) -> Mesh {
    let bounds = Bounds64::of(&mesh.bounds());
    if bounds.is_empty() {
        return Mesh::new(Vec::new(), Vec::new());
    }
    let positions = bounds.corners().map(|p| p.as_vec3().to_array()).to_vec();
    Mesh::new(positions, vec![[0, 1, 2], [3, 4, 5], [5, 6, 7]])
}
