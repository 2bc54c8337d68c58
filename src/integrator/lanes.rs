//! Rays under way with what their paths carry: structure of arrays, in chunks of [`LANES`].

use super::Extension;
use super::wave::Extensions;
use crate::accel::{LANES, Mask, Rays, lanes_of};
use crate::light::LightSamples;
use crate::math::ray::Ray;
use crate::math::{Rgb, Vec3s};

/// What a path carries besides its ray, structure of arrays.
#[derive(Clone, Debug)]
pub struct Paths {
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
pub struct Lanes {
    pub rays: Vec<Rays>,
    pub paths: Vec<Paths>,
    pub len: usize,
}

impl Lanes {
    /// A ray whose path ends with it.
    #[inline(always)]
    pub fn push(&mut self, ray: Ray, beta: Rgb, slot: u32) {
        self.make_room();
        self.put(ray, beta, slot);
    }

    /// A ray to follow, with all that its path carries.
    #[inline(always)]
    pub fn follow(&mut self, next: Extension, slot: u32) {
        self.make_room();
        let (path, lane) = self.put(Ray { o: next.o, d: next.d, tmax: f32::INFINITY }, next.beta, slot);
        (path.pdf[lane], path.normal[lane], path.branch[lane]) = (next.pdf, next.normal, next.branch);
    }

    /// The rays `lanes` of `all`, in their order.
    #[inline(always)]
    pub fn follow_all(&mut self, lanes: Mask, all: &Extensions<'_>) {
        self.make_room();
        if lanes == Mask::MAX && self.len.is_multiple_of(LANES) {
            return self.follow_chunk(all);
        }
        for from in lanes_of(lanes) {
            let ray = Ray { o: all.o.get(from), d: all.d.get(from), tmax: f32::INFINITY };
            let (path, lane) = self.put(ray, all.beta.get(from), all.slot[from]);
            (path.pdf[lane], path.normal[lane]) = (all.pdf[from], all.normal[from]);
            path.branch[lane] = all.branch[from];
        }
    }

    /// A whole chunk of rays, where one begins.
    #[inline(always)]
    fn follow_chunk(&mut self, all: &Extensions<'_>) {
        let chunk = self.len / LANES;
        self.len += LANES;
        let Extensions { o, d, .. } = all;
        let (tmin, tmax) = ([0.0; LANES], [f32::INFINITY; LANES]);
        self.rays[chunk] = Rays { ox: o.x, oy: o.y, oz: o.z, tmin, dx: d.x, dy: d.y, dz: d.z, tmax };
        let beta = [all.beta.x, all.beta.y, all.beta.z];
        let (pdf, normal, slot, branch) = (all.pdf, *all.normal, *all.slot, *all.branch);
        self.paths[chunk] = Paths { beta, pdf, normal, slot, branch };
    }

    /// The shadow rays `lanes` of `lights`, with the radiance that they let through.
    #[inline(always)]
    pub fn push_all(
        &mut self,
        lanes: Mask,
        lights: &LightSamples<LANES>,
        radiance: &Vec3s<LANES>,
        slot: &[u32; LANES],
    ) {
        self.make_room();
        for from in lanes_of(lanes) {
            let ray = Ray { o: lights.o.get(from), d: lights.d.get(from), tmax: lights.tmax[from] };
            self.put(ray, radiance.get(from), slot[from]);
        }
    }

    /// Room for one chunk more than there is.
    #[inline(always)]
    fn make_room(&mut self) {
        while self.rays.len() <= self.len / LANES + 1 {
            self.rays.push(Rays::default());
            self.paths.push(Paths::EMPTY);
        }
    }

    /// Writes the next lane, for which there is room, and gives the place of what else its path carries.
    #[inline(always)]
    fn put(&mut self, ray: Ray, beta: Rgb, slot: u32) -> (&mut Paths, usize) {
        let (chunk, lane) = (self.len / LANES, self.len % LANES);
        self.len += 1;
        self.rays[chunk].set(lane, ray.o, ray.d, 0.0, ray.tmax);
        let path = &mut self.paths[chunk];
        (path.beta[0][lane], path.beta[1][lane], path.beta[2][lane]) = (beta.x, beta.y, beta.z);
        path.slot[lane] = slot;
        (path, lane)
    }

    /// The octants of the lanes' directions.
    #[inline(always)]
    fn octants(&self, chunk: usize) -> [u32; LANES] {
        let rays = &self.rays[chunk];
        let mut octants = [0; LANES];
        for (lane, octant) in octants.iter_mut().enumerate() {
            let negative = |d: f32| u32::from(d < 0.0);
            *octant = negative(rays.dx[lane]) | negative(rays.dy[lane]) << 1 | negative(rays.dz[lane]) << 2;
        }
        octants
    }

    /// Whether all directions of `lanes` of a chunk lie in one octant.
    #[inline(always)]
    pub fn share_an_octant(&self, chunk: usize, lanes: Mask) -> bool {
        let octants = self.octants(chunk);
        let mut same = true;
        for lane in lanes_of(lanes) {
            same &= octants[lane] == octants[0];
        }
        same
    }

    /// The same rays `into` another buffer by the octants of their directions, within one in the order that they had.
    #[inline(always)]
    pub fn sort_by_octant(&self, into: &mut Lanes) {
        let mut ends = [0; 8];
        for (chunk, lanes) in self.chunks() {
            let octants = self.octants(chunk);
            for lane in lanes_of(lanes) {
                ends[octants[lane] as usize % 8] += 1;
            }
        }
        let mut next = [0; 8];
        for octant in 1..8 {
            next[octant] = next[octant - 1] + ends[octant - 1];
        }
        into.len = self.len;
        into.make_room();
        for (chunk, lanes) in self.chunks() {
            let octants = self.octants(chunk);
            for lane in lanes_of(lanes) {
                let at = &mut next[octants[lane] as usize % 8];
                into.copy(*at, self, chunk, lane);
                *at += 1;
            }
        }
    }

    /// Sets lane number `to` to a lane of `all`.
    #[inline(always)]
    fn copy(&mut self, to: usize, all: &Lanes, chunk: usize, lane: usize) {
        let (from, from_path) = (&all.rays[chunk], &all.paths[chunk]);
        let (chunk, at) = (to / LANES, to % LANES);
        self.rays[chunk].set(at, from.o(lane), from.d(lane), from.tmin[lane], from.tmax[lane]);
        let path = &mut self.paths[chunk];
        for (to, beta) in path.beta.iter_mut().zip(&from_path.beta) {
            to[at] = beta[lane];
        }
        (path.pdf[at], path.normal[at]) = (from_path.pdf[lane], from_path.normal[lane]);
        (path.slot[at], path.branch[at]) = (from_path.slot[lane], from_path.branch[lane]);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;

    /// Sorted by octant, every ray is there with what it carries; those of one octant are in their order.
    #[test]
    fn octants_follow_each_other() {
        let mut lanes = Lanes::default();
        for i in 0..100u32 {
            let sign = |bit: u32| if (i * 37 + i / 7) >> bit & 1 == 1 { -1.0 } else { 1.0 };
            let d = Vec3::new(sign(0), sign(1) * 0.5, sign(2) * 0.25);
            let (o, beta) = (Vec3::splat(i as f32), Rgb::new(i as f32, 1.0, 2.0));
            lanes.follow(Extension { o, d, beta, pdf: i as f32, normal: i, branch: i + 1 }, i);
        }
        let mut sorted = Lanes::default();
        lanes.sort_by_octant(&mut sorted);
        assert_eq!(sorted.len, 100);
        let all: Vec<(u32, u32)> = (0..100)
            .map(|i| {
                let (chunk, lane) = (i / LANES, i % LANES);
                let path = &sorted.paths[chunk];
                let slot = path.slot[lane];
                assert_eq!(sorted.rays[chunk].o(lane), Vec3::splat(slot as f32));
                assert_eq!(sorted.beta(chunk, lane), Rgb::new(slot as f32, 1.0, 2.0));
                assert_eq!((path.pdf[lane], path.normal[lane]), (slot as f32, slot));
                assert_eq!(path.branch[lane], slot + 1);
                (sorted.octants(chunk)[lane], slot)
            })
            .collect();
        assert!(all.is_sorted(), "{all:?}");
        assert!((0..8).all(|octant| all.iter().any(|(of, _)| *of == octant)));
        let shared = sorted.chunks().filter(|(chunk, lanes)| sorted.share_an_octant(*chunk, *lanes));
        assert!(shared.count() < 7 && !lanes.share_an_octant(0, 3));
    }

    /// Chunks that are followed as a whole, and parts of them, arrive lane by lane in their order.
    #[test]
    fn whole_chunks_are_their_lanes() {
        let numbers: [u32; LANES] = std::array::from_fn(|i| i as u32);
        let of = |k: f32| numbers.map(|i| i as f32 + k);
        let vectors = |k: f32| Vec3s { x: of(k), y: of(k + 1.0), z: of(k + 2.0) };
        let (normal, slot) = (numbers.map(|i| i + 300), numbers.map(|i| i + 500));
        let (o, d, beta, pdf) = (vectors(10.0), vectors(20.0), vectors(30.0), of(0.5));
        let all = Extensions { o, d, beta, pdf, branch: &numbers, normal: &normal, slot: &slot };
        for masks in [[Mask::MAX, Mask::MAX, 0b101], [0b110, Mask::MAX, Mask::MAX]] {
            let mut lanes = Lanes::default();
            masks.into_iter().for_each(|mask| lanes.follow_all(mask, &all));
            let expected: Vec<usize> = masks.into_iter().flat_map(lanes_of).collect();
            assert_eq!(lanes.len, expected.len());
            for (at, from) in expected.into_iter().enumerate() {
                let (chunk, lane) = (at / LANES, at % LANES);
                let (rays, path) = (&lanes.rays[chunk], &lanes.paths[chunk]);
                assert_eq!((rays.o(lane), rays.d(lane)), (o.get(from), d.get(from)));
                assert_eq!((rays.tmin[lane], rays.tmax[lane]), (0.0, f32::INFINITY));
                assert_eq!(lanes.beta(chunk, lane), beta.get(from));
                assert_eq!((path.pdf[lane], path.branch[lane]), (pdf[from], numbers[from]));
                assert_eq!((path.normal[lane], path.slot[lane]), (normal[from], slot[from]));
            }
        }
    }
}
