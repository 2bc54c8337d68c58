//! drt's backends as the renderer uses them: chunks of rays through [`Intersector`].

use crate::contest::{Contestant, Tracer, timed};
use crate::record::RaySet;
use crate::scenes::Scene;
use drt::accel::{Backend, BuildOptions, Hits, Intersector, MISS, Mask, Quality};
use drt::math::isa::Isa;

/// Every backend, in every quality on this machine's best instruction set and in medium quality on the others.
pub fn contestants() -> Vec<Contestant> {
    let mut all = Vec::new();
    for &backend in Backend::ALL {
        for isa in Isa::ALL.into_iter().rev().filter(|&isa| isa <= Isa::best()) {
            for quality in [Quality::Medium, Quality::Low, Quality::High] {
                if quality == Quality::Medium || isa == Isa::best() {
                    all.push(contestant(backend, isa, quality));
                }
            }
        }
    }
    all
}

fn contestant(backend: Backend, isa: Isa, quality: Quality) -> Contestant {
    let name = format!("{} {} {}", backend.name(), quality.name(), isa.name());
    Contestant::new(name, move |scene: &Scene, threads| {
        let options = BuildOptions { isa: Some(isa), quality, threads, ..BuildOptions::default() };
        Chunks(backend.build(&scene.meshes, &options).expect("builds"))
    })
}

struct Chunks(Box<dyn Intersector>);

impl Tracer for Chunks {
    fn trace(&self, set: &RaySet) -> (f64, usize) {
        // Copied, as everybody's rays are; and no zeroed pages, which are not there until they are written.
        let rays = set.chunks.clone();
        if set.any_hit {
            let mut masks = vec![Mask::MAX; rays.len()];
            let seconds = timed(|| {
                for (rays, mask) in rays.iter().zip(&mut masks) {
                    *mask = self.0.occluded(rays.check(Mask::MAX), set.coherence);
                }
            });
            return (seconds, masks.iter().map(|mask| mask.count_ones() as usize).sum());
        }
        let mut hits = vec![Hits::default(); rays.len()];
        let seconds = timed(|| {
            for (rays, hits) in rays.iter().zip(&mut hits) {
                self.0.closest(rays.check(Mask::MAX), set.coherence, hits);
            }
        });
        (seconds, hits.iter().flat_map(|h| h.mesh).filter(|&mesh| mesh != MISS).count())
    }

    fn bytes(&self) -> usize {
        self.0.bytes()
    }
}
