//! What the vertices of a wave push: the next rays, the shadow rays, and radiance for the samples.

use crate::integrator::lanes::Lanes;
use crate::integrator::{Extension, Sink};
use crate::math::ray::Ray;
use crate::math::{DVec3, Rgb};
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
    pub pushed: &'a mut Pushed,
    /// The path's sample.
    pub slot: u32,
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
