//! The builder: straight to eight children, in parallel, with the same tree on any number of threads.
//!
//! A node starts as one group of triangles; the group with the largest surface is split ([`super::split`])
//! until there are eight or none is worth splitting. Subtrees of up to [`SUBTREE`] triangles are one task each
//! and store their nodes depth first, which keeps what a ray visits close together in memory; the tasks'
//! nodes are then joined in the tree's order.
//!
//! **Depth.** The traversal's stack holds [`MAX_DEPTH`] levels. After [`HEURISTIC_DEPTH`] levels (ordinary
//! meshes need about log₈ n) the largest group is halved by count instead, so that a level divides the
//! number of triangles by eight: at most ten more levels for the largest mesh allowed.

use super::bounds::Bounds;
use super::node::{Child, Node, WIDTH};
use super::split::{Group, PARALLEL, Split, halve};
use super::traverse::MAX_DEPTH;
use super::triangle::{BLOCK, Block};
use crate::accel::{BuildOptions, Quality, cancelled};
use crate::error::{Error, Result};
use crate::shape::Mesh;
use rayon::prelude::*;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

/// Triangles up to which a subtree is built by one thread.
const SUBTREE: usize = 1 << 14;

/// Levels that follow the surface area heuristic.
const HEURISTIC_DEPTH: usize = 24;

// 2^28 triangles are blocks of at most four after ten levels of eight, and one level holds the leaves.
const _: () = assert!(HEURISTIC_DEPTH + 10 < MAX_DEPTH);

/// Cost of visiting a node's child relative to one block of triangles.
const VISIT: f64 = 1.0;

/// The tree: nodes (the root first; none for an empty scene) and blocks of triangles.
pub struct Built {
    /// Nodes.
    pub nodes: Vec<Node>,
    /// Blocks.
    pub blocks: Vec<Block>,
}

/// Builds the tree over `meshes`.
pub fn build(meshes: &[Arc<Mesh>], options: &BuildOptions<'_>) -> Result<Built> {
    let mut refs = references(meshes)?;
    let empty = Built { nodes: Vec::new(), blocks: Vec::new() };
    if refs.is_empty() {
        return if (options.progress)(1.0) { Ok(empty) } else { Err(cancelled()) };
    }
    let builder = Builder {
        bins: if options.quality == Quality::Low { 8 } else { 32 },
        total: refs.len(),
        done: AtomicUsize::new(0),
        stopped: AtomicBool::new(false),
        progress: options.progress,
    };
    let mut scratch = Vec::new();
    if refs.len() >= PARALLEL {
        reserve(&mut scratch, refs.len())?;
        scratch.resize(refs.len(), Bounds::EMPTY);
    }
    let whole = Group::around(&refs, 0);
    let tree = builder.grow(&mut refs, &mut scratch, 0, whole, 0)?;
    drop(scratch);
    let joined = Part::join(tree)?;
    let blocks = fill_blocks(meshes, &refs, &joined.spans)?;
    builder.report(0)?;
    Ok(Built { nodes: joined.nodes, blocks })
}

/// Boxes of all triangles with area, with mesh and triangle id as the owner's words.
fn references(meshes: &[Arc<Mesh>]) -> Result<Vec<Bounds>> {
    let total: usize = meshes.iter().map(|m| m.indices.len()).sum();
    if total > Child::MAX_INDEX || meshes.len() >= u32::MAX as usize {
        return Err(Error::new(format!("{total} triangles are more than the BVH can hold"))
            .advise(format!("its limit is {}; use another backend", Child::MAX_INDEX)));
    }
    let mut refs: Vec<Bounds> = Vec::new();
    reserve(&mut refs, total)?;
    for (id, mesh) in meshes.iter().enumerate() {
        refs.par_extend(mesh.indices.par_iter().enumerate().map(|(triangle, _)| {
            let corners = mesh.triangle(triangle);
            let bounds = Bounds::of_triangle(corners.map(|p| p.to_array()), id as u32, triangle as u32);
            if crate::accel::brute::has_area(corners) { bounds } else { Bounds([f32::NAN; 8]) }
        }));
    }
    // Also drops what is not finite, which the mesh rules out but a mistake elsewhere might bring.
    refs.retain(|r| r.middle2().iter().all(|x| x.is_finite()));
    Ok(refs)
}

/// Reserves room for `more` elements, or says that memory ran out.
fn reserve<T>(vec: &mut Vec<T>, more: usize) -> Result<()> {
    vec.try_reserve_exact(more).map_err(|_| {
        let mib = (more * size_of::<T>()) >> 20;
        Error::new(format!("not enough memory for the acceleration structure ({mib} MiB more were needed)"))
            .advise("use a smaller mesh or a machine with more memory")
    })
}

/// A finished piece of the tree: nodes, and per block the first reference and the number of triangles.
#[derive(Default)]
struct Part {
    nodes: Vec<Node>,
    spans: Vec<(u32, u32)>,
}

/// The tree above the tasks.
enum Tree {
    Leaf { first: usize, len: usize },
    Part(Part),
    Node(Vec<(Group, Tree)>),
}

impl Part {
    fn leaf(&mut self, first: usize, len: usize) -> Child {
        let child = Child::leaf(self.spans.len(), len.div_ceil(BLOCK));
        for start in (0..len).step_by(BLOCK) {
            self.spans.push(((first + start) as u32, BLOCK.min(len - start) as u32));
        }
        child
    }

    /// Everything in one piece, depth first.
    fn join(tree: Tree) -> Result<Part> {
        let mut all = Part::default();
        let (nodes, spans) = tree.size();
        reserve(&mut all.nodes, nodes)?;
        reserve(&mut all.spans, spans)?;
        all.append(tree);
        Ok(all)
    }

    fn append(&mut self, tree: Tree) -> Child {
        match tree {
            Tree::Leaf { first, len } => self.leaf(first, len),
            Tree::Part(part) => {
                let (nodes, blocks) = (self.nodes.len(), self.spans.len());
                self.spans.extend_from_slice(&part.spans);
                self.nodes.extend(part.nodes.into_iter().map(|mut node| {
                    node.children = node.children.map(|c| c.moved(nodes, blocks));
                    node
                }));
                Child::node(nodes)
            }
            Tree::Node(children) => {
                let index = self.nodes.len();
                self.nodes.push(Node::EMPTY);
                for (slot, (group, child)) in children.into_iter().enumerate() {
                    let child = self.append(child);
                    self.nodes[index].set(slot, &group.bounds, child);
                }
                Child::node(index)
            }
        }
    }
}

impl Tree {
    /// Numbers of nodes and blocks.
    fn size(&self) -> (usize, usize) {
        match self {
            Tree::Leaf { len, .. } => (0, len.div_ceil(BLOCK)),
            Tree::Part(part) => (part.nodes.len(), part.spans.len()),
            Tree::Node(children) => children.iter().fold((1, 0), |(n, b), (_, child)| {
                let (more_nodes, more_blocks) = child.size();
                (n + more_nodes, b + more_blocks)
            }),
        }
    }
}

struct Builder<'a> {
    bins: usize,
    total: usize,
    done: AtomicUsize,
    stopped: AtomicBool,
    progress: &'a (dyn Fn(f64) -> bool + Sync),
}

impl Builder<'_> {
    /// Counts finished triangles and asks whether to go on.
    fn report(&self, finished: usize) -> Result<()> {
        let done = self.done.fetch_add(finished, Ordering::Relaxed) + finished;
        if self.stopped.load(Ordering::Relaxed) || !(self.progress)(done as f64 / self.total as f64) {
            self.stopped.store(true, Ordering::Relaxed);
            return Err(cancelled());
        }
        Ok(())
    }

    /// Builds the node over `whole` with all threads; `refs` start at the index `base`.
    fn grow(
        &self,
        refs: &mut [Bounds],
        scratch: &mut [Bounds],
        base: usize,
        whole: Group,
        depth: usize,
    ) -> Result<Tree> {
        if refs.len() <= SUBTREE {
            let mut part = Part::default();
            self.grow_alone(refs, base, whole, depth, &mut part);
            self.report(refs.len())?;
            return Ok(Tree::Part(part));
        }
        self.report(0)?;
        let mut children = Children::new(whole);
        self.divide(refs, scratch, base, depth, &mut children);
        let (mut refs, mut scratch) = (refs, scratch);
        let mut tasks = Vec::with_capacity(WIDTH);
        for (group, is_leaf) in children.iter() {
            let (mine, rest) = refs.split_at_mut(group.len);
            let (my_scratch, scratch_rest) = scratch.split_at_mut(group.len.min(scratch.len()));
            (refs, scratch) = (rest, scratch_rest);
            tasks.push((group, is_leaf, mine, my_scratch));
        }
        let grown = tasks.into_par_iter().map(|(group, is_leaf, refs, scratch)| {
            let tree = match is_leaf {
                true => Tree::Leaf { first: group.first, len: group.len },
                false => self.grow(refs, scratch, group.first, group, depth + 1)?,
            };
            Ok((group, tree))
        });
        Ok(Tree::Node(grown.collect::<Result<Vec<_>>>()?))
    }

    /// As [`Builder::grow`], on this thread, into `part`.
    fn grow_alone(
        &self,
        refs: &mut [Bounds],
        base: usize,
        whole: Group,
        depth: usize,
        part: &mut Part,
    ) -> Child {
        let index = part.nodes.len();
        part.nodes.push(Node::EMPTY);
        let mut children = Children::new(whole);
        self.divide(refs, &mut [], base, depth, &mut children);
        for (slot, (group, is_leaf)) in children.iter().enumerate() {
            let child = match is_leaf {
                true => part.leaf(group.first, group.len),
                false => {
                    let mine = &mut refs[group.first - base..][..group.len];
                    self.grow_alone(mine, group.first, group, depth + 1, part)
                }
            };
            part.nodes[index].set(slot, &group.bounds, child);
        }
        Child::node(index)
    }

    /// Splits groups until there are eight or all are leaves.
    fn divide(
        &self,
        refs: &mut [Bounds],
        scratch: &mut [Bounds],
        base: usize,
        depth: usize,
        children: &mut Children,
    ) {
        let by_surface = depth < HEURISTIC_DEPTH;
        while let Some(index) = children.next_to_split(by_surface) {
            let group = children.groups[index];
            let start = group.first - base;
            let mine = &mut refs[start..][..group.len];
            let my_scratch = if scratch.is_empty() { &mut [] } else { &mut scratch[start..][..group.len] };
            let split = if by_surface { Split::find(mine, &group, self.bins) } else { None };
            let fits = group.len <= Child::MAX_BLOCKS * BLOCK;
            let sides = match split {
                Some(split) if fits && VISIT * group.bounds.half_area() + split.cost >= group.leaf_cost() => {
                    None
                }
                Some(split) => Some(split.apply(mine, my_scratch, group.first)),
                None if fits => None,
                None => Some(halve(mine, group.first)),
            };
            match sides {
                Some((left, right)) => children.replace(index, left, right),
                None => children.is_leaf[index] = true,
            }
        }
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

/// Copies the triangles into their blocks.
fn fill_blocks(meshes: &[Arc<Mesh>], refs: &[Bounds], spans: &[(u32, u32)]) -> Result<Vec<Block>> {
    let mut blocks = Vec::new();
    reserve(&mut blocks, spans.len())?;
    blocks.par_extend(spans.par_iter().map(|&(first, len)| {
        let mut block = Block::EMPTY;
        for (lane, r) in refs[first as usize..][..len as usize].iter().enumerate() {
            let (mesh, triangle) = r.words();
            let corners = meshes[mesh as usize].triangle(triangle as usize);
            block.set(lane, corners.map(|p| p.to_array()), mesh, triangle);
        }
        block
    }));
    Ok(blocks)
}
