//! Embree's single-ray calls in a bare loop over rays that lie ready, on the very scene of the Embree backend
//! (robust, medium quality).

use crate::contest::{Contestant, Tracer};
use crate::record::RaySet;
use crate::scenes::Scene;
use drt::accel::embree::Embree;
use drt::accel::embree::bare::{AnyHit, Closest};
use drt::accel::{BuildOptions, Intersector};

/// The yardstick.
pub fn contestant() -> Contestant {
    Contestant::new("embree, bare loop", |scene: &Scene, threads| {
        let options = BuildOptions { threads, ..BuildOptions::default() };
        let built = Embree::build(&scene.meshes, &options).expect("builds");
        Bare { built, work: Work::None }
    })
}

struct Bare {
    built: Embree,
    work: Work,
}

enum Work {
    None,
    Closest(Closest),
    AnyHit(AnyHit),
    Done(Box<dyn Fn() -> usize>),
}

impl Tracer for Bare {
    fn load(&mut self, set: &RaySet) {
        self.work = match set.any_hit {
            false => Work::Closest(Closest::new(&set.chunks)),
            true => Work::AnyHit(AnyHit::new(&set.chunks)),
        };
    }

    fn trace(&mut self) {
        self.work = match std::mem::replace(&mut self.work, Work::None) {
            Work::Closest(rays) => {
                let traced = rays.trace(&self.built);
                Work::Done(Box::new(move || traced.hits()))
            }
            Work::AnyHit(rays) => {
                let traced = rays.trace(&self.built);
                Work::Done(Box::new(move || traced.hits()))
            }
            other => other,
        };
    }

    fn hits(&self) -> usize {
        if let Work::Done(hits) = &self.work { hits() } else { 0 }
    }

    fn bytes(&self) -> usize {
        self.built.bytes()
    }
}
