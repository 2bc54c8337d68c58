//! What the vertices of a wave push: the next rays, the shadow rays, and radiance for the samples.

use crate::accel::{LANES, Mask};
use crate::bsdf::Scatter;
use crate::integrator::lanes::Lanes;
use crate::integrator::{Batch, Extension, Sink};
use crate::light::LightSamples;
use crate::math::ray::Ray;
use crate::math::{DVec3, Rgb, Vec3s};
use crate::sampler::Key;

/// One sample of one pixel.
#[derive(Clone, Copy, Debug)]
pub struct Slot {
    /// Which one.
    pub key: Key,
    /// Its place in the tile.
    pub pixel: u32,
    /// Its weight by the pixel rule.
    pub weight: f32,
    /// When it is taken: 0 as the shutter opens, before 1 when it closes.
    pub time: f32,
    /// What has come along its paths so far; in f64, since thousands of branches may add up.
    pub radiance: DVec3,
}

/// The wave's sink: the next rays, the shadow rays and the samples' radiance.
#[derive(Debug, Default)]
pub struct Pushed {
    /// The rays to follow.
    pub next: Lanes,
    /// The shadow rays, with the radiance that each lets through.
    pub shadows: Lanes,
    /// The samples.
    pub slots: Vec<Slot>,
}

/// The sink as one path sees it.
pub struct PathSink<'a> {
    /// Of the wave.
    pub(super) pushed: &'a mut Pushed,
    /// The path's sample.
    pub(super) slot: u32,
}

impl Sink for PathSink<'_> {
    #[inline(always)]
    fn emit(&mut self, radiance: Rgb) {
        self.pushed.slots[self.slot as usize].radiance += radiance.as_dvec3();
    }

    #[inline(always)]
    fn connect(&mut self, shadow: Ray, radiance: Rgb) {
        self.pushed.shadows.push(shadow, radiance, self.slot);
    }

    #[inline(always)]
    fn extend(&mut self, next: Extension) {
        self.pushed.next.follow(next, self.slot);
    }
}

/// Rays to follow, lane beside lane.
#[derive(Clone, Debug)]
pub struct Extensions<'a> {
    /// See [`Extension::o`].
    pub o: Vec3s<LANES>,
    /// See [`Extension::d`].
    pub d: Vec3s<LANES>,
    /// See [`Extension::beta`].
    pub beta: Vec3s<LANES>,
    /// See [`Extension::pdf`].
    pub pdf: [f32; LANES],
    /// See [`Extension::branch`].
    pub branch: &'a [u32; LANES],
    /// See [`Extension::normal`].
    pub normal: &'a [u32; LANES],
    /// Their samples.
    pub slot: &'a [u32; LANES],
}

impl<'a> Extensions<'a> {
    /// To be filled.
    #[inline(always)]
    pub fn new(slot: &'a [u32; LANES], branch: &'a [u32; LANES], normal: &'a [u32; LANES]) -> Self {
        let zero = Vec3s::ZERO;
        Extensions { o: zero, d: zero, beta: zero, pdf: [0.0; LANES], branch, normal, slot }
    }

    /// Sets a lane's direction, throughput (of which `share` goes there) and density by the BSDF's sample. False when there is
    /// none, or it would go through the surface. `SMALL`: [`Scatter::is_small`] holds.
    #[inline(always)]
    pub fn sample<B: Scatter, const SMALL: bool>(
        &mut self,
        batch: &Batch<B>,
        lane: usize,
        u: [f32; 2],
        lobe: f32,
        share: f32,
    ) -> bool {
        let facing = batch.facing(lane);
        let (sample, some) = if SMALL {
            batch.bsdf[lane].sample_small(&facing.view, u)
        } else {
            let Some(sample) = batch.bsdf[lane].sample(&facing.view, u, lobe) else { return false };
            (sample, true)
        };
        let wi = facing.frame.to_world(sample.wi);
        self.d.set(lane, wi);
        self.beta.set(lane, facing.beta * (sample.weight * share));
        self.pdf[lane] = sample.pdf;
        some & facing.on_the_same_side_as(sample.wi, wi)
    }
}

/// The wave's sink as a batch of paths sees it.
pub struct BatchSink<'a> {
    /// Of the wave.
    pub(super) pushed: &'a mut Pushed,
}

impl BatchSink<'_> {
    /// The sink of one path.
    #[inline(always)]
    pub fn path(&mut self, slot: u32) -> PathSink<'_> {
        PathSink { pushed: self.pushed, slot }
    }

    /// [`Sink::connect`] of `lanes`, whose samples are `slot`.
    #[inline(always)]
    pub fn connect(
        &mut self,
        lanes: Mask,
        lights: &LightSamples<LANES>,
        radiance: &Vec3s<LANES>,
        slot: &[u32; LANES],
    ) {
        self.pushed.shadows.push_all(lanes, lights, radiance, slot);
    }

    /// [`Sink::extend`] of `lanes`.
    #[inline(always)]
    pub fn extend(&mut self, lanes: Mask, next: &Extensions<'_>) {
        self.pushed.next.follow_all(lanes, next);
    }
}
