//! Asking everybody and comparing each with the first.

use super::class::{Class, Finding};
use super::contestants::Contestant;
use super::court::Court;
use super::outcome::{Answers, Case, Outcome, Report, Tally};
use super::rays::{Chunk, Kind, RaySet};
use super::{Hooks, aimed, rays};
use crate::accel::brute::Ray64;
use crate::accel::judge::Answer;
use crate::accel::{Coherence, Hits, Intersector, LANES, Mask};
use crate::error::Result;
use crate::scene::{Scene, Settings};
use crate::shape::Mesh;
use rayon::prelude::*;
use std::sync::Arc;
use std::time::Instant;

/// Real disagreements that a contestant keeps in full, a kind of ray.
pub const KEPT: usize = 3;

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
    let kinds = aimed::KINDS.into_iter().take_while(|_| !(hooks.stop)());
    sets.extend(kinds.map(|kind| aimed::rays(scene, kind, most, settings.seed)));
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
            let traced = Traced::of(&*accel, set, hooks.stop);
            let pair = [first.get(i).unwrap_or(&traced), &traced];
            let compared = compare(&court, set, pair, (index, contestant.counts), hooks.stop);
            if (hooks.stop)() {
                // Some of these rays were not asked about.
                report.complete = false;
                break;
            }
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

/// Everything that a contestant said about a set.
struct Traced {
    hits: Vec<Hits>,
    blocked: Vec<Mask>,
    seconds: f64,
}

impl Traced {
    /// Asks both questions of all rays, and takes the time of the one that a render would ask. Once `stop` says so,
    /// the rest is left out.
    fn of(accel: &dyn Intersector, set: &RaySet, stop: &(dyn Fn() -> bool + Sync)) -> Traced {
        let coherence = set.coherence();
        let begun = Instant::now();
        let hits = |chunk| if stop() { Hits::default() } else { closest(accel, chunk, coherence) };
        let hits = set.chunks.par_iter().map(hits).collect();
        let closest_seconds = begun.elapsed().as_secs_f64();
        let begun = Instant::now();
        let ask = |chunk: &Chunk| {
            if stop() { 0 } else { accel.occluded(chunk.rays.check(chunk.mask), coherence) }
        };
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

fn compare(
    court: &Court,
    set: &RaySet,
    [first, second]: [&Traced; 2],
    (index, counts): (usize, bool),
    stop: &(dyn Fn() -> bool + Sync),
) -> Compared {
    let chunk = |i: usize| {
        let mut own = Compared { tally: Tally::new(set.kind, 0.0), cases: Vec::new() };
        if stop() {
            return own;
        }
        for lane in (0..LANES).filter(|&lane| set.chunks[i].mask >> lane & 1 == 1) {
            let hits = [first, second].map(|t| Answer::of(&t.hits[i], lane));
            let blocked = [first, second].map(|t| t.blocked[i] >> lane & 1 == 1);
            own.add(court, set, (i, lane), (hits, blocked), (index, counts));
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
        (hits, blocked): ([Option<Answer>; 2], [bool; 2]),
        (index, counts): (usize, bool),
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
        let fails = finding.class == Class::Real && (counts || finding.wrong[0]);
        self.tally.failures += u64::from(fails);
        if fails && self.cases.len() < KEPT {
            self.cases.push(case(court, set, (chunk, lane), answers, finding, index));
        }
    }

    fn plus(mut self, other: Compared) -> Compared {
        let (a, b) = (&mut self.tally, &other.tally);
        a.rays += b.rays;
        a.same += b.same;
        a.hit_miss += b.hit_miss;
        a.leaks += b.leaks;
        a.failures += b.failures;
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
