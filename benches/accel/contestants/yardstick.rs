//! Embree's single-ray calls in a bare loop over rays that lie ready, on the very scene of the Embree backend
//! (robust, medium quality).

use crate::contest::{Contestant, Tracer, timed};
use crate::record::RaySet;
use crate::scenes::Scene;
use drt::accel::embree::Embree;
use drt::accel::{BuildOptions, Intersector, Mask, Rays};

/// The yardstick.
pub fn contestant() -> Contestant {
    Contestant::new("embree, bare loop", |scene: &Scene, threads| {
        let options = BuildOptions { threads, ..BuildOptions::default() };
        Yardstick(Embree::build(&scene.meshes, &options).expect("builds"))
    })
}

struct Yardstick(Embree);

impl Tracer for Yardstick {
    fn trace(&self, set: &RaySet) -> (f64, usize) {
        let chunks: Vec<(Rays, Mask)> = set.chunks.iter().map(|rays| (rays.clone(), Mask::MAX)).collect();
        let mut bare = self.0.bare(&chunks);
        let seconds = timed(|| if set.any_hit { bare.occluded() } else { bare.closest() });
        (seconds, bare.hits()[set.any_hit as usize])
    }

    fn bytes(&self) -> usize {
        self.0.bytes()
    }
}
