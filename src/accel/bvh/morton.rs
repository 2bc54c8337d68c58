//! The fast build: triangles in the order of a space-filling curve, and a tree over that order.
//!
//! Lauterbach et al. 2009 ("Fast BVH construction on GPUs"): the middle of each triangle's box gets a Morton code, ten
//! bits an axis, and is sorted by it. Two codes that differ first in some bit lie on two sides of a plane through
//! the middle of a cell, so groups split there without looking at a box; where few triangles are left they
//! split at whole blocks, which leaves full blocks. A group that shares one code (a small thing in a large hall)
//! is coded anew in its own box. Boxes are made last, from the leaves upwards.
//!
//! The order of equal codes is that of the triangles, and every decision follows from the sorted codes, so
//! the tree is the same on any number of threads.

use super::bounds::Bounds;
use super::build::{Built, HEURISTIC_DEPTH, SUBTREE};
use super::node::{Child, Node, WIDTH};
use super::order::most_promising_last;
use super::parts::{Part, Progress, Tree, fill_blocks, reserve};
use super::triangle::{BLOCK, Block};
use crate::accel::BuildOptions;
use crate::accel::brute::has_area;
use crate::error::Result;
use crate::shape::Mesh;
use rayon::prelude::*;
use std::sync::Arc;

/// Bits of a code along an axis.
const BITS: u32 = 10;

/// Groups of up to this many are split at whole blocks.
const FEW: usize = 8 * BLOCK;

/// Groups with one code and more triangles than this are coded anew.
const SAME: usize = 64;

/// Triangles of all meshes under one number.
struct Numbered<'a> {
    meshes: &'a [Arc<Mesh>],
    /// The first number of each mesh.
    starts: Vec<usize>,
}

impl Numbered<'_> {
    #[inline(always)]
    fn ids(&self, number: usize) -> (u32, u32) {
        let mesh = if self.starts.len() == 1 { 0 } else { self.starts.partition_point(|&s| s <= number) - 1 };
        (mesh as u32, (number - self.starts[mesh]) as u32)
    }

    /// The box around a triangle; `None` without area.
    #[inline(always)]
    fn bounds(&self, number: usize) -> Option<Bounds> {
        let (mesh, triangle) = self.ids(number);
        let corners = self.meshes[mesh as usize].triangle(triangle as usize);
        let bounds = Bounds::of_triangle(corners.map(|p| p.to_array()), 0, 0);
        (bounds.is_in_range() && has_area(corners)).then_some(bounds)
    }

    /// Doubled middle.
    #[inline(always)]
    fn middle2(&self, number: usize) -> [f32; 4] {
        let (mesh, triangle) = self.ids(number);
        let corners = self.meshes[mesh as usize].triangle(triangle as usize);
        Bounds::of_triangle(corners.map(|p| p.to_array()), 0, 0).middle2()
    }
}

/// Code in the upper half, the triangle's number in the lower: sorting needs no second array.
type Key = u64;

fn number(key: Key) -> usize {
    key as u32 as usize
}

fn code(key: Key) -> u32 {
    (key >> 32) as u32
}

/// How middles map to codes.
struct Cells {
    origin: [f32; 3],
    scale: [f32; 3],
}

impl Cells {
    fn new(middles: &Bounds) -> Cells {
        let scale = middles.extent().map(|e| {
            let s = (1 << BITS) as f32 / e;
            if e > 0.0 && s.is_finite() { s } else { 0.0 }
        });
        Cells { origin: middles.lo(), scale }
    }

    #[inline(always)]
    fn key(&self, middle: [f32; 4], number: usize) -> Key {
        let mut code = 0;
        for (k, x) in middle.into_iter().take(3).enumerate() {
            let cell = ((x - self.origin[k]) * self.scale[k]) as i32;
            code |= spread(cell.clamp(0, (1 << BITS) - 1) as u32) << k;
        }
        (code as Key) << 32 | number as Key
    }
}

/// Two zeros between each two of ten bits.
#[inline(always)]
fn spread(x: u32) -> u32 {
    let x = (x | x << 16) & 0x0300_00ff;
    let x = (x | x << 8) & 0x0300_f00f;
    let x = (x | x << 4) & 0x030c_30c3;
    (x | x << 2) & 0x0924_9249
}

/// Builds the tree over `meshes`, whose triangles are no more than a tree can hold.
pub fn build(meshes: &[Arc<Mesh>], options: &BuildOptions<'_>) -> Result<Built> {
    let mut total = 0;
    let mut starts = Vec::with_capacity(meshes.len());
    for mesh in meshes {
        starts.push(total);
        total += mesh.indices.len();
    }
    let triangles = Numbered { meshes, starts };
    let mut keys = sorted(&triangles, total)?;
    let progress = Progress::new(keys.len(), options);
    progress.report(0)?;
    if keys.is_empty() {
        return Ok(Built::empty());
    }
    let builder = Builder { triangles, progress };
    let tree = builder.grow(&mut keys, 0, 0)?;
    let spans = tree.spans()?;
    let blocks = fill_blocks(meshes, |i| builder.triangles.ids(number(keys[i])), &spans)?;
    drop((keys, spans));
    let mut nodes = tree.join()?;
    fit(&mut nodes, &blocks)?;
    most_promising_last(&mut nodes, &blocks, &builder.progress)?;
    Ok(Built { nodes, blocks, leaves_of_one: 1.0 })
}

/// The keys of all triangles with area, in order.
fn sorted(triangles: &Numbered<'_>, total: usize) -> Result<Vec<Key>> {
    // Those without area count here; that costs nothing but a little resolution.
    let point = |n| Bounds::point(triangles.middle2(n));
    let middles = (0..total).into_par_iter().map(point).reduce(|| Bounds::EMPTY, |a, b| a.union(&b));
    let cells = Cells::new(&middles);
    let mut keys: Vec<Key> = Vec::new();
    reserve(&mut keys, total)?;
    let key = |n| triangles.bounds(n).map_or(Key::MAX, |b| cells.key(b.middle2(), n));
    keys.par_extend((0..total).into_par_iter().map(key));
    keys.par_sort_unstable();
    keys.truncate(keys.partition_point(|&k| k != Key::MAX));
    Ok(keys)
}

struct Builder<'a> {
    triangles: Numbered<'a>,
    progress: Progress<'a>,
}

impl Builder<'_> {
    /// Builds the node over `keys`, which start at the index `first`, with all threads.
    fn grow(&self, keys: &mut [Key], first: usize, depth: usize) -> Result<Tree> {
        if keys.len() <= SUBTREE {
            let mut part = Part::default();
            self.grow_alone(keys, first, depth, &mut part);
            self.progress.report(keys.len())?;
            return Ok(Tree::Part(part));
        }
        self.progress.report(0)?;
        let ends = self.divide(keys, depth);
        let (mut tasks, mut rest, mut start) = (Vec::with_capacity(WIDTH), keys, 0);
        for end in ends.iter() {
            let (mine, others) = rest.split_at_mut(end - start);
            tasks.push((mine, first + start));
            (rest, start) = (others, end);
        }
        let grown = tasks.into_par_iter().map(|(keys, first)| {
            let tree = match keys.len() <= BLOCK {
                true => Tree::Leaf { first, len: keys.len() },
                false => self.grow(keys, first, depth + 1)?,
            };
            Ok((Bounds::EMPTY, tree))
        });
        Ok(Tree::Node(grown.collect::<Result<Vec<_>>>()?))
    }

    /// As [`Builder::grow`], on this thread, into `part`.
    fn grow_alone(&self, keys: &mut [Key], first: usize, depth: usize, part: &mut Part) -> Child {
        let index = part.nodes.len();
        part.nodes.push(Node::EMPTY);
        let ends = self.divide(keys, depth);
        let mut start = 0;
        for (slot, end) in ends.iter().enumerate() {
            let child = match end - start <= BLOCK {
                true => part.leaf(first + start, end - start),
                false => self.grow_alone(&mut keys[start..end], first + start, depth + 1, part),
            };
            part.nodes[index].children[slot] = child;
            start = end;
        }
        Child::node(index)
    }

    /// Splits the group in the largest cell until there are eight or all are leaves.
    fn divide(&self, keys: &mut [Key], depth: usize) -> Ends {
        let mut ends = Ends { end: [keys.len(); WIDTH], len: 1 };
        while ends.len < WIDTH {
            let mut best: Option<(usize, (u32, usize))> = None;
            for i in 0..ends.len {
                let (start, end) = ends.range(i);
                // In how large a cell the group is: the first bit in which codes differ.
                let cell = 32 - (code(keys[start]) ^ code(keys[end - 1])).leading_zeros();
                let size = if depth < HEURISTIC_DEPTH { (cell, end - start) } else { (0, end - start) };
                if end - start > BLOCK && best.is_none_or(|(_, b)| size > b) {
                    best = Some((i, size));
                }
            }
            let Some((i, _)) = best else { break };
            let (start, end) = ends.range(i);
            let middle = start + self.split(&mut keys[start..end], depth);
            ends.insert(i, middle);
        }
        ends
    }

    /// Where to cut more than a block's triangles in two.
    fn split(&self, keys: &mut [Key], depth: usize) -> usize {
        let half = (keys.len() / 2).next_multiple_of(BLOCK).min(keys.len() - 1);
        if depth >= HEURISTIC_DEPTH {
            return half;
        }
        let one_code = |keys: &[Key]| code(keys[0]) == code(keys[keys.len() - 1]);
        if one_code(keys) && keys.len() > SAME {
            self.code_anew(keys);
        }
        if one_code(keys) {
            return half;
        }
        let (first, last) = (code(keys[0]), code(keys[keys.len() - 1]));
        let bit = 1 << (31 - (first ^ last).leading_zeros());
        let cut = keys.partition_point(|&k| code(k) & bit == 0);
        if keys.len() > FEW {
            return cut;
        }
        // To the nearest whole block.
        ((cut + BLOCK / 2) / BLOCK * BLOCK).clamp(BLOCK, (keys.len() - 1) / BLOCK * BLOCK)
    }

    /// Sorts triangles of one cell by codes in the box around their middles.
    fn code_anew(&self, keys: &mut [Key]) {
        let mut middles = Bounds::EMPTY;
        for key in keys.iter() {
            middles.add(&Bounds::point(self.triangles.middle2(number(*key))));
        }
        let cells = Cells::new(&middles);
        for key in keys.iter_mut() {
            *key = cells.key(self.triangles.middle2(number(*key)), number(*key));
        }
        keys.par_sort_unstable();
    }
}

/// Up to eight adjoining groups: where each ends.
struct Ends {
    end: [usize; WIDTH],
    len: usize,
}

impl Ends {
    fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        self.end.iter().copied().take(self.len)
    }

    fn range(&self, i: usize) -> (usize, usize) {
        (if i == 0 { 0 } else { self.end[i - 1] }, self.end[i])
    }

    fn insert(&mut self, i: usize, end: usize) {
        self.end.copy_within(i..self.len, i + 1);
        self.end[i] = end;
        self.len += 1;
    }
}

/// Boxes of all nodes' children, from the leaves upwards: a node stands before its children.
fn fit(nodes: &mut [Node], blocks: &[Block]) -> Result<()> {
    let mut leaves = Vec::new();
    reserve(&mut leaves, blocks.len())?;
    leaves.par_extend(blocks.par_iter().map(around_block));
    let mut boxes = Vec::new();
    reserve(&mut boxes, nodes.len())?;
    boxes.resize(nodes.len(), Bounds::EMPTY);
    for (index, node) in nodes.iter_mut().enumerate().rev() {
        for slot in 0..WIDTH {
            let child = node.children[slot];
            if child == Child::NONE {
                break;
            }
            let bounds = match child.is_leaf() {
                true => leaves[child.blocks()].iter().fold(Bounds::EMPTY, |a, b| a.union(b)),
                false => boxes[child.index()],
            };
            node.set(slot, &bounds, child);
            boxes[index].add(&bounds);
        }
    }
    Ok(())
}

fn around_block(block: &Block) -> Bounds {
    let mut bounds = Bounds::EMPTY;
    for lane in (0..BLOCK).filter(|&lane| block.mesh[lane] != u32::MAX) {
        bounds.add(&Bounds::of_triangle(block.triangle_at(lane).map(|p| p.to_array()), 0, 0));
    }
    bounds
}
