//! What only the inside shows: the tree's shape and the claim that boxes never change an answer.

mod answers;
mod shape;
mod stored;

use super::few::Few;
use super::meeting::Meetings;
use super::node::Child;
use super::ray::Prepared;
use super::split::PARALLEL;
use super::traverse::{MAX_DEPTH, Stacks};
use super::tree::{Found, Place, Tree, rank};
use super::{Bvh, build, build::Built};
use crate::accel::{BuildOptions, Intersector, LANES, Mask, Quality, Rays, lanes_of};
use crate::math::Vec3;
use crate::math::isa::{self, Isa, Kernel, Set};
use crate::shape::Mesh;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::sync::Arc;

struct Random(ChaCha8Rng);

impl Random {
    fn unit(&mut self) -> f32 {
        (self.0.next_u32() >> 8) as f32 / (1 << 24) as f32
    }

    fn cube(&mut self) -> [f32; 3] {
        [0; 3].map(|_| self.unit() * 2.0 - 1.0)
    }
}

fn random(seed: u64) -> Random {
    Random(ChaCha8Rng::seed_from_u64(seed))
}

fn soup(n: u32, size: f32, map: impl Fn([f32; 3]) -> [f32; 3]) -> Mesh {
    let mut random = random(n as u64);
    let mut positions = Vec::new();
    for _ in 0..n {
        let at = random.cube();
        for _ in 0..3 {
            let off = random.cube();
            positions.push(map([0, 1, 2].map(|k| at[k] + size * off[k])));
        }
    }
    Mesh::new(positions, (0..n).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

fn built(mesh: Mesh) -> Built {
    built_as(&Arc::new(mesh), Quality::Medium)
}

fn built_as(mesh: &Arc<Mesh>, quality: Quality) -> Built {
    let options = BuildOptions { quality, ..BuildOptions::default() };
    build::build(std::slice::from_ref(mesh), &options).expect("builds")
}

const QUALITIES: [Quality; 3] = [Quality::Low, Quality::Medium, Quality::High];

/// Thin triangles across the axes: their boxes overlap, so space is split.
fn needles(n: u32) -> Mesh {
    let mut random = random(n as u64);
    let mut positions = Vec::new();
    for _ in 0..n {
        let (at, along) = (random.cube(), random.cube());
        for s in [0.0, 1.0, 0.5] {
            let off = random.cube();
            positions.push([0, 1, 2].map(|k| at[k] + along[k] * s + off[k] * 0.003));
        }
    }
    Mesh::new(positions, (0..n).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}
