//! drt's backends as the renderer uses them: chunks of rays through [`Intersector`].

use crate::contest::{Contestant, Tracer};
use crate::record::RaySet;
use crate::scenes::Scene;
use drt::accel::{Backend, BuildOptions, Coherence, Hits, Intersector, MISS, Mask, Quality, Rays};
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
        Chunks {
            built: backend.build(&scene.meshes, &options).expect("builds"),
            rays: Vec::new(),
            answers: Answers::AnyHit(Vec::new()),
            coherence: Coherence::Incoherent,
        }
    })
}

struct Chunks {
    built: Box<dyn Intersector>,
    rays: Vec<Rays>,
    answers: Answers,
    coherence: Coherence,
}

enum Answers {
    Closest(Vec<Hits>),
    AnyHit(Vec<Mask>),
}

impl Tracer for Chunks {
    fn load(&mut self, set: &RaySet) {
        self.rays = set.chunks.clone();
        self.coherence = set.coherence;
        self.answers = match set.any_hit {
            false => Answers::Closest(vec![Hits::default(); set.chunks.len()]),
            // Ones, since zeroed pages are not there until they are written.
            true => Answers::AnyHit(vec![Mask::MAX; set.chunks.len()]),
        };
    }

    fn trace(&mut self) {
        let Chunks { built, rays, answers, coherence } = self;
        match answers {
            Answers::Closest(hits) => {
                for (rays, hits) in rays.iter().zip(hits) {
                    built.closest(rays.check(Mask::MAX), *coherence, hits);
                }
            }
            Answers::AnyHit(masks) => {
                for (rays, mask) in rays.iter().zip(masks) {
                    *mask = built.occluded(rays.check(Mask::MAX), *coherence);
                }
            }
        }
    }

    fn hits(&self) -> usize {
        match &self.answers {
            Answers::Closest(hits) => hits.iter().flat_map(|h| h.mesh).filter(|&mesh| mesh != MISS).count(),
            Answers::AnyHit(masks) => masks.iter().map(|mask| mask.count_ones() as usize).sum(),
        }
    }

    fn bytes(&self) -> usize {
        self.built.bytes()
    }
}
