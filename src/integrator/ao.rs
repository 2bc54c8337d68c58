//! Ambient occlusion: the cosine-weighted share of the hemisphere over the first hit that is free.

use super::wave::BatchSink;
use super::{Arrival, Batch, Context, Integrator, Sink};
use crate::bsdf::Scatter;
use crate::light::End;
use crate::math::ray::{Ray, leave};
use crate::math::warp::cosine_hemisphere;
use crate::math::{Rgb, Vec3};

/// Ambient occlusion; 1 where nothing occludes, and where nothing is hit.
#[derive(Clone, Copy, Debug)]
pub struct Ao {
    /// How far an occluder counts, in metres.
    pub distance: f32,
}

impl Integrator for Ao {
    #[inline(always)]
    fn vertices<B: Scatter>(&self, cx: &Context<'_>, batch: &Batch<B>, out: &mut BatchSink<'_>) {
        let dimensions = cx.dimensions.at(batch.depth);
        batch.each(out, |v, _, out| {
            let u = cx.sampler.d2(v.arrival.key, dimensions.bsdf);
            let wi = v.frame.to_world(cosine_hemisphere(u));
            if v.surface.ng.dot(wi) * v.surface.ng.dot(v.wo) > 0.0 {
                let o = leave(v.surface.p, v.surface.error, v.surface.ng, wi);
                out.connect(Ray { o, d: wi, tmax: self.distance }, Rgb::ONE);
            }
        });
    }

    #[inline(always)]
    fn end(&self, _cx: &Context<'_>, end: End, _o: Vec3, _d: Vec3, _arrival: &Arrival, out: &mut impl Sink) {
        if let End::Sky = end {
            out.emit(Rgb::ONE);
        }
    }
}
