//! Depth-first traversal, near children first, of the rays of a chunk: one by one, or in turns.
//!
//! In a structure larger than the caches, one ray alone waits most of its time for a node from memory. There the
//! rays of a chunk take turns: each visits one node or leaf, finds out where it goes on, asks for that part of the tree
//! to be fetched, and lets the others go first. In a small one that would only cost: its state stays in registers.

use super::kernel::{enter, meet, prefetch};
use super::node::{Child, Node, WIDTH};
use super::ray::Prepared;
use super::tree::{Found, Place, Tree, rank};
use super::triangle::BLOCK;
use crate::accel::{LANES, Mask, lanes_of};
use crate::math::isa::Set;
use std::marker::PhantomData;

/// Levels of nodes that a tree may have; the builder keeps to it ([`super::build`] says how).
pub const MAX_DEPTH: usize = 100;

/// A visited node pushes at most [`WIDTH`] entries and the next one was popped from them, so every level above
/// the current node holds at most `WIDTH − 1`, and the last one pushes `WIDTH`. A power of two, so that an index is
/// brought in range by a mask; none ever is out of it.
const STACK: usize = 1024;

const _: () = assert!(MAX_DEPTH * (WIDTH - 1) < STACK);

/// What is still to be visited: in the upper half the bits of the distance at which the ray enters it (not negative, so
/// they are in its order), in the lower the child.
type Entry = u64;

#[inline(always)]
fn entry(near: f32, child: Child) -> Entry {
    (near.to_bits() as u64) << 32 | child.bits() as u64
}

/// A ray on its way.
#[derive(Clone, Copy)]
struct Walk {
    child: Child,
    top: usize,
    /// Distance of the best hit, scaled, and its ids; where nothing is hit, the end of the interval and all ones.
    t: f32,
    id: u64,
    place: Place,
}

/// What a ray has yet to visit.
type Stack = [Entry; STACK];

/// One lane's, with some lines more, so that the lanes' first entries are not all in the same set of the cache.
#[derive(Clone, Copy)]
struct Lane {
    entries: Stack,
    _more: [Entry; 40],
}

/// Scratch memory of a traversal.
pub struct Stacks([Lane; LANES]);

impl Stacks {
    /// New ones; on the heap, and kept by whoever traces.
    pub fn new() -> Box<Stacks> {
        Box::new(Stacks([Lane { entries: [0; STACK], _more: [0; 40] }; LANES]))
    }
}

/// What rays of a kind do on their way. A trait and not a closure, since only what is always inlined is compiled for the
/// instruction set at hand.
trait Steps {
    /// Visits one node or leaf; false at the end of the way.
    fn step(&self, walk: &mut Walk, stack: &mut Stack, i: usize) -> bool;
}

/// Steps the walks of the live rays to their ends: to the end one by one, or in turns.
#[inline(always)]
fn walk_all(
    rays: &Prepared,
    stacks: &mut Stacks,
    in_turns: bool,
    steps: &impl Steps,
    mut end: impl FnMut(usize, &Walk),
) {
    let start = |i: usize| Walk {
        child: Child::node(0),
        top: 0,
        t: rays.tmax[i],
        id: u64::MAX,
        place: Place::default(),
    };
    let mut live = rays.live;
    if !in_turns {
        // No closure here: it would be a function of its own, and so without the instruction set.
        while live != 0 {
            let i = live.trailing_zeros() as usize % LANES;
            live &= live - 1;
            let (mut walk, stack) = (start(i), &mut stacks.0[i].entries);
            while steps.step(&mut walk, stack, i) {}
            end(i, &walk);
        }
        return;
    }
    let mut walks = [start(0); LANES];
    let (mut lanes, mut len) = ([0u8; LANES], 0);
    for i in lanes_of(live) {
        walks[i] = start(i);
        lanes[len % LANES] = i as u8;
        len += 1;
    }
    while len > 0 {
        let mut turn = 0;
        while turn < len {
            let i = lanes[turn % LANES] as usize % LANES;
            if steps.step(&mut walks[i], &mut stacks.0[i].entries, i) {
                turn += 1;
            } else {
                end(i, &walks[i]);
                len -= 1;
                lanes[turn % LANES] = lanes[len % LANES];
            }
        }
    }
}

/// The way to the closest hit; of hits at equal distance, to the one with the lowest id.
struct ToClosest<'a, S> {
    tree: &'a Tree<'a>,
    rays: &'a Prepared,
    set: PhantomData<S>,
}

impl<S: Set> Steps for ToClosest<'_, S> {
    #[inline(always)]
    fn step(&self, walk: &mut Walk, stack: &mut Stack, i: usize) -> bool {
        let tree = self.tree;
        if walk.child.is_leaf() {
            self.leaf(walk, i);
        } else {
            let node = &tree.nodes[walk.child.index()];
            let (near, met) = enter::<S>(node, self.rays, i, walk.t);
            if met != 0 {
                walk.descend(tree, stack, node, &near, met);
                tree.fetch(walk.child);
                return true;
            }
        }
        // A box entered at exactly the best distance may still hold a tie with a lower id.
        let end = walk.t.to_bits();
        while walk.top > 0 {
            walk.top -= 1;
            let next = stack[walk.top % STACK];
            if (next >> 32) as u32 <= end {
                walk.child = Child::from_bits(next as u32);
                tree.fetch(walk.child);
                return true;
            }
        }
        false
    }
}

impl<S: Set> ToClosest<'_, S> {
    #[inline(always)]
    fn leaf(&self, walk: &mut Walk, i: usize) {
        let blocks = walk.child.blocks();
        for (index, block) in blocks.clone().zip(&self.tree.blocks[blocks]) {
            let (mut met, t) = meet::<S>(block, self.rays, i, walk.t);
            while met != 0 {
                let lane = met.trailing_zeros() as usize % BLOCK;
                met &= met - 1;
                let id = rank(block.ids(lane));
                if t[lane] < walk.t || (t[lane] == walk.t && id < walk.id) {
                    (walk.t, walk.id) = (t[lane], id);
                    walk.place = Place::new(index, lane);
                }
            }
        }
    }
}

/// The way to any hit.
struct ToAny<'a, S> {
    tree: &'a Tree<'a>,
    rays: &'a Prepared,
    set: PhantomData<S>,
}

impl<S: Set> Steps for ToAny<'_, S> {
    #[inline(always)]
    fn step(&self, walk: &mut Walk, stack: &mut Stack, i: usize) -> bool {
        let tree = self.tree;
        if walk.child.is_leaf() {
            for block in &tree.blocks[walk.child.blocks()] {
                if meet::<S>(block, self.rays, i, walk.t).0 != 0 {
                    walk.id = 0;
                    return false;
                }
            }
        } else {
            let node = &tree.nodes[walk.child.index()];
            let (_, mut met) = enter::<S>(node, self.rays, i, walk.t);
            if met != 0 {
                // The most promising child is the last ([`super::order`]): it now, the others when it is done.
                let best = (31 - met.leading_zeros()) as usize % WIDTH;
                met ^= 1 << best;
                while met != 0 {
                    let slot = met.trailing_zeros() as usize % WIDTH;
                    met &= met - 1;
                    let child = node.children[slot];
                    tree.fetch_any(child);
                    stack[walk.top % STACK] = child.bits() as u64;
                    walk.top += 1;
                }
                walk.child = node.children[best];
                tree.fetch(walk.child);
                return true;
            }
        }
        if walk.top == 0 {
            return false;
        }
        walk.top -= 1;
        walk.child = Child::from_bits(stack[walk.top % STACK] as u32);
        tree.fetch(walk.child);
        true
    }
}

impl Tree<'_> {
    /// The closest hits of the live rays; of hits at equal distance, the one with the lowest id.
    #[inline(always)]
    pub fn closest<S: Set>(&self, rays: &Prepared, stacks: &mut Stacks) -> Found {
        let mut found = Found::default();
        let steps = ToClosest::<S> { tree: self, rays, set: PhantomData };
        walk_all(rays, stacks, self.in_turns, &steps, |i, walk| {
            found.hit |= ((walk.id != u64::MAX) as Mask) << i;
            found.place[i] = walk.place;
        });
        found
    }

    /// The live rays that hit anything.
    #[inline(always)]
    pub fn occluded<S: Set>(&self, rays: &Prepared, stacks: &mut Stacks) -> Mask {
        let mut hit = 0;
        let steps = ToAny::<S> { tree: self, rays, set: PhantomData };
        walk_all(rays, stacks, self.in_turns, &steps, |i, walk| {
            hit |= ((walk.id != u64::MAX) as Mask) << i;
        });
        hit
    }

    /// Starts loading what a child refers to, if there is time for it before it is needed.
    #[inline(always)]
    fn fetch(&self, child: Child) {
        if self.in_turns {
            self.fetch_any(child);
        }
    }

    /// Starts loading what a child refers to that has to wait for others.
    #[inline(always)]
    fn fetch_any(&self, child: Child) {
        if child.is_leaf() {
            prefetch(&self.blocks[child.blocks().start], 3);
        } else {
            prefetch(&self.nodes[child.index()], 4);
        }
    }
}

impl Walk {
    /// Goes on with the nearest of the children that are met; pushes the others, the farthest first.
    #[inline(always)]
    fn descend(
        &mut self,
        tree: &Tree<'_>,
        stack: &mut Stack,
        node: &Node,
        near: &[f32; WIDTH],
        mut met: u32,
    ) {
        let slot = met.trailing_zeros() as usize % WIDTH;
        met &= met - 1;
        if met == 0 {
            self.child = node.children[slot];
            return;
        }
        let mut nearest = entry(near[slot], node.children[slot]);
        let floor = self.top;
        while met != 0 {
            let slot = met.trailing_zeros() as usize % WIDTH;
            met &= met - 1;
            let other = entry(near[slot], node.children[slot]);
            tree.fetch_any(node.children[slot]);
            let pushed = nearest.max(other);
            nearest = nearest.min(other);
            // Insertion sort, farthest at the bottom.
            let mut at = self.top;
            while at > floor && stack[(at - 1) % STACK] < pushed {
                stack[at % STACK] = stack[(at - 1) % STACK];
                at -= 1;
            }
            stack[at % STACK] = pushed;
            self.top += 1;
        }
        self.child = Child::from_bits(nearest as u32);
    }
}
