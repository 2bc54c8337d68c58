//! A mesh file with its materials.

use super::auto;
use super::materials::{MaterialSpec, Model};
use super::mtl::{self, At, MtlMaterial};
use super::obj;
use crate::bsdf::fresnel::Reflectance;
use crate::error::{Findings, Result};
use crate::math::{DVec3, Rgb};
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
    /// What the libraries say, by the mesh's material ids; `None` where no library defines it.
    pub definitions: Vec<Option<MtlMaterial>>,
    /// What the file held.
    pub counts: obj::Counts,
    /// The line of each triangle's face, where it was asked for.
    pub face_lines: Option<Vec<u32>>,
}

/// Reads `file` and the material libraries that it names. `progress` hears the share done; its `false`
/// cancels.
///
/// # Errors
/// As [`obj::read`]; a missing library or material is a finding, and its faces are clay.
pub(crate) fn read(file: &Path, progress: &(dyn Fn(f64) -> bool + Sync)) -> Result<Object> {
    read_with(file, &obj::ReadOptions { progress, ..obj::ReadOptions::default() })
}

/// As [`read`], with the reader's options.
///
/// # Errors
/// As [`read`].
pub(crate) fn read_with(file: &Path, options: &obj::ReadOptions<'_>) -> Result<Object> {
    let read = obj::read(file, options)?;
    let resolved = mtl::resolve(file, &read.libraries, &read.material_names);
    let mut findings = read.findings;
    findings.append(resolved.findings);
    let definitions = resolved.materials.iter().map(Option::as_ref).chain(std::iter::repeat(None));
    let materials = read.material_names.iter().zip(definitions).map(|(name, definition)| {
        let name = String::from_utf8_lossy(name).into_owned();
        definition.map_or_else(|| MaterialSpec::diffuse(name.as_str(), auto::CLAY), |m| from_mtl(&name, m))
    });
    Ok(Object {
        mesh: read.mesh,
        origin: read.origin,
        materials: materials.collect(),
        findings,
        skipped_faces: read.counts.skipped_faces,
        libraries: resolved.libraries,
        definitions: resolved.materials,
        counts: read.counts,
        face_lines: read.face_lines,
    })
}

/// An MTL's material. `Pm` of a half or more is a metal that reflects `Kd`, rough by `Pr`; all else is
/// diffuse by `Kd`. What this version cannot show (highlights, glass, textures) is left out.
fn from_mtl(name: &str, m: &MtlMaterial) -> MaterialSpec {
    let color = |stated: &Option<At<[f32; 3]>>| stated.as_ref().map(|at| Rgb::from(at.value));
    let reflectance = color(&m.kd).unwrap_or(auto::CLAY);
    let mut spec = MaterialSpec::diffuse(name, reflectance);
    if m.pm.is_some_and(|pm| pm.value >= 0.5) {
        // The scene file's own rule: GGX α is roughness squared. Without `Pr`, a brushed look.
        let roughness = m.pr.map_or(0.5, |pr| pr.value);
        let reflectance = Reflectance::Constant(reflectance);
        spec.model = Model::Conductor { reflectance, alpha: roughness * roughness, compensate: true };
    }
    spec.emission = color(&m.ke).unwrap_or(Rgb::ZERO);
    spec
}

#[cfg(test)]
mod tests {
    use super::*;

    fn stated<T>(value: T) -> Option<At<T>> {
        Some(At { value, line: 1 })
    }

    #[test]
    fn an_mtl_says_diffuse_metal_and_emission() {
        let plain = from_mtl("", &MtlMaterial::default());
        assert_eq!(plain, MaterialSpec::diffuse("", auto::CLAY));
        let red = MtlMaterial { kd: stated([0.8, 0.1, 0.0]), ke: stated([2.0; 3]), ..MtlMaterial::default() };
        let spec = from_mtl("red", &red);
        assert_eq!(spec.model, Model::Diffuse { reflectance: Rgb::new(0.8, 0.1, 0.0) });
        assert_eq!((spec.emission, spec.two_sided), (Rgb::splat(2.0), true));
        let metal = MtlMaterial { pm: stated(1.0), pr: stated(0.5), ..red };
        let reflectance = Reflectance::Constant(Rgb::new(0.8, 0.1, 0.0));
        let expected = Model::Conductor { reflectance, alpha: 0.25, compensate: true };
        assert_eq!(from_mtl("metal", &metal).model, expected);
    }
}
