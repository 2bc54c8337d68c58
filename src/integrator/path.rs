//! Path tracing: the rendering equation, estimated one vertex at a time.

use super::{Arrival, Context, Integrator, Sink, Vertex};
use crate::bsdf::Scatter;
use crate::light::End;
use crate::math::ray::leave;
use crate::math::{Rgb, Vec3, mis};
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
        self.emitted(cx, v, out);
        if depth >= self.max_depth || !cx.scatters(v) {
            return;
        }
        let dimensions = cx.dimensions.at(depth);
        let light_sampled = cx.samples_lights && !bsdf.is_delta();
        if light_sampled {
            self.connect(cx, v, bsdf, out);
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
        let pdf = match self.lights {
            LightSampling::Mis => sample.pdf,
            LightSampling::Bsdf => f32::INFINITY,
            LightSampling::Light if light_sampled => 0.0,
            LightSampling::Light => f32::INFINITY,
        };
        if pdf == 0.0 && depth + 1 == self.max_depth {
            return; // the next vertex could only emit, and that has been counted
        }
        let o = leave(v.surface.p, v.surface.error, v.surface.ng, wi);
        out.extend(o, wi, beta, pdf);
    }

    #[inline(always)]
    fn end(&self, cx: &Context<'_>, end: End, o: Vec3, d: Vec3, arrival: &Arrival, out: &mut impl Sink) {
        let (le, light_pdf) = cx.lights.at_end(end, o, d);
        out.emit(arrival.beta * le * mis::power(arrival.pdf, light_pdf));
    }
}

impl Path {
    /// Light that the surface itself emits, weighted against the chance that light sampling had found it.
    #[inline(always)]
    fn emitted(&self, cx: &Context<'_>, v: &Vertex, out: &mut impl Sink) {
        let le = cx.lights.emitted(v.material, &v.surface, v.wo);
        if le != Rgb::ZERO {
            let pdf = cx.lights.pdf_of_hit(v.material, &v.surface, v.wo, v.t);
            out.emit(v.arrival.beta * le * mis::power(v.arrival.pdf, pdf));
        }
    }

    /// One light sample, weighted against the chance that BSDF sampling finds the same.
    #[inline(always)]
    fn connect<B: Scatter>(&self, cx: &Context<'_>, v: &Vertex, bsdf: &B, out: &mut impl Sink) {
        let dimensions = cx.dimensions.at(v.arrival.depth);
        let choice = cx.sampler.bits(v.arrival.key, dimensions.choice);
        let u = cx.sampler.d2(v.arrival.key, dimensions.light);
        let Some(light) = cx.lights.sample(&v.surface, choice, u) else { return };
        let wi = v.frame.to_local(light.wi);
        let (f_cos, bsdf_pdf) = bsdf.eval(&v.view, wi);
        if f_cos == Rgb::ZERO || !v.on_the_same_side_as(wi, light.wi) {
            return;
        }
        let weight = match self.lights {
            LightSampling::Mis => mis::power(light.pdf, bsdf_pdf),
            LightSampling::Light => 1.0,
            // Only lights that cannot be hit are sampled then.
            LightSampling::Bsdf if light.pdf == f32::INFINITY => 1.0,
            LightSampling::Bsdf => return,
        };
        out.connect(light.shadow, v.arrival.beta * f_cos * light.radiance_over_pdf * weight);
    }
}
