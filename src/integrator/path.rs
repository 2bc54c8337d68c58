//! Path tracing: the rendering equation, estimated one vertex at a time.

use super::wave::{BatchSink, Extensions};
use super::{Arrival, Batch, Context, Integrator, Sink};
use super::{brought, competing_pdf, emitted, emitted_at_end};
use crate::accel::{LANES, Mask, lanes_of};
use crate::bsdf::Scatter;
use crate::light::{End, LightSample, Receiver};
use crate::math::ray::leave;
use crate::math::soa::{lanes_where, mask};
use crate::math::{Rgb, Vec3, Vec3s};
use crate::sampler::Keys;
use crate::scene::LightSampling;

/// Path tracing with next-event estimation, multiple importance sampling and Russian roulette.
#[derive(Clone, Copy, Debug)]
pub struct Path {
    /// Scattering events at most.
    pub max_depth: u32,
    /// Which sampling finds the lights.
    pub lights: LightSampling,
    /// End dim paths at random, unbiased.
    pub roulette: bool,
}

/// Roulette keeps a path with probability min(1, 2.5·throughput): dim paths go on long enough not to turn
/// into rare bright ones.
const SOFTNESS: f32 = 2.5;

/// Roulette begins with the ray that follows this many scattering events.
const ROULETTE_FROM: u32 = 3;

/// One of the paths into which the samples of a batch split at a vertex.
struct Branch {
    /// Where each lane's numbers come from.
    keys: Keys<LANES>,
    /// See [`Arrival::branch`].
    numbers: [u32; LANES],
    /// Its share of what the vertex sends on.
    share: f32,
    /// The lanes that took a light sample, and their receivers' packed normals.
    lit: Mask,
    normals: [u32; LANES],
}

impl Integrator for Path {
    const BY_MODEL: bool = true;

    fn fan_out(&self, cx: &Context<'_>, depth: u32) -> u32 {
        if depth == 0 { cx.splits.most() } else { 1 }
    }

    #[inline(always)]
    fn vertices<B: Scatter>(&self, cx: &Context<'_>, batch: &Batch<B>, out: &mut BatchSink<'_>) {
        let shining = batch.lanes & lanes_where::<LANES>(|lane| cx.lights.emits(batch.material[lane]));
        for lane in lanes_of(shining) {
            emitted(cx, &batch.vertex(lane), &mut out.path(batch.slot[lane]));
        }
        if batch.depth >= self.max_depth {
            return;
        }
        let alive =
            batch.lanes & lanes_where::<LANES>(|lane| cx.scatters(batch.material[lane], batch.outside[lane]));
        let rough = alive & !lanes_where::<LANES>(|lane| batch.bsdf[lane].is_delta());
        let split = if batch.depth == 0 && batch.paths.first > 0 { rough } else { 0 };
        let last = if split != 0 { batch.paths.paths } else { 0 };
        let (lit, normals) = (0, [Receiver::ALL_AROUND; LANES]);
        let mut branch = Branch { keys: batch.keys, numbers: batch.branch, share: 1.0, lit, normals };
        // One loop and one place for each call: all of it is compiled into this function, once a BSDF.
        for number in 0..=last {
            if number > 0 {
                self.branch_off(cx, batch, number, &mut branch);
            }
            let lanes = if number == 0 { alive & !split } else { split };
            // Branches share one light sample where another would take next to no error away.
            let rough = match number {
                0 if cx.splits_light_samples => rough & !split,
                0 => rough,
                _ if cx.splits_light_samples => split,
                _ => 0,
            };
            if cx.samples_lights && rough != 0 {
                self.connect(cx, batch, &mut branch, rough, out);
            }
            if lanes != 0 {
                self.extend(cx, batch, &branch, lanes, out);
            }
        }
    }

    #[inline(always)]
    fn end(&self, cx: &Context<'_>, end: End, o: Vec3, d: Vec3, arrival: &Arrival, out: &mut impl Sink) {
        emitted_at_end(cx, end, o, d, arrival, out);
    }
}

impl Path {
    /// Goes over to branch `number`, from 1, of every lane.
    #[inline(always)]
    fn branch_off<B: Scatter>(&self, cx: &Context<'_>, batch: &Batch<B>, number: u32, branch: &mut Branch) {
        let number = batch.paths.first + number - 1;
        for lane in 0..LANES {
            branch.keys.set(lane, cx.branched(batch.keys.get(lane), number));
        }
        (branch.numbers, branch.share) = ([number; LANES], 1.0 / batch.paths.paths as f32);
    }

    /// Next-event estimation at the lanes `rough`: a light sample each.
    #[inline(always)]
    fn connect<B: Scatter>(
        &self,
        cx: &Context<'_>,
        batch: &Batch<B>,
        branch: &mut Branch,
        rough: Mask,
        out: &mut BatchSink<'_>,
    ) {
        let dimensions = cx.dimensions.at(batch.depth);
        let mut choices = [0; LANES];
        if cx.lights.has_choice() {
            choices = cx.sampler.bits_of(&branch.keys, dimensions.choice);
            for (lane, normal) in branch.normals.iter_mut().enumerate() {
                let all_around = batch.bsdf[lane].transmits();
                *normal = cx.lights.receiver(&batch.surface.get(lane), batch.wo.get(lane), all_around).1;
            }
        }
        let u = cx.sampler.d2_of(&branch.keys, dimensions.light);
        let lights = cx.lights.sample_all(&batch.surface, &branch.normals, &choices, &batch.time, &u, rough);
        let mut radiance = Vec3s::ZERO;
        let mut arrives = [false; LANES];
        if batch.is_small() {
            for (lane, arrives) in arrives.iter_mut().enumerate() {
                let (brought, some) = self.brought::<B, true>(batch, branch, lane, &lights.get(lane));
                *arrives = some;
                radiance.set(lane, brought);
            }
        } else {
            for lane in lanes_of(lights.lanes) {
                let (brought, some) = self.brought::<B, false>(batch, branch, lane, &lights.get(lane));
                arrives[lane] = some;
                radiance.set(lane, brought);
            }
        }
        out.connect(lights.lanes & mask(&arrives), &lights, &radiance, &batch.slot);
        branch.lit = rough;
    }

    /// What a lane's light sample brings, if the second is true.
    #[inline(always)]
    fn brought<B: Scatter, const SMALL: bool>(
        &self,
        batch: &Batch<B>,
        branch: &Branch,
        lane: usize,
        light: &LightSample,
    ) -> (Rgb, bool) {
        brought::<B, SMALL>(self.lights, &batch.facing(lane), &batch.bsdf[lane], light, branch.share)
    }

    /// Follows the lanes `alive`: the hemisphere integral of eq. (1) by importance sampling, eq. (20), with the BSDF's
    /// density.
    #[inline(always)]
    fn extend<B: Scatter>(
        &self,
        cx: &Context<'_>,
        batch: &Batch<B>,
        branch: &Branch,
        mut alive: Mask,
        out: &mut BatchSink<'_>,
    ) {
        let dimensions = cx.dimensions.at(batch.depth);
        let u = cx.sampler.d2_of(&branch.keys, dimensions.bsdf);
        let lobe = if cx.has_lobes { cx.sampler.d1_of(&branch.keys, dimensions.lobe) } else { [0.0; LANES] };
        let mut next = Extensions::new(&batch.slot, &branch.numbers, &branch.normals);
        let mut goes_on = [false; LANES];
        if batch.is_small() {
            for lane in 0..LANES {
                let u = [u[0][lane], u[1][lane]];
                goes_on[lane] = next.sample::<B, true>(batch, lane, u, lobe[lane], branch.share);
            }
        } else {
            for lane in lanes_of(alive) {
                let u = [u[0][lane], u[1][lane]];
                goes_on[lane] = next.sample::<B, false>(batch, lane, u, lobe[lane], branch.share);
            }
        }
        alive &= mask(&goes_on);
        if self.roulette && batch.depth + 1 >= ROULETTE_FROM {
            let numbers = cx.sampler.d1_of(&branch.keys, dimensions.roulette);
            alive &= roulette(batch.paths.paths, &numbers, &branch.numbers, &mut next.beta);
        }
        let last = batch.depth + 1 == self.max_depth && !cx.lights.has_unsampled;
        for lane in lanes_of(alive) {
            next.pdf[lane] = competing_pdf(self.lights, branch.lit >> lane & 1 == 1, next.pdf[lane]);
            // The next vertex could only emit, and that has been counted.
            alive &= !(Mask::from(next.pdf[lane] == 0.0 && last) << lane);
        }
        for lane in 0..LANES {
            let s = batch.surface.get(lane);
            next.o.set(lane, leave(s.p, s.error, s.ng, next.d.get(lane)));
        }
        out.extend(alive, &next);
    }
}

/// Ends dim paths at random, and makes up for it in the others' throughput. The lanes that go on.
#[inline(always)]
fn roulette(splits: u32, numbers: &[f32; LANES], branches: &[u32; LANES], beta: &mut Vec3s<LANES>) -> Mask {
    let mut kept = [false; LANES];
    for lane in 0..LANES {
        let b = beta.get(lane);
        // A branch's throughput holds its share of the sample.
        let whole = if branches[lane] == 0 { 1.0 } else { splits as f32 };
        let keep = SOFTNESS * whole * b.max_element();
        beta.set(lane, if keep < 1.0 { b / keep } else { b });
        let ends = numbers[lane] >= keep; // never when `keep` is no number: that sample will be counted
        kept[lane] = !ends;
    }
    mask(&kept)
}
