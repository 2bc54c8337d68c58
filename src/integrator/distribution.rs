//! The notes' distribution ray tracer, 13.9: at every hit N directions are chosen on the hemisphere, each is
//! followed, and the sum of ρ·I·cos θ·Δω is what the surface sends back.
//!
//! Where it departs from the notes, and why:
//! - 13.9's sum leaves out the cosine of eq. (18); here it is part of `f_cos`.
//! - Lights that no direction can meet (points, parallel light) and directions that only a mirror or glass can
//!   choose are terms of their own, the "special parts of the integral" of 13.7.
//! - Light that a surface emits is added where a ray meets it: eq. (1) leaves emission to the light sources.
//! - The recursion runs over waves: a vertex pushes its N rays, and what they bring is added to the pixel at once,
//!   times the product of all weights on the way.

use super::wave::BatchSink;
use super::{Arrival, Batch, Context, Extension, Integrator, Sink, Vertex};
use super::{competing_pdf, connect, emitted, emitted_at_end};
use crate::bsdf::Scatter;
use crate::error::Result;
use crate::light::{End, Receiver};
use crate::math::ray::leave;
use crate::math::{Rgb, Vec3};
use crate::quadrature::hemisphere::{Fan, HemisphereRule};
use crate::sampler::{Key, Sampler, SamplerKind, scatter};
use crate::scene::{Directions, LightSampling, Settings};

/// distRtShade with a rule for the hemisphere and a number of directions for every depth.
#[derive(Clone, Debug)]
pub struct Distribution {
    max_depth: u32,
    lights: LightSampling,
    importance: bool,
    /// Numbers for the rule's directions.
    numbers: Sampler,
    /// By depth; the last one for all deeper hits.
    fans: Vec<Fan>,
    /// By depth: into how many branches a sample has split when it gets there. Wraps, and only spreads numbers.
    nodes: Vec<u64>,
}

impl Distribution {
    /// Depths whose branches are told apart by their count; deeper ones go on with the last.
    const DEPTHS: usize = 64;

    /// `rule` with `directions` by depth; `settings` for the rest.
    ///
    /// # Errors
    /// More directions than can be followed; see [`Directions::check`].
    pub fn new(rule: HemisphereRule, directions: &Directions, settings: &Settings) -> Result<Distribution> {
        directions.check(rule, settings.max_depth)?;
        let fans: Vec<Fan> =
            directions.cells().iter().map(|cells| Fan::new(rule, *cells)).collect::<Result<_>>()?;
        let mut nodes = vec![1u64];
        for depth in 0..Self::DEPTHS {
            let count = u64::from(rule.count(directions.at(depth)));
            nodes.push(nodes[depth].wrapping_mul(count));
        }
        let kind = match rule {
            HemisphereRule::Sobol { .. } => SamplerKind::Sobol,
            _ => SamplerKind::Random,
        };
        Ok(Distribution {
            max_depth: settings.max_depth,
            lights: settings.lights,
            importance: rule == HemisphereRule::Importance,
            numbers: Sampler::new(kind, settings.seed, settings.spp),
            fans,
            nodes,
        })
    }

    #[inline(always)]
    fn fan(&self, depth: u32) -> &Fan {
        &self.fans[(depth as usize).min(self.fans.len() - 1)]
    }
}

impl Integrator for Distribution {
    fn fan_out(&self, _cx: &Context<'_>, depth: u32) -> u32 {
        // Both sides of a surface that light passes, and a ray to every light or along every delta.
        2 * self.fan(depth).count() + 2
    }

    #[inline(always)]
    fn vertices<B: Scatter>(&self, cx: &Context<'_>, batch: &Batch<B>, out: &mut BatchSink<'_>) {
        batch.each(out, |v, bsdf, out| self.vertex(cx, v, bsdf, out));
    }

    #[inline(always)]
    fn end(&self, cx: &Context<'_>, end: End, o: Vec3, d: Vec3, arrival: &Arrival, out: &mut impl Sink) {
        emitted_at_end(cx, end, o, d, arrival, out);
    }
}

impl Distribution {
    #[inline(always)]
    fn vertex<B: Scatter>(&self, cx: &Context<'_>, v: &Vertex, bsdf: &B, out: &mut impl Sink) {
        emitted(cx, v, out);
        if v.arrival.depth >= self.max_depth || !cx.scatters(v.material, v.view.outside) {
            return;
        }
        let fan = self.fan(v.arrival.depth);
        self.follow_deltas(v, bsdf, fan.count(), out);
        if bsdf.is_delta() {
            return;
        }
        for light in cx.lights.deltas(&v.surface) {
            connect(self.lights, v, bsdf, &light, 1.0, out);
        }
        let dimensions = cx.dimensions.at(v.arrival.depth);
        if self.importance {
            for k in 0..fan.count() {
                let (branch, key) = self.branch(v, fan.count(), k);
                self.importance(cx, v, bsdf, branch, key, out);
            }
            return;
        }
        for k in 0..fan.count() {
            let (branch, key) = self.branch(v, fan.count(), k);
            let (wi, solid_angle) = fan.direction(k, self.numbers.d2(key, dimensions.bsdf));
            shade(v, bsdf, wi, solid_angle, branch, out);
            if bsdf.transmits() {
                shade(v, bsdf, Vec3::new(wi.x, wi.y, -wi.z), solid_angle, scatter(branch), out);
            }
        }
    }
}

/// One term of eq. (18): ρ·(n·d_i)·Δω times what comes along d_i, which the ray will tell. A direction of
/// weight zero is followed as well, so that rays are as many as the rule says.
#[inline(always)]
fn shade<B: Scatter>(
    v: &Vertex,
    bsdf: &B,
    wi_local: Vec3,
    solid_angle: f32,
    branch: u32,
    out: &mut impl Sink,
) {
    let wi = v.frame.to_world(wi_local);
    if !v.facing().on_the_same_side_as(wi_local, wi) {
        return; // the shading normal's hemisphere, but not the surface's
    }
    let (f_cos, _) = bsdf.eval(&v.view, wi_local);
    let o = leave(v.surface.p, v.surface.error, v.surface.ng, wi);
    out.extend(Extension {
        o,
        d: wi,
        beta: v.arrival.beta * f_cos * solid_angle,
        pdf: f32::INFINITY,
        normal: Receiver::ALL_AROUND,
        branch,
    });
}

impl Distribution {
    /// Child `k` of `count` of the branch at `v`, and the key of its numbers.
    #[inline(always)]
    fn branch(&self, v: &Vertex, count: u32, k: u32) -> (u32, Key) {
        let branch = v.arrival.branch.wrapping_mul(count).wrapping_add(k);
        let nodes = self.nodes[(v.arrival.depth as usize + 1).min(Self::DEPTHS)];
        (branch, self.numbers.branch(v.arrival.key, nodes, branch))
    }

    /// Mirrors, glass and smooth coats: every direction that they choose gets a branch of its own.
    #[inline(always)]
    fn follow_deltas<B: Scatter>(&self, v: &Vertex, bsdf: &B, count: u32, out: &mut impl Sink) {
        let [first, second] = bsdf.deltas(&v.view);
        let (branch, _) = self.branch(v, count, 0);
        // Beside a fan of directions the branches of the deltas must be others than the fan's.
        let branch = if bsdf.is_delta() { branch } else { scatter(!branch) };
        for (delta, branch) in [(first, branch), (second, scatter(branch))] {
            let Some(delta) = delta else { continue };
            let d = v.frame.to_world(delta.wi);
            if v.facing().on_the_same_side_as(delta.wi, d) {
                let o = leave(v.surface.p, v.surface.error, v.surface.ng, d);
                let beta = v.arrival.beta * delta.weight;
                let normal = Receiver::ALL_AROUND;
                out.extend(Extension { o, d, beta, pdf: f32::INFINITY, normal, branch });
            }
        }
    }

    /// Direction k by importance sampling, eq. (20), with the BSDF's density, the lights' density, or both under
    /// multiple importance sampling.
    #[inline(always)]
    fn importance<B: Scatter>(
        &self,
        cx: &Context<'_>,
        v: &Vertex,
        bsdf: &B,
        branch: u32,
        key: Key,
        out: &mut impl Sink,
    ) {
        let depth = v.arrival.depth;
        let share = 1.0 / self.fan(depth).count() as f32;
        let dimensions = cx.dimensions.at(depth);
        let mut normal = Receiver::ALL_AROUND;
        if cx.samples_lights {
            let (from, packed) = cx.lights.receiver(&v.surface, v.wo, bsdf.transmits());
            normal = packed;
            let choice = if cx.lights.has_choice() { self.numbers.bits(key, dimensions.choice) } else { 0 };
            let u = self.numbers.d2(key, dimensions.light);
            if let Some(light) = cx.lights.sample(&v.surface, &from, choice, v.arrival.time, u) {
                connect(self.lights, v, bsdf, &light, share, out);
            }
        }
        let lobe = if cx.has_lobes { self.numbers.d1(key, dimensions.lobe) } else { 0.0 };
        let Some(sample) = bsdf.sample(&v.view, self.numbers.d2(key, dimensions.bsdf), lobe) else { return };
        if sample.pdf == f32::INFINITY {
            return; // deltas have been followed
        }
        let d = v.frame.to_world(sample.wi);
        let pdf = competing_pdf(self.lights, cx.samples_lights, sample.pdf);
        // At the last depth a ray of density zero has nothing left to find.
        if !v.facing().on_the_same_side_as(sample.wi, d)
            || (pdf == 0.0 && depth + 1 == self.max_depth && !cx.lights.has_unsampled)
        {
            return;
        }
        let o = leave(v.surface.p, v.surface.error, v.surface.ng, d);
        let beta: Rgb = v.arrival.beta * sample.weight * share;
        out.extend(Extension { o, d, beta, pdf, normal, branch });
    }
}
