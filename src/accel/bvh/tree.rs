//! The finished tree, as everything that reads it sees it.

use super::node::Node;
use super::triangle::{BLOCK, Block};
use crate::accel::{LANES, Mask};
use crate::math::Vec3;

/// Where a triangle is kept: block and lane.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Place(u32);

impl Place {
    /// The triangle in `lane` of a block.
    #[inline(always)]
    pub fn new(block: usize, lane: usize) -> Place {
        Place((block * BLOCK + lane) as u32)
    }

    /// Index of its block.
    #[inline(always)]
    pub fn block(self) -> usize {
        self.0 as usize / BLOCK
    }

    /// Its lane there.
    #[inline(always)]
    pub fn lane(self) -> usize {
        self.0 as usize % BLOCK
    }
}

/// What the rays of a chunk hit.
#[derive(Clone, Default)]
pub struct Found {
    /// Lanes that hit something.
    pub hit: Mask,
    /// Where the triangles are.
    pub place: [Place; LANES],
}

/// Nodes and triangles; node 0 is the root. Both are empty, or neither.
#[derive(Clone, Copy)]
pub struct Tree<'a> {
    /// Nodes.
    pub nodes: &'a [Node],
    /// Triangles.
    pub blocks: &'a [Block],
    /// Whether rays are worth taking in turns, see [`super::traverse`].
    pub in_turns: bool,
}

impl Tree<'_> {
    /// Mesh and triangle at a place.
    #[inline(always)]
    pub fn ids(&self, place: Place) -> [u32; 2] {
        self.blocks[place.block()].ids(place.lane())
    }

    /// The corners of the triangle at a place.
    #[inline(always)]
    pub fn triangle(&self, place: Place) -> [Vec3; 3] {
        self.blocks[place.block()].triangle_at(place.lane())
    }
}

/// The order in which ties are broken: mesh id in the upper half, triangle id in the lower.
#[inline(always)]
pub fn rank([mesh, triangle]: [u32; 2]) -> u64 {
    (mesh as u64) << 32 | triangle as u64
}
