//! From a binary tree to eight children a node, at the least cost.
//!
//! Opening the largest child again and again leaves the nodes above the leaves half empty, and how full a node is costs
//! nothing: eight boxes are met in one step. So the whole binary tree of a task is there first, down to halves of a block, and a
//! dynamic programme (Ylitie, Karras and Laine 2017, "Efficient incoherent ray traversal on GPUs through compressed wide
//! BVHs", section 3.1, in our own form) finds which of its nodes become nodes, which become leaves, and which
//! disappear. With A the surface of a node's box and C(n, i) the least cost of the triangles below n in at most i
//! children of one node,
//!
//! C(n, 1) = min(A·blocks, A·visit + min_k C(l, k) + C(r, 8 − k)) + A·push,
//! C(n, i) = min(C(n, i − 1), min_k C(l, k) + C(r, i − k)).

use super::bins::blocks;
use super::bounds::Bounds;
use super::node::{Child, Node, WIDTH};
use super::parts::Part;
use super::split::Group;
use super::triangle::BLOCK;

/// Cost of visiting a node, of a block of triangles 1.
const VISIT: f32 = 1.0;

/// Cost of a child that is met.
const PUSH: f32 = 0.1;

/// A node of the binary tree.
struct Binary {
    /// The box, and in its words the first reference and how many they are.
    bounds: Bounds,
    /// The children; 0 where there are none, since the root is nobody's child.
    children: [u32; 2],
    /// C(n, i) at i − 1.
    cost: [f32; WIDTH - 1],
    /// Of i children (at i − 1), how many come from the first child; 0: one fewer is as good.
    first: [u8; WIDTH],
    /// Its references adjoin: nothing below has room to spare.
    is_solid: bool,
    /// As one child it is a leaf.
    is_leaf: bool,
}

impl Binary {
    fn len(&self) -> usize {
        self.bounds.words().1 as usize
    }

    fn first_reference(&self) -> usize {
        self.bounds.words().0 as usize
    }
}

/// A binary tree under construction; node 0 is the root.
pub struct BinaryTree {
    nodes: Vec<Binary>,
    /// What surfaces are divided by, so that f32 holds their sums.
    unit: f64,
}

impl BinaryTree {
    /// An empty one, for the references of `whole`.
    pub fn new(whole: &Group) -> BinaryTree {
        let area = whole.bounds.half_area();
        let unit = if area > 0.0 && area.is_finite() { 1.0 / area } else { 1.0 };
        BinaryTree { nodes: Vec::with_capacity(whole.len + 2), unit }
    }

    /// Adds a node without children; the first is the root.
    pub fn push(&mut self, group: Group) -> usize {
        let bounds = group.bounds.with_words(group.first as u32, group.len as u32);
        // What fits a block is not split in space any more, and takes no room.
        let is_solid = group.room == group.len || group.len <= BLOCK;
        let (cost, first) = ([0.0; WIDTH - 1], [0; WIDTH]);
        self.nodes.push(Binary { bounds, children: [0; 2], is_solid, cost, first, is_leaf: false });
        self.nodes.len() - 1
    }

    /// Makes two nodes the children of a third, once what is below them is complete.
    pub fn join(&mut self, parent: usize, children: [usize; 2]) {
        let [l, r] = children.map(|i| &self.nodes[i]);
        let adjoin = l.first_reference() + l.len() == r.first_reference();
        let (is_solid, len) = (l.is_solid && r.is_solid && adjoin, l.len() + r.len());
        let node = &mut self.nodes[parent];
        // After a split in space there are more of them below.
        let is_solid = is_solid && len == node.len();
        node.children = children.map(|i| i as u32);
        node.is_solid = is_solid;
    }

    /// Chooses what to keep, and stores it in `part`.
    pub fn collapse(mut self, part: &mut Part) {
        for index in (0..self.nodes.len()).rev() {
            self.weigh(index);
        }
        self.store_node(0, part);
    }

    /// Fills the costs of a node whose children have theirs.
    fn weigh(&mut self, index: usize) {
        let node = &self.nodes[index];
        let area = (node.bounds.half_area() * self.unit) as f32;
        // A box larger than f32's range counts as the root: costs are finite, so that there always is a least one.
        let area = if area.is_finite() { area } else { 1.0 };
        let fits = node.len() <= Child::MAX_BLOCKS * BLOCK && node.is_solid;
        let as_leaf = if fits { area * blocks(node.len()) as f32 } else { f32::INFINITY };
        let (mut cost, mut first) = ([0.0; WIDTH - 1], [0; WIDTH]);
        let mut least = f32::INFINITY;
        if node.children != [0; 2] {
            let [l, r] = node.children.map(|i| &self.nodes[i as usize].cost);
            for i in 2..=WIDTH {
                let mut best = f32::INFINITY;
                for k in 1..i {
                    let sum = l[k - 1] + r[i - k - 1];
                    if sum < best {
                        (best, first[i - 1]) = (sum, k as u8);
                    }
                }
                if i < WIDTH {
                    cost[i - 1] = best;
                }
                least = best;
            }
        } else {
            cost = [f32::INFINITY; WIDTH - 1];
        }
        let as_node = area * VISIT + least;
        let is_leaf = as_leaf <= as_node;
        cost[0] = as_leaf.min(as_node) + area * PUSH;
        for i in 1..WIDTH - 1 {
            if cost[i - 1] <= cost[i] {
                (cost[i], first[i]) = (cost[i - 1], 0);
            }
        }
        let node = &mut self.nodes[index];
        (node.cost, node.first, node.is_leaf) = (cost, first, is_leaf);
    }

    fn store_node(&self, index: usize, part: &mut Part) -> Child {
        let at = part.nodes.len();
        part.nodes.push(Node::EMPTY);
        let (mut chosen, mut len) = ([0; WIDTH], 0);
        self.gather(index, WIDTH, true, &mut chosen, &mut len);
        for (slot, &index) in chosen[..len].iter().enumerate() {
            let node = &self.nodes[index];
            let child = match node.is_leaf {
                true => part.leaf(node.first_reference(), node.len()),
                false => self.store_node(index, part),
            };
            part.nodes[at].set(slot, &node.bounds, child);
        }
        Child::node(at)
    }

    /// The at most `slots` children into which a node is opened, in the order of their references.
    fn gather(&self, index: usize, slots: usize, open: bool, chosen: &mut [usize; WIDTH], len: &mut usize) {
        let node = &self.nodes[index];
        let mut slots = slots;
        while !open && slots > 1 && node.first[slots - 1] == 0 {
            slots -= 1;
        }
        if node.children == [0; 2] || slots == 1 {
            chosen[*len] = index;
            *len += 1;
            return;
        }
        let first = node.first[slots - 1] as usize;
        self.gather(node.children[0] as usize, first, false, chosen, len);
        self.gather(node.children[1] as usize, slots - first, false, chosen, len);
    }
}
