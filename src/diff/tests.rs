//! Planted faults are found, blamed on the right one, and reproduced; what is sound is called sound.

use super::compare::{Answers, ask};
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
use court::Court;
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
    let faulty = Contestant { backend: "faulty".to_string(), isa, quality, build: Box::new(faulty) };
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
fn planted_faults_are_real_and_blamed_on_the_faulty() {
    let faults = [
        Fault::Drops(seen_corner()),
        Fault::Stretches(1e-3),
        Fault::Stretches(-1e-5),
        Fault::Swaps,
        Fault::Endless,
    ];
    for fault in faults {
        let (report, ..) = found(fault);
        assert!(report.of(Class::Real) > 0, "{fault:?}");
        assert!(report.cases.iter().all(|case| case.wrong == [false, true]), "{fault:?}: {:?}", report.cases);
        assert!(
            report::table(&report).contains("REAL") && report.sentence(&report.cases[0]).contains("faulty")
        );
        let blocked = report.cases.iter().all(|case| matches!(case.answers, Answers::Blocked(_)));
        assert_eq!(blocked, fault == Fault::Endless);
    }
}

/// Files and back, with every bit; asked again, the same two disagree.
#[test]
fn reproducers_fail_on_their_own() {
    let corner = seen_corner();
    for (fault, most) in
        [(Fault::Drops(corner), 2), (Fault::Stretches(1e-3), 1), (Fault::DropsInLarge(corner, 9), 10)]
    {
        let (report, scene, contestants) = found(fault);
        let court = Court::new(&scene.meshes);
        let case = &report.cases[0];
        let made = minimal(case, &court, &scene.meshes, &contestants).unwrap();
        let triangles: usize = made.meshes.iter().map(|m| m.indices.len()).sum();
        assert!(made.fails && triangles <= most, "{fault:?}: {triangles} triangles");
        let folder = tempfile::TempDir::new().unwrap();
        let path = made.write(folder.path(), 1, &report.sentence(case)).unwrap();
        let read = Reproducer::read(&path).unwrap().expect("a case");
        let corners = |r: &Reproducer| -> Vec<[u32; 3]> {
            let all = r.meshes.iter().flat_map(|m| (0..m.indices.len()).flat_map(|t| m.triangle(t)));
            all.map(|p| p.to_array().map(f32::to_bits)).collect()
        };
        assert_eq!(corners(&read), corners(&made));
        let ray = |r: &Reproducer| {
            let rays = &r.rays.chunks[0].rays;
            (rays.o(0), rays.d(0), rays.tmin[0], rays.tmax[0])
        };
        assert_eq!(ray(&read), (case.o, case.d, case.tmin, case.tmax));
        let again = |contestants: &[Contestant]| {
            let all: Vec<&Contestant> = contestants.iter().collect();
            ask(&read.meshes, std::slice::from_ref(&read.rays), &all, &Hooks::NONE).unwrap()
        };
        assert!(again(&contestants).of(Class::Real) > 0, "{fault:?}");
        assert_eq!(again(&pair(Fault::None)).of(Class::Real), 0);
    }
}

#[test]
fn files_that_are_no_reproducer() {
    let folder = tempfile::TempDir::new().unwrap();
    let (case, obj) = (folder.path().join("c.toml"), folder.path().join("c.obj"));
    let text = "[case]\nmesh = \"c.obj\"\norigin = [0, 0, 1]\ndirection = [0, 0, -1]\ntmin = 0\ntmax = inf\n";
    std::fs::write(&obj, "o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let read = |text: &str| {
        std::fs::write(&case, text).unwrap();
        Reproducer::read(&case)
    };
    assert_eq!(read(text).unwrap().unwrap().meshes[0].indices, [[0, 1, 2]]);
    assert!(read("[camera]\nfov = 3\n").unwrap().is_none());
    assert!(read("no TOML").unwrap().is_none());
    for (from, to, said) in [
        ("origin = [0, 0, 1]", "origin = [0, 1]", "case.origin must be three numbers"),
        ("tmin = 0", "tmin = -1", "tmin not negative"),
        ("tmin = 0", "", "case.tmin must be a number"),
        ("c.obj", "d.obj", "d.obj"),
    ] {
        let error = read(&text.replace(from, to)).unwrap_err().to_string();
        assert!(error.contains(said), "{error}");
    }
    for line in ["v 1 2", "v 1 2 nan", "v 1 2 1e30", "f 1 2 4", "f 0 1 2", "g x"] {
        std::fs::write(&obj, format!("o a\nv 0 0 0\nv 1 0 0\nv 0 1 0\n{line}\n")).unwrap();
        let error = read(text).unwrap_err();
        assert_eq!((error.line, error.message.as_str()), (Some(5), "not a line of a reproducer"), "{line}");
    }
}

/// Two triangles of a square at z = 0, and one at z = −1 behind it.
fn square() -> Vec<Arc<Mesh>> {
    let positions = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, -1], [1, 0, -1], [1, 1, -1]];
    let positions = positions.map(|p| p.map(|x: i8| f32::from(x))).to_vec();
    vec![Arc::new(Mesh::new(positions, vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [0, 1, 2]]))]
}

/// Every class by a ray for which it is the answer.
#[test]
fn classes_are_what_the_geometry_says() {
    let court = Court::new(&square());
    let down = |x: f32, y: f32| (Vec3::new(x, y, 1.0), -Vec3::Z);
    let hit = |triangle: u32, t: f32, u: f32, v: f32| Some(Answer { t, u, v, mesh: 0, triangle });
    let judge = |(o, d): (Vec3, Vec3), tmax: f32, pair: [Option<Answer>; 2]| {
        let chunk = &aimed::chunks([(o, d, 0.0, tmax)].into_iter())[0];
        court.closest(&chunk.rays, 0, pair).map(|f| (f.class, f.wrong, f.leak))
    };
    let inf = f32::INFINITY;
    // Within the first triangle and its twin: (0.75, 0.25) is u = 0.5, v = 0.25.
    let (inside, front) = (down(0.75, 0.25), hit(0, 1.0, 0.5, 0.25));
    assert_eq!(judge(inside, inf, [front, front]), None);
    assert_eq!(judge(inside, inf, [front, hit(3, 1.0, 0.5, 0.25)]), Some((Class::Tie, [false; 2], false)));
    assert_eq!(judge(inside, inf, [front, None]), Some((Class::Real, [false, true], false)));
    assert_eq!(
        judge(inside, inf, [front, hit(2, 2.0, 0.5, 0.25)]),
        Some((Class::Real, [false, true], false))
    );
    assert_eq!(judge(inside, 0.5, [front, None]), Some((Class::Real, [true, false], false)));
    assert_eq!(judge(inside, 1.0, [front, None]), Some((Class::Tie, [false; 2], false)));
    assert_eq!(judge(inside, inf, [hit(9, 1.0, 0.5, 0.25), None]), Some((Class::Real, [true, true], false)));
    // The diagonal: a surface on all sides, so that a miss is a leak; the border: none.
    let diagonal = hit(0, 1.0, 0.0, 0.5);
    assert_eq!(
        judge(down(0.5, 0.5), inf, [diagonal, hit(1, 1.0, 0.5, 0.0)]),
        Some((Class::Edge, [false; 2], false))
    );
    assert_eq!(judge(down(0.5, 0.5), inf, [diagonal, None]), Some((Class::Edge, [false; 2], true)));
    assert_eq!(
        judge(down(0.5, 0.0), inf, [hit(0, 1.0, 0.5, 0.0), None]),
        Some((Class::Edge, [false; 2], false))
    );
    assert_eq!(
        judge(down(1.0, 0.0), inf, [hit(0, 1.0, 1.0, 0.0), None]),
        Some((Class::Vertex, [false; 2], false))
    );
    let along = (Vec3::new(-1.0, 0.25, 1e-7), Vec3::X);
    assert_eq!(judge(along, inf, [hit(0, 1.5, 0.25, 0.25), None]), Some((Class::Graze, [false; 2], false)));
    let needle = Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.5, 1e-7, 0.0]], vec![[0, 1, 2]]);
    let chunk = &aimed::chunks([(Vec3::new(0.4, 0.0, 1.0), -Vec3::Z, 0.0, inf)].into_iter())[0];
    let sliver = Court::new(&[Arc::new(needle)]).closest(&chunk.rays, 0, [hit(0, 1.0, 0.4, 0.0), None]);
    assert_eq!(sliver.map(|f| f.class), Some(Class::Sliver));
}

/// Settling moves a ray at an edge across by some tens of roundings; the hit is then one of the moved ray.
#[test]
fn settled_hits_stand_and_wrong_distances_do_not() {
    let steep = Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 4.0]], vec![[0, 1, 2]]);
    let court = Court::new(&[Arc::new(steep)]);
    let chunk = &aimed::chunks([(Vec3::new(0.25, 0.0, 5.0), -Vec3::Z, 0.0, f32::INFINITY)].into_iter())[0];
    let judge = |moved: f32, t: f32| {
        let answer = Answer { t, u: 0.25, v: moved, mesh: 0, triangle: 0 };
        court.closest(&chunk.rays, 0, [Some(answer), None]).map(|f| (f.class, f.wrong))
    };
    // ε·W is 6e-7: moved by a hundred of them, up the slope of 4.
    assert_eq!(judge(6e-5, 5.0 - 2.4e-4), Some((Class::Edge, [false; 2])));
    assert_eq!(judge(6e-5, 5.0 + 2.4e-4), Some((Class::Real, [true, false])));
    assert_eq!(judge(6e-4, 5.0 - 2.4e-3), Some((Class::Real, [true, false])));
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

#[test]
fn coordinates_keep_every_bit_in_files() {
    let corners =
        [[0.1, -1.0 / 3.0, 1e-30], [123_456.79, f32::MIN_POSITIVE, -0.0], [1e18, 16_777_217.0, 2.5e-7]];
    let rays = aimed::chunks([(Vec3::from(corners[0]), Vec3::from(corners[1]), 0.1, 1e18)].into_iter());
    let meshes = vec![Arc::new(Mesh::new(corners.to_vec(), vec![[2, 0, 1]]))];
    let made = Reproducer { meshes, rays: RaySet { kind: Kind::Replay, chunks: rays }, fails: true };
    let folder = tempfile::TempDir::new().unwrap();
    let read = Reproducer::read(&made.write(folder.path(), 7, "").unwrap()).unwrap().unwrap();
    let bits = |r: &Reproducer| r.meshes[0].positions.iter().map(|p| p.map(f32::to_bits)).collect::<Vec<_>>();
    assert_eq!((bits(&read), &read.meshes[0].indices), (bits(&made), &made.meshes[0].indices));
    let ray = |r: &Reproducer| {
        let rays = &r.rays.chunks[0].rays;
        [rays.o(0).to_array(), rays.d(0).to_array(), [rays.tmin[0], rays.tmax[0], 0.0]]
            .map(|v| v.map(f32::to_bits))
    };
    assert_eq!(ray(&read), ray(&made));
}

#[test]
fn shadow_rays_are_judged_by_what_is_in_their_way() {
    let court = Court::new(&square());
    let judge = |x: f32, tmax: f32, pair: [bool; 2]| {
        let chunk = &aimed::chunks([(Vec3::new(x, 0.25, 1.0), -Vec3::Z, 0.0, tmax)].into_iter())[0];
        court.blocked(&chunk.rays, 0, pair).map(|f| (f.class, f.wrong))
    };
    assert_eq!(judge(0.75, 3.0, [true, true]), None);
    assert_eq!(judge(0.75, 3.0, [true, false]), Some((Class::Real, [false, true])));
    assert_eq!(judge(0.75, 0.5, [true, false]), Some((Class::Real, [true, false])));
    assert_eq!(judge(0.75, 1.0, [true, false]), Some((Class::Tie, [false; 2])));
    assert_eq!(judge(1.0, 3.0, [false, true]), Some((Class::Edge, [false; 2])));
    assert_eq!(judge(1.5, 3.0, [false, true]), Some((Class::Real, [false, true])));
}

/// The scan leaves nothing out: it finds what looking at every triangle finds.
#[test]
fn the_scan_finds_what_every_triangle_says() {
    let (scene, _) = scene();
    let brute = crate::accel::brute::Brute::new(&scene.meshes);
    let court = Court::new(&scene.meshes);
    for kind in aimed::KINDS {
        let set = aimed::rays(&scene, kind, 400, 5);
        for chunk in &set.chunks {
            for lane in (0..LANES).filter(|&lane| chunk.mask >> lane & 1 == 1) {
                let ray = crate::accel::brute::Ray64::of(&chunk.rays, lane);
                let slack = crate::accel::judge::ACROSS * f64::from(f32::EPSILON) * 1e-3;
                let mut all = brute.hits_within(&ray, f64::NEG_INFINITY, f64::INFINITY, slack);
                let near: Vec<[u32; 2]> =
                    court.scan().near(&ray).iter().map(|n| [n.mesh, n.triangle]).collect();
                all.retain(|(_, mesh, triangle)| !near.contains(&[*mesh, *triangle]));
                assert!(all.is_empty(), "{}: {all:?}", kind.name());
            }
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
        let counts = |t: &compare::Tally| (t.kind, t.rays, t.same, t.classes, t.hit_miss, t.leaks);
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
