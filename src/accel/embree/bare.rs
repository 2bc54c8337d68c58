//! Embree by itself, for measurements: the yardstick that the backend's own cost is held against
//! (`benches/accel`, `benches/embree.rs`), and the ways that `trace.rs` chooses from.
#![allow(unsafe_code)]

use super::Embree;
use super::trace;
pub use super::trace::Way;
use crate::accel::{Checked, Hits, LANES, Mask, Rays};
use embree_sys as sys;

/// Rays in Embree's own layout, ready to be traced once by a loop in C.
pub struct Bare<'a> {
    embree: &'a Embree,
    closest: Vec<sys::RTCRayHit>,
    any: Vec<sys::RTCRay>,
    /// Whether closest hits, any hits have been asked.
    asked: [bool; 2],
}

impl Embree {
    /// Lays out the lanes of `chunks` that are asked and sound.
    pub fn bare(&self, chunks: &[(Rays, Mask)]) -> Bare<'_> {
        let lanes = || {
            chunks.iter().flat_map(|(rays, mask)| {
                let active = rays.check(*mask).active();
                (0..LANES).filter(move |lane| active >> lane & 1 == 1).map(move |lane| (rays, lane))
            })
        };
        let closest = lanes().map(|(rays, lane)| trace::ray_hit(rays, lane)).collect();
        let any = lanes().map(|(rays, lane)| trace::ray(rays, lane)).collect();
        Bare { embree: self, closest, any, asked: [false; 2] }
    }

    /// Closest hits as Embree gives them, by the way that is named: neither named nor settled.
    pub fn closest_by(&self, way: Way, rays: Checked<'_>, hits: &mut Hits) {
        let _ = trace::closest_by(way, &self.scene, self.width, rays, hits);
    }

    /// The active lanes that hit anything, by the way that is named.
    pub fn occluded_by(&self, way: Way, rays: Checked<'_>) -> Mask {
        trace::occluded_by(way, &self.scene, self.width, rays)
    }
}

impl Bare<'_> {
    /// How many rays there are.
    pub fn len(&self) -> usize {
        self.any.len()
    }

    /// True when there is none.
    pub fn is_empty(&self) -> bool {
        self.any.is_empty()
    }

    /// `rtcIntersect1` on all of them, the first time.
    pub fn closest(&mut self) {
        if std::mem::replace(&mut self.asked[0], true) {
            return;
        }
        // SAFETY: the scene is committed, the structures are Embree's own, every ray passed the gate.
        unsafe {
            sys::drt_rtc_intersect_each(
                self.embree.scene.handle(),
                self.closest.as_mut_ptr(),
                self.closest.len(),
            );
        }
    }

    /// `rtcOccluded1` on all of them, the first time.
    pub fn occluded(&mut self) {
        if std::mem::replace(&mut self.asked[1], true) {
            return;
        }
        // SAFETY: as above.
        unsafe {
            sys::drt_rtc_occluded_each(self.embree.scene.handle(), self.any.as_mut_ptr(), self.any.len());
        }
    }

    /// How many rays have hit something so far: closest hits and blocked ones.
    pub fn hits(&self) -> [usize; 2] {
        let closest = self.closest.iter().filter(|q| q.hit.geomID != sys::INVALID_ID).count();
        [closest, self.any.iter().filter(|q| q.tfar == f32::NEG_INFINITY).count()]
    }
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
    fn the_bare_loop_hits_what_the_backend_hits() -> crate::error::Result<()> {
        let mesh = Mesh::new(vec![[0.0, 0.0, 0.0], [4.1, 0.0, 0.0], [0.0, 0.0, 4.1]], vec![[0, 1, 2]]);
        let embree = Embree::build(&[Arc::new(mesh)], &BuildOptions::default())?;
        let mut rays = Rays::default();
        for lane in 0..LANES {
            let o = Vec3::new((lane % 4) as f32 + 0.5, 1.0, (lane / 4) as f32 + 0.5);
            rays.set(lane, o, Vec3::NEG_Y, 0.0, f32::INFINITY);
        }
        rays.ox[0] = f32::NAN;
        let blocked = embree.occluded(rays.check(Mask::MAX), Coherence::Incoherent).count_ones() as usize;
        let chunks = [(rays, Mask::MAX)];
        let mut bare = embree.bare(&chunks);
        assert_eq!((bare.len(), bare.hits()), (15, [0, 0]));
        bare.closest();
        bare.occluded();
        assert_eq!((blocked, bare.hits()), (9, [9, 9]));
        Ok(())
    }
}
