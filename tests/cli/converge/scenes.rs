//! Studies of scenes: their errors are those of the pictures that the renderer writes.

use super::*;

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
