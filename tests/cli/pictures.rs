//! Runs that end well.

use super::{drt, folder, names};
use std::fs;

const SMALL: [&str; 6] = ["--size", "16x12", "--spp", "2", "--backend", "bvh"];

fn with<'w>(words: &[&'w str]) -> Vec<&'w str> {
    words.iter().copied().chain(SMALL).collect()
}

#[test]
fn one_word_makes_a_picture_in_the_current_folder() {
    let folder = folder();
    let dir = folder.path();
    fs::create_dir(dir.join("here")).unwrap();
    let ended = drt(&dir.join("here"), &with(&["../t.obj"]));
    ended.expect(0, &[]);
    assert!(ended.out.is_empty());
    assert_eq!(names(&dir.join("here")), ["t.png"]);
    let quiet = drt(&dir.join("here"), &with(&["../t.obj", "-q"]));
    quiet.expect(0, &[]);
    assert!(quiet.err.is_empty(), "{}", quiet.err);
}

#[test]
fn the_same_bytes_on_any_number_of_threads() {
    let folder = folder();
    let dir = folder.path();
    for (threads, name) in [("1", "a.exr"), ("3", "b.exr")] {
        drt(dir, &with(&["t.obj", "--ground", "--threads", threads, "-o", name])).expect(0, &[]);
    }
    assert_eq!(fs::read(dir.join("a.exr")).unwrap(), fs::read(dir.join("b.exr")).unwrap());
}

#[test]
fn stats_have_every_key() {
    let folder = folder();
    let ended = drt(folder.path(), &with(&["s.toml", "-q", "--stats", "-", "--seed", "7"]));
    ended.expect(0, &[]);
    let stats: serde_json::Value = serde_json::from_str(&ended.out).unwrap();
    for key in [
        "version",
        "backend",
        "isa",
        "threads",
        "seed",
        "spp",
        "width",
        "height",
        "triangles",
        "vertices",
        "skipped_faces",
        "warnings",
        "seconds",
        "cpu_seconds",
        "rays",
        "rejected_rays",
        "invalid_samples",
        "peak_rss_bytes",
        "bvh_bytes",
        "seconds_in",
    ] {
        assert!(!stats[key].is_null(), "{key}");
    }
    for key in ["load", "build", "render", "write", "total"] {
        assert!(stats["seconds"][key].is_number() && stats["cpu_seconds"][key].is_number(), "{key}");
    }
    assert_eq!((stats["triangles"].as_u64(), stats["seed"].as_u64()), (Some(4), Some(7)));
    // Whole 8×8 tiles are traced: 16×16 pixels twice.
    assert!(stats["rays"]["camera"].as_u64() >= Some(16 * 12 * 2));
}

#[test]
fn findings_are_summed_up_and_strict_refuses_them() {
    let folder = folder();
    let dir = folder.path();
    let bad = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 9\nf 1 2 10\n";
    fs::write(dir.join("bad.obj"), bad).unwrap();
    let ended = drt(dir, &with(&["bad.obj", "--stats", "s.json"]));
    ended.expect(0, &[]);
    assert_eq!(ended.err.lines().filter(|l| l.starts_with("warning: ")).count(), 1, "{}", ended.err);
    assert!(ended.err.contains("bad.obj:5:") && ended.err.contains("2 in all"), "{}", ended.err);
    let stats: serde_json::Value = serde_json::from_slice(&fs::read(dir.join("s.json")).unwrap()).unwrap();
    assert_eq!(stats["skipped_faces"].as_u64(), Some(2));
    fs::remove_file(dir.join("bad.png")).unwrap();
    drt(dir, &with(&["bad.obj", "--strict"])).expect(1, &["bad.obj:5:", "--strict"]);
    assert!(!dir.join("bad.png").exists());
}

#[test]
fn a_dark_scene_says_so_and_renders() {
    let folder = folder();
    let dir = folder.path();
    fs::write(dir.join("dark.toml"), "[[mesh]]\nfile = \"t.obj\"\n").unwrap();
    let ended = drt(dir, &with(&["dark.toml"]));
    ended.expect(0, &[]);
    assert!(ended.err.contains("no light in the scene"), "{}", ended.err);
}

#[test]
fn thin_pictures_work() {
    let folder = folder();
    for size in ["1x1", "1x100000"] {
        drt(folder.path(), &["t.obj", "--spp", "1", "--size", size, "--backend", "bvh"]).expect(0, &[]);
    }
}

#[test]
fn progress_in_json_is_one_object_a_line() {
    let folder = folder();
    let ended = drt(folder.path(), &with(&["t.obj", "--progress", "json"]));
    ended.expect(0, &[]);
    let lines: Vec<&str> = ended.err.lines().filter(|l| l.starts_with('{')).collect();
    assert!(!lines.is_empty());
    for line in lines {
        let object: serde_json::Value = serde_json::from_str(line).unwrap();
        assert!(object["phase"].is_string() && object["share"].is_number(), "{line}");
    }
}

/// The first signal ends a render within two seconds, with the samples done in the picture.
#[test]
fn an_interrupted_render_keeps_what_is_done() {
    let folder = folder();
    let dir = folder.path();
    for (signal, code) in [(signal_hook::consts::SIGINT, 130), (signal_hook::consts::SIGTERM, 143)] {
        let mut command = std::process::Command::new(assert_cmd::cargo::cargo_bin("drt"));
        let words =
            ["t.obj", "--size", "64x48", "--spp", "1048576", "--backend", "bvh", "--progress", "json"];
        command.current_dir(dir).args(words).stderr(std::process::Stdio::piped());
        let mut child = command.spawn().unwrap();
        let mut err = std::io::BufReader::new(child.stderr.take().unwrap());
        let mut said = String::new();
        // No clock: the signal is sent once the render has said that it is under way.
        while !said.contains("\"phase\":\"render\"") {
            assert!(std::io::BufRead::read_line(&mut err, &mut said).unwrap() > 0, "{said}");
        }
        let pid = rustix::process::Pid::from_child(&child);
        let number = rustix::process::Signal::from_named_raw(signal).unwrap();
        rustix::process::kill_process(pid, number).unwrap();
        std::io::Read::read_to_string(&mut err, &mut said).unwrap();
        assert_eq!(child.wait().unwrap().code(), Some(code), "{said}");
        assert!(said.contains("error: stopped by SIG"), "{said}");
        assert_eq!(names(dir), ["s.toml", "t.obj", "t.png"]);
        fs::remove_file(dir.join("t.png")).unwrap();
    }
}
