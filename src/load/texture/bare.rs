//! Triangles without texture coordinates show no pictures.

use super::build::material;
use crate::bsdf::{Maps, Material, Mix};
use crate::error::{Finding, Findings, Severity};
use crate::load::materials::MaterialSpec;
use crate::shape::{FaceMaterials, Mesh};
use std::collections::{BTreeMap, HashMap};
use std::sync::Arc;

/// Gives triangles that have pictures and no texture coordinates a twin of their material with constants, so that
/// nobody has to ask at every hit. One warning a material.
pub(super) fn separate(
    specs: &[MaterialSpec],
    meshes: &mut [Arc<Mesh>],
    materials: &mut Vec<Material>,
    findings: &mut Findings,
) {
    let pictured = pictured(materials);
    if !pictured.contains(&true) {
        return;
    }
    let is_bare = |mesh: &Mesh, t: usize| {
        pictured.get(mesh.materials.get(t) as usize) == Some(&true) && mesh.triangle_uvs(t).is_none()
    };
    // Placed several times, it is one mesh still, and looked at once.
    let mut places: HashMap<*const Mesh, Vec<usize>> = HashMap::new();
    for (i, mesh) in meshes.iter().enumerate() {
        places.entry(Arc::as_ptr(mesh)).or_default().push(i);
    }
    let mut counts: BTreeMap<u32, u64> = BTreeMap::new();
    for places in places.values() {
        let Some(mesh) = places.first().and_then(|i| meshes.get(*i)) else { continue };
        for t in (0..mesh.indices.len()).filter(|t| is_bare(mesh, *t)) {
            *counts.entry(mesh.materials.get(t)).or_default() += places.len() as u64;
        }
    }
    if counts.is_empty() {
        return;
    }
    let twins = add_twins(specs, &counts, &pictured, materials);
    for (id, triangles) in counts {
        if let Some(spec) = specs.get(id as usize) {
            findings.push(warning(spec, triangles));
        }
    }
    for places in places.into_values() {
        let Some(mesh) = places.first().and_then(|i| meshes.get(*i)).cloned() else { continue };
        let count = mesh.indices.len();
        if !(0..count).any(|t| is_bare(&mesh, t)) {
            continue;
        }
        let id = |t: usize| mesh.materials.get(t);
        let ids = (0..count)
            .map(|t| if is_bare(&mesh, t) { twins.get(&id(t)).copied() } else { None }.unwrap_or(id(t)));
        let mut own = Mesh::clone(&mesh);
        own.materials = FaceMaterials::PerFace(ids.collect());
        let own = Arc::new(own);
        for i in places {
            if let Some(place) = meshes.get_mut(i) {
                *place = own.clone();
            }
        }
    }
}

/// By material: whether it, or a part that it is mixed of, has pictures. Parts come before the mixture.
fn pictured(materials: &[Material]) -> Vec<bool> {
    let mut pictured: Vec<bool> = Vec::with_capacity(materials.len());
    for m in materials {
        let part = |id: &u32| pictured.get(*id as usize) == Some(&true);
        let mixed = m.mix.is_some_and(|mix| mix.parts.iter().any(part));
        pictured.push(mixed || m.maps.as_deref().is_some_and(Maps::have_pictures));
    }
    pictured
}

/// Adds the twins of the materials in `counts` and of their parts, parts first; twins by the originals' ids.
fn add_twins(
    specs: &[MaterialSpec],
    counts: &BTreeMap<u32, u64>,
    pictured: &[bool],
    materials: &mut Vec<Material>,
) -> BTreeMap<u32, u32> {
    let mut needed: BTreeMap<u32, ()> = counts.keys().map(|id| (*id, ())).collect();
    for id in (0..specs.len() as u32).rev().filter(|id| pictured.get(*id as usize) == Some(&true)) {
        let mix = materials.get(id as usize).and_then(|m| m.mix);
        if let (true, Some(mix)) = (needed.contains_key(&id), mix) {
            needed.extend(mix.parts.map(|part| (part, ())));
        }
    }
    let mut twins = BTreeMap::new();
    for id in needed.into_keys() {
        let Some(spec) = specs.get(id as usize) else { continue };
        let mut twin = material(spec, None);
        twin.mix = twin
            .mix
            .map(|mix| Mix { parts: mix.parts.map(|part| twins.get(&part).copied().unwrap_or(part)), ..mix });
        twins.insert(id, materials.len() as u32);
        materials.push(twin);
    }
    twins
}

fn warning(spec: &MaterialSpec, triangles: u64) -> Finding {
    let stated = spec.maps.first().map(|map| &map.stated);
    let name = &spec.name;
    Finding {
        file: stated.map(|stated| stated.file.clone()).unwrap_or_default(),
        line: stated.map_or(0, |stated| stated.line),
        kind: "texture-without-coordinates",
        message: format!(
            "material \"{name}\" has textures, and {triangles} of its triangles have no texture coordinates: they show constants"
        ),
        severity: Severity::Warning,
    }
}
