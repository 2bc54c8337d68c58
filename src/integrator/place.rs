//! What a hit's id stands for: a mesh at rest, or an instance and its mesh.

use super::Context;
use crate::shape::{Instance, Mesh};
use glam::DAffine3;

impl<'a> Context<'a> {
    /// The mesh of a hit, and where it stands unless its coordinates are the scene's.
    #[inline(always)]
    pub fn mesh(&self, id: u32) -> (&'a Mesh, Option<&'a Instance>) {
        let id = id as usize;
        if let Some(mesh) = self.meshes.get(id) {
            return (mesh, None);
        }
        let place = &self.instances.places[id - self.meshes.len()];
        (&self.instances.meshes[place.mesh as usize], Some(place))
    }

    /// The material of a hit.
    #[inline(always)]
    pub fn material(&self, id: u32, triangle: u32) -> u32 {
        let (mesh, place) = self.mesh(id);
        let own = place.and_then(|place| place.material);
        own.unwrap_or_else(|| mesh.materials.get(triangle as usize))
    }

    /// From an instance's mesh to the scene at a sample's time.
    #[inline]
    pub fn transform(&self, place: &Instance, time: f32) -> DAffine3 {
        place.during(self.shutter, time)
    }
}
