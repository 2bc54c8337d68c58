//! How a wave begins: the rays through its pixels, lane beside lane.

use super::pushed::{Extensions, Pushed, Slot};
use super::{Job, Wave};
use crate::accel::{LANES, Mask};
use crate::film::Film;
use crate::film::rule::Numbers;
use crate::integrator::{Context, Dimensions};
use crate::light::Receiver;
use crate::math::{DVec3, Vec3s};
use crate::sampler::{Key, Keys};

impl Wave {
    /// Camera rays: all samples of a pixel side by side, so that a packet is as coherent as can be.
    #[inline(always)]
    pub(super) fn start<I>(&mut self, job: &Job<'_, I>) {
        let cx = job.cx;
        self.pushed.slots.clear();
        let mut starts = Starts::NONE;
        for pixel in 0..Film::TILE * Film::TILE {
            let x = job.tile[0] * Film::TILE + pixel % Film::TILE;
            let y = job.tile[1] * Film::TILE + pixel / Film::TILE;
            if x >= cx.size[0] || y >= cx.size[1] {
                continue;
            }
            for index in job.samples.clone() {
                let key = cx.sampler.key(y * cx.size[0] + x, index);
                let time = time(cx, key);
                starts.push([x, y], key, time);
                self.pushed.slots.push(Slot { key, pixel, weight: 0.0, time, radiance: DVec3::ZERO });
                if starts.len == LANES {
                    self.set_out(job, &mut starts);
                }
            }
        }
        if starts.len > 0 {
            self.set_out(job, &mut starts);
        }
    }

    /// The camera rays of the last slots, which are those of `starts`.
    #[inline(always)]
    fn set_out<I>(&mut self, job: &Job<'_, I>, starts: &mut Starts) {
        let Pushed { next, slots, .. } = &mut self.pushed;
        let ([o, d], weights) = camera_rays(job.cx, starts);
        let first = slots.len() - starts.len;
        for (slot, weight) in slots[first..].iter_mut().zip(weights) {
            slot.weight = weight * job.part.weight;
        }
        let mut slot = [0; LANES];
        for (lane, slot) in slot.iter_mut().enumerate() {
            *slot = (first + lane) as u32;
        }
        let one = [1.0; LANES];
        let beta = Vec3s { x: one, y: one, z: one };
        let (pdf, branch, normal) = ([f32::INFINITY; LANES], &[0; LANES], &[Receiver::ALL_AROUND; LANES]);
        let lanes = (u32::from(Mask::MAX) >> (LANES - starts.len)) as Mask;
        next.follow_all(lanes, &Extensions { o, d, beta, pdf, branch, normal, slot: &slot });
        starts.len = 0;
    }
}

/// Samples of any pixels, lane beside lane.
struct Starts {
    /// Columns of their pixels.
    x: [u32; LANES],
    /// Rows of their pixels.
    y: [u32; LANES],
    /// Which samples.
    keys: Keys<LANES>,
    /// See [`time`].
    times: [f32; LANES],
    /// How many; the lanes after them mean nothing.
    len: usize,
}

impl Starts {
    /// None.
    const NONE: Starts =
        Starts { x: [0; LANES], y: [0; LANES], keys: Keys::ZERO, times: [0.0; LANES], len: 0 };

    /// Adds a sample, for which there is room.
    #[inline(always)]
    fn push(&mut self, [x, y]: [u32; 2], key: Key, time: f32) {
        (self.x[self.len], self.y[self.len], self.times[self.len]) = (x, y, time);
        self.keys.set(self.len, key);
        self.len += 1;
    }

    /// Lets the lanes after the last repeat it, so that they can be computed as well.
    #[inline(always)]
    fn fill(&mut self) {
        for lane in self.len.max(1)..LANES {
            let last = self.len.max(1) - 1;
            (self.x[lane], self.y[lane], self.times[lane]) = (self.x[last], self.y[last], self.times[last]);
            self.keys.set(lane, self.keys.get(last));
        }
    }
}

/// When a sample is taken: 0 as the shutter opens, before 1 when it closes.
#[inline(always)]
fn time(cx: &Context<'_>, key: Key) -> f32 {
    if cx.moves { cx.sampler.d1(key, cx.dimensions.time) } else { 0.0 }
}

/// The rays' origins and directions through the points that the pixel rule chooses for samples, and their weights.
#[inline(always)]
fn camera_rays(cx: &Context<'_>, starts: &mut Starts) -> ([Vec3s<LANES>; 2], [f32; LANES]) {
    starts.fill();
    let keys = &starts.keys;
    let middle = [[0.5; LANES]; 2];
    let numbers = match cx.pixel.numbers() {
        Numbers::Sampler => cx.sampler.d2_of(keys, Dimensions::PIXEL),
        Numbers::Random => cx.random.d2_of(keys, Dimensions::PIXEL),
        Numbers::None => middle,
    };
    let ([u, v], weights) = cx.pixel.points(&keys.index, &numbers);
    let lens = if cx.camera.has_lens() { cx.sampler.d2_of(keys, Dimensions::LENS) } else { middle };
    let [mut x, mut y] = [[0.0; LANES]; 2];
    let size = cx.size.map(f64::from);
    // In f64: at 100,000 pixels a side f32 leaves 1/128 of a pixel.
    for lane in 0..LANES {
        x[lane] = ((f64::from(starts.x[lane]) + 0.5 + f64::from(u[lane])) / size[0]) as f32;
        y[lane] = ((f64::from(starts.y[lane]) + 0.5 + f64::from(v[lane])) / size[1]) as f32;
    }
    (cx.camera.rays([&x, &y], &lens, &starts.times), weights)
}
