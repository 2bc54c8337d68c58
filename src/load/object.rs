//! What the reader of any format makes of a file: a mesh with its materials.

use super::framing::Lens;
use super::materials::MaterialSpec;
use super::mtl::MtlMaterial;
use super::place::Transform;
use super::scene_file::LightPlan;
use super::{auto, obj};
use crate::error::Findings;
use crate::math::DVec3;
use crate::shape::{Bounds64, Mesh};
use glam::DAffine3;
use std::path::PathBuf;

/// A mesh file, read.
#[derive(Debug)]
pub(crate) struct Object {
    /// The mesh, relative to `origin`.
    pub mesh: Mesh,
    /// The file's coordinates of the mesh's origin.
    pub origin: DVec3,
    /// By the mesh's material ids.
    pub materials: Vec<MaterialSpec>,
    /// What was skipped or replaced.
    pub findings: Findings,
    /// Faces left out.
    pub skipped_faces: u64,
    /// The material libraries that were read.
    pub libraries: Vec<PathBuf>,
    /// How many names the libraries define, used or not.
    pub defined: u64,
    /// What the libraries say, by the mesh's material ids; `None` where no library defines it.
    pub definitions: Vec<Option<MtlMaterial>>,
    /// What the file held.
    pub counts: obj::Counts,
    /// The line of each triangle's face, where it was asked for.
    pub face_lines: Option<Vec<u32>>,
    /// What the file shows in several places, besides `mesh`.
    pub parts: Vec<Part>,
    /// The camera that the file brings, for a scene that places none.
    pub camera: Option<FileCamera>,
    /// The lights that the file brings.
    pub lights: Vec<LightPlan>,
}

/// Copies beyond a mesh's first may have so many triangles together (about 200 MB with their structure) before instances
/// take their place: one level is traced faster than two.
pub(crate) const MOST_COPIED: u64 = 1 << 20;

/// A mesh that stands in several places of a file.
#[derive(Debug)]
pub(crate) struct Part {
    /// The mesh, relative to `origin`, with the file's material ids.
    pub mesh: Mesh,
    /// Its coordinates of the mesh's origin.
    pub origin: DVec3,
    /// From its coordinates to the file's; all invertible.
    pub places: Vec<DAffine3>,
}

/// A camera in a mesh file, in the file's coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FileCamera {
    /// The eye.
    pub position: DVec3,
    /// Where it looks; unit.
    pub forward: DVec3,
    /// Up; not along `forward`.
    pub up: DVec3,
    /// The picture's height.
    pub lens: Lens,
}

impl Part {
    /// The box around it in all its places, in the file's coordinates.
    pub fn bounds(&self) -> Bounds64 {
        let own = Transform::IDENTITY.extent(&self.mesh.bounds(), self.origin);
        self.places.iter().fold(Bounds64::EMPTY, |sum, place| sum.union(&own.moved(place)))
    }
}

impl Object {
    /// A mesh whose file says nothing of materials beyond `materials`, by its ids.
    pub fn of_mesh(read: obj::ObjFile, materials: Vec<MaterialSpec>) -> Object {
        Object {
            mesh: read.mesh,
            origin: read.origin,
            materials,
            findings: read.findings,
            skipped_faces: read.counts.skipped_faces,
            libraries: Vec::new(),
            defined: 0,
            definitions: Vec::new(),
            counts: read.counts,
            face_lines: read.face_lines,
            parts: Vec::new(),
            camera: None,
            lights: Vec::new(),
        }
    }

    /// A mesh of a file that has no materials: all of it is clay.
    pub fn of_clay(read: obj::ObjFile) -> Object {
        let names = read.material_names.iter().map(|name| String::from_utf8_lossy(name).into_owned());
        let clay = names.map(|name| MaterialSpec::diffuse(name, auto::CLAY)).collect();
        Object::of_mesh(read, clay)
    }
}
