//! Builds the tree: a binary one by the surface area orientation heuristic, whose nodes are then merged eight to one.

use super::{LEAF, LightTree, Node, ROOT, WIDTH};
use crate::light::bounds::LightBounds;
use crate::light::importance::Importances;
use crate::math::{Aabb, Vec3};

/// Of the binary tree; n lights have 2n − 1, depth first: the first child follows its parent.
#[derive(Clone, Copy)]
struct Pair {
    bounds: LightBounds,
    /// The second child, or a leaf's light.
    child: u32,
}

/// See [`LightTree::new`].
pub fn build(lights: &[LightBounds]) -> LightTree {
    if lights.is_empty() {
        return LightTree::default();
    }
    let mut order: Vec<u32> = (0..lights.len() as u32).collect();
    let mut pairs = vec![Pair { bounds: lights[0], child: LEAF }; 2 * lights.len() - 1];
    halve(lights, &mut order, &mut pairs, 0, 0);
    let mut tree = LightTree {
        root: pairs[0].bounds.importance(),
        nodes: Vec::new(),
        parents: vec![ROOT],
        places: vec![0; lights.len()],
    };
    // Level by level: a node's children follow each other, and all of them what is above.
    let mut sources = vec![0];
    while let Some(&source) = sources.get(tree.nodes.len()) {
        let mut node = Node { groups: Importances::NONE, child: [LEAF; WIDTH] };
        for (lane, group) in merged(&pairs, source).into_iter().enumerate() {
            let pair = &pairs[group as usize];
            node.groups.set(lane, &pair.bounds.importance());
            let place = (WIDTH * tree.nodes.len() + lane) as u32;
            if pair.child & LEAF != 0 {
                tree.places[(pair.child & !LEAF) as usize] = place;
                node.child[lane] = pair.child;
            } else {
                node.child[lane] = sources.len() as u32;
                sources.push(group);
                tree.parents.push(place);
            }
        }
        tree.nodes.push(node);
    }
    tree
}

/// The groups below a node of the binary tree, at most [`WIDTH`]: of those that have parts, the one that says least about
/// them is taken apart first.
fn merged(pairs: &[Pair], source: u32) -> Vec<u32> {
    let mut groups = vec![source];
    while groups.len() < WIDTH {
        let vague = |group: u32| {
            let Pair { bounds, child } = &pairs[group as usize];
            // Infinite strength in one point is no number, and must be taken apart like the others.
            if child & LEAF != 0 { -1.0 } else { (bounds.strength * size(&bounds.bounds)).max(0.0) }
        };
        let (mut worst, mut most) = (0, -1.0);
        for (i, &group) in groups.iter().enumerate() {
            let vagueness = vague(group);
            if vagueness > most {
                (worst, most) = (i, vagueness);
            }
        }
        if most < 0.0 {
            break; // nothing but lights
        }
        let apart = groups[worst];
        groups[worst] = apart + 1;
        groups.insert(worst + 1, pairs[apart as usize].child);
    }
    groups
}

/// Deeper trees are split in the middle, so that no order of lights makes the recursion deep.
const DEEPEST: u32 = 64;
/// More lights than this are built by two threads.
const PARALLEL: usize = 4096;

/// Builds the lights of `order` into `pairs`, of which the first is number `first` of the tree.
fn halve(
    lights: &[LightBounds],
    order: &mut [u32],
    pairs: &mut [Pair],
    first: u32,
    depth: u32,
) -> LightBounds {
    let (pair, below) = pairs.split_at_mut(1);
    if let [light] = order {
        let bounds = lights[*light as usize];
        pair[0] = Pair { bounds, child: LEAF | *light };
        return bounds;
    }
    let middle = if depth < DEEPEST { split(lights, order) } else { order.len() / 2 };
    let (left, right) = order.split_at_mut(middle);
    let (left_pairs, right_pairs) = below.split_at_mut(2 * left.len() - 1);
    let child = first + 2 * left.len() as u32;
    let parallel = left.len().min(right.len()) > PARALLEL;
    let mut halve_left = || halve(lights, left, left_pairs, first + 1, depth + 1);
    let mut halve_right = || halve(lights, right, right_pairs, child, depth + 1);
    let (a, b) = if parallel { rayon::join(halve_left, halve_right) } else { (halve_left(), halve_right()) };
    let bounds = a.union(&b);
    pair[0] = Pair { bounds, child };
    bounds
}

/// What a bin of a split has gathered.
#[derive(Clone, Copy)]
struct Bin {
    bounds: Aabb,
    axes: Vec3,
    strength: f32,
    count: u32,
}

impl Bin {
    const EMPTY: Bin = Bin { bounds: Aabb::EMPTY, axes: Vec3::ZERO, strength: 0.0, count: 0 };

    fn add(&mut self, other: &Bin) {
        self.bounds = self.bounds.union(other.bounds);
        self.axes += other.axes;
        self.strength += other.strength;
        self.count += other.count;
    }

    /// The surface area orientation heuristic's product of strength, area and spread of directions; the spread from the
    /// length of the mean normal, which costs no trigonometric function a light. The longest edge keeps flat boxes
    /// from costing nothing.
    fn cost(&self) -> f32 {
        if self.count == 0 {
            return 0.0;
        }
        let spread = 2.0 - self.axes.length() / self.count as f32;
        self.strength * spread * size(&self.bounds)
    }
}

/// An area that is none for points alone.
fn size(bounds: &Aabb) -> f32 {
    bounds.half_area() + bounds.extent().max_element().powi(2) * 0.1
}

const BINS: usize = 12;

/// Sorts `order` into two parts and says how long the first one is; neither is empty.
fn split(lights: &[LightBounds], order: &mut [u32]) -> usize {
    let center = |i: u32| lights[i as usize].bounds.center();
    let centers = order.iter().fold(Aabb::EMPTY, |b, &i| b.grow(center(i)));
    let extent = centers.extent();
    let bin_of = |axis: usize, i: u32| {
        let share = (center(i)[axis] - centers.min[axis]) / extent[axis];
        ((share * BINS as f32) as usize).min(BINS - 1)
    };
    let mut best = (f32::INFINITY, 0, 0);
    for axis in (0..3).filter(|a| extent[*a] > 0.0) {
        let mut bins = [Bin::EMPTY; BINS];
        for &i in order.iter() {
            let light = &lights[i as usize];
            bins[bin_of(axis, i)].add(&Bin {
                bounds: light.bounds,
                axes: light.cone.axis,
                strength: light.strength,
                count: 1,
            });
        }
        let mut after = [0.0; BINS];
        let mut right = Bin::EMPTY;
        for k in (1..BINS).rev() {
            right.add(&bins[k]);
            after[k] = right.cost();
        }
        let mut left = Bin::EMPTY;
        // Thin boxes are not cut lengthwise.
        let shape = extent.max_element() / extent[axis];
        for k in 1..BINS {
            left.add(&bins[k - 1]);
            let cost = (left.cost() + after[k]) * shape;
            if left.count > 0 && (left.count as usize) < order.len() && cost < best.0 {
                best = (cost, axis, k);
            }
        }
    }
    let (cost, axis, k) = best;
    if cost == f32::INFINITY {
        return order.len() / 2; // all in one place
    }
    let mut middle = 0;
    for i in 0..order.len() {
        if bin_of(axis, order[i]) < k {
            order.swap(i, middle);
            middle += 1;
        }
    }
    middle
}
