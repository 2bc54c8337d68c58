//! Asking everybody and comparing each with the first.

use super::contestants::Contestant;
use super::court::{Class, Court, Finding};
use super::rays::{Chunk, Kind, RaySet};
use super::{Hooks, aimed, rays};
use crate::accel::brute::Ray64;
use crate::accel::judge::Answer;
use crate::accel::{Coherence, Hits, Intersector, LANES, Mask};
use crate::error::Result;
use crate::math::Vec3;
use crate::math::isa::Isa;
use crate::scene::{Scene, Settings};
use crate::shape::Mesh;
use rayon::prelude::*;
use std::sync::Arc;
use std::time::Instant;

/// Real disagreements that a contestant keeps in full, a kind of ray.
pub const KEPT: usize = 3;

/// All that was found.
#[derive(Clone, Debug)]
pub struct Report {
    /// How many rays of each kind were asked.
    pub rays: Vec<(Kind, u64)>,
    /// What each contestant did; the first is the one that the others are compared with.
    pub outcomes: Vec<Outcome>,
    /// The first real disagreements.
    pub cases: Vec<Case>,
    /// False when it was stopped before the last contestant.
    pub complete: bool,
}

/// What one contestant did.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Backend, instruction set, quality.
    pub name: String,
    /// The backend's name.
    pub backend: String,
    /// The instruction set.
    pub isa: Isa,
    /// The build's quality.
    pub quality: &'static str,
    /// Wall time of the build.
    pub build_seconds: f64,
    /// Bytes of the structure.
    pub bytes: usize,
    /// Its answers compared with the first contestant's, a kind of ray each.
    pub tallies: Vec<Tally>,
}

/// Counts of one contestant and kind of ray. `rays` is the sum of `same` and `classes`.
#[derive(Clone, Copy, Debug)]
pub struct Tally {
    /// The kind.
    pub kind: Kind,
    /// Rays compared.
    pub rays: u64,
    /// Rays with the same answers.
    pub same: u64,
    /// Rays with different ones, in the order of [`Class::ALL`].
    pub classes: [u64; Class::ALL.len()],
    /// Of those, the ones that one hits and the other misses.
    pub hit_miss: u64,
    /// Of those, the ones that slipped through a closed surface at an edge or a vertex.
    pub leaks: u64,
    /// Wall time of its own question: closest hits, of shadow rays whether anything is in the way.
    pub seconds: f64,
}

impl Tally {
    fn new(kind: Kind, seconds: f64) -> Tally {
        Tally { kind, rays: 0, same: 0, classes: [0; Class::ALL.len()], hit_miss: 0, leaks: 0, seconds }
    }

    /// How many of a class.
    pub fn of(&self, class: Class) -> u64 {
        self.classes[class as usize]
    }

    /// Millions of rays a second.
    pub fn speed(&self) -> Option<f64> {
        (self.rays > 0 && self.seconds > 0.0).then(|| self.rays as f64 / self.seconds * 1e-6)
    }
}

/// What a ray was asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Answers {
    /// The closest hit.
    Closest([Option<Answer>; 2]),
    /// Whether anything is in the way.
    Blocked([bool; 2]),
}

/// A real disagreement.
#[derive(Clone, Debug)]
pub struct Case {
    /// Where the ray comes from.
    pub kind: Kind,
    /// Origin.
    pub o: Vec3,
    /// Direction.
    pub d: Vec3,
    /// Start of the interval.
    pub tmin: f32,
    /// End of the interval.
    pub tmax: f32,
    /// Which contestants.
    pub contestants: [usize; 2],
    /// What they said.
    pub answers: Answers,
    /// What f64 says.
    pub truth: Option<Answer>,
    /// Whom f64 refutes.
    pub wrong: [bool; 2],
}

/// Records about `most` rays of each kind of a render of `scene`, makes as many at vertices, edges, axes and
/// planes, and asks all `contestants`.
///
/// # Errors
/// A render that cannot be, or a backend that cannot be built.
pub fn run(
    scene: &Scene,
    settings: &Settings,
    contestants: &[Contestant],
    most: u64,
    hooks: &Hooks<'_>,
) -> Result<Report> {
    let mut sets = Vec::new();
    if let Some(first) = contestants.first()
        && let Some(accel) = built(first, &scene.meshes, hooks)?
    {
        sets.extend(rays::record(scene, settings, &*accel, most, hooks.stop)?.into_iter().flatten());
    }
    (hooks.progress)(0.1);
    sets.extend(aimed::KINDS.map(|kind| aimed::rays(scene, kind, most, settings.seed)));
    let later = Hooks { progress: &|share| (hooks.progress)(0.1 + 0.9 * share), stop: hooks.stop };
    ask(&scene.meshes, &sets, &contestants.iter().collect::<Vec<_>>(), &later)
}

/// Asks all `contestants` the `sets` of rays.
///
/// # Errors
/// A backend that cannot be built.
pub fn ask(
    meshes: &[Arc<Mesh>],
    sets: &[RaySet],
    contestants: &[&Contestant],
    hooks: &Hooks<'_>,
) -> Result<Report> {
    let rays = sets.iter().map(|set| (set.kind, set.len())).collect();
    let mut report = Report { rays, outcomes: Vec::new(), cases: Vec::new(), complete: true };
    let court = Court::new(meshes);
    let mut first: Vec<Traced> = Vec::new();
    for (index, contestant) in contestants.iter().enumerate() {
        let share = |part: f64| (hooks.progress)((index as f64 + part) / contestants.len() as f64);
        share(0.0);
        let begun = Instant::now();
        let Some(accel) = built(contestant, meshes, hooks)? else {
            report.complete = false;
            break;
        };
        let build_seconds = begun.elapsed().as_secs_f64();
        let mut outcome = Outcome::new(contestant, build_seconds, accel.bytes());
        for (i, set) in sets.iter().enumerate() {
            share(0.2 + 0.8 * i as f64 / sets.len() as f64);
            if (hooks.stop)() {
                report.complete = false;
                break;
            }
            let traced = Traced::of(&*accel, set);
            let compared = compare(&court, set, first.get(i).unwrap_or(&traced), &traced, index);
            outcome.tallies.push(compared.tally);
            report.add_cases(compared.cases);
            if index == 0 {
                first.push(traced);
            }
        }
        report.outcomes.push(outcome);
        if !report.complete {
            break;
        }
    }
    if report.complete {
        (hooks.progress)(1.0);
    }
    Ok(report)
}

/// The contestant's structure; `None` when it was stopped.
fn built(
    contestant: &Contestant,
    meshes: &[Arc<Mesh>],
    hooks: &Hooks<'_>,
) -> Result<Option<Box<dyn Intersector>>> {
    let threads = rayon::current_num_threads();
    match contestant.intersector(meshes, threads, &|_| !(hooks.stop)()) {
        Ok(accel) => Ok(Some(accel)),
        Err(_) if (hooks.stop)() => Ok(None),
        Err(error) => Err(error),
    }
}

impl Outcome {
    fn new(contestant: &Contestant, build_seconds: f64, bytes: usize) -> Outcome {
        Outcome {
            name: contestant.name(),
            backend: contestant.backend.clone(),
            isa: contestant.isa,
            quality: contestant.quality.name(),
            build_seconds,
            bytes,
            tallies: Vec::new(),
        }
    }
}

impl Report {
    /// A ray that is known already tells nothing new: its reproducer asks everybody.
    fn add_cases(&mut self, cases: Vec<Case>) {
        let ray = |c: &Case| (c.o, c.d, c.tmin, c.tmax);
        for case in cases {
            if !self.cases.iter().any(|known| ray(known) == ray(&case)) {
                self.cases.push(case);
            }
        }
    }
}

/// Everything that a contestant said about a set.
struct Traced {
    hits: Vec<Hits>,
    blocked: Vec<Mask>,
    seconds: f64,
}

impl Traced {
    /// Asks both questions of all rays, and takes the time of the one that a render would ask.
    fn of(accel: &dyn Intersector, set: &RaySet) -> Traced {
        let coherence = set.coherence();
        let begun = Instant::now();
        let hits = set.chunks.par_iter().map(|chunk| closest(accel, chunk, coherence)).collect();
        let closest_seconds = begun.elapsed().as_secs_f64();
        let begun = Instant::now();
        let ask = |chunk: &Chunk| accel.occluded(chunk.rays.check(chunk.mask), coherence);
        let blocked = set.chunks.par_iter().map(ask).collect();
        let blocked_seconds = begun.elapsed().as_secs_f64();
        let seconds = if set.kind == Kind::Shadow { blocked_seconds } else { closest_seconds };
        Traced { hits, blocked, seconds }
    }
}

fn closest(accel: &dyn Intersector, chunk: &Chunk, coherence: Coherence) -> Hits {
    let mut hits = Hits::default();
    accel.closest(chunk.rays.check(chunk.mask), coherence, &mut hits);
    hits
}

/// The comparison of a set.
struct Compared {
    tally: Tally,
    cases: Vec<Case>,
}

fn compare(court: &Court, set: &RaySet, first: &Traced, second: &Traced, index: usize) -> Compared {
    let chunk = |i: usize| {
        let mut own = Compared { tally: Tally::new(set.kind, 0.0), cases: Vec::new() };
        for lane in (0..LANES).filter(|&lane| set.chunks[i].mask >> lane & 1 == 1) {
            let hits = [first, second].map(|t| Answer::of(&t.hits[i], lane));
            let blocked = [first, second].map(|t| t.blocked[i] >> lane & 1 == 1);
            own.add(court, set, (i, lane), hits, blocked, index);
        }
        own
    };
    let none = || Compared { tally: Tally::new(set.kind, second.seconds), cases: Vec::new() };
    // Collected in their order, so that which cases are kept depends on no thread.
    let parts: Vec<Compared> = (0..set.chunks.len()).into_par_iter().map(chunk).collect();
    parts.into_iter().fold(none(), Compared::plus)
}

impl Compared {
    /// Judges both answers to one ray, which counts as the worse of them.
    fn add(
        &mut self,
        court: &Court,
        set: &RaySet,
        (chunk, lane): (usize, usize),
        hits: [Option<Answer>; 2],
        blocked: [bool; 2],
        index: usize,
    ) {
        let rays = &set.chunks[chunk].rays;
        let judged = [
            (court.closest(rays, lane, hits), Answers::Closest(hits)),
            (court.blocked(rays, lane, blocked), Answers::Blocked(blocked)),
        ];
        let found = judged.into_iter().filter_map(|(finding, answers)| Some((finding?, answers)));
        self.tally.rays += 1;
        let Some((finding, answers)) = found.max_by_key(|(finding, _)| finding.class == Class::Real) else {
            self.tally.same += 1;
            return;
        };
        self.tally.classes[finding.class as usize] += 1;
        self.tally.hit_miss += u64::from(hits[0].is_some() != hits[1].is_some() || blocked[0] != blocked[1]);
        self.tally.leaks += u64::from(finding.leak);
        if finding.class == Class::Real && self.cases.len() < KEPT {
            self.cases.push(case(court, set, (chunk, lane), answers, finding, index));
        }
    }

    fn plus(mut self, other: Compared) -> Compared {
        let (a, b) = (&mut self.tally, &other.tally);
        a.rays += b.rays;
        a.same += b.same;
        a.hit_miss += b.hit_miss;
        a.leaks += b.leaks;
        a.classes.iter_mut().zip(b.classes).for_each(|(a, b)| *a += b);
        let room = KEPT - self.cases.len();
        self.cases.extend(other.cases.into_iter().take(room));
        self
    }
}

fn case(
    court: &Court,
    set: &RaySet,
    (chunk, lane): (usize, usize),
    answers: Answers,
    finding: Finding,
    index: usize,
) -> Case {
    let rays = &set.chunks[chunk].rays;
    Case {
        kind: set.kind,
        o: rays.o(lane),
        d: rays.d(lane),
        tmin: rays.tmin[lane],
        tmax: rays.tmax[lane],
        contestants: [0, index],
        answers,
        truth: court.truth(&Ray64::of(rays, lane)),
        wrong: finding.wrong,
    }
}
