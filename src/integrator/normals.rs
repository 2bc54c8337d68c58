//! Shading normals as colours.

use super::wave::BatchSink;
use super::{Arrival, Batch, Context, Integrator, Sink};
use crate::bsdf::Scatter;
use crate::light::End;
use crate::math::Vec3;

/// (n+1)/2 of the shading normal on the viewer's side; black where nothing is hit.
#[derive(Clone, Copy, Debug)]
pub struct Normals;

impl Integrator for Normals {
    #[inline(always)]
    fn vertices<B: Scatter>(&self, _cx: &Context<'_>, batch: &Batch<B>, out: &mut BatchSink<'_>) {
        batch.each(out, |v, _, out| out.emit((v.frame.n + Vec3::ONE) * 0.5));
    }

    #[inline(always)]
    fn end(
        &self,
        _cx: &Context<'_>,
        _end: End,
        _o: Vec3,
        _d: Vec3,
        _arrival: &Arrival,
        _out: &mut impl Sink,
    ) {
    }
}
