//! Counts of verdicts.

use super::{Answer, Verdict};
use crate::math::Vec3;

/// Disagreements that a [`Tally`] keeps in full.
pub const KEPT: usize = 100;

/// Counts of verdicts.
#[derive(Clone, Debug, Default)]
pub struct Tally {
    /// Rays compared.
    pub rays: u64,
    /// [`Verdict::Same`].
    pub same: u64,
    /// [`Verdict::Tie`].
    pub tie: u64,
    /// [`Verdict::Edge`].
    pub edge: u64,
    /// [`Verdict::Graze`].
    pub graze: u64,
    /// [`Verdict::Real`].
    pub real: u64,
    /// Rays that one backend says hit and the other says miss, whatever the verdict.
    pub hit_miss: u64,
    /// The first [`KEPT`] real disagreements.
    pub kept: Vec<Disagreement>,
}

/// A ray and its two answers.
#[derive(Clone, Copy, Debug)]
pub struct Disagreement {
    /// Origin.
    pub o: Vec3,
    /// Direction.
    pub d: Vec3,
    /// Start of the interval.
    pub tmin: f32,
    /// End of the interval.
    pub tmax: f32,
    /// The first backend's answer.
    pub first: Option<Answer>,
    /// The second backend's answer.
    pub second: Option<Answer>,
}

impl Tally {
    /// Adds the counts of `other` and as many of its kept disagreements as there is room for.
    pub fn merge(&mut self, other: Tally) {
        self.rays += other.rays;
        self.same += other.same;
        self.tie += other.tie;
        self.edge += other.edge;
        self.graze += other.graze;
        self.real += other.real;
        self.hit_miss += other.hit_miss;
        let room = KEPT.saturating_sub(self.kept.len());
        self.kept.extend(other.kept.into_iter().take(room));
    }

    pub(super) fn add(&mut self, verdict: Verdict, case: Disagreement) {
        self.rays += 1;
        self.hit_miss += (case.first.is_some() != case.second.is_some()) as u64;
        match verdict {
            Verdict::Same => self.same += 1,
            Verdict::Tie => self.tie += 1,
            Verdict::Edge => self.edge += 1,
            Verdict::Graze => self.graze += 1,
            Verdict::Real => {
                self.real += 1;
                if self.kept.len() < KEPT {
                    self.kept.push(case);
                }
            }
        }
    }
}
