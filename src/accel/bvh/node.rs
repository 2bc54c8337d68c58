//! The wide node: eight boxes in structure-of-arrays form, and the conservative slab test against them.
//!
//! **Why the boxes are a little too large.** The triangle test of [`super::triangle`] moves vertices into the
//! ray's sheared frame in f32. With u = 2⁻²⁴, a vertex at the offset (x, y, z) from the ray's origin, z along
//! the dominant axis, lands within 2u·|x| + 4u·|z| of where it belongs, so a ray may hit a triangle whose
//! exact box it misses by that much. A slab distance plane·(1/d) − origin·(1/d) is off by at most 2u of the
//! offset (1/d, the result), 2u of the origin and 1u of the plane (the products; where the machine fuses the last two
//! steps, the plane's is none), and storing enlarged planes adds 2u of them. The sum is below 11u, and an offset is at most
//! |coordinate| + |origin|: both sides get their share at 16u = [`MARGIN`] — the boxes once, when they are
//! stored ([`enlarge`]), the origin once a ray ([`super::ray`]). (Ize 2013, "Robust BVH ray traversal", bounds
//! the slab's part; Woop, Benthin and Wald 2013, section 3.3, the shear's part.) Nothing is added per
//! node visited, and the sign of t does not matter.

use super::bounds::Bounds;
use super::ray::Prepared;

/// Children of a node.
pub const WIDTH: usize = 8;

/// Relative enlargement of boxes and of ray origins: 16 half-ulps, see the module's derivation.
pub const MARGIN: f32 = 1.0 / (1 << 20) as f32;

/// How far a box or an origin with this largest absolute coordinate is moved outwards. The smallest normal
/// number is added since errors stop being relative below it.
#[inline(always)]
pub fn margin(largest: f32) -> f32 {
    largest * MARGIN + f32::MIN_POSITIVE
}

/// `bounds` as stored: monotone, so a box that holds another still holds it when both are enlarged.
#[inline(always)]
pub fn enlarge(lo: [f32; 3], hi: [f32; 3]) -> ([f32; 3], [f32; 3]) {
    let mut largest = 0.0f32;
    for k in 0..3 {
        largest = largest.max(lo[k].abs()).max(hi[k].abs());
    }
    let e = margin(largest);
    (lo.map(|x| x - e), hi.map(|x| x + e))
}

/// What a node's slot or a stack entry points to: a node, or a run of triangle blocks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Child(u32);

impl Child {
    const LEAF: u32 = 1 << 31;
    const COUNT_BITS: u32 = 3;

    /// The most blocks a leaf can have.
    pub const MAX_BLOCKS: usize = 1 << Self::COUNT_BITS;
    /// The most blocks a structure can have, 2²⁸, and the most nodes.
    pub const MAX_INDEX: usize = 1 << 28;
    /// A slot without a child (the root is nobody's); its box is empty, so it is never entered.
    pub const NONE: Child = Child(0);

    /// The node of that index.
    pub fn node(index: usize) -> Child {
        Child(index as u32)
    }

    /// The blocks `first .. first + count`.
    pub fn leaf(first: usize, count: usize) -> Child {
        Child(Self::LEAF | (first as u32) << Self::COUNT_BITS | (count as u32 - 1))
    }

    /// The same child after nodes and blocks moved up by these numbers.
    pub fn moved(self, nodes: usize, blocks: usize) -> Child {
        match self {
            Self::NONE => self,
            _ if self.is_leaf() => Child(self.0 + ((blocks as u32) << Self::COUNT_BITS)),
            _ => Child(self.0 + nodes as u32),
        }
    }

    /// As a number, and back.
    #[inline(always)]
    pub fn bits(self) -> u32 {
        self.0
    }

    /// The child of that number.
    #[inline(always)]
    pub fn from_bits(bits: u32) -> Child {
        Child(bits)
    }

    /// True when it is a run of blocks.
    #[inline(always)]
    pub fn is_leaf(self) -> bool {
        self.0 & Self::LEAF != 0
    }

    /// The node's index; only for what is no leaf.
    #[inline(always)]
    pub fn index(self) -> usize {
        self.0 as usize
    }

    /// The leaf's blocks; only for a leaf.
    #[inline(always)]
    pub fn blocks(self) -> std::ops::Range<usize> {
        let bits = self.0 & !Self::LEAF;
        let first = (bits >> Self::COUNT_BITS) as usize;
        first..first + (bits as usize & (Self::MAX_BLOCKS - 1)) + 1
    }
}

/// Eight children: 224 bytes, so that eight lanes of one plane are one aligned 32-byte load.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(32))]
pub struct Node {
    /// Enlarged planes: axis, then side (0 lower, 1 upper), then child. A side is picked by a ray's sign.
    pub planes: [[[f32; WIDTH]; 2]; 3],
    /// The children; [`Child::NONE`] behind the last.
    pub children: [Child; WIDTH],
}

impl Node {
    /// A node without children.
    pub const EMPTY: Node = Node {
        planes: [[[f32::INFINITY; WIDTH], [f32::NEG_INFINITY; WIDTH]]; 3],
        children: [Child::NONE; WIDTH],
    };

    /// Fills one slot.
    pub fn set(&mut self, slot: usize, bounds: &Bounds, child: Child) {
        let (lo, hi) = enlarge(bounds.lo(), bounds.hi());
        for axis in 0..3 {
            self.planes[axis][0][slot] = lo[axis];
            self.planes[axis][1][slot] = hi[axis];
        }
        self.children[slot] = child;
    }

    /// Half the surface of a child's box.
    pub fn half_area(&self, slot: usize) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|k| (self.planes[k][1][slot] - self.planes[k][0][slot]).max(0.0));
        x * (y + z) + y * z
    }

    /// Half the surface of the box around all children.
    pub fn half_area_of_all(&self) -> f32 {
        let [x, y, z] = self.planes.map(|[lo, hi]| {
            let least = lo.iter().copied().fold(f32::INFINITY, f32::min);
            let most = hi.iter().copied().fold(f32::NEG_INFINITY, f32::max);
            (most - least).max(0.0)
        });
        x * (y + z) + y * z
    }

    /// Puts the children into that order.
    pub fn permute(&mut self, order: &[usize; WIDTH]) {
        let before = *self;
        for (slot, &from) in order.iter().enumerate() {
            for k in 0..3 {
                for side in 0..2 {
                    self.planes[k][side][slot] = before.planes[k][side][from];
                }
            }
            self.children[slot] = before.children[from];
        }
    }

    /// The distances at which the ray of lane `i` enters each child's box, and one bit for each box that it meets
    /// on `tmin ..= tmax`. No NaN can arise: 1/d and o/d are finite and 1/d is not zero, so infinite planes (of empty
    /// slots) stay infinite. A distance is never negative, nor −0, so that its bits are in
    /// its order.
    #[inline(always)]
    pub fn enter(&self, rays: &Prepared, i: usize, tmax: f32) -> ([f32; WIDTH], u32) {
        let mut near = [rays.tmin[i]; WIDTH];
        let mut far = [tmax; WIDTH];
        for k in 0..3 {
            let side = rays.near_side[k][i] as usize & 1;
            let (first, last) = (&self.planes[k][side], &self.planes[k][side ^ 1]);
            let (near_start, far_start) = (rays.near_start[k][i], rays.far_start[k][i]);
            let inverse = rays.inverse[k][i];
            for i in 0..WIDTH {
                near[i] = max(first[i] * inverse - near_start, near[i]);
                far[i] = min(last[i] * inverse - far_start, far[i]);
            }
        }
        // Selected constants and a sum, which compile to a blend and three shuffles; shifting single bits
        // together would take each lane through a general register.
        let mut met = [0; WIDTH];
        for i in 0..WIDTH {
            met[i] = if near[i] <= far[i] { 1 << i } else { 0 };
        }
        (near, met.iter().sum())
    }
}

/// `f32::max` without its care for NaN, which costs two instructions more.
#[inline(always)]
pub fn max(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// `f32::min` without its care for NaN.
#[inline(always)]
pub fn min(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}
