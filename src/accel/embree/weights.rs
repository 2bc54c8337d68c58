//! The weights of hits on triangles that Embree takes to be too small to divide by.
//!
//! Its robust test leaves u and v at 0 where the sum of the edge functions, which grows with the triangle's area and
//! the direction's length, is below 1e-18: t is right then, but the point would be the first corner.

use crate::accel::brute::{Measure, Ray64};
use crate::accel::{Hits, LANES, MISS, Mask, Rays};
use crate::math::Vec3;

/// Computes the weights of hits that have none in f64. A true hit at a first corner stays one.
#[inline(always)]
pub(super) fn weigh(corners: impl Fn(&Hits, usize) -> [Vec3; 3], rays: &Rays, active: Mask, hits: &mut Hits) {
    for lane in 0..LANES {
        let no_weights = hits.u[lane] == 0.0 && hits.v[lane] == 0.0;
        if active >> lane & 1 == 1 && hits.mesh[lane] != MISS && no_weights {
            let corners = corners(hits, lane).map(|p| p.as_dvec3());
            if let Some(m) = Measure::of(&Ray64::of(rays, lane), corners) {
                let (u, v) = (m.u.clamp(0.0, 1.0), m.v.clamp(0.0, 1.0));
                let scale = 1.0 / (u + v).max(1.0);
                (hits.u[lane], hits.v[lane]) = ((u * scale) as f32, (v * scale) as f32);
            }
        }
    }
}
