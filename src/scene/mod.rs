//! The scene as plain data: meshes, materials, lights, camera, and how to render them. Ids instead of
//! pointers: a mesh's faces name materials by index.

mod directions;
mod fingerprint;
pub mod need;
pub mod settings;

pub use directions::Directions;
pub use settings::{BuildQuality, Compact, IntegratorKind, LightSampling, Quantity, Settings};

pub use crate::sampler::SamplerKind;

use crate::accel::Geometry;
use crate::accel::need::Extent;
use crate::bsdf::Material;
use crate::camera::CameraSpec;
use crate::light::Light;
use crate::math::{Aabb, DVec3, Rgb};
use crate::shape::{FaceMaterials, Instance, Instances, Mesh};
use std::sync::Arc;

/// Everything that is looked at. Mesh coordinates, lights and the built camera live in scene coordinates:
/// the file's own coordinates minus [`Scene::origin`], which is zero unless the scene lies far away.
#[derive(Clone, Debug)]
pub struct Scene {
    /// File coordinates of the scene's origin.
    pub origin: DVec3,
    /// The meshes at rest, transformed into scene coordinates.
    pub meshes: Vec<Arc<Mesh>>,
    /// Meshes that stand in several places or move.
    pub instances: Instances,
    /// The materials that faces name.
    pub materials: Vec<Material>,
    /// Lights that are no geometry; positions in scene coordinates.
    pub lights: Vec<Light>,
    /// The camera, in file coordinates.
    pub camera: CameraSpec,
}

impl Scene {
    /// What rays meet while the camera's shutter is open.
    pub fn geometry(&self) -> Geometry<'_> {
        Geometry { meshes: &self.meshes, instances: &self.instances, shutter: self.camera.shutter }
    }

    /// Triangles in memory: a mesh with many instances counts once.
    pub fn triangles(&self) -> u64 {
        self.all_meshes().map(|m| m.indices.len() as u64).sum()
    }

    /// Triangles that are seen: those of a mesh as often as it has instances.
    pub fn placed_triangles(&self) -> u64 {
        let at_rest: u64 = self.meshes.iter().map(|m| m.indices.len() as u64).sum();
        let of =
            |place: &Instance| self.instances.meshes.get(place.mesh as usize).map_or(0, |m| m.indices.len());
        at_rest + self.instances.places.iter().map(|place| of(place) as u64).sum::<u64>()
    }

    /// Vertices in memory.
    pub fn vertices(&self) -> u64 {
        self.all_meshes().map(|m| m.positions.len() as u64).sum()
    }

    /// The meshes at rest, and those that have instances.
    pub fn all_meshes(&self) -> impl Iterator<Item = &Arc<Mesh>> {
        self.meshes.iter().chain(&self.instances.meshes)
    }

    /// True when something moves while the shutter is open, so that a picture depends on the samples' times.
    pub fn moves(&self) -> bool {
        let shutter = self.camera.shutter;
        let camera = self.camera.motion.as_ref().is_some_and(|motion| !motion.rests(shutter));
        camera || self.instances.places.iter().any(|place| !place.rests(shutter))
    }

    /// Whether there are lamps, and more than a single square at rest, whose edges a pixel may see.
    pub fn has_lamps(&self) -> bool {
        let shines =
            |id: u32| self.materials.get(id as usize).is_some_and(|material| material.emission != Rgb::ZERO);
        let lamps = |mesh: &Arc<Mesh>| match &mesh.materials {
            FaceMaterials::Uniform(id) if shines(*id) => mesh.indices.len(),
            FaceMaterials::Uniform(_) => 0,
            FaceMaterials::PerFace(ids) => ids.iter().filter(|id| shines(**id)).count(),
        };
        let instances = &self.instances;
        let shown: Vec<bool> = instances.meshes.iter().map(|mesh| lamps(mesh) > 0).collect();
        let placed = |place: &Instance| {
            place.material.map_or_else(|| shown.get(place.mesh as usize).is_some_and(|s| *s), shines)
        };
        let balls = self.lights.iter().any(|light| matches!(light, Light::Sphere(_)));
        balls || instances.places.iter().any(placed) || self.meshes.iter().map(lamps).sum::<usize>() > 2
    }

    /// What building over it and rendering it will take in memory.
    pub fn need(&self) -> need::Need {
        let meshes = self.all_meshes().count() as u64;
        let over = Extent { triangles: self.triangles(), vertices: self.vertices(), meshes };
        need::Need { meshes: need::Meshes::default(), over }
    }

    /// The smallest box around everything while the shutter is open, in scene coordinates.
    pub fn bounds(&self) -> Aabb {
        let at_rest = self.meshes.iter().fold(Aabb::EMPTY, |b, m| b.union(m.bounds()));
        let boxes: Vec<Aabb> = self.instances.meshes.iter().map(|mesh| mesh.bounds()).collect();
        self.instances.places.iter().fold(at_rest, |sum, place| {
            let Some(mesh) = boxes.get(place.mesh as usize) else { return sum };
            let swept = place.bounds(mesh, self.camera.shutter);
            sum.union(Aabb { min: swept.min.as_vec3(), max: swept.max.as_vec3() })
        })
    }
}
