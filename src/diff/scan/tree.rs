//! A tree of boxes, asked which of its leaves a line comes near.
//!
//! The nodes stand in the order in which they are visited: a node, all of its left half, all of its right half. Leaves
//! hold [`LEAF`] pieces (the last one may hold fewer), so that n pieces make ⌈n/LEAF⌉ leaves and twice as many nodes less
//! one, and where the right half begins is known without a pointer.

use crate::math::{DVec3, Vec3};
use std::ops::ControlFlow;

/// Pieces in a leaf.
const LEAF: usize = 4;

/// Pieces from which halves are built on two threads.
const LARGE: usize = 1 << 14;

/// A corner with the least and one with the largest coordinates.
type Box = [Vec3; 2];

/// A triangle, or a part of one.
pub(super) struct Piece {
    pub bounds: Box,
    /// Mesh and triangle.
    pub ids: [u32; 2],
}

/// A line that is a tube: everything within `slack` of it, along each axis.
pub(super) struct Line {
    o: DVec3,
    d: DVec3,
    slack: f64,
}

impl Line {
    pub fn new(o: DVec3, d: DVec3, slack: f64) -> Line {
        Line { o, d, slack }
    }

    /// Seen along the line, a box is a hexagon around its middle, and is passed outside of one of three pairs of edges
    /// or not at all (separating axes; S. Gottschalk, "Separating axis theorem", 1996).
    fn meets(&self, [low, high]: Box) -> bool {
        let (low, high) = (low.as_dvec3(), high.as_dvec3());
        let (middle, half) = ((low + high) * 0.5 - self.o, (high - low) * 0.5 + self.slack);
        let (off, d) = (self.d.cross(middle).abs(), self.d.abs());
        off.x <= half.y * d.z + half.z * d.y
            && off.y <= half.z * d.x + half.x * d.z
            && off.z <= half.x * d.y + half.y * d.x
    }
}

/// Pieces in a tree.
pub(super) struct Tree {
    nodes: Vec<Box>,
    ids: Vec<[u32; 2]>,
}

impl Tree {
    pub fn new(mut pieces: Vec<Piece>) -> Tree {
        let mut nodes = vec![[Vec3::ZERO; 2]; nodes_of(pieces.len())];
        if !pieces.is_empty() {
            build(&mut pieces, &mut nodes);
        }
        Tree { nodes, ids: pieces.into_iter().map(|piece| piece.ids).collect() }
    }

    /// The box around everything; one at the origin around nothing.
    pub fn bounds(&self) -> Box {
        self.nodes.first().copied().unwrap_or_default()
    }

    /// Calls `each` with at least all pieces that meet the line, until it breaks off.
    pub fn along(&self, line: &Line, each: &mut dyn FnMut([u32; 2]) -> ControlFlow<()>) -> ControlFlow<()> {
        if self.ids.is_empty() {
            ControlFlow::Continue(())
        } else {
            visit(&self.nodes, &self.ids, line, each)
        }
    }
}

fn visit(
    nodes: &[Box],
    ids: &[[u32; 2]],
    line: &Line,
    each: &mut dyn FnMut([u32; 2]) -> ControlFlow<()>,
) -> ControlFlow<()> {
    if !line.meets(nodes[0]) {
        return ControlFlow::Continue(());
    }
    let Some(half) = half(ids.len()) else { return ids.iter().try_for_each(|ids| each(*ids)) };
    let (left, right) = nodes[1..].split_at(nodes_of(half));
    visit(left, &ids[..half], line, each)?;
    visit(right, &ids[half..], line, each)
}

/// Halves by the middle one along the longest side, down to the leaves.
fn build(pieces: &mut [Piece], nodes: &mut [Box]) {
    let union = |a: Box, b: Box| [a[0].min(b[0]), a[1].max(b[1])];
    let none = [Vec3::INFINITY, Vec3::NEG_INFINITY];
    let bounds = pieces.iter().fold(none, |all, piece| union(all, piece.bounds));
    nodes[0] = bounds;
    let Some(half) = half(pieces.len()) else { return };
    let middle = |piece: &Piece| piece.bounds[0] * 0.5 + piece.bounds[1] * 0.5;
    let (low, high) = pieces.iter().map(middle).fold((none[0], none[1]), |(l, h), p| (l.min(p), h.max(p)));
    let axis = (high - low).max_position();
    pieces.select_nth_unstable_by(half, |a, b| {
        middle(a)[axis].total_cmp(&middle(b)[axis]).then(a.ids.cmp(&b.ids))
    });
    let large = pieces.len() >= LARGE;
    let (left, right) = pieces.split_at_mut(half);
    let (left_nodes, right_nodes) = nodes[1..].split_at_mut(nodes_of(half));
    if large {
        rayon::join(|| build(left, left_nodes), || build(right, right_nodes));
    } else {
        build(left, left_nodes);
        build(right, right_nodes);
    }
}

/// How many of so many pieces are in the left half, which has full leaves only; none in a leaf.
fn half(pieces: usize) -> Option<usize> {
    let leaves = pieces.div_ceil(LEAF);
    (leaves > 1).then_some(leaves / 2 * LEAF)
}

/// Nodes over so many pieces.
fn nodes_of(pieces: usize) -> usize {
    (2 * pieces.div_ceil(LEAF)).saturating_sub(1)
}
