//! How fast rules of integration converge: error against the number of samples, and the slope of it.
//!
//! A study takes [`Rule`]s, runs each at N = 1, 4, 16, … ([`run`]), compares every result with a [`Reference`] and
//! fits a slope to each rule's errors. What is integrated is one of the [`integrals`] with a known answer or a scene's
//! picture ([`scene`]); the driver knows neither. A result is drawn by [`plot`] and written by [`report`].

pub mod fit;
pub mod integrals;
pub mod plot;
pub mod report;
mod run;
pub mod scene;
mod subject;
mod value;

pub use run::run;
pub use value::{F32, F64, Reference, Value};

use crate::error::{Error, Result, unknown_word_advice};
use fit::Slope;

/// A way to estimate the quantity of a study from N samples.
pub struct Rule<'a> {
    /// Its name, as in `--rules`.
    pub name: &'static str,
    /// One line about it, with the notes' equation.
    pub meaning: &'static str,
    /// False where every run gives the same: one is enough.
    pub is_random: bool,
    /// Estimates with N samples and a seed; `None` when [`Hooks::stop`] ended it.
    pub run: Box<RunFn<'a>>,
}

/// What a [`Rule`] does: (N, seed, hooks of this run).
pub type RunFn<'a> = dyn Fn(u64, u64, &Hooks<'_>) -> Result<Option<Run>> + 'a;

/// One estimate and what it cost.
#[derive(Clone, Debug)]
pub struct Run {
    /// The estimate.
    pub value: Value,
    /// Wall time.
    pub seconds: f64,
    /// Rays of all kinds; of an integral, evaluations of the integrand.
    pub rays: u64,
}

/// What the caller hears and says while a study goes on. Called from several threads.
pub struct Hooks<'a> {
    /// Told now and then the share done, 0 to 1.
    pub progress: &'a (dyn Fn(f64) + Sync),
    /// Asked often; `true` ends the study with what is finished.
    pub stop: &'a (dyn Fn() -> bool + Sync),
}

impl Hooks<'_> {
    /// Hears nothing and never stops.
    pub const NONE: Hooks<'static> = Hooks { progress: &|_| (), stop: &|| false };
}

/// How a study is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Plan {
    /// The largest N; the others are the powers of four up to it.
    pub max_n: u64,
    /// Independent runs of a random rule at each N, with the seeds `seed`, `seed` + 1, …
    pub seeds: u64,
    /// The first seed.
    pub seed: u64,
}

impl Plan {
    /// 1, 4, 16, … up to `max_n`.
    pub fn numbers(&self) -> impl Iterator<Item = u64> + use<> {
        let max_n = self.max_n;
        std::iter::successors(Some(1_u64), |n| n.checked_mul(4)).take_while(move |n| *n <= max_n)
    }

    /// The seeds of the runs of a rule.
    fn seeds_of(&self, rule: &Rule<'_>) -> impl Iterator<Item = u64> + use<> {
        let (first, count) = (self.seed, if rule.is_random { self.seeds } else { 1 });
        (0..count).map(move |k| first.wrapping_add(k))
    }
}

/// What a figure says besides its curves.
#[derive(Clone, Debug, PartialEq)]
pub struct Labels {
    /// What is integrated: a name.
    pub title: String,
    /// The same in a formula or a sentence.
    pub subtitle: String,
    /// What N counts.
    pub samples: &'static str,
    /// Settings that the results depend on, for the JSON.
    pub settings: serde_json::Value,
}

/// A finished study, or the part of it that was done when it was stopped.
#[derive(Clone, Debug)]
pub struct Study {
    /// What was integrated.
    pub labels: Labels,
    /// How it was run.
    pub plan: Plan,
    /// What the errors are measured against.
    pub reference: Reference,
    /// One curve a rule.
    pub series: Vec<Series>,
    /// False when it was stopped.
    pub complete: bool,
}

/// The errors of one rule.
#[derive(Clone, Debug)]
pub struct Series {
    /// The rule's name.
    pub name: &'static str,
    /// One line about it.
    pub meaning: &'static str,
    /// Whether it has random numbers.
    pub is_random: bool,
    /// Its errors, N rising.
    pub points: Vec<Point>,
    /// The slope through the points that are [`Point::is_fitted`].
    pub slope: Option<Slope>,
}

/// The error of a rule at one N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// The number of samples.
    pub n: u64,
    /// Runs that the errors are the means of.
    pub runs: u64,
    /// Root of the mean squared error over runs, pixels and colours.
    pub rmse: f64,
    /// Mean of (a − b)²/(b² + 0.01), as in [`crate::compare`].
    pub rel_mse: f64,
    /// Wall seconds a run.
    pub seconds: f64,
    /// Rays (evaluations) a run.
    pub rays: u64,
    /// No more than rounding is left of the error: it has no place on a log axis.
    pub is_exact: bool,
    /// Far enough above the reference's own error to say something about the rule.
    pub is_fitted: bool,
}

impl Point {
    /// 1/(relMSE·seconds): twice as much reaches the same error in half the time. `None` without an error.
    pub fn efficiency(&self) -> Option<f64> {
        let cost = self.rel_mse * self.seconds;
        (!self.is_exact && cost > 0.0).then(|| 1.0 / cost)
    }
}

impl Series {
    /// No point shows more than rounding.
    pub fn is_exact(&self) -> bool {
        !self.points.is_empty() && self.points.iter().all(|point| point.is_exact)
    }
}

/// Refuses `names` (separated by commas) of rules that are not `known`.
///
/// # Errors
/// The first name that no rule has.
pub fn check_names(names: &str, known: &[&str]) -> Result<()> {
    match names.split(',').map(str::trim).find(|name| !known.contains(name)) {
        Some(wrong) => {
            Err(Error::usage(format!("unknown rule \"{wrong}\"")).advise(unknown_word_advice(wrong, known)))
        }
        None => Ok(()),
    }
}

/// Keeps those `rules` that `names` (separated by commas) say, in the order of the table.
///
/// # Errors
/// As [`check_names`].
pub fn choose<'a>(rules: Vec<Rule<'a>>, names: &str) -> Result<Vec<Rule<'a>>> {
    check_names(names, &rules.iter().map(|rule| rule.name).collect::<Vec<_>>())?;
    let is_meant = |rule: &Rule<'_>| names.split(',').any(|name| name.trim() == rule.name);
    Ok(rules.into_iter().filter(is_meant).collect())
}
