//! How a wave begins: the rays through its pixels, lane beside lane.

use super::pushed::{Extensions, Pushed, Slot};
use super::{Job, Wave};
use crate::accel::{LANES, Mask};
use crate::film::Film;
use crate::film::rule::Numbers;
use crate::integrator::{Context, Dimensions};
use crate::light::Receiver;
use crate::math::{DVec3, Vec3s};
use crate::sampler::Keys;

impl Wave {
    /// Camera rays: all samples of a pixel side by side, so that a packet is as coherent as can be.
    #[inline(always)]
    pub(super) fn start<I>(&mut self, job: &Job<'_, I>) {
        let cx = job.cx;
        self.pushed.slots.clear();
        for pixel in 0..Film::TILE * Film::TILE {
            let x = job.tile[0] * Film::TILE + pixel % Film::TILE;
            let y = job.tile[1] * Film::TILE + pixel / Film::TILE;
            if x >= cx.size[0] || y >= cx.size[1] {
                continue;
            }
            for index in job.samples.clone() {
                let key = cx.sampler.key(y * cx.size[0] + x, index);
                let time = if cx.moves { cx.sampler.d1(key, cx.dimensions.time) } else { 0.0 };
                self.pushed.slots.push(Slot { key, pixel, weight: 0.0, time, radiance: DVec3::ZERO });
            }
        }
        for first in (0..self.pushed.slots.len()).step_by(LANES) {
            self.set_out(job, first);
        }
    }

    /// The camera rays of up to [`LANES`] samples from number `first`, and the weights that the pixel rule gives them.
    #[inline(always)]
    fn set_out<I>(&mut self, job: &Job<'_, I>, first: usize) {
        let Pushed { next, slots, .. } = &mut self.pushed;
        let len = LANES.min(slots.len() - first);
        let [mut x, mut y, mut slot] = [[0; LANES]; 3];
        let (mut keys, mut times) = (Keys::ZERO, [0.0; LANES]);
        for lane in 0..LANES {
            // Lanes after the last repeat it: they can be computed as well.
            let Slot { key, pixel, time, .. } = slots[first + lane.min(len - 1)];
            (x[lane], y[lane]) = (pixel % Film::TILE, pixel / Film::TILE);
            (times[lane], slot[lane]) = (time, (first + lane) as u32);
            keys.set(lane, key);
        }
        let corner = job.tile.map(|at| at * Film::TILE);
        let ([o, d], weights) = camera_rays(job.cx, corner, [&x, &y], &keys, &times);
        for (slot, weight) in slots[first..first + len].iter_mut().zip(weights) {
            slot.weight = weight * job.part.weight;
        }
        let one = [1.0; LANES];
        let beta = Vec3s { x: one, y: one, z: one };
        let (pdf, branch, normal) = ([f32::INFINITY; LANES], &[0; LANES], &[Receiver::ALL_AROUND; LANES]);
        let lanes = (u32::from(Mask::MAX) >> (LANES - len)) as Mask;
        next.follow_all(lanes, &Extensions { o, d, beta, pdf, branch, normal, slot: &slot });
    }
}

/// The rays' origins and directions through the points that the pixel rule chooses for samples, and their weights.
/// Their pixels are (`x`, `y`) from that at the tile's `corner`.
#[inline(always)]
fn camera_rays(
    cx: &Context<'_>,
    corner: [u32; 2],
    [x, y]: [&[u32; LANES]; 2],
    keys: &Keys<LANES>,
    times: &[f32; LANES],
) -> ([Vec3s<LANES>; 2], [f32; LANES]) {
    let middle = [[0.5; LANES]; 2];
    let numbers = match cx.pixel.numbers() {
        Numbers::Sampler => cx.sampler.d2_of(keys, Dimensions::PIXEL),
        Numbers::Random => cx.random.d2_of(keys, Dimensions::PIXEL),
        Numbers::None => middle,
    };
    let ([u, v], weights) = cx.pixel.points(&keys.index, &numbers);
    let lens = if cx.camera.has_lens() { cx.sampler.d2_of(keys, Dimensions::LENS) } else { middle };
    let [mut across, mut down] = [[0.0; LANES]; 2];
    let size = cx.size.map(f64::from);
    // In f64: at 100,000 pixels a side f32 leaves 1/128 of a pixel.
    for lane in 0..LANES {
        across[lane] = ((f64::from(corner[0] + x[lane]) + 0.5 + f64::from(u[lane])) / size[0]) as f32;
        down[lane] = ((f64::from(corner[1] + y[lane]) + 0.5 + f64::from(v[lane])) / size[1]) as f32;
    }
    (cx.camera.rays([&across, &down], &lens, times), weights)
}
