//! Rays under way with what their paths carry: structure of arrays, in chunks of [`LANES`].

use super::Extension;
use crate::accel::{LANES, Mask, Rays};
use crate::math::Rgb;
use crate::math::ray::Ray;

/// What a path carries besides its ray, structure of arrays.
#[derive(Clone, Debug)]
pub(super) struct Paths {
    beta: [[f32; LANES]; 3],
    pub pdf: [f32; LANES],
    pub normal: [u32; LANES],
    pub slot: [u32; LANES],
    pub branch: [u32; LANES],
}

impl Paths {
    const EMPTY: Paths = Paths {
        beta: [[0.0; LANES]; 3],
        pdf: [0.0; LANES],
        normal: [0; LANES],
        slot: [0; LANES],
        branch: [0; LANES],
    };
}

/// Rays with what they carry, in chunks; all of one depth.
#[derive(Debug, Default)]
pub(super) struct Lanes {
    pub rays: Vec<Rays>,
    pub paths: Vec<Paths>,
    pub len: usize,
}

impl Lanes {
    /// A ray whose path ends with it.
    #[inline(always)]
    pub fn push(&mut self, ray: Ray, beta: Rgb, slot: u32) {
        let (chunk, lane) = (self.len / LANES, self.len % LANES);
        if chunk == self.rays.len() {
            self.rays.push(Rays::default());
            self.paths.push(Paths::EMPTY);
        }
        self.rays[chunk].set(lane, ray.o, ray.d, 0.0, ray.tmax);
        let path = &mut self.paths[chunk];
        (path.beta[0][lane], path.beta[1][lane], path.beta[2][lane]) = (beta.x, beta.y, beta.z);
        path.slot[lane] = slot;
        self.len += 1;
    }

    /// A ray to follow, with all that its path carries.
    #[inline(always)]
    pub fn follow(&mut self, next: Extension, slot: u32) {
        let (chunk, lane) = (self.len / LANES, self.len % LANES);
        self.push(Ray { o: next.o, d: next.d, tmax: f32::INFINITY }, next.beta, slot);
        let path = &mut self.paths[chunk];
        path.pdf[lane] = next.pdf;
        path.normal[lane] = next.normal;
        path.branch[lane] = next.branch;
    }

    /// Takes the last lanes in whole chunks, at most `most` of them, leaving the rest.
    pub fn split_off(&mut self, most: usize, into: &mut Lanes) {
        let rest = (self.len - most.min(self.len)).next_multiple_of(LANES).min(self.len);
        into.rays.clear();
        into.paths.clear();
        into.rays.extend_from_slice(&self.rays[rest / LANES..self.len.div_ceil(LANES)]);
        into.paths.extend_from_slice(&self.paths[rest / LANES..self.len.div_ceil(LANES)]);
        into.len = self.len - rest;
        self.len = rest;
    }

    #[inline(always)]
    pub fn beta(&self, chunk: usize, lane: usize) -> Rgb {
        let b = &self.paths[chunk].beta;
        Rgb::new(b[0][lane], b[1][lane], b[2][lane])
    }

    /// The chunks in use, each with the mask of its lanes in use.
    pub fn chunks(&self) -> impl Iterator<Item = (usize, Mask)> + use<> {
        let len = self.len;
        (0..len.div_ceil(LANES)).map(move |c| {
            let used = (len - c * LANES).min(LANES);
            (c, (u32::from(Mask::MAX) >> (LANES - used)) as Mask)
        })
    }
}
