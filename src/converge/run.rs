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

#[cfg(test)]
mod tests {
    use super::super::{Run, Value};
    use super::*;
    use std::sync::atomic::{AtomicU64, Ordering};

    fn labels() -> Labels {
        Labels {
            title: String::new(),
            subtitle: String::new(),
            samples: "N",
            settings: serde_json::Value::Null,
        }
    }

    /// Off by 1/n, or exact; a random one also depends on the seed's last bit.
    fn rule(is_random: bool, error: f64) -> Rule<'static> {
        let run = move |n: u64, seed: u64, _: &Hooks<'_>| {
            let sign = if seed & 1 == 0 { 1.0 } else { -1.0 };
            let value = Value::number(3.0 + sign * error / n as f64);
            Ok(Some(Run { value, seconds: 0.5, rays: 2 * n }))
        };
        Rule { name: "rule", meaning: "", is_random, run: Box::new(run) }
    }

    fn reference(rmse: f64) -> Reference {
        Reference { description: String::new(), value: Value::number(3.0), rmse, rounding: super::super::F64 }
    }

    #[test]
    fn only_what_the_reference_can_judge_is_fitted() {
        let plan = Plan { max_n: 300, seeds: 4, seed: 8 };
        let rules = [rule(true, 1.0), rule(false, 1.0), rule(true, 0.0)];
        let study = run(&rules, &plan, labels(), reference(0.02), &Hooks::NONE).unwrap();
        let [random, fixed, exact] = study.series.as_slice() else { panic!("three series") };
        for (series, runs) in [(random, 4), (fixed, 1)] {
            let fitted: Vec<(u64, bool)> = series.points.iter().map(|p| (p.n, p.is_fitted)).collect();
            // 1/16 is more than twice 0.02, 1/64 is not.
            assert_eq!(fitted, [(1, true), (4, true), (16, true), (64, false), (256, false)]);
            assert!(series.points.iter().all(|p| p.runs == runs && p.rays == 2 * p.n && p.seconds == 0.5));
            let slope = series.slope.unwrap();
            assert!((slope.value + 1.0).abs() < 1e-12 && slope.points == 3);
        }
        assert!(exact.is_exact() && exact.slope.is_none() && exact.points[0].efficiency().is_none());
        assert!(study.complete);
    }

    #[test]
    fn a_stop_keeps_what_is_finished() {
        let asked = AtomicU64::new(0);
        // Asked before each run: two rules' first points of four runs, and one run of the next.
        let stop = || asked.fetch_add(1, Ordering::Relaxed) >= 9;
        let hooks = Hooks { progress: &|_| (), stop: &stop };
        let plan = Plan { max_n: 16, seeds: 4, seed: 0 };
        let rules = [rule(true, 1.0), rule(true, 2.0)];
        let study = run(&rules, &plan, labels(), reference(0.0), &hooks).unwrap();
        let runs = study.series.iter().map(|s| s.points.iter().map(|p| (p.n, p.runs)).collect::<Vec<_>>());
        assert_eq!(runs.collect::<Vec<_>>(), [vec![(1, 4), (4, 1)], vec![(1, 4)]]);
        assert!(!study.complete);
    }

    #[test]
    fn results_that_cannot_be_compared_are_named() {
        let plan = Plan { max_n: 1, seeds: 1, seed: 0 };
        for error in [f64::NAN, f64::INFINITY] {
            let failed = run(&[rule(false, error)], &plan, labels(), reference(0.0), &Hooks::NONE);
            assert_eq!(failed.unwrap_err().message, "rule rule at N = 1: a result is not finite");
        }
        let other = Reference { value: Value(vec![1.0, 2.0]), ..reference(0.0) };
        assert!(run(&[rule(false, 1.0)], &plan, labels(), other, &Hooks::NONE).is_err());
    }

    #[test]
    fn progress_rises_to_one() {
        let last = std::sync::Mutex::new(0.0);
        let progress = |share: f64| {
            let mut last = last.lock().unwrap();
            assert!(share >= *last);
            *last = share;
        };
        let hooks = Hooks { progress: &progress, stop: &|| false };
        let plan = Plan { max_n: 64, seeds: 3, seed: 0 };
        run(&[rule(true, 1.0), rule(false, 1.0)], &plan, labels(), reference(0.0), &hooks).unwrap();
        assert_eq!(*last.lock().unwrap(), 1.0);
    }
}
