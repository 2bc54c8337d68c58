//! Meshes that nodes show again and again: read once, with all the places where they stand.

use super::Document;
use super::item::Item;
use super::nodes::{self, Nodes};
use super::skin::Skin;
use crate::error::{Error, Result};
use crate::load::place::Transform;
use crate::math::DMat4;
use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::sync::Arc;

/// How much the nodes of a document may show: vertices, and places, which take time as well.
pub(super) struct Room<'d> {
    /// What is shown by now.
    pub taken: u64,
    /// The limit.
    pub most: u64,
    /// The document.
    pub file: &'d Path,
}

impl Room<'_> {
    /// Takes room for `more`.
    ///
    /// # Errors
    /// There is none left.
    pub fn take(&mut self, more: u64) -> Result<()> {
        self.taken = self.taken.saturating_add(more);
        if self.taken <= self.most {
            return Ok(());
        }
        let error = format!("its nodes show meshes again and again, with more than {} vertices", self.most);
        Err(Error::new(error).at(self.file).advise("split it, or place its mesh in a scene file"))
    }
}

/// A mesh that a node shows.
pub(super) struct Shown<'d> {
    /// Its index in the document.
    pub mesh: usize,
    /// The mesh.
    pub item: Item<'d>,
    /// Where it stands.
    pub places: Vec<DMat4>,
    /// The joints that bend it.
    pub skin: Option<Arc<Skin>>,
    /// Who says how much of each morph target: the node, or the mesh.
    pub weights: Item<'d>,
    /// Whether the node changes its shape, or flattens it.
    is_special: bool,
}

impl<'d> Shown<'d> {
    /// What the nodes show, in their order.
    ///
    /// # Errors
    /// References that lead nowhere; more places than there is `room` for.
    pub fn all(document: &Document<'d>, nodes: &Nodes<'d>, room: &mut Room<'_>) -> Result<Vec<Shown<'d>>> {
        let mut skins: HashMap<usize, Arc<Skin>> = HashMap::new();
        let mut all = Vec::new();
        for placed in &nodes.placed {
            let Some(mesh) = placed.node.index("mesh")? else { continue };
            let item = document.root.at("meshes", mesh)?;
            let skin = match placed.node.index("skin")? {
                None => None,
                Some(index) => Some(match skins.get(&index) {
                    Some(skin) => skin.clone(),
                    None => {
                        let skin = Arc::new(Skin::of(document, nodes, index)?);
                        skins.insert(index, skin.clone());
                        skin
                    }
                }),
            };
            let copies = nodes::copies(document, &placed.node)?;
            room.take(copies.len() as u64)?;
            let places: Vec<DMat4> = copies.iter().map(|copy| placed.matrix * *copy).collect();
            let has_own = placed.node.get("weights").is_some();
            let weights = if has_own { placed.node.clone() } else { item.clone() };
            let is_flat = places.iter().any(|place| Transform::new(*place).is_none());
            let is_special = has_own || skin.is_some() || is_flat;
            all.push(Shown { mesh, item, places, skin, weights, is_special });
        }
        Ok(all)
    }

    /// The size of its mesh's triangles, about.
    fn triangles(&self, document: &Document<'_>) -> u64 {
        let count = |accessor: Result<Option<usize>>| {
            let accessor = accessor.ok().flatten().and_then(|index| document.accessor(index).ok());
            accessor.map_or(0, |accessor| accessor.count as u64)
        };
        let of = |primitive: Item<'_>| match count(primitive.index("indices")) {
            0 => primitive.need("attributes").map_or(0, |attributes| count(attributes.index("POSITION"))),
            indices => indices,
        };
        self.item.list("primitives").map(of).fold(0, u64::saturating_add) / 3
    }

    /// The meshes to keep once, so that copies beyond a mesh's first have no more than `most` triangles together: those
    /// that save most.
    pub fn shared(all: &[Shown<'_>], document: &Document<'_>, most: u64) -> BTreeMap<usize, Vec<DMat4>> {
        let mut places: BTreeMap<usize, (u64, &Shown<'_>)> = BTreeMap::new();
        for shown in all.iter().filter(|shown| !shown.is_special) {
            places.entry(shown.mesh).or_insert((0, shown)).0 += shown.places.len() as u64;
        }
        let saved = |(mesh, (count, shown)): (usize, (u64, &Shown<'_>))| {
            (shown.triangles(document).saturating_mul(count.saturating_sub(1)), mesh)
        };
        let mut saved: Vec<(u64, usize)> =
            places.into_iter().map(saved).filter(|(saved, _)| *saved > 0).collect();
        saved.sort_unstable();
        let mut kept = 0u64;
        saved.retain(|(triangles, _)| {
            kept = kept.saturating_add(*triangles);
            kept > most
        });
        saved.into_iter().map(|(_, mesh)| (mesh, Vec::new())).collect()
    }

    /// Whether it stands among the places of its mesh in `shared`.
    pub fn joins<'s>(&self, shared: &'s mut BTreeMap<usize, Vec<DMat4>>) -> Option<&'s mut Vec<DMat4>> {
        if self.is_special { None } else { shared.get_mut(&self.mesh) }
    }
}
