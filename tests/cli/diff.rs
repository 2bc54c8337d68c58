//! `drt diff-backends`: counts that add up, who is asked, mistakes in one line, Ctrl-C.

use super::{Ended, drt, folder, names};
use serde_json::Value;
use std::fs;
use std::path::Path;

const CLASSES: [&str; 6] = ["tie", "edge", "vertex", "graze", "sliver", "real"];

fn json(ended: &Ended) -> Value {
    serde_json::from_str(&ended.out).expect("JSON on standard output")
}

fn scene(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name).display().to_string()
}

fn number(value: &Value, key: &str) -> u64 {
    value[key].as_u64().unwrap_or_else(|| panic!("{key} in {value}"))
}

/// Every backend and instruction set is asked every ray, and every ray gets one verdict.
#[test]
fn a_sound_mesh_passes_and_its_counts_add_up() {
    let folder = folder();
    let dir = folder.path();
    let ended = drt(dir, &["diff-backends", &scene("ball.obj"), "--rays", "2000", "--json", "-o", "out"]);
    ended.expect(0, &[]);
    let report = json(&ended);
    let contestants = report["contestants"].as_array().unwrap();
    let version = drt(dir, &["--version"]).out;
    let listed = |title: &str| -> Vec<String> {
        let line = version.lines().find_map(|line| line.strip_prefix(title)).unwrap();
        let words = line.split(" (").next().unwrap();
        words.split(", ").map(str::to_string).collect()
    };
    for backend in listed("backends: ") {
        for isa in listed("instruction sets of this machine: ") {
            let own = contestants.iter().filter(|c| c["backend"] == *backend && c["isa"] == *isa);
            let qualities: Vec<&str> = own.map(|c| c["quality"].as_str().unwrap()).collect();
            assert!(qualities.contains(&"medium") && (backend == "bvh" || qualities.contains(&"low")));
        }
    }
    assert_eq!(report["reference"], contestants[0]["name"]);
    let mut total = 0;
    for contestant in contestants {
        for (kind, rays) in report["rays"].as_object().unwrap() {
            let tally = &contestant["kinds"][kind];
            assert_eq!(number(tally, "rays"), rays.as_u64().unwrap());
            assert!((1..=2000).contains(&number(tally, "rays")), "{kind}: {tally}");
            let verdicts: u64 = CLASSES.iter().map(|class| number(tally, class)).sum();
            assert_eq!(number(tally, "rays"), number(tally, "same") + verdicts);
            if contestant["backend"] == "bvh" {
                assert_eq!(number(tally, "rays"), number(tally, "same"), "the hierarchy has one answer");
            }
            total += number(tally, "rays");
        }
        assert!(contestant["build_seconds"].as_f64().unwrap() >= 0.0 && number(contestant, "bytes") > 0);
    }
    assert_eq!((number(&report["totals"], "rays"), number(&report["totals"], "real")), (total, 0));
    assert_eq!((&report["complete"], &report["cases"]), (&true.into(), &Value::Array(vec![])));
    assert_eq!(names(&dir.join("out")), ["report.json"]);
    let file: Value =
        serde_json::from_str(&fs::read_to_string(dir.join("out/report.json")).unwrap()).unwrap();
    assert_eq!(file, report);
}

#[test]
fn the_table_says_the_same_and_nothing_is_left_behind() {
    let folder = folder();
    let dir = folder.path();
    let ended = drt(dir, &["diff-backends", "t.obj", "--rays", "300", "--threads", "1"]);
    ended.expect(0, &[]);
    for words in ["camera", "million rays a second", "other than bvh", "nowhere", "none of them real"] {
        assert!(ended.out.contains(words), "{words:?} not in\n{}", ended.out);
    }
    assert_eq!(ended.err, "");
    assert_eq!(drt(dir, &["diff-backends", "s.toml", "--rays", "50", "-q"]).expect(0, &[]).out, "");
    assert_eq!(names(dir), ["s.toml", "t.obj"]);
}

/// Everything but the time is the same on any number of threads.
#[test]
fn the_same_counts_on_any_number_of_threads() {
    let folder = folder();
    let on = |threads: &str| {
        let words = ["diff-backends", "s.toml", "--rays", "1000", "--json", "--threads", threads];
        let mut report = json(drt(folder.path(), &words).expect(0, &[]));
        report["threads"] = Value::Null;
        for contestant in report["contestants"].as_array_mut().unwrap() {
            contestant["build_seconds"] = Value::Null;
            // Embree's allocator keeps blocks a thread.
            contestant["bytes"] = Value::Null;
            for tally in contestant["kinds"].as_object_mut().unwrap().values_mut() {
                tally["mrays_per_second"] = Value::Null;
            }
        }
        report
    };
    assert_eq!(on("1"), on("2"));
}

/// A ray on which all agree now: what a reproducer looks like once its fault is gone.
#[test]
fn a_reproducer_is_asked_again() {
    let folder = folder();
    let dir = folder.path();
    fs::write(dir.join("case-1.obj"), "o mesh-0\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    let case = "# what was found\n[case]\nmesh = \"case-1.obj\"\norigin = [0.25, 0.25, 1.0]\n\
                direction = [0.0, 0.0, -1.0]\ntmin = 0.0\ntmax = inf\n";
    fs::write(dir.join("case-1.toml"), case).unwrap();
    let ended = drt(dir, &["diff-backends", "case-1.toml", "--json"]);
    let report = json(ended.expect(0, &[]));
    // Alone, and as a packet of sixteen.
    assert_eq!((&report["rays"]["replay"], &report["triangles"]), (&17.into(), &1.into()));
    fs::write(dir.join("case-1.toml"), case.replace("tmax = inf", "")).unwrap();
    drt(dir, &["diff-backends", "case-1.toml"]).expect(1, &["case-1.toml:", "case.tmax must be a number"]);
    fs::write(dir.join("case-1.toml"), case).unwrap();
    fs::write(dir.join("case-1.obj"), "o mesh-0\nv 0 0 0\nf 1 2 3\n").unwrap();
    drt(dir, &["diff-backends", "case-1.toml"]).expect(1, &["case-1.obj:3:", "not a line of a reproducer"]);
}

/// What the tool found the first time it was run: a ray along a wall, past the edge of the roof, onto a lamp right under
/// the ceiling. Hits at edges were settled among all triangles within the wall's length, whatever lay between.
#[test]
fn a_lamp_is_not_passed_over_for_the_ceiling_behind_it() {
    let folder = folder();
    let dir = folder.path();
    let obj = "o mesh-0\nv 0.556 0.5488 0\nv 0 0.5488 0.5592\nv 0.556 0.5488 0.5592\nv 0.343 0.5487 0.227\n\
               v 0.343 0.5487 0.332\nv 0.213 0.5487 0.332\nv 0.423 0.33 0.247\nv 0.265 0.33 0.296\n\
               v 0.314 0.33 0.456\nv 0.265 0 0.296\nf 1 3 2\nf 4 5 6\nf 7 8 9\nf 10 8 7\n";
    let case = "[case]\nmesh = \"c.obj\"\norigin = [0.3001648485660553, 0.2874019145965576, 0.2850944399833679]\n\
                direction = [-0.0, 1.0, -0.0]\ntmin = 0.0\ntmax = inf\n";
    fs::write(dir.join("c.obj"), obj).unwrap();
    fs::write(dir.join("c.toml"), case).unwrap();
    drt(dir, &["diff-backends", "c.toml"]).expect(0, &[]);
}

/// Who is asked can be chosen; the first of the usual order is the one that the others are compared with.
#[test]
fn contestants_are_chosen() {
    let folder = folder();
    let asked = |list: &str| -> Vec<String> {
        let words = ["diff-backends", "t.obj", "--rays", "50", "--json", "--contestants", list];
        let report = json(drt(folder.path(), &words).expect(0, &[]));
        report["contestants"].as_array().unwrap().iter().map(|c| c["name"].to_string()).collect()
    };
    let qualities = asked("bvh-sse2");
    assert_eq!(qualities.len(), 3);
    assert_eq!(asked("bvh-low,bvh-medium,bvh-high").len() % 3, 0);
    assert_eq!(asked("sse2-high,bvh-sse2-medium")[0], qualities[0]);
}

#[test]
fn mistakes_are_named_before_any_work() {
    let folder = folder();
    let dir = folder.path();
    let cases: &[(&[&str], i32, &[&str])] = &[
        (&[], 2, &["required arguments were not provided"]),
        (&["t.obj", "--rays", "0"], 2, &["--rays", "from 1 to 100000000"]),
        (&["t.obj", "--rays", "-3"], 2, &["--rays", "-3"]),
        (&["t.obj", "--rays", "many"], 2, &["--rays", "many"]),
        (&["t.obj", "--threads", "0"], 2, &["--threads", "1 to 1024"]),
        (&["t.obj", "--progress", "loud"], 2, &["--progress", "loud"]),
        (&["t.obj", "--set", "render.spq=1"], 2, &["spq"]),
        (&["t.obj", "--jsno"], 2, &["--jsno"]),
        (&["t.obj", "--contestants", "bhv"], 2, &["bhv", "bvh"]),
        (&["t.obj", "--contestants", "bvh,"], 2, &["--contestants", "bvh,"]),
        (&["none.obj"], 1, &["none.obj"]),
        (&["t.obj", "-o", "t.obj"], 1, &["t.obj"]),
    ];
    for (words, code, said) in cases {
        let ended = drt(dir, &[&["diff-backends"][..], words].concat());
        ended.expect(*code, said);
        assert_eq!((ended.out.as_str(), ended.err.lines().count()), ("", 1), "{words:?}: {}", ended.err);
    }
    assert_eq!(names(dir), ["s.toml", "t.obj"]);
    let help = drt(dir, &["diff-backends", "--help"]);
    for word in CLASSES.iter().chain(&["leaks", "--rays", "--contestants"]) {
        assert!(help.expect(0, &[]).out.contains(word), "{word}");
    }
}

/// What is finished is reported, whichever phase the signal meets.
#[test]
fn a_signal_ends_it_with_what_is_finished() {
    use rustix::process::{Pid, Signal, kill_process};
    use std::io::{BufRead, BufReader, Read};
    use std::process::{Command, Stdio};
    let folder = folder();
    let mut command = Command::new(assert_cmd::cargo::cargo_bin("drt"));
    command.args(["diff-backends", "t.obj", "--rays", "3000000", "--json", "--progress", "json"]);
    command.current_dir(folder.path()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let mut err = BufReader::new(child.stderr.take().unwrap());
    let mut said = String::new();
    while !said.contains("\"phase\":\"diff\"") {
        assert!(err.read_line(&mut said).unwrap() > 0, "{said}");
    }
    kill_process(Pid::from_child(&child), Signal::INT).unwrap();
    let mut out = String::new();
    child.stdout.take().unwrap().read_to_string(&mut out).unwrap();
    err.read_to_string(&mut said).unwrap();
    assert_eq!(child.wait().unwrap().code(), Some(130), "{said}");
    let report: Value = serde_json::from_str(&out).unwrap();
    assert_eq!(report["complete"], false);
    assert!(said.lines().last().unwrap().starts_with("error: stopped by SIGINT; "), "{said}");
}
