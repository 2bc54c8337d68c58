//! `drt converge`: slopes that theory knows, files that can be read, mistakes in one line, Ctrl-C.

mod scenes;
mod stops;

use super::{drt, folder, names};
use serde_json::Value;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// Runs a study and reads its JSON from standard output.
#[track_caller]
fn study(dir: &Path, words: &[&str]) -> Value {
    let ended = drt(dir, &[&["converge", "--json"][..], words].concat());
    ended.expect(0, &[]);
    serde_json::from_str(&ended.out).expect("JSON")
}

fn rule<'a>(study: &'a Value, name: &str) -> &'a Value {
    let rules = study["rules"].as_array().expect("rules");
    rules.iter().find(|rule| rule["rule"] == name).unwrap_or_else(|| panic!("no rule {name}"))
}

fn last<'a>(study: &'a Value, name: &str) -> &'a Value {
    rule(study, name)["points"].as_array().and_then(|points| points.last()).expect("a point")
}

/// The same over the hemisphere: a smooth sky, and a lamp with edges.
#[test]
fn integrals_over_the_hemisphere_have_the_slopes_of_theory() {
    let dir = folder();
    type Expected = (&'static str, f64, f64);
    let expected: [(&str, &[Expected]); 2] = [
        (
            "sky",
            &[
                // M·N points: the grid's error is of the second order in θ alone, √N points along it.
                ("uniform", -1.0, 0.1),
                ("random", -0.5, 0.04),
                ("stratified", -1.0, 0.1),
                ("nonuniform-random", -1.0, 0.1),
                ("importance", -0.5, 0.04),
                ("sobol", -1.25, 0.15),
            ],
        ),
        (
            "lamp",
            &[
                ("random", -0.5, 0.04),
                ("stratified", -0.75, 0.07),
                ("nonuniform-random", -0.75, 0.07),
                ("importance", -0.5, 0.04),
                ("sobol", -0.75, 0.07),
            ],
        ),
    ];
    for (integral, rules) in expected {
        let study = study(dir.path(), &[integral, "--seeds", "256"]);
        for (name, slope, tolerance) in rules {
            let value = rule(&study, name)["slope"]["value"].as_f64().expect("a slope");
            assert!((value - slope).abs() < *tolerance, "{integral} {name}: {value}");
        }
    }
}

/// The hemisphere's rules are compared on direct light, unless more is asked for.
#[test]
fn the_hemisphere_is_studied_at_depth_one() {
    let dir = folder();
    let depth = |words: &[&str]| {
        let words = [&["s.toml", "--max-n", "1", "--size", "8x8"][..], words].concat();
        study(dir.path(), &words)["settings"]["max_depth"].as_u64()
    };
    assert_eq!(depth(&[]), Some(1));
    assert_eq!(depth(&["--max-depth", "3"]), Some(3));
    assert_eq!(depth(&["--set", "render.max_depth=4"]), Some(4));
    assert_eq!(depth(&["--vary", "pixel"]), Some(16));
}

/// The orders of the notes' rules: the tolerance is some three standard deviations of 256 runs.
#[test]
fn built_in_integrals_have_the_slopes_of_theory() {
    let dir = folder();
    /// A rule with its slope and a tolerance.
    type Expected = (&'static str, f64, f64);
    let expected: [(&str, &[Expected]); 3] = [
        (
            "smooth",
            &[
                ("uniform", -2.0, 0.02),
                ("uniform-corner", -1.0, 0.04),
                ("random", -0.5, 0.04),
                ("stratified", -1.5, 0.04),
                ("nonuniform", -2.0, 0.05),
                ("nonuniform-random", -1.5, 0.05),
                ("importance", -0.5, 0.04),
            ],
        ),
        (
            "step",
            &[
                ("uniform", -1.0, 0.001),
                ("uniform-corner", -1.0, 0.001),
                ("random", -0.5, 0.04),
                ("stratified", -1.0, 0.04),
                ("importance", -0.5, 0.04),
            ],
        ),
        ("peak", &[("random", -0.5, 0.04), ("importance", -0.5, 0.04), ("nonuniform", -2.0, 0.05)]),
    ];
    for (integral, rules) in expected {
        let study = study(dir.path(), &[integral, "--seeds", "256"]);
        for (name, slope, tolerance) in rules {
            let fitted = &rule(&study, name)["slope"];
            let value = fitted["value"].as_f64().expect("a slope");
            assert!((value - slope).abs() < *tolerance, "{integral} {name}: {value}");
            let ends: Vec<f64> =
                fitted["ci95"].as_array().unwrap().iter().filter_map(Value::as_f64).collect();
            assert!(
                ends[0] <= value && value <= ends[1] && fitted["points"] == 7,
                "{integral} {name}: {fitted}"
            );
        }
        let perfect = rule(&study, "importance-exact");
        assert!(perfect["exact"] == true && perfect["slope"].is_null(), "{integral}: {perfect}");
        let (gaussian, simple) = (last(&study, "importance"), last(&study, "random"));
        assert!(gaussian["rmse"].as_f64() < simple["rmse"].as_f64(), "{integral}");
        assert!(gaussian["runs"] == 256 && last(&study, "uniform")["runs"] == 1, "{integral}");
    }
}

/// Every figure of the CSV is a number, there is a row a rule and N, and the figure's marks and words lie in it.
#[test]
fn files_hold_the_study() {
    let folder = folder();
    let dir = folder.path();
    let words = ["step", "--max-n", "64", "--json", "-o", "a.svg", "-o", "a.csv", "-o", "a.json"];
    let ended = drt(dir, &[&["converge"][..], &words].concat());
    assert!(ended.expect(0, &[]).err.contains("wrote a.svg, a.csv, a.json in"), "{}", ended.err);
    assert_eq!(fs::read_to_string(dir.join("a.json")).unwrap(), ended.out);
    let study: Value = serde_json::from_str(&ended.out).unwrap();
    for key in ["version", "settings", "max_n", "seeds", "seed", "complete", "reference", "rules"] {
        assert!(!study[key].is_null(), "{key}");
    }
    let efficiency = last(&study, "random")["efficiency"].as_f64().unwrap();
    let cost = ["relmse", "seconds"].map(|key| last(&study, "random")[key].as_f64().unwrap());
    assert!((efficiency * cost[0] * cost[1] - 1.0).abs() < 1e-12);

    let csv = fs::read_to_string(dir.join("a.csv")).unwrap();
    let mut lines = csv.lines();
    assert_eq!(lines.next(), Some("rule,n,runs,rmse,relmse,seconds,rays"));
    let rows: Vec<Vec<&str>> = lines.map(|line| line.split(',').collect()).collect();
    assert_eq!(rows.len(), 8 * 4);
    for row in &rows {
        let figures: Vec<f64> = row[1..].iter().map(|word| word.parse().expect("a number")).collect();
        assert!(figures.len() == 6 && figures.iter().all(|v| v.is_finite() && *v >= 0.0), "{row:?}");
        assert_eq!(figures[0], figures[5], "one evaluation a sample: {row:?}");
        let points = rule(&study, row[0])["points"].as_array().unwrap();
        let point = points.iter().find(|point| point["n"].as_f64() == Some(figures[0])).expect("a point");
        let same = ["n", "runs", "rmse", "relmse", "seconds", "rays"].map(|key| point[key].as_f64().unwrap());
        let is_same = |(a, b): (&f64, f64)| (a - b).abs() <= 1e-12 * b;
        assert!(figures.iter().zip(same).all(is_same), "{row:?} {same:?}");
    }

    let svg = fs::read_to_string(dir.join("a.svg")).unwrap();
    assert!(
        svg.starts_with("<svg width=\"860\" height=\"540\" viewBox=\"0 0 8600 5400\"")
            && svg.ends_with("</svg>\n")
    );
    for word in
        ["step", "importance-exact", "exact", "slope −1.00 ± 0.00", "closed form, 4.666", "64 runs", "−1/2"]
    {
        assert!(svg.contains(word), "{word}");
    }
    for (name, most) in [("x=\"", 8600.0), ("y=\"", 5400.0)] {
        for text in svg.split("<text ").skip(1) {
            let value: f64 =
                text.split(name).nth(1).and_then(|t| t.split('"').next()).unwrap().parse().unwrap();
            assert!((0.0..most).contains(&value), "{text}");
        }
    }
}

#[test]
fn the_table_is_the_answer_unless_json_or_quiet() {
    let folder = folder();
    let dir = folder.path();
    let table = drt(dir, &["converge", "smooth", "--rules", "random, uniform", "--max-n", "64"]).out;
    let first: Vec<&str> = table.lines().filter_map(|line| line.split_whitespace().next()).collect();
    assert_eq!(first, ["smooth:", "reference:", "rule", "uniform", "random"]);
    assert_eq!(drt(dir, &["converge", "smooth", "-q", "-o", "a.csv"]).expect(0, &[]).out, "");
    let csv = fs::read_to_string(dir.join("a.csv")).unwrap();
    assert_eq!(csv.lines().count(), 1 + 8 * 7);
}

/// Nothing but a constant sky: every rule is exact, and the figure says so instead of taking a logarithm of 0.
#[test]
fn no_error_at_all_is_exact() {
    let folder = folder();
    let dir = folder.path();
    fs::write(dir.join("sky.toml"), "[film]\nsize = [8, 8]\n[[light]]\ntype = \"environment\"\n").unwrap();
    let study = study(dir, &["sky.toml", "--max-n", "16", "-o", "sky.svg"]);
    for name in ["random", "stratified", "sobol"] {
        assert!(rule(&study, name)["exact"] == true && last(&study, name)["rmse"] == 0.0);
        assert!(last(&study, name)["efficiency"].is_null());
    }
    let svg = fs::read_to_string(dir.join("sky.svg")).unwrap();
    // An axis of nothing shows something.
    for word in ["exact", "\n0.1\n", "\n1\n"] {
        assert!(svg.contains(word), "{word:?} not in {svg}");
    }
}

#[test]
fn mistakes_are_one_line_before_the_work() {
    let folder = folder();
    let dir = folder.path();
    fs::create_dir(dir.join("d.svg")).unwrap();
    let cases: &[(&[&str], i32, &[&str])] = &[
        (&["smoth"], 1, &["smoth: no such file", "did you mean \"smooth\"", "smooth, step, peak"]),
        (&["qqq"], 1, &["qqq: no such file; built-in integrals are smooth, step, peak"]),
        (&["none.toml"], 1, &["none.toml"]),
        (&["smooth", "--rules", "randm"], 2, &["--rules", "unknown rule \"randm\"", "\"random\""]),
        (&["s.toml", "--rules", "random,halton"], 2, &["--rules", "\"halton\"", "sobol"]),
        (&["smooth", "--rules", ""], 2, &["--rules"]),
        (&["s.toml", "--vary", "pixl"], 2, &["--vary", "\"pixl\"", "\"pixel\""]),
        (&["smooth", "--max-n", "0"], 2, &["--max-n: must be a whole number from 1 to 16777216, not \"0\""]),
        (&["s.toml", "--max-n", "65537"], 2, &["--max-n: must be a whole number from 1 to 65536"]),
        (&["smooth", "--seeds", "-1"], 2, &["--seeds: must be a whole number from 1 to 65536"]),
        (&["smooth", "--seed", "x"], 2, &["--seed: must be a whole number from 0 to"]),
        (&["smooth", "--threads", "0"], 2, &["--threads"]),
        (&["smooth", "--progress", "bar"], 2, &["--progress", "\"bar\""]),
        (&["smooth", "--size", "4x4"], 2, &["--size is for scenes; smooth is an integral"]),
        (&["s.toml", "--size", "4"], 2, &["--size 4"]),
        (&["s.toml", "--set", "film.sise=[4,4]"], 2, &["film.sise"]),
        (&["smooth", "-o", "a.png"], 1, &["a.png", "\".png\"", "svg, csv, json"]),
        (&["smooth", "-o", "a"], 1, &["a:", "no extension", "svg, csv, json"]),
        (&["smooth", "-o", "-"], 1, &["no extension"]),
        (&["smooth", "-o", "none/a.svg"], 1, &["none/a.svg", "does not exist"]),
        (&["smooth", "-o", "d.svg"], 1, &["d.svg", "folder"]),
        (&["smooth", "-o", "a.svg", "-o", "./a.svg"], 2, &["named twice"]),
        (&["s.toml", "--reference", "none.exr"], 1, &["none.exr"]),
        (&["s.toml", "--reference", "s.toml"], 1, &["s.toml", "not a picture"]),
    ];
    for (words, code, said) in cases {
        let ended = drt(dir, &[&["converge"][..], words].concat());
        ended.expect(*code, said);
        assert_eq!((ended.out.as_str(), ended.err.lines().count()), ("", 1), "{words:?}: {}", ended.err);
    }
    drt(dir, &["s.toml", "-q", "-o", "truth.exr"]).expect(0, &[]);
    drt(dir, &["converge", "s.toml", "--size", "8x8", "--reference", "truth.exr"])
        .expect(2, &["--reference has 16x12 pixels", "8x8"]);
    assert_eq!(names(dir), ["d.svg", "s.toml", "t.obj", "truth.exr"]);
}
