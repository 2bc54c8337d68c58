//! What the study promises, on a contestant with planted faults; the rest by story.

mod faults;
mod files;
mod verdicts;

use super::compare::ask;
use super::court::Court;
use super::outcome::{Answers, Tally};
use super::reproducer::{Reproducer, minimal};
use super::*;
use crate::accel::judge::Answer;
use crate::accel::{
    Backend, BuildOptions, Checked, Coherence, Hits, Intersector, LANES, MISS, Mask, Quality,
};
use crate::error::Result;
use crate::math::Vec3;
use crate::math::isa::Isa;
use crate::scene::{Scene, Settings};
use crate::shape::Mesh;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// What is wrong with a [`Faulty`].
#[derive(Clone, Copy, Debug, PartialEq)]
enum Fault {
    None,
    /// Misses the triangle with a corner here.
    Drops(Vec3),
    /// t too large by this share.
    Stretches(f32),
    /// Barycentrics exchanged.
    Swaps,
    /// Shadow rays never end.
    Endless,
    /// As `Drops`, but only where the mesh has more than this many triangles.
    DropsInLarge(Vec3, usize),
}

/// The hierarchy with a fault.
struct Faulty {
    accel: Box<dyn Intersector>,
    meshes: Vec<Arc<Mesh>>,
    fault: Fault,
}

impl Faulty {
    fn drops(&self, mesh: u32, triangle: u32) -> bool {
        let triangles: usize = self.meshes.iter().map(|m| m.indices.len()).sum();
        let corner = match self.fault {
            Fault::Drops(corner) => corner,
            Fault::DropsInLarge(corner, least) if triangles > least => corner,
            _ => return false,
        };
        mesh != MISS && self.meshes[mesh as usize].triangle(triangle as usize)[0] == corner
    }
}

impl Intersector for Faulty {
    fn closest(&self, rays: Checked<'_>, coherence: Coherence, hits: &mut Hits) {
        self.accel.closest(rays, coherence, hits);
        for lane in (0..LANES).filter(|&lane| rays.active() >> lane & 1 == 1) {
            if self.drops(hits.mesh[lane], hits.triangle[lane]) {
                hits.mesh[lane] = MISS;
            }
            match self.fault {
                Fault::Stretches(share) => hits.t[lane] *= 1.0 + share,
                Fault::Swaps => std::mem::swap(&mut hits.u[lane], &mut hits.v[lane]),
                _ => {}
            }
        }
    }

    fn occluded(&self, rays: Checked<'_>, coherence: Coherence) -> Mask {
        let mut rays_without_end = rays.rays().clone();
        if self.fault == Fault::Endless {
            rays_without_end.tmax = [f32::INFINITY; LANES];
        }
        self.accel.occluded(rays_without_end.check(rays.active()), coherence)
    }

    fn bytes(&self) -> usize {
        self.accel.bytes()
    }

    fn isa(&self) -> &str {
        "faulty"
    }
}

/// The hierarchy, and the hierarchy with `fault`.
fn pair(fault: Fault) -> Vec<Contestant> {
    let faulty = move |meshes: &[Arc<Mesh>], options: &BuildOptions<'_>| -> Result<Box<dyn Intersector>> {
        let accel = Backend::Bvh.build(meshes, options)?;
        Ok(Box::new(Faulty { accel, meshes: meshes.to_vec(), fault }))
    };
    let (isa, quality) = (Isa::best(), Quality::Medium);
    let faulty =
        Contestant { backend: "faulty".to_string(), isa, quality, counts: true, build: Box::new(faulty) };
    vec![Contestant::of(Backend::Bvh, isa, quality), faulty]
}

/// A closed rough ball.
fn scene() -> (Scene, Settings) {
    let loaded = crate::load::scene("scenes/ball.obj".as_ref(), crate::load::Options::default()).unwrap();
    (loaded.scene, loaded.settings)
}

fn found(fault: Fault) -> (Report, Scene, Vec<Contestant>) {
    let ((scene, settings), contestants) = (scene(), pair(fault));
    let report = run(&scene, &settings, &contestants, 3000, &Hooks::NONE).unwrap();
    assert!(report.complete);
    for outcome in &report.outcomes {
        for tally in &outcome.tallies {
            assert_eq!(tally.rays, tally.same + tally.classes.iter().sum::<u64>());
        }
    }
    (report, scene, contestants)
}

/// The corner of a triangle that a camera ray meets.
fn seen_corner() -> Vec3 {
    let (scene, settings) = scene();
    let accel = Backend::Bvh.build(&scene.meshes, &BuildOptions::default()).unwrap();
    let sets = rays::record(&scene, &settings, &*accel, 500, &|| false).unwrap().unwrap();
    let mut hits = Hits::default();
    let chunk = &sets[0].chunks[sets[0].chunks.len() / 2];
    accel.closest(chunk.rays.check(chunk.mask), Coherence::Coherent, &mut hits);
    let lane = (0..LANES).find(|&lane| hits.mesh[lane] != MISS).expect("a hit");
    scene.meshes[hits.mesh[lane] as usize].triangle(hits.triangle[lane] as usize)[0]
}

#[test]
fn what_is_sound_is_called_sound() {
    let (report, ..) = found(Fault::None);
    assert_eq!(report.of(Class::Real), 0);
    let tallies = &report.outcomes[1].tallies;
    assert_eq!(tallies.len(), 7);
    assert!(tallies.iter().all(|t| t.same == t.rays && t.rays > 0), "{tallies:?}");
    assert!(report.rays.iter().all(|(_, rays)| *rays <= 3000), "{:?}", report.rays);
}

#[test]
fn no_more_rays_are_recorded_than_asked_for() {
    let (scene, settings) = scene();
    let accel = Backend::Bvh.build(&scene.meshes, &BuildOptions::default()).unwrap();
    for most in [1, 50, 333] {
        for set in rays::record(&scene, &settings, &*accel, most, &|| false).unwrap().unwrap() {
            assert!((1..=most).contains(&set.len()), "{} of {most}: {}", set.kind.name(), set.len());
        }
    }
}

/// The same rays and counts on any number of threads.
#[test]
fn nothing_but_time_depends_on_threads() {
    let (scene, settings) = scene();
    let on = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let all = pair(Fault::Stretches(1e-3));
        let report = pool.install(|| run(&scene, &settings, &all, 2000, &Hooks::NONE)).unwrap();
        let counts = |t: &Tally| (t.kind, t.rays, t.same, t.classes, t.hit_miss, t.leaks);
        let tallies: Vec<_> = report.outcomes.iter().flat_map(|o| o.tallies.iter().map(counts)).collect();
        (tallies, report.cases.iter().map(|c| report.sentence(c)).collect::<Vec<_>>())
    };
    assert_eq!(on(1), on(3));
}

#[test]
fn a_stop_keeps_what_is_finished() {
    let (scene, settings) = scene();
    let share = AtomicUsize::new(0);
    let progress = |part: f64| share.store((part * 1000.0) as usize, Ordering::Relaxed);
    let hooks = Hooks { progress: &progress, stop: &|| share.load(Ordering::Relaxed) > 700 };
    let report = run(&scene, &settings, &pair(Fault::None), 1000, &hooks).unwrap();
    assert!(!report.complete);
    assert_eq!(report.outcomes[0].tallies.len(), 7);
    assert!(report.outcomes.get(1).is_none_or(|outcome| outcome.tallies.len() < 7));
}

/// A contestant asked for comparison only: what it does wrong is counted, but is no failure and no case.
#[test]
fn what_does_not_count_is_shown_and_no_failure() {
    let (scene, settings) = scene();
    let mut contestants = pair(Fault::Swaps);
    contestants[1].counts = false;
    let report = run(&scene, &settings, &contestants, 1000, &Hooks::NONE).unwrap();
    assert!(report.of(Class::Real) > 0);
    assert_eq!((report.failures(), report.cases.len()), (0, 0));
    // Unless it is the one that the others are compared with.
    contestants.swap(0, 1);
    let report = run(&scene, &settings, &contestants, 1000, &Hooks::NONE).unwrap();
    assert_eq!(report.failures(), report.of(Class::Real));
    assert!(!report.cases.is_empty());
}

#[test]
fn contestants_are_named_by_their_words() {
    let names = |list: &str| -> Vec<String> {
        Contestant::named(list).unwrap().iter().map(Contestant::name).collect()
    };
    let all = names("all");
    assert_eq!(all.len(), Contestant::all().len());
    assert!(names("bvh").iter().all(|name| name.starts_with("bvh ")) && names("bvh").len() >= 3);
    // In the order of `all`, whatever the list's; each once.
    let both = names("bvh-low, bvh-medium, bvh-low");
    assert_eq!(both, all.iter().filter(|n| both.contains(n)).cloned().collect::<Vec<_>>());
    let usual: Vec<String> = Contestant::usual().iter().map(Contestant::name).collect();
    assert_eq!(usual[0], all[0]);
    #[cfg(feature = "embree")]
    {
        assert!(names("embree").len() > names("embree-fast").len());
        assert_eq!(names("fast"), names("embree-fast"));
        assert!(Contestant::all().iter().all(|c| c.counts != c.backend.contains("fast")));
        assert!(Contestant::named("bvh-fast").err().unwrap().message.contains("bvh-fast"));
    }
    let error = Contestant::named("bhv").err().unwrap();
    assert!(error.message.contains("bhv") && error.advice.unwrap_or_default().contains("bvh"));
}
