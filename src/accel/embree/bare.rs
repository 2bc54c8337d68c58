//! Embree by itself, for measurements: the yardstick that the backend's own cost is held against
//! (`benches/embree.rs`), and the ways that `trace.rs` chooses from.
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
