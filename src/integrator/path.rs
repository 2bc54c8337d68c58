//! Path tracing: the rendering equation, estimated one vertex at a time.

use super::{Arrival, Context, Extension, Integrator, Sink, Vertex};
use super::{competing_pdf, connect, emitted, emitted_at_end};
use crate::bsdf::Scatter;
use crate::light::{End, Receiver};
use crate::math::Vec3;
use crate::math::ray::leave;
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

impl Integrator for Path {
    #[inline(always)]
    fn vertex<B: Scatter>(&self, cx: &Context<'_>, v: &Vertex, bsdf: &B, out: &mut impl Sink) {
        let Arrival { beta, depth, key, .. } = v.arrival;
        emitted(cx, v, out);
        if depth >= self.max_depth || !cx.scatters(v) {
            return;
        }
        let dimensions = cx.dimensions.at(depth);
        let light_sampled = cx.samples_lights && !bsdf.is_delta();
        let mut normal = Receiver::ALL_AROUND;
        if light_sampled {
            let (from, packed) = cx.lights.receiver(&v.surface, v.wo, bsdf.transmits());
            normal = packed;
            let choice = if cx.lights.has_choice() { cx.sampler.bits(key, dimensions.choice) } else { 0 };
            let u = cx.sampler.d2(key, dimensions.light);
            if let Some(light) = cx.lights.sample(&v.surface, &from, choice, u) {
                connect(self.lights, v, bsdf, &light, 1.0, out);
            }
        }

        // The hemisphere integral of eq. (1) by importance sampling, eq. (20), with the BSDF's density.
        let u = cx.sampler.d2(key, dimensions.bsdf);
        let lobe = if cx.has_lobes { cx.sampler.d1(key, dimensions.lobe) } else { 0.0 };
        let Some(sample) = bsdf.sample(&v.view, u, lobe) else { return };
        let wi = v.frame.to_world(sample.wi);
        if !v.on_the_same_side_as(sample.wi, wi) {
            return;
        }
        let mut beta = beta * sample.weight;
        if self.roulette && depth + 1 >= ROULETTE_FROM {
            let keep = SOFTNESS * beta.max_element();
            if keep < 1.0 {
                if cx.sampler.d1(key, dimensions.roulette) >= keep {
                    return;
                }
                beta /= keep;
            }
        }
        let pdf = competing_pdf(self.lights, light_sampled, sample.pdf);
        if pdf == 0.0 && depth + 1 == self.max_depth && !cx.has_moving_lamps {
            return; // the next vertex could only emit, and that has been counted
        }
        let o = leave(v.surface.p, v.surface.error, v.surface.ng, wi);
        out.extend(Extension { o, d: wi, beta, pdf, normal, branch: 0 });
    }

    #[inline(always)]
    fn end(&self, cx: &Context<'_>, end: End, o: Vec3, d: Vec3, arrival: &Arrival, out: &mut impl Sink) {
        emitted_at_end(cx, end, o, d, arrival, out);
    }
}
