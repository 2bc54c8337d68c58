//! The builder: straight to eight children, in parallel, with the same tree on any number of threads.
//!
//! The nodes above the tasks start as one group of triangles; the group with the largest surface is split
//! ([`super::split`]) until there are eight. Subtrees of up to [`SUBTREE`] triangles are one task each: halved down to less than
//! a block, then made nodes of eight at the least cost ([`super::collapse`]), stored depth first, which keeps what a ray
//! visits close together in memory; the tasks' nodes are joined in the tree's order. That is medium quality; high also splits
//! space ([`super::spatial`]), for which every group has spare room behind its references; low is another matter
//! ([`super::morton`]).
//!
//! **Memory.** References are sorted in place and are gone, but for the triangles' ids, before the blocks are
//! filled, so a build peaks at 1.35 times the finished structure (1.5 in high quality).
//!
//! **Depth.** The traversal's stack holds [`MAX_DEPTH`] levels. After [`HEURISTIC_DEPTH`] levels (ordinary
//! meshes need about log₈ n) the largest group is halved by count instead, so that a level divides the
//! number of triangles by eight: at most ten more levels for the largest mesh allowed. A task does the same after
//! [`HEURISTIC_LEVELS`] levels of two.

use super::bounds::Bounds;
use super::collapse::BinaryTree;
use super::morton;
use super::node::{Child, Node, WIDTH};
use super::order::most_promising_last;
use super::parts::{Part, Progress, Tree, fill_blocks, reserve};
use super::spatial::{self, BUDGET, OVERLAP, Spatial};
use super::split::{Group, Split, halve, part_few, share_room};
use super::traverse::MAX_DEPTH;
use super::triangle::{BLOCK, Block};
use crate::accel::{BuildOptions, Quality};
use crate::error::{Error, Result};
use crate::shape::Mesh;
use rayon::prelude::*;
use std::sync::Arc;

/// Triangles up to which a subtree is built by one thread.
pub const SUBTREE: usize = 1 << 14;

/// Levels that follow the surface area heuristic.
pub const HEURISTIC_DEPTH: usize = 24;

/// Binary levels of a task that follow the heuristic.
const HEURISTIC_LEVELS: usize = 48;

// 2^28 triangles are blocks of at most four after ten levels of eight, a task's are single ones after fourteen levels of
// two, and one level holds the leaves.
const _: () = assert!(HEURISTIC_DEPTH + 10 + HEURISTIC_LEVELS + 14 < MAX_DEPTH && SUBTREE <= 1 << 14);

/// The tree: nodes (the root first; none for an empty scene) and blocks of triangles.
pub struct Built {
    /// Nodes.
    pub nodes: Vec<Node>,
    /// Blocks.
    pub blocks: Vec<Block>,
    /// In how many leaves a triangle is on average: more than 1 where space was split.
    pub leaves_of_one: f64,
}

impl Built {
    /// What there is over no triangles.
    pub fn empty() -> Built {
        Built { nodes: Vec::new(), blocks: Vec::new(), leaves_of_one: 1.0 }
    }

    /// Bytes of nodes and blocks.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.blocks[..])
    }
}

/// Builds the tree over `meshes`.
pub fn build(meshes: &[Arc<Mesh>], options: &BuildOptions<'_>) -> Result<Built> {
    let total: usize = meshes.iter().map(|m| m.indices.len()).sum();
    if total > Child::MAX_INDEX || meshes.len() >= u32::MAX as usize {
        return Err(Error::new(format!("{total} triangles are more than the BVH can hold"))
            .advise(format!("its limit is {}; use another backend", Child::MAX_INDEX)));
    }
    if options.quality == Quality::Low {
        return morton::build(meshes, options);
    }
    let extra = match options.quality {
        Quality::High => ((total as f64 * BUDGET) as usize).min(Child::MAX_INDEX - total),
        _ => 0,
    };
    let mut refs = references(meshes, total, extra)?;
    let progress = Progress::new(refs.len(), options);
    if refs.is_empty() {
        return progress.report(0).map(|()| Built::empty());
    }
    let triangles = refs.len();
    let mut whole = Group::around(&refs, 0);
    whole.room += extra;
    refs.resize(whole.room, Bounds::EMPTY);
    let builder = Builder { meshes, least_overlap: OVERLAP * whole.bounds.half_area(), progress };
    let tree = builder.grow(&mut refs, 0, whole, 0)?;
    // The boxes are in the nodes by now; a quarter of the memory keeps what the blocks still need. Blocks come before the
    // nodes are joined: what the parts give back would not go back to the system, and add to the peak.
    let ids = ids(refs)?;
    let spans = tree.spans()?;
    let blocks = fill_blocks(meshes, |i| ids[i], &spans)?;
    drop(ids);
    let in_leaves: usize = spans.iter().map(|(_, len)| *len as usize).sum();
    drop(spans);
    let mut nodes = tree.join()?;
    most_promising_last(&mut nodes, &blocks, &builder.progress)?;
    Ok(Built { nodes, blocks, leaves_of_one: in_leaves as f64 / triangles as f64 })
}

/// Boxes of all triangles with area, with mesh and triangle id as the owner's words, and room for
/// `extra` more.
fn references(meshes: &[Arc<Mesh>], total: usize, extra: usize) -> Result<Vec<Bounds>> {
    let mut refs: Vec<Bounds> = Vec::new();
    reserve(&mut refs, total + extra)?;
    for (id, mesh) in meshes.iter().enumerate() {
        refs.par_extend(mesh.indices.par_iter().enumerate().map(|(triangle, _)| {
            let corners = mesh.triangle(triangle);
            let points = corners.map(|p| p.to_array());
            let bounds = Bounds::of_triangle(points, id as u32, triangle as u32);
            let bounds = if extra > 0 { spatial::with_margin(bounds, &points) } else { bounds };
            if crate::accel::brute::has_area(corners) { bounds } else { Bounds([f32::NAN; 8]) }
        }));
    }
    // Also drops what is not finite, and what is too far out for sizes that are; the readers let neither through, but a caller
    // of the library may.
    refs.retain(Bounds::is_in_range);
    Ok(refs)
}

/// Mesh and triangle of each reference.
fn ids(refs: Vec<Bounds>) -> Result<Vec<(u32, u32)>> {
    let mut ids = Vec::new();
    reserve(&mut ids, refs.len())?;
    ids.par_extend(refs.par_iter().map(Bounds::words));
    Ok(ids)
}

struct Builder<'a> {
    meshes: &'a [Arc<Mesh>],
    /// Half the area from which an overlap is worth a split in space.
    least_overlap: f64,
    progress: Progress<'a>,
}

impl Builder<'_> {
    /// Builds the node over `whole` with all threads; `refs` start at the index `base`.
    fn grow(&self, refs: &mut [Bounds], base: usize, whole: Group, depth: usize) -> Result<Tree> {
        if whole.len <= SUBTREE {
            let mut part = Part::default();
            self.grow_alone(refs, whole, &mut part);
            // Until they are joined there are thousands of parts.
            part.nodes.shrink_to_fit();
            part.spans.shrink_to_fit();
            self.progress.report(whole.len)?;
            return Ok(Tree::Part(part));
        }
        self.progress.report(0)?;
        let mut children = Children::new(whole);
        self.divide(refs, base, depth, &mut children);
        let mut refs = refs;
        let mut tasks = Vec::with_capacity(WIDTH);
        for (group, is_leaf) in children.iter() {
            let (mine, rest) = refs.split_at_mut(group.room);
            refs = rest;
            tasks.push((group, is_leaf, mine));
        }
        let grown = tasks.into_par_iter().map(|(group, is_leaf, refs)| {
            let tree = match is_leaf {
                true => Tree::Leaf { first: group.first, len: group.len },
                false => self.grow(refs, group.first, group, depth + 1)?,
            };
            Ok((group.bounds, tree))
        });
        Ok(Tree::Node(grown.collect::<Result<Vec<_>>>()?))
    }

    /// As [`Builder::grow`], on this thread, into `part`.
    fn grow_alone(&self, refs: &mut [Bounds], whole: Group, part: &mut Part) {
        let mut tree = BinaryTree::new(&whole);
        self.halve_down(refs, whole, 0, &mut tree);
        tree.collapse(part);
    }

    /// The binary tree over `whole`, down to halves of a block; returns its root.
    fn halve_down(&self, refs: &mut [Bounds], whole: Group, level: usize, tree: &mut BinaryTree) -> usize {
        let node = tree.push(whole);
        if whole.len <= BLOCK {
            if whole.len > 1 {
                let (left, right) = part_few(&mut refs[..whole.len], whole.first);
                let children = [tree.push(left), tree.push(right)];
                tree.join(node, children);
            }
        } else {
            let (left, right) = self.split(refs, whole, level < HEURISTIC_LEVELS);
            let (mine, rest) = refs.split_at_mut(left.room);
            let children = [
                self.halve_down(mine, left, level + 1, tree),
                self.halve_down(&mut rest[..right.room], right, level + 1, tree),
            ];
            tree.join(node, children);
        }
        node
    }

    /// Splits a group of more than a block, whose references `refs` begin with.
    fn split(&self, refs: &mut [Bounds], group: Group, by_surface: bool) -> (Group, Group) {
        let split = if by_surface { Split::find(&refs[..group.len], &group) } else { None };
        let spatial = if by_surface { self.spatial(refs, &group, split.as_ref()) } else { None };
        let in_space = spatial.and_then(|s| s.apply(self.meshes, refs, group.len, group.first));
        let whole = &mut refs[..group.len];
        let (mut left, mut right) = in_space.unwrap_or_else(|| match split {
            Some(split) => split.apply(whole, group.first),
            None => halve(whole, group.first),
        });
        share_room(refs, &mut left, &mut right);
        (left, right)
    }

    /// Splits groups until there are eight or all fit a block.
    fn divide(&self, refs: &mut [Bounds], base: usize, depth: usize, children: &mut Children) {
        let by_surface = depth < HEURISTIC_DEPTH;
        while let Some(index) = children.next_to_split(by_surface) {
            let group = children.groups[index];
            let mine = &mut refs[group.first - base..][..group.room];
            let (left, right) = self.split(mine, group, by_surface);
            children.replace(index, left, right);
        }
    }

    /// A split in space that is cheaper than `split`, where that one's sides overlap and there is room.
    fn spatial(&self, refs: &[Bounds], group: &Group, split: Option<&Split>) -> Option<Spatial> {
        let overlap = split.map_or(f64::INFINITY, Split::overlap);
        if refs.len() == group.len || overlap <= self.least_overlap {
            return None;
        }
        let found = Spatial::find(self.meshes, &refs[..group.len], group)?;
        split.is_none_or(|s| found.cost < s.cost).then_some(found)
    }
}

/// The groups that become a node's children, in the order of their references.
struct Children {
    groups: [Group; WIDTH],
    is_leaf: [bool; WIDTH],
    len: usize,
}

impl Children {
    fn new(whole: Group) -> Children {
        Children { groups: [whole; WIDTH], is_leaf: [whole.len <= BLOCK; WIDTH], len: 1 }
    }

    fn iter(&self) -> impl Iterator<Item = (Group, bool)> + '_ {
        self.groups.iter().copied().zip(self.is_leaf).take(self.len)
    }

    /// The largest group that is no leaf, by surface (then by count) or by count alone.
    fn next_to_split(&self, by_surface: bool) -> Option<usize> {
        if self.len == WIDTH {
            return None;
        }
        let size = |i: usize| {
            let g = &self.groups[i];
            (if by_surface { g.bounds.half_area() } else { 0.0 }, g.len)
        };
        let mut best: Option<usize> = None;
        for i in (0..self.len).filter(|&i| !self.is_leaf[i]) {
            if best.is_none_or(|b| size(i) > size(b)) {
                best = Some(i);
            }
        }
        best
    }

    fn replace(&mut self, index: usize, left: Group, right: Group) {
        for i in (index + 1..self.len).rev() {
            self.groups[i + 1] = self.groups[i];
            self.is_leaf[i + 1] = self.is_leaf[i];
        }
        self.len += 1;
        for (i, group) in [(index, left), (index + 1, right)] {
            self.groups[i] = group;
            self.is_leaf[i] = group.len <= BLOCK;
        }
    }
}
