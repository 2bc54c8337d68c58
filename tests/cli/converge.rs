//! `drt converge`: slopes that theory knows, files that can be read, mistakes in one line, Ctrl-C.

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

/// A point's error is the one that `drt compare` finds between the reference and the picture that the rule's settings
/// give: what is varied and what is rendered are the same.
#[test]
fn a_scenes_errors_are_those_of_its_pictures() {
    let folder = folder();
    let dir = folder.path();
    let directions = |rule: &str| {
        let integrator =
            format!("render.integrator={{ type = \"distribution\", {rule}, directions = [[4, 4], 1] }}");
        let centres = "film.rule={ type = \"uniform\", grid = [1, 1] }".to_string();
        vec![integrator, centres, "render.max_depth=1".to_string()]
    };
    let points = |rule: &str, sampler: &str| {
        let sampler = format!("render.sampler={sampler}");
        vec![format!("film.rule={rule}"), "render.spp=16".to_string(), sampler]
    };
    let grid = |name: &str| format!("{{ type = \"{name}\", grid = [4, 4] }}");
    let by_light = |mut set: Vec<String>, lights: &str| {
        set.push(format!("render.lights={lights}"));
        set
    };
    let importance = || directions("rule = \"importance\"");
    let hemisphere = vec![
        ("uniform", directions("rule = \"uniform\"")),
        ("uniform-corner", directions("rule = \"uniform-corner\"")),
        ("random", directions("rule = \"random\"")),
        ("stratified", directions("rule = \"stratified\"")),
        ("nonuniform", directions("rule = \"nonuniform\"")),
        ("nonuniform-random", directions("rule = \"nonuniform\", per_cell = 1")),
        ("importance-bsdf", by_light(importance(), "bsdf")),
        ("importance-light", by_light(importance(), "light")),
        ("importance", importance()),
        ("sobol", directions("rule = \"sobol\"")),
    ];
    let pixel = vec![
        ("uniform", points(&grid("uniform"), "random")),
        ("uniform-corner", points(&grid("uniform-corner"), "random")),
        ("random", points("random", "random")),
        ("stratified", points(&grid("stratified"), "stratified")),
        ("nonuniform", points(&grid("nonuniform"), "random")),
        ("importance", points("importance", "random")),
        ("sobol", points("sampler", "sobol")),
    ];
    drt(dir, &["s.toml", "-q", "--spp", "512", "--seed", "99", "-o", "truth.exr"]).expect(0, &[]);
    for (vary, rules) in [("hemisphere", hemisphere), ("pixel", pixel)] {
        let words = ["s.toml", "--vary", vary, "--reference", "truth.exr", "--max-n", "16", "--seed", "7"];
        let study = study(dir, &words);
        assert_eq!(study["reference"]["description"], "truth.exr");
        assert_eq!(study["rules"].as_array().map(Vec::len), Some(rules.len()), "{vary}");
        for (name, set) in rules {
            let mut words = vec!["s.toml", "-q", "--seed", "7", "-o", "a.exr"];
            words.extend(set.iter().flat_map(|s| ["--set", s.as_str()]));
            drt(dir, &words).expect(0, &[]);
            let compared: Value =
                serde_json::from_str(&drt(dir, &["compare", "a.exr", "truth.exr", "--json"]).out).unwrap();
            let point = last(&study, name);
            let rmse = point["rmse"].as_f64().unwrap();
            assert_eq!(point["n"], 16);
            let ratio = rmse * rmse / compared["mse"].as_f64().unwrap();
            assert!((ratio - 1.0).abs() < 1e-12, "{vary} {name}: {ratio}");
            let relative = point["relmse"].as_f64().unwrap() / compared["relmse"].as_f64().unwrap();
            assert!((relative - 1.0).abs() < 1e-12, "{vary} {name}");
        }
    }
}

/// Several runs: the mean of their squared errors.
#[test]
fn runs_are_averaged_by_their_squares() {
    let folder = folder();
    let square = |words: &[&str]| {
        let all = [&["peak", "--rules", "random", "--max-n", "4"][..], words].concat();
        last(&study(folder.path(), &all), "random")["rmse"].as_f64().unwrap().powi(2)
    };
    let (a, b) = (square(&["--seeds", "1", "--seed", "5"]), square(&["--seeds", "1", "--seed", "6"]));
    let both = square(&["--seeds", "2", "--seed", "5"]);
    assert!(a != b && (both - 0.5 * (a + b)).abs() < 1e-15, "{a} {b} {both}");
}

/// A scene without a reference gets one, with seeds that no run has and an error of its own below theirs.
#[test]
fn a_scene_gets_a_long_run_as_its_reference() {
    let folder = folder();
    let dir = folder.path();
    let pixel = ["--vary", "pixel"];
    let long = study(
        dir,
        &[&pixel[..], &["t.obj", "--set", "film.size=[12,8]", "--max-n", "64", "--seeds", "2"]].concat(),
    );
    let reference = &long["reference"];
    assert_eq!(reference["description"], "path, sobol sampler, 1024 samples a pixel, seeds 2 and 3");
    assert_eq!(long["settings"]["size"], serde_json::json!([12, 8]));
    let own = reference["rmse"].as_f64().unwrap();
    for name in ["random", "stratified", "sobol"] {
        let points = rule(&long, name)["points"].as_array().unwrap();
        assert_eq!(points.iter().map(|p| p["n"].as_u64().unwrap()).collect::<Vec<_>>(), [1, 4, 16, 64]);
        assert!(own > 0.0 && own < points[0]["rmse"].as_f64().unwrap(), "{name}");
        for point in points {
            assert_eq!(point["fitted"], point["rmse"].as_f64().unwrap() > 2.0 * own, "{point}");
        }
    }
    let slope = |name: &str| rule(&long, name)["slope"]["value"].as_f64().unwrap();
    assert!((slope("random") + 0.5).abs() < 0.1 && slope("sobol") < slope("random"), "{}", slope("random"));

    // Its own error: half of what lies between its two halves.
    let short = study(dir, &["s.toml", "--vary", "pixel", "--max-n", "1"]);
    for seed in ["1", "2"] {
        let file = format!("{seed}.exr");
        drt(dir, &["s.toml", "-q", "--spp", "8", "--seed", seed, "-o", &file]).expect(0, &[]);
    }
    let between: Value =
        serde_json::from_str(&drt(dir, &["compare", "1.exr", "2.exr", "--json"]).out).unwrap();
    let half = 0.5 * between["mse"].as_f64().unwrap().sqrt();
    assert!((short["reference"]["rmse"].as_f64().unwrap() / half - 1.0).abs() < 1e-12, "{half}");
}

/// Small unless its size is asked for; what else is said of the film does not count.
#[test]
fn a_scenes_picture_is_small_by_default() {
    let folder = folder();
    let size = |words: &[&str]| {
        let all = [&["t.obj", "--max-n", "1", "--rules", "sobol"][..], words].concat();
        study(folder.path(), &all)["settings"]["size"].clone()
    };
    let small = size(&[]);
    assert_eq!(size(&["--set", "film.filter=gaussian"]), small);
    assert_eq!(small.as_array().unwrap().iter().map(|v| v.as_u64().unwrap()).max(), Some(96));
    assert_eq!(size(&["--size", "10x99"]), serde_json::json!([10, 99]));
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

/// The same figures on any number of threads, apart from the time they took.
#[test]
fn the_same_errors_on_any_number_of_threads() {
    fn without_time(value: &mut Value) {
        match value {
            Value::Object(object) => {
                object.retain(|key, _| key != "seconds" && key != "efficiency");
                object.values_mut().for_each(without_time);
            }
            Value::Array(items) => items.iter_mut().for_each(without_time),
            _ => {}
        }
    }
    let folder = folder();
    for input in [&["smooth"][..], &["s.toml", "--max-n", "16", "--seeds", "2"]] {
        let [one, two] = ["1", "2"].map(|threads| {
            let mut all = study(folder.path(), &[input, &["--threads", threads]].concat());
            without_time(&mut all);
            all
        });
        assert_eq!(one, two);
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

/// Starts a study that would take days.
fn endless(dir: &Path, words: &[&str]) -> (Child, BufReader<std::process::ChildStderr>) {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin("drt"));
    command.args(["converge", "--seeds", "65536", "--progress", "json", "--json"]).args(words);
    command.args(["-o", "x.svg", "-o", "x.csv"]).current_dir(dir);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
    let err = BufReader::new(child.stderr.take().unwrap());
    (child, err)
}

fn send(child: &Child, signal: rustix::process::Signal) {
    rustix::process::kill_process(rustix::process::Pid::from_child(child), signal).unwrap();
}

/// Reads until the program has said `word`.
fn wait_for(err: &mut impl BufRead, word: &str) -> String {
    let mut said = String::new();
    while !said.contains(word) {
        assert!(err.read_line(&mut said).unwrap() > 0, "{said}");
    }
    said
}

/// An integral's progress is told after a run, so that something is finished: it is written.
#[test]
fn a_study_that_is_stopped_writes_what_is_finished() {
    use rustix::process::Signal;
    for (signal, code, name) in [(Signal::INT, 130, "SIGINT"), (Signal::TERM, 143, "SIGTERM")] {
        let folder = folder();
        let dir = folder.path();
        let (mut child, mut err) = endless(dir, &["smooth", "--max-n", "16777216"]);
        let mut said = wait_for(&mut err, "\"phase\":\"study\"");
        send(&child, signal);
        let mut out = String::new();
        child.stdout.take().unwrap().read_to_string(&mut out).unwrap();
        err.read_to_string(&mut said).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(code), "{said}");
        let message = format!("error: stopped by {name}; what was finished is in x.svg, x.csv");
        assert_eq!(said.lines().last(), Some(message.as_str()));
        let study: Value = serde_json::from_str(&out).unwrap();
        assert_eq!(study["complete"], false);
        let runs = rule(&study, "uniform")["points"][0]["runs"].as_u64();
        assert_eq!(runs, Some(1), "{study}");
        assert!(fs::read_to_string(dir.join("x.csv")).unwrap().lines().count() > 1);
        assert!(fs::read_to_string(dir.join("x.svg")).unwrap().contains("Stopped before the end"));
    }
}

/// A scene, in whichever phase: the signal's code, and no part of a file.
#[test]
fn a_scenes_study_stops_in_every_phase() {
    use rustix::process::Signal;
    let folder = folder();
    let dir = folder.path();
    drt(dir, &["s.toml", "-q", "-o", "truth.exr"]).expect(0, &[]);
    for (phase, words) in [
        ("reference", &["s.toml", "--max-n", "65536"][..]),
        ("study", &["s.toml", "--max-n", "65536", "--reference", "truth.exr"]),
    ] {
        let (mut child, mut err) = endless(dir, words);
        let mut said = wait_for(&mut err, &format!("\"phase\":\"{phase}\""));
        send(&child, Signal::INT);
        err.read_to_string(&mut said).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(130), "{said}");
        let is_written = dir.join("x.svg").exists();
        assert_eq!(is_written, said.contains("what was finished is in x.svg, x.csv"), "{said}");
        assert!(is_written || said.contains("nothing was written"), "{said}");
        assert!(phase == "study" || !is_written, "{said}");
        assert!(names(dir).iter().all(|name| !name.starts_with(".drt-")));
    }
}

/// A pipe that nobody reads holds the writing up for ever: only the second signal can end it.
#[test]
fn the_second_signal_ends_a_study_at_once() {
    use rustix::process::Signal;
    let folder = folder();
    let dir = folder.path();
    assert!(Command::new("mkfifo").arg(dir.join("x.svg")).status().unwrap().success());
    let (mut child, mut err) = endless(dir, &["smooth", "--max-n", "16777216"]);
    wait_for(&mut err, "\"phase\":\"study\"");
    send(&child, Signal::INT);
    // Which of two signals is taken first is the system's choice, so the second is sent until it was the second.
    let begun = std::time::Instant::now();
    let ended = loop {
        send(&child, Signal::TERM);
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        // Judges nothing: it ends a program that hangs.
        if begun.elapsed().as_secs() > 60 {
            child.kill().unwrap();
        }
        std::thread::yield_now();
    };
    assert!(matches!(ended.code(), Some(130 | 143)), "{ended:?}");
    assert_eq!(names(dir), ["s.toml", "t.obj", "x.svg"], "the second signal writes nothing");
}

/// A reference that shows something else than what is studied is used, with a warning that says what it is.
#[test]
fn a_reference_of_something_else_is_told() {
    let folder = folder();
    let dir = folder.path();
    let render = |words: &[&str]| {
        drt(dir, &[&["s.toml", "-q"][..], words].concat()).expect(0, &[]);
    };
    let said = || drt(dir, &["converge", "s.toml", "--reference", "r.exr", "--max-n", "1"]).err;
    render(&["-o", "r.exr"]);
    assert!(said().contains("max_depth 16, and the study is with 1"), "{}", said());
    render(&["--max-depth", "1", "-o", "r.exr"]);
    assert!(said().contains("per_cell = SAMPLES"), "{}", said());
    let centres = "film.rule={ type = \"uniform\", grid = [1, 1], per_cell = 8 }";
    render(&["--max-depth", "1", "--set", centres, "-o", "r.exr"]);
    assert!(!said().contains("warning"), "{}", said());
}
