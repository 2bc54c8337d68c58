//! Triangles without texture coordinates show no pictures.

use super::build::material;
use crate::bsdf::{Maps, Material};
use crate::error::{Finding, Findings, Severity};
use crate::load::materials::MaterialSpec;
use crate::shape::{FaceMaterials, Mesh};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Gives triangles that have pictures and no texture coordinates a twin of their material with constants, so that
/// nobody has to ask at every hit. One warning a material.
pub(super) fn separate(
    specs: &[MaterialSpec],
    meshes: &mut [Arc<Mesh>],
    materials: &mut Vec<Material>,
    findings: &mut Findings,
) {
    let pictured: Vec<bool> =
        materials.iter().map(|m| m.maps.as_deref().is_some_and(Maps::have_pictures)).collect();
    if !pictured.contains(&true) {
        return;
    }
    // Twins and the number of their triangles by material.
    let mut twins: BTreeMap<u32, (u32, u64)> = BTreeMap::new();
    for i in 0..meshes.len() {
        let Some(mesh) = meshes.get(i).cloned() else { continue };
        let is_bare = |t: usize| {
            let id = mesh.materials.get(t) as usize;
            pictured.get(id) == Some(&true) && mesh.triangle_uvs(t).is_none()
        };
        if !(0..mesh.indices.len()).any(is_bare) {
            continue;
        }
        let mut ids: Vec<u32> = (0..mesh.indices.len()).map(|t| mesh.materials.get(t)).collect();
        for (_, id) in ids.iter_mut().enumerate().filter(|(t, _)| is_bare(*t)) {
            let next = (materials.len() + twins.len()) as u32;
            let twin = twins.entry(*id).or_insert((next, 0));
            (*id, twin.1) = (twin.0, twin.1 + 1);
        }
        let mut own = Mesh::clone(&mesh);
        own.materials = match ids.first() {
            Some(first) if ids.iter().all(|id| id == first) => FaceMaterials::Uniform(*first),
            _ => FaceMaterials::PerFace(ids),
        };
        let own = Arc::new(own);
        // Placed several times, it is one mesh still.
        for other in meshes.iter_mut().skip(i).filter(|other| Arc::ptr_eq(other, &mesh)) {
            *other = own.clone();
        }
    }
    let mut in_order: Vec<(u32, u32, u64)> = twins.into_iter().map(|(id, (twin, n))| (twin, id, n)).collect();
    in_order.sort_unstable();
    for (_, id, triangles) in in_order {
        let Some(spec) = specs.get(id as usize) else { continue };
        materials.push(material(spec, None));
        let stated = spec.maps.first().map(|map| &map.stated);
        findings.push(Finding {
            file: stated.map(|stated| stated.file.clone()).unwrap_or_default(),
            line: stated.map_or(0, |stated| stated.line),
            kind: "texture-without-coordinates",
            message: format!(
                "material \"{}\" has textures, and {triangles} of its triangles have no texture coordinates: they show constants",
                spec.name
            ),
            severity: Severity::Warning,
        });
    }
}
