//! The tree of nodes: where meshes, cameras and lights stand.

use super::Document;
use super::accessor::Accessor;
use super::item::Item;
use crate::error::{Error, Result};
use crate::math::{DMat4, DVec3};
use glam::{DQuat, DVec4};
use std::collections::HashSet;

/// A node that is in the scene, and its place.
pub(super) struct Placed<'d> {
    pub node: Item<'d>,
    pub matrix: DMat4,
}

/// The nodes of a document.
pub(super) struct Nodes<'d> {
    /// Those of the scene, parents first, in the order of the document.
    pub placed: Vec<Placed<'d>>,
    /// By node: its place; unit where it is not in the scene.
    pub matrices: Vec<DMat4>,
}

impl<'d> Nodes<'d> {
    /// The nodes of the scene that the document shows; of the first one, or all of them, where it does not say.
    ///
    /// # Errors
    /// A node that does not exist, or that is below two others.
    pub fn of(root: &Item<'d>) -> Result<Nodes<'d>> {
        let count = root.count("nodes");
        let mut waiting: Vec<(usize, DMat4)> = Vec::new();
        match root.count("scenes") {
            0 => {
                let children = root.list("nodes").flat_map(|n| n.list("children"));
                let below: HashSet<usize> = children.filter_map(|c| c.as_index().ok()).collect();
                waiting.extend((0..count).filter(|n| !below.contains(n)).map(|n| (n, DMat4::IDENTITY)));
            }
            _ => {
                let scene = root.at("scenes", root.size("scene", Some(0))?)?;
                for node in scene.list("nodes") {
                    waiting.push((node.as_index()?, DMat4::IDENTITY));
                }
            }
        }
        waiting.reverse();
        let mut nodes = Nodes { placed: Vec::new(), matrices: vec![DMat4::IDENTITY; count] };
        let mut seen = vec![false; count];
        while let Some((index, parent)) = waiting.pop() {
            let node = root.at("nodes", index)?;
            if seen.get(index) != Some(&false) {
                return Err(node.error("is below two other nodes, or below itself"));
            }
            let matrix = parent * own_matrix(&node)?;
            if let (Some(seen), Some(slot)) = (seen.get_mut(index), nodes.matrices.get_mut(index)) {
                (*seen, *slot) = (true, matrix);
            }
            let first = waiting.len();
            for child in node.list("children") {
                waiting.push((child.as_index()?, matrix));
            }
            if let Some(children) = waiting.get_mut(first..) {
                children.reverse();
            }
            nodes.placed.push(Placed { node, matrix });
        }
        Ok(nodes)
    }
}

/// A matrix column by column, or scale, then rotation, then translation.
fn own_matrix(node: &Item<'_>) -> Result<DMat4> {
    if node.get("matrix").is_some() {
        return Ok(DMat4::from_cols_array(&node.numbers("matrix", [0.0; 16])?));
    }
    let translation = node.numbers("translation", [0.0; 3])?;
    let rotation = node.numbers("rotation", [0.0, 0.0, 0.0, 1.0])?;
    let scale = node.numbers("scale", [1.0; 3])?;
    Ok(steps(scale, rotation, translation))
}

fn steps(scale: [f64; 3], rotation: [f64; 4], translation: [f64; 3]) -> DMat4 {
    let rotation = DVec4::from_array(rotation).try_normalize().map_or(DQuat::IDENTITY, DQuat::from_vec4);
    DMat4::from_scale_rotation_translation(DVec3::from_array(scale), rotation, DVec3::from_array(translation))
}

/// The places of a node's copies by `EXT_mesh_gpu_instancing`, relative to it; one without that extension.
///
/// # Errors
/// An accessor that cannot be read.
pub(super) fn copies(document: &Document<'_>, node: &Item<'_>) -> Result<Vec<DMat4>> {
    let Some(instancing) = node.extension("EXT_mesh_gpu_instancing") else {
        return Ok(vec![DMat4::IDENTITY]);
    };
    let attributes = instancing.need("attributes")?;
    let of = |name: &str| attributes.index(name)?.map(|a| Accessor::of(document, a)).transpose();
    let (translation, rotation, scale) = (of("TRANSLATION")?, of("ROTATION")?, of("SCALE")?);
    let count = [&translation, &rotation, &scale].into_iter().flatten().map(|a| a.count).max().unwrap_or(0);
    let mut copies = Vec::new();
    copies.try_reserve_exact(count).map_err(|_| Error::new("not enough memory for the copies of a mesh"))?;
    copies.extend((0..count).map(|i| {
        steps(
            scale.as_ref().map_or([1.0; 3], |a| a.element(i)),
            rotation.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |a| a.element(i)),
            translation.as_ref().map_or([0.0; 3], |a| a.element(i)),
        )
    }));
    Ok(copies)
}
