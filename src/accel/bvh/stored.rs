//! A tree as plain numbers, to be kept in a file and taken up again.
//!
//! Whoever wrote the numbers may have been anybody, so [`Stored::finish`] believes none of them: the nodes must be one
//! tree of no more levels than the traversal has room for, and each triangle the mesh's own, bit for bit. What it cannot
//! see is whether the boxes hold what is in them: wrong ones lose hits, nothing worse.

use super::Bvh;
use super::build::Built;
use super::node::{Child, Node, WIDTH};
use super::parts::reserve;
use super::traverse::MAX_DEPTH;
use super::triangle::{BLOCK, Block};
use crate::error::Result;
use crate::math::isa::Isa;
use crate::memory;
use crate::shape::Mesh;
use rayon::prelude::*;
use std::sync::Arc;

/// Counts up whenever nodes or blocks have another form, or a build makes other ones.
pub const LAYOUT: u32 = 2;
/// Numbers of a node: the planes, then the children.
pub const NODE: usize = 7 * WIDTH;
/// Numbers of a block: the corners, the meshes, the triangles.
pub const TRIANGLES: usize = 11 * BLOCK;

/// No build puts a triangle into more leaves on average.
const MOST_LEAVES: f64 = 16.0;

impl Bvh {
    /// The nodes as numbers.
    pub fn nodes(&self) -> impl ExactSizeIterator<Item = [u32; NODE]> + '_ {
        self.tree.nodes.iter().map(|node| {
            let planes = node.planes.as_flattened().as_flattened().iter().map(|x| x.to_bits());
            collected(planes.chain(node.children.iter().map(|child| child.bits())))
        })
    }

    /// In how many leaves a triangle is on average: from 1.
    pub fn leaves_of_one(&self) -> f64 {
        self.tree.leaves_of_one
    }

    /// The blocks of triangles as numbers.
    pub fn blocks(&self) -> impl ExactSizeIterator<Item = [u32; TRIANGLES]> + '_ {
        self.tree.blocks.iter().map(|block| {
            let corners = block.corners.as_flattened().as_flattened().iter().map(|x| x.to_bits());
            collected(corners.chain(block.mesh).chain(block.triangle))
        })
    }
}

fn collected<const N: usize>(mut numbers: impl Iterator<Item = u32>) -> [u32; N] {
    std::array::from_fn(|_| numbers.next().unwrap_or(0))
}

/// A tree that is being taken up.
#[derive(Default)]
pub struct Stored {
    nodes: Vec<Node>,
    blocks: Vec<Block>,
}

impl Stored {
    /// Room for so many nodes and blocks.
    ///
    /// # Errors
    /// Not enough memory.
    pub fn new(nodes: usize, blocks: usize) -> Result<Stored> {
        let mut stored = Stored::default();
        reserve(&mut stored.nodes, nodes)?;
        reserve(&mut stored.blocks, blocks)?;
        Ok(stored)
    }

    /// Adds a node.
    pub fn node(&mut self, numbers: [u32; NODE]) {
        let mut node = Node::EMPTY;
        let (planes, children) = numbers.split_at(6 * WIDTH);
        for (to, from) in node.planes.as_flattened_mut().as_flattened_mut().iter_mut().zip(planes) {
            *to = f32::from_bits(*from);
        }
        for (to, from) in node.children.iter_mut().zip(children) {
            *to = Child::from_bits(*from);
        }
        self.nodes.push(node);
    }

    /// Adds a block.
    pub fn block(&mut self, numbers: [u32; TRIANGLES]) {
        let mut block = Block::EMPTY;
        let (corners, ids) = numbers.split_at(9 * BLOCK);
        for (to, from) in block.corners.as_flattened_mut().as_flattened_mut().iter_mut().zip(corners) {
            *to = f32::from_bits(*from);
        }
        for (to, from) in block.mesh.iter_mut().chain(&mut block.triangle).zip(ids) {
            *to = *from;
        }
        self.blocks.push(block);
    }

    /// The structure, if it is one over `meshes`. `leaves_of_one`: as [`Bvh::leaves_of_one`] said.
    pub fn finish(self, meshes: &[Arc<Mesh>], leaves_of_one: f64, isa: Option<Isa>) -> Option<Bvh> {
        let Stored { nodes, blocks } = self;
        let sound = is_tree(&nodes, blocks.len())?
            && nodes.is_empty() == blocks.is_empty()
            && (1.0..=MOST_LEAVES).contains(&leaves_of_one)
            && nodes.par_iter().with_min_len(1 << 12).all(has_sound_planes)
            && blocks.par_iter().with_min_len(1 << 12).all(|block| is_of(block, meshes));
        sound.then(|| Bvh::over(Built { nodes, blocks, leaves_of_one }, isa))
    }
}

/// Whether every node but the first hangs below one that comes before it, in no more levels than there may be, and leaves
/// name blocks that there are. `None` where there is not enough memory to tell.
fn is_tree(nodes: &[Node], blocks: usize) -> Option<bool> {
    let mut levels: Vec<u8> = Vec::new();
    memory::reserve(&mut levels, nodes.len()).ok()?;
    levels.resize(nodes.len(), 0);
    for (index, node) in nodes.iter().enumerate() {
        let level = levels.get(index).copied().filter(|level| index == 0 || *level > 0);
        let Some(next) = level.map(|level| level + 1).filter(|next| usize::from(*next) < MAX_DEPTH) else {
            return Some(false);
        };
        for child in node.children.iter().filter(|child| **child != Child::NONE) {
            let sound = if child.is_leaf() {
                child.blocks().end <= blocks
            } else {
                let unseen =
                    levels.get_mut(child.index()).filter(|level| child.index() > index && **level == 0);
                unseen.map(|level| *level = next).is_some()
            };
            if !sound {
                return Some(false);
            }
        }
    }
    Some(true)
}

/// Whether no plane is NaN: a box that is entered by none or by all is no trouble, one that is neither might be.
fn has_sound_planes(node: &Node) -> bool {
    node.planes.as_flattened().as_flattened().iter().all(|x| !x.is_nan())
}

/// Whether a block's triangles are those of the meshes, and its unused lanes empty.
fn is_of(block: &Block, meshes: &[Arc<Mesh>]) -> bool {
    (0..BLOCK).all(|lane| {
        let [mesh, triangle] = block.ids(lane);
        let ours = |corner: usize, axis: usize| block.corners[corner][axis][lane];
        if mesh == u32::MAX && triangle == u32::MAX {
            return (0..9).all(|i| ours(i / 3, i % 3).is_nan());
        }
        let Some(mesh) = meshes.get(mesh as usize).filter(|m| (triangle as usize) < m.indices.len()) else {
            return false;
        };
        let theirs = mesh.triangle(triangle as usize);
        (0..9).all(|i| ours(i / 3, i % 3).to_bits() == theirs[i / 3][i % 3].to_bits())
    })
}
