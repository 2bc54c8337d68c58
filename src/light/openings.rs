//! Where the sky is seen from indoors: directions that lead out, by place.
//!
//! A room is lit through what little of the sky its window leaves. A direction that a BSDF samples rarely leads there, and
//! uniform samples of the sky as rarely. So some random paths are traced before the picture is ([`crate::integrator::explore`]),
//! and the rays of theirs that found the way out become a density: space is halved until a part holds few of them, and each part
//! keeps how often they went where. It only says where to look: light samples and BSDF samples are weighed by their true
//! densities, so a poor guess costs noise and nothing else. (Jensen 1995, "Importance driven path tracing using the photon map",
//! has the idea; the halved space is as in Müller, Gross and Novák 2017, "Practical path guiding", with directions of the
//! sky alone.)

use crate::math::approx::sin_cos_turn;
use crate::math::{Aabb, Vec3};
use std::f32::consts::{PI, TAU};

/// Bins of a direction: equal steps of height, by equal angles around z. All have the same solid angle.
const ROWS: usize = 32;
const COLUMNS: usize = 64;
const BINS: usize = ROWS * COLUMNS;

/// Density in a bin that is chosen with certainty.
const DENSITY: f32 = BINS as f32 / (4.0 * PI);

/// A part of space with fewer rays than twice as many is not halved.
const FEWEST: usize = 128;

/// How wide a gap is at least, in errors of a point: rays start an error or two away from their surface.
const CLEAR: f32 = 16.0;

/// A ray that found the sky: where it started, and its direction.
pub type Escape = (Vec3, Vec3);

/// Which directions lead to the sky, by place.
#[derive(Clone, Debug)]
pub struct Openings {
    /// The halved space; the first is all of it.
    nodes: Vec<Node>,
    /// By part of space: the chance of each bin and all before it.
    chances: Vec<[f32; BINS]>,
    /// Of all rays that were traced, those that found the sky.
    pub share: f32,
}

#[derive(Clone, Copy, Debug)]
enum Node {
    /// Points below `at` are in node `below`, the others in the next.
    Halves { axis: u8, at: f32, below: u32 },
    /// A part of space, by its number.
    Part(u32),
}

impl Openings {
    /// From rays that found the sky, at least one, which are `share` of all. Rays start at most some two `error` away from
    /// the surface that they leave.
    pub fn new(mut escapes: Vec<Escape>, share: f32, error: f32) -> Openings {
        let mut all = Openings { nodes: vec![Node::Part(0)], chances: Vec::new(), share };
        all.grow(0, &mut escapes, CLEAR * error);
        all
    }

    fn grow(&mut self, node: usize, rays: &mut [Escape], clear: f32) {
        let Some((axis, at, middle)) = halve(rays, clear) else {
            self.nodes[node] = Node::Part(self.chances.len() as u32);
            self.chances.push(chances(rays));
            return;
        };
        let (low, high) = rays.split_at_mut(middle);
        let below = self.nodes.len();
        self.nodes.extend([Node::Part(0); 2]);
        self.nodes[node] = Node::Halves { axis: axis as u8, at, below: below as u32 };
        self.grow(below, low, clear);
        self.grow(below + 1, high, clear);
    }

    /// The chances at a place.
    #[inline]
    fn at(&self, p: Vec3) -> &[f32; BINS] {
        let mut node = 0;
        loop {
            match self.nodes[node] {
                Node::Part(part) => return &self.chances[part as usize],
                Node::Halves { axis, at, below } => {
                    node = below as usize + usize::from(p[usize::from(axis)] >= at);
                }
            }
        }
    }

    /// A direction that may lead from `p` to the sky, with its density per solid angle.
    #[inline]
    pub fn sample(&self, p: Vec3, u: [f32; 2]) -> (Vec3, f32) {
        let chances = self.at(p);
        let bin = chances.partition_point(|c| *c <= u[0]).min(BINS - 1);
        let (before, chance) = of(chances, bin);
        let rest = ((u[0] - before) / chance).clamp(0.0, 1.0);
        let (row, column) = (bin / COLUMNS, bin % COLUMNS);
        let z = 1.0 - 2.0 / ROWS as f32 * (row as f32 + rest);
        let r = (1.0 - z * z).max(0.0).sqrt();
        let (sin, cos) = sin_cos_turn((column as f32 + u[1]) / COLUMNS as f32);
        (Vec3::new(r * cos, r * sin, z), chance * DENSITY)
    }

    /// Density per solid angle with which [`Openings::sample`] gives the unit direction `d` at `p`.
    #[inline]
    pub fn pdf(&self, p: Vec3, d: Vec3) -> f32 {
        of(self.at(p), bin_of(d)).1 * DENSITY
    }
}

/// The chance of all bins before `bin`, and its own.
#[inline]
fn of(chances: &[f32; BINS], bin: usize) -> (f32, f32) {
    let before = if bin == 0 { 0.0 } else { chances[bin - 1] };
    (before, chances[bin] - before)
}

#[inline]
fn bin_of(d: Vec3) -> usize {
    let row = (0.5 * (1.0 - d.z) * ROWS as f32) as usize;
    let turn = libm::atan2f(d.y, d.x) / TAU;
    let turn = if turn < 0.0 { turn + 1.0 } else { turn };
    row.min(ROWS - 1) * COLUMNS + ((turn * COLUMNS as f32) as usize).min(COLUMNS - 1)
}

/// Where to halve the space of `rays`, which are sorted by it then, and how many are below: along the longest side on which they can be parted, in
/// the widest gap of the middle half.
///
/// A sample is taken at a point of a surface, its density asked for at the start of a ray, a rounding off the surface. Walls are
/// often parallel to an axis: were a plane as near to one as that, all of the wall would be lit by the one part and weighed
/// by the other. So a gap is far wider than rounding, and no plane is in its middle, where another wall may well be.
fn halve(rays: &mut [Escape], clear: f32) -> Option<(usize, f32, usize)> {
    if rays.len() < 2 * FEWEST {
        return None;
    }
    let bounds = rays.iter().fold(Aabb::EMPTY, |all, (p, _)| all.grow(*p));
    let side = bounds.extent();
    let mut axes = [0, 1, 2];
    axes.sort_by(|&a, &b| side[b].total_cmp(&side[a]));
    axes.into_iter().find_map(|axis| {
        rays.sort_by(|(p, _), (q, _)| p[axis].total_cmp(&q[axis]));
        let gap = |i: &usize| rays[*i].0[axis] - rays[*i - 1].0[axis];
        let middle = rays.len() / 4 + 1..rays.len() - rays.len() / 4;
        let widest = middle.max_by(|i, j| gap(i).total_cmp(&gap(j)))?;
        let below = rays[widest - 1].0[axis];
        (gap(&widest) > clear).then_some((axis, below + 0.382 * gap(&widest), widest))
    })
}

/// The chance of each bin and all before it: each ray counts in its bin and those around it, so that a few rays cover
/// the opening they came through.
fn chances(rays: &[Escape]) -> [f32; BINS] {
    let mut counts = [0u32; BINS];
    for (_, d) in rays {
        let bin = bin_of(*d);
        let (row, column) = (bin / COLUMNS, bin % COLUMNS);
        for (up, weight) in [(0, 1), (1, 2), (2, 1)] {
            let row = (row + up).clamp(1, ROWS) - 1;
            for (along, weight) in [(COLUMNS - 1, weight), (0, 2 * weight), (1, weight)] {
                counts[row * COLUMNS + (column + along) % COLUMNS] += weight;
            }
        }
    }
    let total: u32 = counts.iter().sum();
    let mut sum = 0;
    counts.map(|count| {
        sum += count;
        (f64::from(sum) / f64::from(total.max(1))) as f32
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::surface::ROUNDING;

    /// Rays to a window of a room, from all over its floor.
    fn to_a_window() -> Openings {
        let ray = |k: usize| {
            let part = |step: usize| ((k * step) % 1009) as f32 / 1009.0;
            let from = Vec3::new(4.0 * part(17), 4.0 * part(101), 0.0);
            (from, (Vec3::new(0.0, 1.0 + part(251), 1.0 + part(499)) - from).normalize())
        };
        Openings::new((0..1009).map(ray).collect(), 0.01, 1e-5)
    }

    /// The samples of a fine grid fall as often into a bin as the density says, and know their own.
    #[test]
    fn samples_have_their_density() {
        let openings = to_a_window();
        assert!(openings.chances.len() > 3, "{} parts", openings.chances.len());
        for p in [Vec3::new(0.5, 0.5, 0.0), Vec3::new(3.5, 3.0, 0.0), Vec3::new(90.0, -7.0, 3.0)] {
            let side = 512;
            let mut found = [0u32; BINS];
            for k in 0..side * side {
                let u = [k / side, k % side].map(|i| (i as f32 + 0.5) / side as f32);
                let (d, pdf) = openings.sample(p, u);
                assert!(pdf > 0.0 && (d.length() - 1.0).abs() < 1e-5);
                assert!((openings.pdf(p, d) / pdf - 1.0).abs() < 1e-6, "{d} {pdf}");
                found[bin_of(d)] += 1;
            }
            let mut whole = 0.0;
            for (bin, found) in found.into_iter().enumerate() {
                let chance = of(openings.at(p), bin).1;
                whole += chance;
                let found = found as f32 / (side * side) as f32;
                assert!((found - chance).abs() < 1.0 / side as f32, "{bin}: {found} {chance}");
            }
            assert!((whole - 1.0).abs() < 1e-5);
        }
    }

    /// What is learned at one end of the room is not what is learned at the other.
    #[test]
    fn directions_depend_on_the_place() {
        let openings = to_a_window();
        let (near, far) = (Vec3::new(0.2, 1.5, 0.0), Vec3::new(3.8, 1.5, 0.0));
        let up = Vec3::new(-0.1, 0.0, 1.5).normalize();
        assert!(openings.pdf(near, up) > 20.0 * openings.pdf(far, up));
        assert_eq!(openings.pdf(near, -Vec3::Z), 0.0);
    }

    /// On the faces of a room, also of one whose coordinates are rounded, a ray's start is in the part of its surface.
    #[test]
    fn parts_do_not_end_at_walls() {
        for size in [Vec3::new(12.0, 12.0, 2.5), Vec3::new(8.1, 7.9, 2.7), Vec3::new(300.3, 5.7, 2.9)] {
            let part = |k: usize, step: usize| ((k * step) % 10_007) as f32 / 10_007.0;
            let inside = |k: usize| Vec3::new(part(k, 17), part(k, 4001), part(k, 251)) * size;
            let face = |k: usize| {
                let mut p = inside(k);
                p[k % 3] = if k % 6 < 3 { 0.0 } else { size[k % 3] };
                // The last digit, as points on a triangle have it.
                p[k % 3] *= 1.0 + f32::EPSILON * (k % 5) as f32;
                p
            };
            let window = Vec3::new(0.0, 0.5, 0.6) * size;
            let ray = |k: usize| (face(k), (window + 0.1 * inside(k) - face(k)).normalize());
            let error = ROUNDING * size.max_element();
            let openings = Openings::new((0..10_007).map(ray).collect(), 0.01, error);
            assert!(openings.chances.len() > 30, "{} parts", openings.chances.len());
            for k in 0..10_007 {
                let (p, mut q) = (face(k), face(k));
                let axis = k % 3;
                q[axis] += 2.0 * error * if k % 6 < 3 { 1.0 } else { -1.0 };
                assert!(std::ptr::eq(openings.at(p), openings.at(q)), "{p} of {size}");
            }
        }
    }

    /// Thousands in one place, and a single one.
    #[test]
    fn crowds_and_single_rays_end() {
        for count in [1, 5000] {
            let openings = Openings::new(vec![(Vec3::ONE, Vec3::Z); count], 0.5, 1e-5);
            assert_eq!(openings.nodes.len(), 1);
            let (d, pdf) = openings.sample(Vec3::ZERO, [0.999_999_9, 0.5]);
            assert!(pdf > 0.0 && d.z > 0.85);
        }
    }
}
