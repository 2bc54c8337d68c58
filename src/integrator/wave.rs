//! Waves: some hundreds of paths advanced together, in chunks of [`LANES`] lanes.
//!
//! A wave is one tile of the picture times one block of samples, formed from the full picture's fixed grid,
//! so that it is the same wave, and the same bits, whatever is cropped, resumed or run in parallel. It
//! repeats `extend` (closest hits) → `shade` (lanes grouped by BSDF, each vertex pushing into the next
//! chunks, which also compacts them) → `connect` (shadow rays) until no path is left. It knows no physics.

mod first;
mod gather;
mod pushed;
mod start;

use super::cutout;
use super::lanes::{Lanes, Paths};
use super::{Arrival, Context, Integrator, RenderStats};
use crate::accel::{Checked, Coherence, Hits, Intersector, LANES, MISS, Mask, lanes_of};
use crate::bsdf::{Bsdf, Material, Scatter};
use crate::film::Tile;
use crate::light::{End, sphere};
use crate::math::DVec3;
use crate::sampler::Part;
use first::{first_hit, first_hit_of_lamp};
use gather::{Traced, batch};
pub use pushed::{BatchSink, Extensions, PathSink};
use pushed::{Pushed, Slot};
use std::ops::Range;
use std::time::Instant;

/// The lanes of a wave by what they met: no mesh, then one group a BSDF.
#[derive(Debug, Default)]
struct Groups {
    of: [Vec<u32>; 1 + Bsdf::NAMES.len()],
}

/// Rays that a piece of a wave may push in one step, about: 4 MB.
const PIECE: usize = 1 << 16;

/// Buffers of one thread, kept from wave to wave.
#[derive(Debug, Default)]
pub struct Wave {
    current: Lanes,
    hits: Vec<Hits>,
    groups: Groups,
    pushed: Pushed,
    /// Rays that wait, with their depths, the deepest last.
    waiting: Vec<(u32, Lanes)>,
    /// Empty buffers.
    spare: Vec<Lanes>,
    /// What was counted since [`Wave::take_stats`].
    stats: RenderStats,
}

/// What one wave is made of.
pub struct Job<'a, I> {
    /// The picture.
    pub cx: &'a Context<'a>,
    /// The mathematics.
    pub integrator: &'a I,
    /// Who intersects.
    pub accel: &'a dyn Intersector,
    /// The tile's column and row.
    pub tile: [u32; 2],
    /// The block of samples.
    pub samples: Range<u32>,
    /// Which of their paths.
    pub part: Part,
    /// True when first hits go to the film's layers.
    pub layers: bool,
    /// Asked before every step; `true` gives the wave up.
    pub stop: &'a (dyn Fn() -> bool + Sync),
}

impl Wave {
    /// What was counted since the last call.
    pub fn take_stats(&mut self) -> RenderStats {
        std::mem::take(&mut self.stats)
    }

    /// Traces the wave of `job` and adds its samples to `tile`. False when it was given up: the tile is of no use then.
    ///
    /// The deepest rays go first, and where a vertex sends out many a few at a time, so that what waits is at most
    /// one piece's offspring a depth.
    #[inline(always)]
    pub fn run<I: Integrator>(&mut self, job: &Job<'_, I>, tile: &mut Tile) -> bool {
        let mut clock = Instant::now();
        self.start(job);
        self.stats.rest_seconds += lap(&mut clock);
        let mut piece = self.next_piece(job, 0);
        while let Some(depth) = piece {
            if (job.stop)() {
                self.give_up();
                return false;
            }
            self.extend(job, depth);
            self.stats.intersect_seconds += lap(&mut clock);
            self.group(job.cx, depth);
            self.shade(job, depth, tile);
            self.stats.shade_seconds += lap(&mut clock);
            self.connect(job);
            self.stats.intersect_seconds += lap(&mut clock);
            piece = self.next_piece(job, depth + 1);
        }
        self.finish(job, tile);
        self.stats.rest_seconds += lap(&mut clock);
        true
    }

    /// Forgets the rays under way.
    fn give_up(&mut self) {
        self.current.len = 0;
        self.pushed.next.len = 0;
        self.spare.extend(self.waiting.drain(..).map(|(_, lanes)| lanes));
    }

    /// Makes the next rays to trace the current ones: what was pushed for `depth`, or else what waits. Says how
    /// deep they are.
    #[inline(always)]
    fn next_piece<I: Integrator>(&mut self, job: &Job<'_, I>, mut depth: u32) -> Option<u32> {
        std::mem::swap(&mut self.current, &mut self.pushed.next);
        self.pushed.next.len = 0;
        if self.current.len == 0 {
            let (of, lanes) = self.waiting.pop()?;
            self.spare.push(std::mem::replace(&mut self.current, lanes));
            depth = of;
        }
        let fan_out = job.integrator.fan_out(job.cx, depth) as usize;
        let most = (PIECE / fan_out).max(LANES);
        if fan_out > 1 && self.current.len > most {
            let mut rest = self.spare.pop().unwrap_or_default();
            std::mem::swap(&mut self.current, &mut rest);
            rest.split_off(most, &mut self.current);
            self.waiting.push((depth, rest));
        }
        Some(depth)
    }

    #[inline(always)]
    fn extend<I: Integrator>(&mut self, job: &Job<'_, I>, depth: u32) {
        let by_octants = depth > 0 && job.accel.gains_from_octants();
        if by_octants && self.current.len > LANES {
            let mut sorted = self.spare.pop().unwrap_or_default();
            self.current.sort_by_octant(&mut sorted);
            self.spare.push(std::mem::replace(&mut self.current, sorted));
        }
        let counter = if depth == 0 { &mut self.stats.camera_rays } else { &mut self.stats.bounce_rays };
        *counter += self.current.len as u64;
        self.hits.resize(self.current.rays.len().max(self.hits.len()), Hits::default());
        for (chunk, mask) in self.current.chunks() {
            let times = times(job.cx, &self.current.paths[chunk], mask, &self.pushed.slots);
            let rays: Checked<'_> = self.current.rays[chunk].check(mask).at(&times);
            if rays.rejected() > 0 {
                self.stats.rejected_rays += u64::from(rays.rejected());
                self.hits[chunk].mesh = [MISS; LANES];
            }
            let coherent = depth == 0 || (by_octants && self.current.share_an_octant(chunk, mask));
            let coherence = if coherent { Coherence::Coherent } else { Coherence::Incoherent };
            job.accel.closest(rays, coherence, &mut self.hits[chunk]);
            if !job.cx.lights.spheres.is_empty() {
                sphere::closest(&job.cx.lights.spheres, rays, &mut self.hits[chunk]);
            }
            if job.cx.has_cutouts {
                let (hits, path) = (&mut self.hits[chunk], &self.current.paths[chunk]);
                let slots = &self.pushed.slots;
                let counts = |lane: usize, hits: &Hits, opacity| {
                    let key = slots[path.slot[lane] as usize].key;
                    let hit = [hits.mesh[lane], hits.triangle[lane]];
                    cutout::counts(job.cx, key, [depth, path.branch[lane]], hit, opacity)
                };
                self.stats.bounce_rays += cutout::pass(job.cx, job.accel, rays, hits, counts);
            }
        }
    }

    /// Sorts lanes by what they met, keeping their order within a group.
    #[inline(always)]
    fn group(&mut self, cx: &Context<'_>, depth: u32) {
        for group in &mut self.groups.of {
            group.clear();
        }
        for i in 0..self.current.len {
            let hits = &self.hits[i / LANES];
            let (mesh, triangle) = (hits.mesh[i % LANES], hits.triangle[i % LANES]);
            let group = if mesh & sphere::SPHERE != 0 {
                0 // a lamp, or nothing at all
            } else {
                let material = cx.material(mesh, triangle);
                let path = &self.current.paths[i / LANES];
                let key = self.pushed.slots[path.slot[i % LANES] as usize].key;
                let part = cx.part(material, key, depth, path.branch[i % LANES]);
                1 + cx.materials[part as usize].bsdf.kind()
            };
            self.groups.of[group].push(i as u32);
        }
    }

    #[inline(always)]
    fn shade<I: Integrator>(&mut self, job: &Job<'_, I>, depth: u32, tile: &mut Tile) {
        let groups = std::mem::take(&mut self.groups);
        for &i in &groups.of[0] {
            let (chunk, lane) = (i as usize / LANES, i as usize % LANES);
            let (arrival, slot) = self.arrival(chunk, lane, depth);
            let rays = &self.current.rays[chunk];
            let (o, d) = (rays.o(lane), rays.d(lane));
            let end = match self.hits[chunk].mesh[lane] {
                MISS => End::Sky,
                lamp => End::Sphere(lamp & !sphere::SPHERE),
            };
            if depth == 0
                && job.layers
                && let End::Sphere(i) = end
            {
                let hit =
                    first_hit_of_lamp(&job.cx.lights.spheres[i as usize], o, d, self.hits[chunk].t[lane]);
                tile.add_first_hit(self.pushed.slots[slot as usize].pixel as usize, arrival.key.index, &hit);
            }
            job.integrator.end(job.cx, end, o, d, &arrival, &mut PathSink { pushed: &mut self.pushed, slot });
        }
        macro_rules! shade_kind {
            ($group:expr, $kind:path) => {
                self.shade_group(job, depth, tile, &groups.of[$group], |material| match &material.bsdf {
                    $kind(bsdf) => Some(bsdf),
                    _ => None,
                })
            };
        }
        if I::BY_MODEL {
            shade_kind!(1, Bsdf::Diffuse);
            shade_kind!(2, Bsdf::Mirror);
            shade_kind!(3, Bsdf::Conductor);
            shade_kind!(4, Bsdf::Phong);
            shade_kind!(5, Bsdf::Dielectric);
            shade_kind!(6, Bsdf::Translucent);
            shade_kind!(7, Bsdf::OrenNayar);
            shade_kind!(8, Bsdf::Plastic);
            shade_kind!(9, Bsdf::Principled);
        } else {
            for group in &groups.of[1..] {
                self.shade_group(job, depth, tile, group, |material| Some(&material.bsdf));
            }
        }
        self.groups = groups;
    }

    /// Shades one group with code compiled for its BSDF.
    #[inline(always)]
    fn shade_group<I: Integrator, B: Scatter + Clone>(
        &mut self,
        job: &Job<'_, I>,
        depth: u32,
        tile: &mut Tile,
        group: &[u32],
        bsdf: impl Fn(&Material) -> Option<&B>,
    ) {
        for of in group.chunks(LANES) {
            let (slots, part) = (&self.pushed.slots, job.part);
            let traced = Traced { lanes: &self.current, hits: &self.hits, slots, part };
            let Some(batch) = batch(job.cx, &traced, depth, of, &bsdf) else { continue };
            if depth == 0 && job.layers {
                for lane in lanes_of(batch.lanes) {
                    let (v, pixel) = (batch.vertex(lane), self.pushed.slots[batch.slot[lane] as usize].pixel);
                    tile.add_first_hit(pixel as usize, v.arrival.key.index, &first_hit(job.cx, &v));
                }
            }
            job.integrator.vertices(job.cx, &batch, &mut BatchSink { pushed: &mut self.pushed });
        }
    }

    #[inline(always)]
    fn arrival(&self, chunk: usize, lane: usize, depth: u32) -> (Arrival, u32) {
        let path = &self.current.paths[chunk];
        let slot = path.slot[lane];
        let Slot { key, time, .. } = self.pushed.slots[slot as usize];
        let (beta, branch) = (self.current.beta(chunk, lane), path.branch[lane]);
        let (pdf, normal) = (path.pdf[lane], path.normal[lane]);
        (Arrival { beta, pdf, normal, depth, branch, time, key }, slot)
    }

    /// Traces the shadow rays; what is free reaches its sample.
    #[inline(always)]
    fn connect<I: Integrator>(&mut self, job: &Job<'_, I>) {
        let Pushed { shadows, slots, .. } = &mut self.pushed;
        self.stats.shadow_rays += shadows.len as u64;
        for (chunk, mask) in shadows.chunks() {
            let times = times(job.cx, &shadows.paths[chunk], mask, slots);
            let rays = shadows.rays[chunk].check(mask).at(&times);
            self.stats.rejected_rays += u64::from(rays.rejected());
            let mut open = rays.active();
            if !job.cx.lights.spheres.is_empty() {
                open &= !sphere::occluded(&job.cx.lights.spheres, rays);
            }
            let blocked = job.accel.occluded(rays, Coherence::Incoherent);
            let slot = |lane: usize| shadows.paths[chunk].slot[lane] as usize;
            for lane in lanes_of(open & !blocked) {
                slots[slot(lane)].radiance += shadows.beta(chunk, lane).as_dvec3();
            }
            if job.cx.has_cutouts && open & blocked != 0 {
                let (share, traced) = cutout::transmittance(job.cx, job.accel, rays, open & blocked);
                self.stats.shadow_rays += traced;
                for lane in lanes_of(open & blocked) {
                    let passed = shadows.beta(chunk, lane).as_dvec3() * f64::from(share[lane]);
                    slots[slot(lane)].radiance += passed;
                }
            }
        }
        shadows.len = 0;
    }

    /// Adds the samples to the film; one that is not a colour is dropped and counted (it adds black).
    #[inline(always)]
    fn finish<I>(&mut self, job: &Job<'_, I>, tile: &mut Tile) {
        for slot in &self.pushed.slots {
            let c = slot.radiance;
            let sound = c.is_finite() && c.min_element() >= 0.0;
            self.stats.invalid_samples += u64::from(!sound);
            // Scaled rather than cut, so that a clamped sample keeps its hue.
            let excess = (c.max_element() / job.cx.brightest).max(1.0);
            let radiance = if sound { c / excess } else { DVec3::ZERO };
            tile.add(slot.pixel as usize, radiance, slot.weight, !job.part.again);
        }
    }
}

/// When the rays of a chunk are under way.
#[inline(always)]
fn times(cx: &Context<'_>, paths: &Paths, mask: Mask, slots: &[Slot]) -> [f32; LANES] {
    let mut times = [0.0; LANES];
    if cx.moves {
        for lane in lanes_of(mask) {
            times[lane] = slots[paths.slot[lane] as usize].time;
        }
    }
    times
}

/// Seconds since `clock`, which is set to now.
#[inline]
fn lap(clock: &mut Instant) -> f64 {
    let now = Instant::now();
    let seconds = now.duration_since(*clock).as_secs_f64();
    *clock = now;
    seconds
}
