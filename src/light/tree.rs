//! One of many lights, chosen by what it can mean to a point: a tree of light bounds, walked from the root by the
//! importance of a node's children (Conty Estévez and Kulla 2018). The probability of a given light is the product
//! along its way to the root, so a ray that hits a lamp can ask for it.
//!
//! A node has eight children, weighed at once: fewer steps wait for memory, and what is chosen among is closer to the
//! lights themselves than pairs of groups are.

mod build;

use super::Receiver;
use super::bounds::LightBounds;
use super::importance::{Importance, Importances};

/// Children of a node.
const WIDTH: usize = 8;
/// In [`Node::child`]: a leaf, with the light's index.
const LEAF: u32 = 1 << 31;
/// In [`LightTree::parents`]: the root's.
const ROOT: u32 = u32::MAX;

/// Some groups of lights; those that are not there have no strength.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
struct Node {
    groups: Importances<WIDTH>,
    /// Nodes, or leaves' lights.
    child: [u32; WIDTH],
}

/// A tree over lights that are numbered from 0.
#[derive(Clone, Debug, Default)]
pub struct LightTree {
    root: Importance,
    /// Level by level.
    nodes: Vec<Node>,
    /// By node: the place that it has in its parent, [`WIDTH`]·node + lane.
    parents: Vec<u32>,
    /// By light: its place.
    places: Vec<u32>,
}

impl LightTree {
    /// A tree over at most 2²⁹ lights. The same lights give the same tree on any number of threads.
    pub fn new(lights: &[LightBounds]) -> LightTree {
        build::build(lights)
    }

    /// Importance of all lights together.
    #[inline(always)]
    pub fn importance(&self, to: &Receiver) -> f32 {
        self.root.at(to)
    }

    /// The light that `u` in [0, 1) chooses, and its probability. `None` when none of them can reach `to`.
    #[inline(always)]
    pub fn sample(&self, to: &Receiver, mut u: f64) -> Option<(u32, f32)> {
        let (mut i, mut probability) = (0, 1.0);
        loop {
            let node = self.nodes.get(i as usize)?;
            let shares = node.shares(to)?;
            let mut ends = [0.0; WIDTH];
            let mut sum = 0.0;
            for (end, share) in ends.iter_mut().zip(shares) {
                sum += f64::from(share);
                *end = sum;
            }
            let mut chosen = ends.iter().map(|end| usize::from(u >= *end)).sum();
            if chosen == WIDTH {
                chosen = shares.iter().rposition(|share| *share > 0.0)?; // rounding
            }
            let share = shares[chosen];
            u = ((u - (ends[chosen] - f64::from(share))) / f64::from(share)).clamp(0.0, 1.0 - f64::EPSILON);
            probability *= share;
            let child = node.child[chosen];
            if child & LEAF != 0 {
                return Some((child & !LEAF, probability));
            }
            i = child;
        }
    }

    /// The probability with which [`LightTree::sample`] chooses `light`.
    #[inline(always)]
    pub fn probability(&self, light: u32, to: &Receiver) -> f32 {
        let (mut place, mut probability) = (self.places[light as usize], 1.0);
        while place != ROOT {
            let (node, lane) = (place as usize / WIDTH, place as usize % WIDTH);
            let Some(shares) = self.nodes[node].shares(to) else { return 0.0 };
            probability *= shares[lane];
            place = self.parents[node];
        }
        probability
    }
}

impl Node {
    /// The probabilities of the children; `None` when none of them can reach `to`.
    #[inline(always)]
    fn shares(&self, to: &Receiver) -> Option<[f32; WIDTH]> {
        let importance = self.groups.at(to);
        let sum: f32 = importance.iter().sum();
        (sum > 0.0 && sum.is_finite()).then(|| importance.map(|x| x / sum))
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::light::bounds::Cone;
    use crate::math::{Aabb, Vec3};

    /// Lamps of all strengths and directions; the same each time.
    pub fn lamps(n: u32) -> Vec<LightBounds> {
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
                let reached = tree.sample(&to, 0.5).is_some();
                assert!(sum < 1.0 + 1e-4 && (sum > 0.5 || !reached), "{n}: {sum}");
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
        // So strong in one point that their sum is infinite, and that times their extent no number.
        let point = LightBounds { bounds: Aabb::EMPTY.grow(Vec3::ONE), strength: f32::MAX, ..lamps(1)[0] };
        let tree = LightTree::new(&[point; 20]);
        assert!((0..20).all(|i| tree.probability(i, &receivers()[0]).is_finite()));
        // Each twice as far as the one before: every split takes one off.
        let mut far = lamps(120);
        for (i, light) in far.iter_mut().enumerate() {
            let p = Vec3::X * 2f32.powi(i as i32 - 60);
            light.bounds = Aabb::EMPTY.grow(p).grow(p * 1.01);
        }
        let tree = LightTree::new(&far);
        let sum: f32 = (0..120).map(|i| tree.probability(i, &receivers()[0])).sum();
        assert!((sum - 1.0).abs() < 1e-4, "{sum}");
    }
}
