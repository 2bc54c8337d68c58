//! A mesh file with its materials.

use super::auto;
use super::materials::MaterialSpec;
use super::obj;
use crate::error::{Findings, Result};
use crate::math::DVec3;
use crate::shape::Mesh;
use std::path::Path;

/// A mesh file, read.
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
}

/// Reads `file`. `progress` hears the share done; its `false` cancels.
pub(crate) fn read(file: &Path, progress: &(dyn Fn(f64) -> bool + Sync)) -> Result<Object> {
    let options = obj::ReadOptions { progress, ..obj::ReadOptions::default() };
    let read = obj::read(file, &options)?;
    let names = read.material_names.iter().map(|name| String::from_utf8_lossy(name).into_owned());
    let materials = names.map(|name| MaterialSpec::diffuse(name, auto::CLAY)).collect();
    Ok(Object {
        mesh: read.mesh,
        origin: read.origin,
        materials,
        findings: read.findings,
        skipped_faces: read.counts.skipped_faces,
    })
}
