//! Embree with nothing around it: recorded rays in its own structures, `rtcIntersect1` or `rtcOccluded1` in a bare
//! loop. The benchmarks' yardstick; nothing else uses it.
//!
//! It lives here and not in `benches/` because it takes raw pointers, and because it must trace the very scene
//! that the backend traces: what the two differ by is then the backend's overhead alone.
#![allow(unsafe_code)]

use super::{Embree, trace};
use crate::accel::{LANES, Mask, Rays};
use embree_sys as sys;

/// Rays to be traced once: the answers overwrite them.
pub struct Closest(Vec<sys::RTCRayHit>);

/// Rays to be asked once whether they hit anything.
pub struct AnyHit(Vec<sys::RTCRay>);

/// Answers.
pub struct Traced<R>(Vec<R>);

impl Closest {
    /// All lanes that pass the gate.
    pub fn new(chunks: &[Rays]) -> Self {
        Closest(sound(chunks).map(|(rays, lane)| trace::query(rays, lane)).collect())
    }

    /// Traces one after the other.
    #[inline(never)]
    pub fn trace(mut self, embree: &Embree) -> Traced<sys::RTCRayHit> {
        // SAFETY: the scene is committed, pointer and length are the vector's, and every ray passed the gate.
        unsafe {
            sys::drt_rtc_intersect1_each(embree.scene.handle(), self.0.as_mut_ptr(), self.0.len());
        }
        Traced(self.0)
    }
}

impl AnyHit {
    /// All lanes that pass the gate.
    pub fn new(chunks: &[Rays]) -> Self {
        AnyHit(sound(chunks).map(|(rays, lane)| trace::ray(rays, lane)).collect())
    }

    /// Traces one after the other.
    #[inline(never)]
    pub fn trace(mut self, embree: &Embree) -> Traced<sys::RTCRay> {
        // SAFETY: as in `Closest::trace`.
        unsafe {
            sys::drt_rtc_occluded1_each(embree.scene.handle(), self.0.as_mut_ptr(), self.0.len());
        }
        Traced(self.0)
    }
}

impl Traced<sys::RTCRayHit> {
    /// How many hit something.
    pub fn hits(&self) -> usize {
        self.0.iter().filter(|query| query.hit.geomID != sys::INVALID_ID).count()
    }
}

impl Traced<sys::RTCRay> {
    /// How many hit something.
    pub fn hits(&self) -> usize {
        self.0.iter().filter(|ray| ray.tfar == f32::NEG_INFINITY).count()
    }
}

/// The rays that Embree may see (`Rays::check` says why).
fn sound(chunks: &[Rays]) -> impl Iterator<Item = (&Rays, usize)> {
    chunks.iter().flat_map(|rays| {
        let active = rays.check(Mask::MAX).active();
        (0..LANES).filter(move |&lane| active >> lane & 1 == 1).map(move |lane| (rays, lane))
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::{BuildOptions, Coherence, Intersector};
    use crate::math::Vec3;
    use crate::shape::Mesh;
    use std::sync::Arc;

    /// Rays straight down at a triangle that covers half of a grid, one of them unfit for Embree.
    #[test]
    fn bare_loop_hits_what_the_backend_hits() -> crate::error::Result<()> {
        let mesh = Mesh::new(vec![[0.0, 0.0, 0.0], [4.1, 0.0, 0.0], [0.0, 0.0, 4.1]], vec![[0, 1, 2]]);
        let embree = Embree::build(&[Arc::new(mesh)], &BuildOptions::default())?;
        let mut rays = Rays::default();
        for lane in 0..LANES {
            let o = Vec3::new((lane % 4) as f32 + 0.5, 1.0, (lane / 4) as f32 + 0.5);
            rays.set(lane, o, Vec3::NEG_Y, 0.0, f32::INFINITY);
        }
        rays.ox[0] = f32::NAN;
        let blocked = embree.occluded(rays.check(Mask::MAX), Coherence::Incoherent).count_ones() as usize;
        let chunks = [rays];
        assert_eq!(blocked, 9);
        assert_eq!(Closest::new(&chunks).trace(&embree).hits(), blocked);
        assert_eq!(AnyHit::new(&chunks).trace(&embree).hits(), blocked);
        Ok(())
    }
}
