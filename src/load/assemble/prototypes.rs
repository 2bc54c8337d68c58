//! Which meshes are kept once, and what each instance takes of them.

use super::palette::Choice;
use super::places::{Kind, Placement, Stock, kind};
use crate::load::materials::MaterialSpec;
use crate::shape::{Mesh, NO_INDEX};
use std::collections::BTreeMap;

/// The meshes that have instances, and what each instance takes of them.
pub struct Prototypes<'p> {
    /// The first placement of each mesh.
    pub of: Vec<&'p Placement>,
    /// By instance: the mesh, and a material instead of its own.
    pub uses: Vec<(usize, Option<u32>)>,
}

impl<'p> Prototypes<'p> {
    /// Of placements with their indices.
    pub fn new(instances: impl Iterator<Item = (usize, &'p Placement)> + Clone, stock: &Stock<'_>) -> Self {
        let mut all = Prototypes { of: Vec::new(), uses: Vec::new() };
        // Meshes with their own materials first: they serve those with others as well.
        let mut known: BTreeMap<Kind, Vec<usize>> = BTreeMap::new();
        let by_file = instances.clone().filter(|(_, p)| matches!(p.choice, Choice::ByFile(_)));
        for (_, p) in by_file {
            known.entry(kind(p)).or_insert_with(|| {
                all.of.push(p);
                vec![all.of.len() - 1]
            });
        }
        for (_, p) in instances {
            let meshes = known.entry(kind(p)).or_default();
            let of = &all.of;
            let same = meshes.iter().find(|m| of.get(**m).is_some_and(|other| other.choice == p.choice));
            let fits = match (same, &p.choice) {
                (Some(mesh), _) => Some((*mesh, None)),
                (None, Choice::One(id)) if stands_in(*id, p, stock) => {
                    meshes.first().map(|m| (*m, Some(*id)))
                }
                _ => None,
            };
            let taken = fits.unwrap_or_else(|| {
                all.of.push(p);
                meshes.push(all.of.len() - 1);
                (all.of.len() - 1, None)
            });
            all.uses.push(taken);
        }
        all
    }
}

/// Whether the material `id` can stand in for a mesh's own by name alone: where it has pictures, triangles without
/// texture coordinates need to be known beforehand.
fn stands_in(id: u32, p: &Placement, stock: &Stock<'_>) -> bool {
    fn is_plain(id: u32, specs: &[MaterialSpec]) -> bool {
        let Some(spec) = specs.get(id as usize) else { return true };
        let parts_are_plain = |ids: [u32; 2]| ids.iter().all(|part| *part < id && is_plain(*part, specs));
        spec.maps.is_empty() && spec.mix.as_ref().is_none_or(|mix| parts_are_plain(mix.ids))
    }
    let has_all = |mesh: &Mesh| {
        mesh.uvs.as_ref().is_some_and(|uvs| {
            uvs.indices.as_ref().is_none_or(|own| !own.iter().flatten().any(|i| *i == NO_INDEX))
        })
    };
    is_plain(id, stock.specs) || p.mesh(stock.objects).is_some_and(|o| has_all(&o.mesh))
}
