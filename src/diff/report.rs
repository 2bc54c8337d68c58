//! The report as a table and as JSON.

use super::class::Class;
use super::outcome::{Answers, Case, Outcome, Report, Tally};
use super::rays::Kind;
use crate::accel::judge::Answer;
use serde_json::{Map, Value, json};
use std::fmt::Write;

impl Report {
    /// Disagreements of a class, of all contestants and kinds.
    pub fn of(&self, class: Class) -> u64 {
        self.tallies().map(|tally| tally.of(class)).sum()
    }

    /// Real disagreements that are failures.
    pub fn failures(&self) -> u64 {
        self.sum(|tally| tally.failures)
    }

    fn tallies(&self) -> impl Iterator<Item = &Tally> {
        self.outcomes.iter().flat_map(|outcome| &outcome.tallies)
    }

    fn sum(&self, value: impl Fn(&Tally) -> u64) -> u64 {
        self.tallies().map(value).sum()
    }

    /// One line about a real disagreement: who said what.
    pub fn sentence(&self, case: &Case) -> String {
        let name = |i: usize| self.outcomes.get(case.contestants[i]).map_or("?", |outcome| &outcome.name);
        let (says, others) = match case.answers {
            Answers::Closest([a, b]) => (hit(a), hit(b)),
            Answers::Blocked([a, b]) => (blocked(a), blocked(b)),
        };
        let mark = |i: usize| if case.wrong[i] { " (wrong)" } else { "" };
        format!(
            "{}: {} says {says}{}, {} says {others}{}; f64 finds {}",
            case.kind.name(),
            name(0),
            mark(0),
            name(1),
            mark(1),
            hit(case.truth)
        )
    }
}

fn hit(answer: Option<Answer>) -> String {
    answer.map_or("nothing".to_string(), |a| format!("triangle {} of mesh {} at {}", a.triangle, a.mesh, a.t))
}

fn blocked(is_blocked: bool) -> String {
    (if is_blocked { "blocked" } else { "free" }).to_string()
}

/// The report for people: who is how fast and how large, who differs from the first, and what is wrong.
pub fn table(report: &Report) -> String {
    let Some(first) = report.outcomes.first() else { return "nothing was asked\n".to_string() };
    let kinds: Vec<(Kind, u64)> = report.rays.iter().filter(|(_, rays)| *rays > 0).copied().collect();
    let mut text = format!("{:25} {:>8} {:>9}", "", "build", "memory");
    kinds.iter().for_each(|(kind, _)| text += &format!(" {:>8}", kind.name()));
    text += &format!("\n{:25} {:>8} {:>9}", "rays", "", "");
    kinds.iter().for_each(|(_, rays)| text += &format!(" {rays:>8}"));
    text += "\n";
    for outcome in &report.outcomes {
        text += &speeds(outcome, &kinds);
    }
    let _ = writeln!(text, "{:45} million rays a second\n", "");
    let _ = write!(text, "{:25} {:8} {:>9}", format!("other than {}", first.name), "", "same");
    Class::ALL.iter().for_each(|class| text += &format!(" {:>8}", class.name()));
    let _ = writeln!(text, " {:>8} {:>8}", "hit/miss", "leaks");
    for outcome in report.outcomes.iter().skip(1) {
        text += &differences(outcome);
    }
    for case in &report.cases {
        let _ = writeln!(text, "real: {}", report.sentence(case));
    }
    text + &conclusion(report)
}

/// One contestant's row of the first table.
fn speeds(outcome: &Outcome, kinds: &[(Kind, u64)]) -> String {
    let megabytes = outcome.bytes as f64 * 1e-6;
    let mut text = format!("{:25} {:>6.2} s {megabytes:>6.1} MB", outcome.name, outcome.build_seconds);
    for (kind, _) in kinds {
        let speed = outcome.tallies.iter().find(|tally| tally.kind == *kind).and_then(Tally::speed);
        text += &speed.map_or(format!(" {:>8}", "-"), |speed| format!(" {speed:>8.2}"));
    }
    text + "\n"
}

/// One contestant's rows of the second table: the kinds in which it differs.
fn differences(outcome: &Outcome) -> String {
    let mut text = String::new();
    let mut name = outcome.name.as_str();
    for tally in outcome.tallies.iter().filter(|tally| tally.same < tally.rays) {
        text += &format!("{name:25} {:8} {:>8.4}%", tally.kind.name(), share(tally.same, tally.rays));
        tally.classes.iter().for_each(|count| text += &format!(" {count:>8}"));
        text += &format!(" {:>8} {:>8}\n", tally.hit_miss, tally.leaks);
        name = "";
    }
    if text.is_empty() { format!("{name:25} nowhere\n") } else { text }
}

fn share(part: u64, whole: u64) -> f64 {
    // Rounded down: 100 % is all of them.
    (part as f64 / whole.max(1) as f64 * 1e6).floor() * 1e-4
}

fn conclusion(report: &Report) -> String {
    let stopped = if report.complete { "" } else { ", stopped before the last" };
    let rays = report.sum(|tally| tally.rays);
    let different = rays - report.sum(|tally| tally.same);
    let (real, failures) = (report.of(Class::Real), report.failures());
    let real = match (real, failures) {
        (0, _) => "none of them real".to_string(),
        (real, 0) => format!("{real} of them real, all of contestants asked for comparison only"),
        (real, failures) if real == failures => format!("{real} of them REAL"),
        (real, failures) => format!("{real} of them REAL, {failures} of contestants that count"),
    };
    format!("\n{} contestants, {rays} answers{stopped}: {different} differ, {real}\n", report.outcomes.len())
}

/// The report for programs. Of its numbers only `build_seconds` and `mrays_per_second` differ from run to run.
pub fn json(report: &Report) -> Value {
    let rays: Map<String, Value> =
        report.rays.iter().map(|(kind, rays)| (kind.name().to_string(), json!(rays))).collect();
    let mut totals = classes(|class| report.of(class));
    totals.insert("rays".into(), json!(report.sum(|tally| tally.rays)));
    totals.insert("same".into(), json!(report.sum(|tally| tally.same)));
    totals.insert("hit_miss".into(), json!(report.sum(|tally| tally.hit_miss)));
    totals.insert("leaks".into(), json!(report.sum(|tally| tally.leaks)));
    totals.insert("failures".into(), json!(report.failures()));
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "complete": report.complete,
        "rays": rays,
        "reference": report.outcomes.first().map(|outcome| &outcome.name),
        "contestants": report.outcomes.iter().map(outcome).collect::<Vec<_>>(),
        "totals": totals,
        "cases": report.cases.iter().map(|c| case(report, c)).collect::<Vec<_>>(),
    })
}

fn classes(count: impl Fn(Class) -> u64) -> Map<String, Value> {
    Class::ALL.iter().map(|class| (class.name().to_string(), json!(count(*class)))).collect()
}

fn outcome(outcome: &Outcome) -> Value {
    let kinds: Map<String, Value> =
        outcome.tallies.iter().map(|t| (t.kind.name().to_string(), tally(t))).collect();
    json!({
        "name": outcome.name,
        "backend": outcome.backend,
        "isa": outcome.isa.name(),
        "quality": outcome.quality,
        "counts": outcome.counts,
        "build_seconds": outcome.build_seconds,
        "bytes": outcome.bytes,
        "kinds": kinds,
    })
}

fn tally(t: &Tally) -> Value {
    let mut object = classes(|class| t.of(class));
    object.insert("rays".into(), json!(t.rays));
    object.insert("same".into(), json!(t.same));
    object.insert("hit_miss".into(), json!(t.hit_miss));
    object.insert("leaks".into(), json!(t.leaks));
    object.insert("failures".into(), json!(t.failures));
    object.insert("mrays_per_second".into(), json!(t.speed()));
    Value::Object(object)
}

fn case(report: &Report, case: &Case) -> Value {
    let name = |i: usize| report.outcomes.get(i).map(|outcome| outcome.name.clone());
    let answer = |a: Option<Answer>| {
        a.map(|a| json!({ "t": a.t, "u": a.u, "v": a.v, "mesh": a.mesh, "triangle": a.triangle }))
    };
    let (question, answers) = match case.answers {
        Answers::Closest(pair) => ("closest", json!(pair.map(answer))),
        Answers::Blocked(pair) => ("occluded", json!(pair)),
    };
    json!({
        "kind": case.kind.name(),
        "question": question,
        "contestants": case.contestants.map(name),
        "answers": answers,
        "wrong": case.wrong,
        "f64": answer(case.truth),
        "origin": case.o.to_array(),
        "direction": case.d.to_array(),
        "tmin": case.tmin,
        "tmax": case.tmax.is_finite().then_some(case.tmax),
    })
}
