//! The scene as plain data: meshes, materials, lights, camera, and how to render them. Ids instead of
//! pointers: a mesh's faces name materials by index.

mod directions;
pub mod settings;

pub use directions::Directions;
pub use settings::{BuildQuality, Compact, IntegratorKind, LightSampling, Quantity, Settings};

pub use crate::sampler::SamplerKind;

use crate::bsdf::Material;
use crate::camera::CameraSpec;
use crate::light::Light;
use crate::math::{Aabb, DVec3};
use crate::shape::Mesh;
use std::sync::Arc;

/// Everything that is looked at. Mesh coordinates, lights and the built camera live in scene coordinates:
/// the file's own coordinates minus [`Scene::origin`], which is zero unless the scene lies far away.
#[derive(Clone, Debug)]
pub struct Scene {
    /// File coordinates of the scene's origin.
    pub origin: DVec3,
    /// The meshes, transformed into scene coordinates.
    pub meshes: Vec<Arc<Mesh>>,
    /// The materials that faces name.
    pub materials: Vec<Material>,
    /// Lights that are no geometry; positions in scene coordinates.
    pub lights: Vec<Light>,
    /// The camera, in file coordinates.
    pub camera: CameraSpec,
}

impl Scene {
    /// Triangles of all meshes.
    pub fn triangles(&self) -> u64 {
        self.meshes.iter().map(|m| m.indices.len() as u64).sum()
    }

    /// Vertices of all meshes.
    pub fn vertices(&self) -> u64 {
        self.meshes.iter().map(|m| m.positions.len() as u64).sum()
    }

    /// The smallest box around all meshes, in scene coordinates.
    pub fn bounds(&self) -> Aabb {
        self.meshes.iter().fold(Aabb::EMPTY, |b, m| b.union(m.bounds()))
    }
}
