//! What contestants from other crates have in common: triangles in one list, one ray at a time, no packets.

use crate::contest::{Tracer, timed};
use crate::record::RaySet;
use crate::scenes::Scene;
use drt::accel::{LANES, Rays};
use drt::math::Vec3;

/// A structure that traces one ray.
pub trait Single {
    /// The crate's ray.
    type Ray;

    /// The lane of a chunk as its ray.
    fn ray(rays: &Rays, lane: usize) -> Self::Ray;

    /// Distance and triangle of the closest hit.
    fn closest(&self, ray: &Self::Ray) -> Option<(f32, u32)>;

    /// True when anything is hit.
    fn any_hit(&self, ray: &Self::Ray) -> bool;

    /// Bytes of the structure with its triangles.
    fn bytes(&self) -> usize;
}

/// All triangles of a scene.
pub fn triangles(scene: &Scene) -> impl Iterator<Item = [Vec3; 3]> + '_ {
    scene.meshes.iter().flat_map(|mesh| (0..mesh.indices.len()).map(|i| mesh.triangle(i)))
}

/// Runs `build` on at most so many threads (0: all).
pub fn on_threads<T: Send>(threads: usize, build: impl FnOnce() -> T + Send) -> T {
    if threads == 0 {
        return build();
    }
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start").install(build)
}

/// A [`Single`] as a contestant.
pub struct Singles<S>(pub S);

impl<S: Single> Tracer for Singles<S> {
    fn trace(&self, set: &RaySet) -> (f64, usize) {
        let lanes = |rays| (0..LANES).map(move |lane| S::ray(rays, lane));
        let rays: Vec<S::Ray> = set.chunks.iter().flat_map(lanes).collect();
        // No zeroed pages: they are not there until they are written.
        if set.any_hit {
            let mut hits = vec![true; rays.len()];
            let seconds =
                timed(|| hits.iter_mut().zip(&rays).for_each(|(hit, ray)| *hit = self.0.any_hit(ray)));
            return (seconds, hits.iter().filter(|hit| **hit).count());
        }
        let mut hits = vec![Some((1.0, 1)); rays.len()];
        let seconds = timed(|| hits.iter_mut().zip(&rays).for_each(|(hit, ray)| *hit = self.0.closest(ray)));
        (seconds, hits.iter().flatten().count())
    }

    fn bytes(&self) -> usize {
        self.0.bytes()
    }
}
