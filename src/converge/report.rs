//! A study as CSV, JSON and a table for the terminal.

use super::{Point, Series, Study, plot};
use crate::error::{Error, Result, unknown_word_advice};
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::Path;

/// The encoder of a study.
pub type Encode = fn(&Study) -> Result<String>;

/// The files that a study can be written to: extension, meaning, encoder.
pub const FORMATS: &[(&str, &str, Encode)] = &[
    ("svg", "the figure: error against N on log axes", plot::svg),
    ("csv", "a row a rule and N", |study| Ok(csv(study))),
    ("json", "everything, with settings and slopes", |study| Ok(json(study))),
];

/// The encoder that `path`'s extension names.
///
/// # Errors
/// An unknown or missing extension.
pub fn format_of(path: &Path) -> Result<Encode> {
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    FORMATS.iter().find(|row| row.0 == extension).map(|row| row.2).ok_or_else(|| {
        let known: Vec<&str> = FORMATS.iter().map(|row| row.0).collect();
        let message = match extension.as_str() {
            "" => "the output's name has no extension to tell its format".to_string(),
            other => format!("unknown format \".{other}\" of a study"),
        };
        Error::new(message).at(path).advise(unknown_word_advice(&extension, &known))
    })
}

/// One row a rule and N.
pub fn csv(study: &Study) -> String {
    let mut text = "rule,n,runs,rmse,relmse,seconds,rays\n".to_string();
    for series in &study.series {
        for p in &series.points {
            let _ = writeln!(
                text,
                "{},{},{},{:e},{:e},{:e},{}",
                series.name, p.n, p.runs, p.rmse, p.rel_mse, p.seconds, p.rays
            );
        }
    }
    text
}

/// Everything that is known of the study. Apart from `seconds` and `efficiency` it is the same whenever it is run.
pub fn json(study: &Study) -> String {
    let point = |p: &Point| {
        json!({
            "n": p.n, "runs": p.runs, "rmse": p.rmse, "relmse": p.rel_mse,
            "seconds": p.seconds, "rays": p.rays, "efficiency": p.efficiency(),
            "exact": p.is_exact, "fitted": p.is_fitted,
        })
    };
    let slope = |series: &Series| {
        let slope = series.slope?;
        let ends = slope.half_width.map(|half| [slope.value - half, slope.value + half]);
        Some(json!({ "value": slope.value, "ci95": ends, "points": slope.points }))
    };
    let series = |s: &Series| {
        json!({
            "rule": s.name, "meaning": s.meaning, "random": s.is_random, "exact": s.is_exact(),
            "slope": slope(s), "points": s.points.iter().map(point).collect::<Vec<_>>(),
        })
    };
    let value = match study.reference.value.0.as_slice() {
        [number] => Some(*number),
        _ => None,
    };
    let all = json!({
        "version": env!("CARGO_PKG_VERSION"),
        "title": study.labels.title,
        "subtitle": study.labels.subtitle,
        "samples": study.labels.samples,
        "settings": study.labels.settings,
        "max_n": study.plan.max_n,
        "seeds": study.plan.seeds,
        "seed": study.plan.seed,
        "complete": study.complete,
        "reference": {
            "description": study.reference.description, "value": value, "rmse": study.reference.rmse,
        },
        "rules": study.series.iter().map(series).collect::<Vec<Value>>(),
    });
    format!("{all:#}\n")
}

/// `slope −0.50 ± 0.02`, or why there is none.
pub fn slope_text(series: &Series) -> String {
    match series.slope {
        _ if series.is_exact() => "exact".to_string(),
        Some(slope) => match slope.half_width {
            Some(half) => format!("slope {} ± {half:.2}", signed(slope.value)),
            None => format!("slope {} (two points)", signed(slope.value)),
        },
        None => "too few points for a slope".to_string(),
    }
}

/// Two decimals with a minus sign instead of a hyphen.
fn signed(value: f64) -> String {
    format!("{value:.2}").replace('-', "−")
}

/// The slopes, errors and efficiencies at each rule's largest N, for people.
pub fn table(study: &Study) -> String {
    let width = study.series.iter().map(|series| series.name.len()).max().unwrap_or(0).max(4);
    let mut text = format!("{}: {}\n", study.labels.title, study.labels.subtitle);
    let _ = writeln!(text, "reference: {}", study.reference.description);
    let _ = writeln!(
        text,
        "{:width$}  {:>16}  {:>6}  {:>8}  {:>10}  {:>10}  1/(relMSE·s)",
        "rule", "slope", "points", "N", "RMSE", "relMSE"
    );
    for series in &study.series {
        let Some(last) = series.points.last() else {
            let _ = writeln!(text, "{:width$}  {:>16}", series.name, "no run");
            continue;
        };
        let slope = match series.slope.map(|slope| (slope.value, slope.half_width)) {
            _ if series.is_exact() => "exact".to_string(),
            Some((value, Some(half))) => format!("{value:.3} ± {half:.3}"),
            Some((value, None)) => format!("{value:.3}"),
            None => "-".to_string(),
        };
        let efficiency = last.efficiency().map_or("-".to_string(), |e| format!("{e:.3e}"));
        let _ = writeln!(
            text,
            "{:width$}  {slope:>16}  {:>6}  {:>8}  {:>10.3e}  {:>10.3e}  {efficiency:>12}",
            series.name,
            series.slope.map_or(0, |slope| slope.points),
            last.n,
            last.rmse,
            last.rel_mse
        );
    }
    if !study.complete {
        text.push_str("stopped before the end\n");
    }
    text
}
