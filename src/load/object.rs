//! A mesh file with its materials.

use super::materials::MaterialSpec;
use super::mtl::{self, MtlMaterial};
use super::obj;
use super::texture::{self, Search};
use super::{auto, classic};
use crate::error::{Findings, Result};
use crate::math::DVec3;
use crate::shape::Mesh;
use std::path::{Path, PathBuf};

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
}

/// Reads `file` and the material libraries that it names. `progress` hears the share done; its `false`
/// cancels. `defined`: the materials that need no library.
///
/// # Errors
/// As [`obj::read`]; a missing library or material is a finding, and its faces are clay.
pub(crate) fn read(
    file: &Path,
    progress: &(dyn Fn(f64) -> bool + Sync),
    defined: &dyn Fn(&[u8]) -> bool,
) -> Result<Object> {
    read_with(file, &obj::ReadOptions { progress, ..obj::ReadOptions::default() }, defined)
}

/// As [`read`], with the reader's options.
///
/// # Errors
/// As [`read`].
pub(crate) fn read_with(
    file: &Path,
    options: &obj::ReadOptions<'_>,
    defined: &dyn Fn(&[u8]) -> bool,
) -> Result<Object> {
    let read = obj::read(file, options)?;
    let resolved = mtl::resolve(file, &read.libraries, &read.material_names, defined);
    let mut findings = read.findings;
    findings.append(resolved.findings);
    let mut search = Search::default();
    let definitions = resolved.materials.iter().map(Option::as_ref).chain(std::iter::repeat(None));
    let materials = read.material_names.iter().zip(definitions).map(|(name, definition)| {
        let name = String::from_utf8_lossy(name).into_owned();
        match definition {
            None => MaterialSpec::diffuse(name, auto::CLAY),
            Some(m) => texture::of_mtl(&name, m, classic::from_mtl, &mut search, &mut findings),
        }
    });
    let materials = materials.collect();
    Ok(Object {
        mesh: read.mesh,
        origin: read.origin,
        materials,
        findings,
        skipped_faces: read.counts.skipped_faces,
        libraries: resolved.libraries,
        defined: resolved.defined,
        definitions: resolved.materials,
        counts: read.counts,
        face_lines: read.face_lines,
    })
}
