//! The order in which a ray that looks for any hit tries a node's children.
//!
//! Of independent tries, each with a chance p and a cost c, those with the largest p/c come first. A ray that meets a convex box
//! hits something in it about as often as the surface within fills the box's own: p = 1 − exp(−A/(S/2)), with A the
//! area of the triangles, which are hit from both sides, and S the box's surface (Crofton's formula for the mean, with hits
//! spread evenly). Both p and c follow from the leaves up, so a box that is large and nearly empty comes behind a
//! small one full of triangles.

use super::node::{Child, Node, WIDTH};
use super::parts::{Progress, reserve};
use super::triangle::{BLOCK, Block};
use crate::error::Result;
use rayon::prelude::*;

/// Cost of a node that is visited; of a block of triangles it is 1.
const VISIT: f32 = 1.0;

/// What is known of a child: how likely a ray that meets its box hits something there, and what finding that out costs.
#[derive(Clone, Copy, Default)]
struct Try {
    chance: f32,
    cost: f32,
}

/// Sorts the children of all `nodes`, the most promising last: they are taken from a stack. Children stand behind their
/// parents.
pub fn most_promising_last(nodes: &mut [Node], blocks: &[Block], progress: &Progress<'_>) -> Result<()> {
    let (mut areas, mut known): (Vec<f32>, Vec<Try>) = (Vec::new(), Vec::new());
    reserve(&mut areas, blocks.len())?;
    reserve(&mut known, nodes.len())?;
    areas.par_extend(blocks.par_iter().map(area));
    known.resize(nodes.len(), Try::default());
    for index in (0..nodes.len()).rev() {
        if index % (1 << 16) == 0 {
            progress.report(0)?;
        }
        let node = &mut nodes[index];
        let tries: [Try; WIDTH] = std::array::from_fn(|slot| match node.children[slot] {
            Child::NONE => Try::default(),
            leaf if leaf.is_leaf() => Try::of_leaf(&areas[leaf.blocks()], node.half_area(slot)),
            inner => known[inner.index()],
        });
        let mut order: [usize; WIDTH] = std::array::from_fn(|slot| slot);
        let is_none = |slot: usize| node.children[slot] == Child::NONE;
        let gain = |slot: usize| tries[slot].chance / tries[slot].cost;
        // Slots without a child stay behind the others.
        order.sort_by(|&a, &b| is_none(a).cmp(&is_none(b)).then(gain(a).total_cmp(&gain(b))));
        known[index] = Try::of_node(node, &order, &tries);
        node.permute(&order);
    }
    Ok(())
}

impl Try {
    /// A leaf with triangles of these areas in a box of that half surface.
    fn of_leaf(areas: &[f32], half_surface: f32) -> Try {
        let within: f32 = areas.iter().sum();
        let chance = 1.0 - libm::expf(-within / half_surface.max(f32::MIN_POSITIVE));
        Try { chance, cost: areas.len() as f32 }
    }

    /// A node whose children are tried in that order, from the last.
    fn of_node(node: &Node, order: &[usize; WIDTH], tries: &[Try; WIDTH]) -> Try {
        let whole = node.half_area_of_all();
        let (mut missed, mut cost) = (1.0, VISIT);
        for &slot in order.iter().rev().filter(|slot| node.children[**slot] != Child::NONE) {
            let entered = (node.half_area(slot) / whole).min(1.0);
            cost += missed * entered * tries[slot].cost;
            missed *= 1.0 - entered * tries[slot].chance;
        }
        Try { chance: 1.0 - missed, cost }
    }
}

/// The area of a block's triangles. Lanes without one are not finite.
fn area(block: &Block) -> f32 {
    let area = |lane: usize| {
        let [a, b, c] = block.triangle_at(lane);
        0.5 * (b - a).cross(c - a).length()
    };
    (0..BLOCK).map(area).filter(|area| area.is_finite()).sum()
}

#[cfg(test)]
mod tests {
    use super::super::bounds::Bounds;
    use super::*;
    use crate::accel::BuildOptions;

    /// A node with a large and nearly empty box, a small full one and a node below it that is emptier still.
    #[test]
    fn full_boxes_are_tried_first_however_small() {
        let mut sparse = Block::EMPTY;
        sparse.set(0, [[0.0; 3], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0]], 0, 0);
        let mut full = Block::EMPTY;
        full.set(0, [[0.0; 3], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0]], 0, 1);
        let cube = |side: f32| Bounds::of_triangle([[0.0; 3], [side; 3], [0.0, side, 0.0]], 0, 0);
        let (mut root, mut below) = (Node::EMPTY, Node::EMPTY);
        root.set(0, &cube(2.0), Child::leaf(1, 1));
        root.set(1, &cube(10.0), Child::leaf(0, 1));
        root.set(2, &cube(9.0), Child::node(1));
        below.set(0, &cube(9.0), Child::leaf(0, 1));
        let mut nodes = [root, below];
        let options = BuildOptions::default();
        most_promising_last(&mut nodes, &[sparse, full], &Progress::new(2, &options)).unwrap();
        let children = &nodes[0].children;
        assert_eq!(children[..3], [Child::node(1), Child::leaf(0, 1), Child::leaf(1, 1)]);
        assert!(children[3..].iter().all(|child| *child == Child::NONE));
        assert!(nodes[0].half_area(2) < nodes[0].half_area(1), "boxes go with their children");
    }
}
