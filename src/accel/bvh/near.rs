//! The triangles around a point.

use super::node::{Child, WIDTH};
use super::tree::Tree;
use super::triangle::BLOCK;
use crate::math::Vec3;

impl Tree<'_> {
    /// Calls `each` with the block and lane of every triangle in a leaf whose box comes within `radius` of
    /// `point`. Rare and short, so plainly written.
    pub fn around(&self, point: Vec3, radius: f32, each: &mut dyn FnMut(usize, usize)) {
        let mut todo = vec![Child::node(0)];
        while let Some(child) = todo.pop() {
            if child.is_leaf() {
                for index in child.blocks() {
                    let used = |lane: &usize| self.blocks[index].mesh[*lane] != u32::MAX;
                    (0..BLOCK).filter(used).for_each(|lane| each(index, lane));
                }
                continue;
            }
            let node = &self.nodes[child.index()];
            let comes_near = |slot: &usize| {
                // Empty slots reach from +∞ to −∞. An infinite radius would take them in, and their child is the root.
                (0..3).all(|k| {
                    let [lo, hi] = &node.planes[k];
                    lo[*slot] <= hi[*slot] && lo[*slot] <= point[k] + radius && hi[*slot] >= point[k] - radius
                })
            };
            todo.extend((0..WIDTH).filter(comes_near).map(|slot| node.children[slot]));
        }
    }
}
