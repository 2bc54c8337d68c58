//! The driver: every rule at every N, small N first, so that a study that is stopped still has all of its curves.

use super::value::Squares;
use super::{Hooks, Labels, Plan, Point, Reference, Rule, Series, Study, fit};
use crate::error::Result;

/// Runs `rules` by `plan` and compares their results with `reference`.
///
/// # Errors
/// A rule's own error, or a result that cannot be compared.
pub fn run(
    rules: &[Rule<'_>],
    plan: &Plan,
    labels: Labels,
    reference: Reference,
    hooks: &Hooks<'_>,
) -> Result<Study> {
    let begin = |rule: &Rule<'_>| Series {
        name: rule.name,
        meaning: rule.meaning,
        is_random: rule.is_random,
        points: Vec::new(),
        slope: None,
    };
    let mut study =
        Study { labels, plan: *plan, reference, series: rules.iter().map(begin).collect(), complete: true };
    let cost = |n: u64| rules.iter().map(|rule| plan.seeds_of(rule).count() as f64 * n as f64).sum::<f64>();
    let mut work = Work { hooks, done: 0.0, total: plan.numbers().map(cost).sum() };
    'all: for n in plan.numbers() {
        for (rule, series) in rules.iter().zip(&mut study.series) {
            let (point, is_whole) = work.point(rule, plan, n, &study.reference)?;
            series.points.extend(point);
            if !is_whole {
                study.complete = false;
                break 'all;
            }
        }
    }
    for series in &mut study.series {
        let fitted = series.points.iter().filter(|point| point.is_fitted);
        series.slope = fit::slope(&fitted.map(|point| (point.n as f64, point.rmse)).collect::<Vec<_>>());
    }
    Ok(study)
}

/// What is done, counted in samples.
struct Work<'a> {
    hooks: &'a Hooks<'a>,
    done: f64,
    total: f64,
}

impl Work<'_> {
    /// The errors of `rule` at `n` over all seeds; false when it was stopped before the last. What was finished until
    /// then is a point of fewer runs.
    fn point(
        &mut self,
        rule: &Rule<'_>,
        plan: &Plan,
        n: u64,
        reference: &Reference,
    ) -> Result<(Option<Point>, bool)> {
        let mut sum = Sum::default();
        for seed in plan.seeds_of(rule) {
            let (done, total) = (self.done, self.total);
            let progress = |share: f64| (self.hooks.progress)((done + share * n as f64) / total);
            let hooks = Hooks { progress: &progress, stop: self.hooks.stop };
            let stopped = (self.hooks.stop)();
            let result = if stopped { None } else { (rule.run)(n, seed, &hooks)? };
            let Some(run) = result else { return Ok((sum.point(n, reference), false)) };
            let squares = run.value.squares(&reference.value).map_err(|mut e| {
                e.message = format!("rule {} at N = {n}: {}", rule.name, e.message);
                e
            })?;
            sum.add(&squares, run.seconds, run.rays);
            self.done += n as f64;
            (self.hooks.progress)(self.done / self.total);
        }
        Ok((sum.point(n, reference), true))
    }
}

/// Sums over the runs of a point.
#[derive(Default)]
struct Sum {
    runs: u64,
    squares: Squares,
    seconds: f64,
    rays: u64,
}

impl Sum {
    fn add(&mut self, squares: &Squares, seconds: f64, rays: u64) {
        self.runs += 1;
        self.squares.mse += squares.mse;
        self.squares.rel_mse += squares.rel_mse;
        self.seconds += seconds;
        self.rays += rays;
    }

    fn point(&self, n: u64, reference: &Reference) -> Option<Point> {
        if self.runs == 0 {
            return None;
        }
        let runs = self.runs as f64;
        let rmse = (self.squares.mse / runs).sqrt();
        let is_exact = reference.is_rounding(rmse);
        Some(Point {
            n,
            runs: self.runs,
            rmse,
            rel_mse: self.squares.rel_mse / runs,
            seconds: self.seconds / runs,
            rays: self.rays / self.runs,
            is_exact,
            is_fitted: !is_exact && reference.is_below(rmse),
        })
    }
}
