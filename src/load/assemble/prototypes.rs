//! Which meshes are kept once, and what each instance takes of them.

use super::places::{Kind, Placement, Stock, kind};
use crate::shape::{Mesh, NO_INDEX};
use std::collections::{BTreeMap, HashMap};

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
        let mut substitutes = Substitutes::new(stock);
        // By what a mesh is and what its materials are, and the first one of each kind.
        let mut known: BTreeMap<(Kind, Option<u32>), usize> = BTreeMap::new();
        let mut first: BTreeMap<Kind, usize> = BTreeMap::new();
        // Meshes with their own materials first: they serve those with others as well.
        for (_, p) in instances.clone().filter(|(_, p)| p.choice.key().is_none()) {
            let mesh = *known.entry((kind(p), None)).or_insert_with(|| {
                all.of.push(p);
                all.of.len() - 1
            });
            first.entry(kind(p)).or_insert(mesh);
        }
        for (_, p) in instances {
            let (kind, own) = (kind(p), p.choice.key());
            if let Some(mesh) = known.get(&(kind, own)) {
                all.uses.push((*mesh, None));
                continue;
            }
            match (first.get(&kind), own) {
                (Some(mesh), Some(id)) if substitutes.allow(id, p) => all.uses.push((*mesh, own)),
                _ => {
                    all.of.push(p);
                    let mesh = all.of.len() - 1;
                    known.insert((kind, own), mesh);
                    first.entry(kind).or_insert(mesh);
                    all.uses.push((mesh, None));
                }
            }
        }
        all
    }
}

/// Which materials can stand in for a mesh's own by name alone: where one has pictures, triangles without texture
/// coordinates need to be known beforehand.
struct Substitutes<'s> {
    stock: &'s Stock<'s>,
    /// By material: neither it nor a part of it has pictures.
    is_plain: Vec<bool>,
    /// By file, as far as it was asked: all triangles have texture coordinates.
    has_all: HashMap<usize, bool>,
}

impl<'s> Substitutes<'s> {
    fn new(stock: &'s Stock<'s>) -> Self {
        let mut is_plain: Vec<bool> = Vec::with_capacity(stock.specs.len());
        for spec in stock.specs {
            // Parts come before the mixture.
            let part_is_plain = |part: &u32| is_plain.get(*part as usize) == Some(&true);
            let parts_are_plain = spec.mix.as_ref().is_none_or(|mix| mix.ids.iter().all(part_is_plain));
            is_plain.push(spec.maps.is_empty() && parts_are_plain);
        }
        Substitutes { stock, is_plain, has_all: HashMap::new() }
    }

    /// Whether the material `id` can stand in for those of a placement's mesh.
    fn allow(&mut self, id: u32, p: &Placement) -> bool {
        let has_all = |mesh: &Mesh| {
            mesh.uvs.as_ref().is_some_and(|uvs| {
                uvs.indices.as_ref().is_none_or(|own| !own.iter().flatten().any(|i| *i == NO_INDEX))
            })
        };
        self.is_plain.get(id as usize) != Some(&false)
            || *self
                .has_all
                .entry(p.file)
                .or_insert_with(|| p.mesh(self.stock.objects).is_some_and(|o| has_all(&o.mesh)))
    }
}
