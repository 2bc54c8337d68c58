//! One of many lights, chosen by what it can mean to a point: a binary tree of light bounds, walked from the root by
//! the importance of the two children (Conty Estévez and Kulla 2018). The probability of a given light is the product
//! along its way to the root, so a ray that hits a lamp can ask for it.

use super::Receiver;
use super::bounds::{Importance, LightBounds};
use crate::math::{Aabb, Vec3};

/// In [`Node::child`]: a leaf, with the light's index.
const LEAF: u32 = 1 << 31;
/// In [`Node::parent`]: the root.
const ROOT: u32 = u32::MAX;

/// The tree of `n` lights has 2n − 1 nodes, depth first: the first child follows its parent.
#[derive(Clone, Copy, Debug, Default)]
struct Node {
    importance: Importance,
    parent: u32,
    /// The second child, or a leaf's light.
    child: u32,
}

/// A tree over lights that are numbered from 0.
#[derive(Clone, Debug, Default)]
pub struct LightTree {
    nodes: Vec<Node>,
    /// By light.
    leaf: Vec<u32>,
}

impl LightTree {
    /// A tree over at most 2³⁰ lights. The same lights give the same tree on any number of threads.
    pub fn new(lights: &[LightBounds]) -> LightTree {
        if lights.is_empty() {
            return LightTree::default();
        }
        let mut order: Vec<u32> = (0..lights.len() as u32).collect();
        let mut nodes = vec![Node::default(); 2 * lights.len() - 1];
        build(lights, &mut order, &mut nodes, 0, ROOT, 0);
        let mut leaf = vec![0; lights.len()];
        for (i, node) in nodes.iter().enumerate().filter(|(_, node)| node.child & LEAF != 0) {
            leaf[(node.child & !LEAF) as usize] = i as u32;
        }
        LightTree { nodes, leaf }
    }

    /// Importance of all lights together.
    #[inline(always)]
    pub fn importance(&self, to: &Receiver) -> f32 {
        self.nodes.first().map_or(0.0, |root| root.importance.at(to))
    }

    /// The light that `u` in [0, 1) chooses, and its probability. `None` when none of them can reach `to`.
    #[inline(always)]
    pub fn sample(&self, to: &Receiver, mut u: f64) -> Option<(u32, f32)> {
        let (mut i, mut probability) = (0, 1.0);
        loop {
            let node = self.nodes.get(i as usize)?;
            if node.child & LEAF != 0 {
                return Some((node.child & !LEAF, probability));
            }
            let [first, second] = self.shares(i, node.child, to)?;
            let split = f64::from(first);
            if u < split {
                (i, probability, u) = (i + 1, probability * first, u / split);
            } else {
                (i, probability, u) = (node.child, probability * second, (u - split) / (1.0 - split));
            }
        }
    }

    /// The probability with which [`LightTree::sample`] chooses `light`.
    #[inline(always)]
    pub fn probability(&self, light: u32, to: &Receiver) -> f32 {
        let (mut i, mut probability) = (self.leaf[light as usize], 1.0);
        loop {
            let parent = self.nodes[i as usize].parent;
            if parent == ROOT {
                return probability;
            }
            let Some([first, second]) = self.shares(parent, self.nodes[parent as usize].child, to) else {
                return 0.0;
            };
            probability *= if i == parent + 1 { first } else { second };
            i = parent;
        }
    }

    /// The probabilities of a node's two children; `None` when neither can reach `to`.
    #[inline(always)]
    fn shares(&self, node: u32, child: u32, to: &Receiver) -> Option<[f32; 2]> {
        let at = |i: u32| self.nodes[i as usize].importance.at(to);
        let (a, b) = (at(node + 1), at(child));
        let sum = a + b;
        (sum > 0.0 && sum.is_finite()).then(|| [a / sum, b / sum])
    }
}

/// Deeper trees are split in the middle, so that no order of lights makes the recursion deep.
const DEEPEST: u32 = 64;
/// More lights than this are built by two threads.
const PARALLEL: usize = 4096;

/// Builds the lights of `order` into `nodes`, of which the first is number `first` of the tree.
fn build(
    lights: &[LightBounds],
    order: &mut [u32],
    nodes: &mut [Node],
    first: u32,
    parent: u32,
    depth: u32,
) -> LightBounds {
    let (node, below) = nodes.split_at_mut(1);
    if let [light] = order {
        let bounds = lights[*light as usize];
        node[0] = Node { importance: bounds.importance(), parent, child: LEAF | *light };
        return bounds;
    }
    let middle = if depth < DEEPEST { split(lights, order) } else { order.len() / 2 };
    let (left, right) = order.split_at_mut(middle);
    let (left_nodes, right_nodes) = below.split_at_mut(2 * left.len() - 1);
    let child = first + 2 * left.len() as u32;
    let parallel = left.len().min(right.len()) > PARALLEL;
    let mut build_left = || build(lights, left, left_nodes, first + 1, first, depth + 1);
    let mut build_right = || build(lights, right, right_nodes, child, first, depth + 1);
    let (a, b) = if parallel { rayon::join(build_left, build_right) } else { (build_left(), build_right()) };
    let bounds = a.union(&b);
    node[0] = Node { importance: bounds.importance(), parent, child };
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
        let extent = self.bounds.extent();
        self.strength * spread * (self.bounds.half_area() + extent.max_element().powi(2) * 0.1)
    }
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::bounds::Cone;

    fn lamps(n: u32) -> Vec<LightBounds> {
        let f = |i: u32, k: u32| {
            let x = i.wrapping_mul(0x9e37_79b9) ^ k.wrapping_mul(0x85eb_ca6b);
            (x.wrapping_mul(0x2c1b_3c6d) >> 9) as f32 / (1 << 23) as f32
        };
        (0..n)
            .map(|i| {
                let p = 10.0 * Vec3::new(f(i, 1), f(i, 2), f(i, 3));
                let axis = (Vec3::new(f(i, 4), f(i, 5), f(i, 6)) - 0.5).normalize();
                LightBounds {
                    bounds: Aabb::EMPTY.grow(p).grow(p + 0.1),
                    cone: Cone { axis, cos_normals: 1.0, cos_light: 0.0 },
                    two_sided: i % 3 == 0,
                    strength: f(i, 7) * f(i, 8),
                }
            })
            .collect()
    }

    fn receivers() -> Vec<Receiver> {
        let n = Receiver::pack(Vec3::new(0.6, 0.0, 0.8));
        vec![
            Receiver::new(Vec3::new(5.0, 5.0, 5.0), Receiver::ALL_AROUND),
            Receiver::new(Vec3::new(5.0, 5.0, 5.0), n),
            Receiver::new(Vec3::new(-9.0, 3.0, 14.0), Receiver::pack(Vec3::X)),
        ]
    }

    /// What is chosen is chosen as often as [`LightTree::probability`] says, and the probabilities of all
    /// lights add up to one.
    #[test]
    fn probabilities_are_those_of_the_samples() {
        for n in [1, 2, 3, 57, 400] {
            let tree = LightTree::new(&lamps(n));
            for to in receivers() {
                let p: Vec<f64> = (0..n).map(|i| f64::from(tree.probability(i, &to))).collect();
                let sum: f64 = p.iter().sum();
                // A group can seem in reach when none of its members is: then nothing is chosen.
                assert!(sum < 1.0 + 1e-4 && sum > 0.5, "{n}: {sum}");
                let samples = 400_000u32;
                let mut counts = vec![0u32; n as usize];
                for k in 0..samples {
                    let u = (f64::from(k) + 0.5) / f64::from(samples);
                    let Some((light, chance)) = tree.sample(&to, u) else { continue };
                    assert!((f64::from(chance) / p[light as usize] - 1.0).abs() < 1e-5);
                    counts[light as usize] += 1;
                }
                // Stratified numbers: every count is within rounding of its expectation.
                for (count, p) in counts.iter().zip(&p) {
                    let expected = p * f64::from(samples);
                    assert!(
                        (f64::from(*count) - expected).abs() < 2.0 + 2e-4 * expected,
                        "{count} {expected}"
                    );
                }
            }
        }
    }

    #[test]
    fn lights_that_cannot_reach_a_point_are_not_chosen() {
        let mut all = lamps(50);
        for light in &mut all {
            (light.cone.axis, light.two_sided) = (Vec3::Z, false);
        }
        let tree = LightTree::new(&all);
        let below = Receiver::new(Vec3::new(5.0, 5.0, -50.0), Receiver::ALL_AROUND);
        assert!(tree.sample(&below, 0.3).is_none());
        let turned_away = Receiver::new(Vec3::new(5.0, 5.0, 50.0), Receiver::pack(Vec3::Z));
        assert!(tree.sample(&turned_away, 0.3).is_none());
        assert!(tree.sample(&Receiver::new(turned_away.p, Receiver::pack(-Vec3::Z)), 0.3).is_some());
        assert!(LightTree::new(&[]).sample(&below, 0.5).is_none());
    }

    #[test]
    fn any_order_of_lights_can_be_built() {
        let one_place = vec![lamps(1)[0]; 5000];
        let tree = LightTree::new(&one_place);
        assert!(tree.sample(&receivers()[0], 0.999_999).is_some());
        // Each twice as far as the one before: every split takes one off.
        let mut far = lamps(120);
        for (i, light) in far.iter_mut().enumerate() {
            let p = Vec3::X * 2f32.powi(i as i32 - 60);
            light.bounds = Aabb::EMPTY.grow(p).grow(p * 1.01);
        }
        assert!(LightTree::new(&far).nodes.len() == 239);
    }
}
