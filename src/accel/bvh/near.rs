//! The triangles around a point.

use super::node::{Child, WIDTH};
use super::tree::Tree;
use super::triangle::BLOCK;
use crate::math::Vec3;

impl Tree<'_> {
    /// Calls `each` with mesh, triangle and corners of every triangle in a leaf whose box comes within `radius` of
    /// `point`. Rare and short, so plainly written.
    pub fn around(&self, point: Vec3, radius: f32, each: &mut dyn FnMut([u32; 2], [Vec3; 3])) {
        let mut todo = vec![Child::node(0)];
        while let Some(child) = todo.pop() {
            if child.is_leaf() {
                for block in &self.blocks[child.blocks()] {
                    let used = |lane: &usize| block.mesh[*lane] != u32::MAX;
                    (0..BLOCK).filter(used).for_each(|lane| each(block.ids(lane), block.triangle_at(lane)));
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
