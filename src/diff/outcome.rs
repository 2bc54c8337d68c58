//! What was found: counts of each contestant and kind of ray, and the first real disagreements in full.

use super::class::Class;
use super::contestants::Contestant;
use super::rays::Kind;
use crate::accel::judge::Answer;
use crate::math::Vec3;
use crate::math::isa::Isa;

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
    /// False: asked for comparison only ([`Contestant::counts`]).
    pub counts: bool,
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
    /// Real disagreements that are failures: not those of a contestant asked for comparison only, unless the first
    /// one is wrong.
    pub failures: u64,
    /// Wall time of its own question: closest hits, of shadow rays whether anything is in the way.
    pub seconds: f64,
}

impl Tally {
    pub(super) fn new(kind: Kind, seconds: f64) -> Tally {
        Tally {
            kind,
            rays: 0,
            same: 0,
            classes: [0; Class::ALL.len()],
            hit_miss: 0,
            leaks: 0,
            failures: 0,
            seconds,
        }
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

impl Outcome {
    pub(super) fn new(contestant: &Contestant, build_seconds: f64, bytes: usize) -> Outcome {
        Outcome {
            name: contestant.name(),
            backend: contestant.backend.clone(),
            isa: contestant.isa,
            quality: contestant.quality.name(),
            counts: contestant.counts,
            build_seconds,
            bytes,
            tallies: Vec::new(),
        }
    }
}

impl Report {
    /// A ray that is known already tells nothing new: its reproducer asks everybody.
    pub(super) fn add_cases(&mut self, cases: Vec<Case>) {
        let ray = |c: &Case| (c.o, c.d, c.tmin, c.tmax);
        for case in cases {
            if !self.cases.iter().any(|known| ray(known) == ray(&case)) {
                self.cases.push(case);
            }
        }
    }
}
