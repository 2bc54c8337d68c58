//! Depth-first traversal, near children first, without allocation.

use super::node::{Child, Node, WIDTH};
use super::ray::Ray;
use super::triangle::{Block, Hit};

/// Levels of nodes that a tree may have; the builder keeps to it ([`super::build`] says how).
pub const MAX_DEPTH: usize = 36;

/// A visited node pushes at most [`WIDTH`] entries and the next one was popped from them, so every level above
/// the current node holds at most `WIDTH − 1`, and the last one pushes `WIDTH`.
const STACK: usize = MAX_DEPTH * (WIDTH - 1) + 1;

/// What is still to be visited, with the distance at which the ray enters it.
#[derive(Clone, Copy)]
struct Entry {
    near: f32,
    child: Child,
}

/// Scratch memory of a traversal, made once a chunk of rays.
pub struct Stack([Entry; STACK]);

impl Default for Stack {
    fn default() -> Self {
        Stack([Entry { near: 0.0, child: Child::NONE }; STACK])
    }
}

/// Where a triangle is kept.
#[derive(Clone, Copy, Debug, Default)]
pub struct Place {
    /// Index of its block.
    pub block: u32,
    /// Its lane there.
    pub lane: u32,
}

/// The tree as the traversal sees it; node 0 is the root, and there is at least that one.
#[derive(Clone, Copy)]
pub struct Tree<'a> {
    /// Nodes.
    pub nodes: &'a [Node],
    /// Triangles.
    pub blocks: &'a [Block],
}

impl Tree<'_> {
    /// The closest hit; of hits at equal distance, the one with the lowest id. With it, its triangle's place.
    #[inline(always)]
    pub fn closest(&self, ray: &Ray, stack: &mut Stack) -> Option<(Hit, Place)> {
        let stack = &mut stack.0;
        let mut best = Hit { t: ray.tmax, u: 0.0, v: 0.0, id: u64::MAX };
        let mut place = Place::default();
        let mut top = 0;
        let mut child = Child::node(0);
        loop {
            if child.is_leaf() {
                let first = child.blocks().start;
                for (i, block) in self.blocks[child.blocks()].iter().enumerate() {
                    let mut candidates = block.candidates(ray);
                    while candidates != 0 {
                        let lane = candidates.trailing_zeros() as usize;
                        candidates &= candidates - 1;
                        if let Some(hit) = block.hit(lane, ray, best.t)
                            && (hit.t < best.t || hit.id < best.id)
                        {
                            best = hit;
                            place = Place { block: (first + i) as u32, lane: lane as u32 };
                        }
                    }
                }
            } else {
                let node = &self.nodes[child.index()];
                let (near, mut met) = node.enter(&ray.slab, ray.tmin, best.t);
                let floor = top;
                while met != 0 {
                    let slot = met.trailing_zeros() as usize;
                    met &= met - 1;
                    let entry = Entry { near: near[slot], child: node.children[slot] };
                    // Insertion sort, farthest at the bottom: two or three entries as a rule.
                    let mut at = top;
                    while at > floor && stack[at - 1].near < entry.near {
                        stack[at] = stack[at - 1];
                        at -= 1;
                    }
                    stack[at] = entry;
                    top += 1;
                }
            }
            // A box entered at exactly the best distance may still hold a tie with a lower id.
            loop {
                if top == 0 {
                    return (best.id != u64::MAX).then_some((best, place));
                }
                top -= 1;
                if stack[top].near <= best.t {
                    child = stack[top].child;
                    break;
                }
            }
        }
    }

    /// True when anything is hit.
    #[inline(always)]
    pub fn occluded(&self, ray: &Ray, stack: &mut Stack) -> bool {
        let stack = &mut stack.0;
        let mut top = 0;
        let mut child = Child::node(0);
        loop {
            if child.is_leaf() {
                for block in &self.blocks[child.blocks()] {
                    let mut candidates = block.candidates(ray);
                    while candidates != 0 {
                        let lane = candidates.trailing_zeros() as usize;
                        candidates &= candidates - 1;
                        if block.hit(lane, ray, ray.tmax).is_some() {
                            return true;
                        }
                    }
                }
            } else {
                let node = &self.nodes[child.index()];
                let (_, mut met) = node.enter(&ray.slab, ray.tmin, ray.tmax);
                while met != 0 {
                    let slot = met.trailing_zeros() as usize;
                    met &= met - 1;
                    stack[top] = Entry { near: 0.0, child: node.children[slot] };
                    top += 1;
                }
            }
            if top == 0 {
                return false;
            }
            top -= 1;
            child = stack[top].child;
        }
    }
}
