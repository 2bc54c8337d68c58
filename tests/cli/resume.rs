//! Rows D5 and D6 through the program: `--checkpoint`, `--resume`, killed and stopped renders, more samples.

use super::universal::engines;
use super::{drt, folder, names};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// All formats that hold all of it, of a picture with layers whose tiles do not fit its size.
const OUTPUTS: [&str; 4] = ["-o", "x.exr", "-o", "x.png"];
const PICTURE: [&str; 6] = ["--size", "45x29", "--aov", "depth,normal,ids", "--seed", "7"];

fn words<'w>(parts: &[&[&'w str]]) -> Vec<&'w str> {
    parts.concat()
}

/// The bytes of both pictures, which are removed.
fn take(dir: &Path) -> [Vec<u8>; 2] {
    ["x.exr", "x.png"].map(|name| {
        let bytes = fs::read(dir.join(name)).unwrap();
        drt::load::picture::read(&dir.join(name)).unwrap();
        fs::remove_file(dir.join(name)).unwrap();
        bytes
    })
}

/// Pseudo-random milliseconds below `most`, a different one for every `i`.
fn some(i: u64, most: u64) -> Duration {
    let mixed = (i + 1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    Duration::from_millis((mixed >> 33) % most)
}

/// Killed at any time and started again, as often as it takes: the same bytes as never stopped, nothing else left.
#[test]
fn d5_killed_at_any_time_the_same_bytes_come_out() {
    let folder = folder();
    let dir = folder.path();
    // One that takes no time to load, and one whose loading and building are hit as well.
    fs::write(dir.join("g.obj"), grid(150)).unwrap();
    let kills = if std::env::var_os("DRT_HEAVY_TESTS").is_some() { 200 } else { 10 };
    let engines: Vec<[&str; 4]> = engines().collect();
    let mut phases: BTreeMap<String, u64> = BTreeMap::new();
    let mut killed = 0;
    let mut round = 0;
    while killed < kills {
        let engine = engines[round % engines.len()];
        // A whole number of blocks, and one that cuts the last one short.
        let (mesh, spp) = [("t.obj", "512"), ("g.obj", "90")][round / engines.len() % 2];
        let job = words(&[&[mesh, "--ground"], &PICTURE, &["--spp", spp], &OUTPUTS, &engine[..2]]);
        drt(dir, &job).expect(0, &[]);
        let whole = take(dir);
        let kept = ["--checkpoint", "c", "--every", "20ms", "--resume", "--progress", "json"];
        loop {
            let said = dir.join("said");
            let mut command = Command::new(assert_cmd::cargo::cargo_bin("drt"));
            command
                .args(&job)
                .args(kept)
                .args(&engine[2..])
                .current_dir(dir)
                .stderr(fs::File::create(&said).unwrap());
            let mut child = command.spawn().unwrap();
            wait_at_most(&mut child, some(killed, 250));
            let _ = child.kill();
            let ended = child.wait().unwrap();
            let phase = last_phase(&said);
            if ended.success() {
                break;
            }
            killed += 1;
            *phases.entry(phase).or_default() += 1;
            all_is_old_or_whole(dir);
        }
        // A kill between the two names of a new file leaves one that the next run removes.
        let left = names(dir).into_iter().find(|n| n.starts_with(".drt-"));
        assert_eq!(left, None, "a temporary file is left");
        assert!(take(dir) == whole, "round {round}: {engine:?}, {spp} samples");
        fs::remove_file(dir.join("c")).unwrap();
        round += 1;
    }
    eprintln!("{killed} kills in {round} renders, by phase: {phases:?}");
    assert!(kills < 200 || phases.len() > 3, "not every phase was hit: {phases:?}");
}

/// Nothing but whole pictures and a whole checkpoint, or none.
fn all_is_old_or_whole(dir: &Path) {
    for name in ["x.exr", "x.png"] {
        if dir.join(name).exists() {
            drt::load::picture::read(&dir.join(name)).unwrap();
        }
    }
    if dir.join("c").exists() {
        drt::checkpoint::read(&fs::read(dir.join("c")).unwrap()).unwrap();
    }
}

/// A sheet of `2 n²` triangles that is not flat.
fn grid(n: usize) -> String {
    let vertex = |i: usize| format!("v {} {} {}\n", i % (n + 1), i * 7 % 5, i / (n + 1));
    let quad = |i: usize| {
        let a = i / n * (n + 1) + i % n + 1;
        format!("f {a} {} {} {}\n", a + 1, a + n + 2, a + n + 1)
    };
    (0..(n + 1) * (n + 1)).map(vertex).chain((0..n * n).map(quad)).collect()
}

/// The last phase that a program's progress names; `start` before the first.
fn last_phase(said: &Path) -> String {
    let text = fs::read_to_string(said).unwrap();
    let _ = fs::remove_file(said);
    let phase = |line: &str| {
        let value: serde_json::Value = serde_json::from_str(line).ok()?;
        value["phase"].as_str().map(str::to_string)
    };
    text.lines().rev().find_map(phase).unwrap_or_else(|| "start".to_string())
}

/// Waits for the end of `child`, but no longer than so.
fn wait_at_most(child: &mut std::process::Child, time: std::time::Duration) {
    let started = std::time::Instant::now();
    while started.elapsed() < time && matches!(child.try_wait(), Ok(None)) {
        std::thread::sleep(std::time::Duration::from_millis(2));
    }
}

/// Stopped by a signal, on other threads, in the middle of a crop: the same bytes.
#[test]
fn d5_a_stopped_crop_goes_on_with_other_threads() {
    let folder = folder();
    let dir = folder.path();
    let job = words(&[&["s.toml", "--crop", "3,5,30,17", "--spp", "4000"], &PICTURE, &OUTPUTS]);
    drt(dir, &job).expect(0, &[]);
    let whole = take(dir);
    let mut stops = 0;
    for threads in ["1", "2", "8"] {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin("drt"));
        let kept = ["--resume", "--threads", threads, "--progress", "json"];
        let mut child =
            command.args(&job).args(kept).current_dir(dir).stderr(Stdio::piped()).spawn().unwrap();
        let mut err = std::io::BufReader::new(child.stderr.take().unwrap());
        // What is left may be nothing: a busy machine delivers the signal late.
        if super::rows_output::said_until(&mut err, "render").1 {
            super::rows_output::send(&child, rustix::process::Signal::INT);
        }
        let _ = std::io::copy(&mut err, &mut std::io::sink());
        match child.wait().unwrap().code() {
            Some(130) => stops += 1,
            code => assert_eq!(code, Some(0)),
        }
    }
    assert!(stops > 0, "no run was stopped");
    drt(dir, &words(&[&job, &["--resume"]])).expect(0, &[]);
    assert!(take(dir) == whole);
    // The default name, and the picture stays extensible.
    assert_eq!(names(dir), ["s.toml", "t.obj", "x.exr.checkpoint"]);
}

/// More samples for a finished picture: the bytes of a render with all of them at once.
#[test]
fn a_finished_picture_can_get_more_samples() {
    let folder = folder();
    let dir = folder.path();
    for backend in drt::accel::Backend::ALL.iter().map(|b| b.name()) {
        let base = words(&[&["t.obj", "--ground", "--backend", backend], &PICTURE, &OUTPUTS]);
        for (first, then) in [("16", "64"), ("20", "50"), ("3", "33"), ("1", "5")] {
            drt(dir, &words(&[&base, &["--spp", then]])).expect(0, &[]);
            let whole = take(dir);
            let kept = ["--checkpoint", "c", "--resume", "--spp"];
            drt(dir, &words(&[&base, &kept, &[first]])).expect(0, &[]);
            take(dir);
            drt(dir, &words(&[&base, &kept, &[then]])).expect(0, &[]);
            assert!(take(dir) == whole, "{backend}: {first} and then {then}");
            // Nothing is left to trace, and the same pictures are written.
            drt(dir, &words(&[&base, &kept, &[then]])).expect(0, &[]);
            assert!(take(dir) == whole);
            fs::remove_file(dir.join("c")).unwrap();
        }
    }
}

/// Points that depend on their number are no beginning of more points.
#[test]
fn what_depends_on_the_number_of_samples_is_not_extended() {
    let folder = folder();
    let dir = folder.path();
    let rule = |rule: &str, n: u32| format!("film.rule={{ type = \"{rule}\", grid = [{n}, {n}] }}");
    let base = ["s.toml", "-o", "x.exr", "--checkpoint", "c", "--resume"];
    for name in ["uniform", "uniform-corner", "stratified", "nonuniform"] {
        drt(dir, &words(&[&base, &["--set", &rule(name, 2)]])).expect(0, &[]);
        drt(dir, &words(&[&base, &["--set", &rule(name, 4)]])).expect(1, &["c: ", "film.rule"]);
        fs::remove_file(dir.join("c")).unwrap();
    }
    let stratified = ["--sampler", "stratified", "--spp"];
    drt(dir, &words(&[&base, &stratified, &["4"]])).expect(0, &[]);
    drt(dir, &words(&[&base, &stratified, &["16"]])).expect(1, &["stratified sampler", "was 4", "--spp 4"]);
    drt(dir, &words(&[&base, &stratified, &["4"]])).expect(0, &[]);
    fs::remove_file(dir.join("c")).unwrap();
    drt(dir, &words(&[&base, &["--spp", "16"]])).expect(0, &[]);
    drt(dir, &words(&[&base, &["--spp", "5"]])).expect(1, &["c: ", "16 samples a pixel already", "--spp 16"]);
}

#[test]
fn d6_another_renders_checkpoint_is_refused_with_the_reason() {
    let folder = folder();
    let dir = folder.path();
    let base = ["s.toml", "-o", "x.exr", "--checkpoint", "c"];
    drt(dir, &base).expect(0, &[]);
    let mesh = fs::read_to_string(dir.join("t.obj")).unwrap();
    let kept = fs::read(dir.join("c")).unwrap();
    let resumed = words(&[&base, &["--resume"]]);
    let table: &[(&[&str], &str)] = &[
        (&["--seed", "1"], "render.seed = 0, and now it is 1"),
        (&["--size", "17x12"], "film.size = [16,12], and now it is [17,12]"),
        (&["--max-depth", "3"], "render.max_depth"),
        (&["--crop", "0,0,8,8"], "film.crop"),
        (&["--aov", "depth"], "film.aov"),
        (&["--clamp", "2"], "film.clamp = nothing, and now it is 2"),
        (&["--sampler", "random"], "render.sampler"),
        (&["--set", "film.filter=gaussian"], "film.filter"),
        (&["--set", "render.build=high"], "render.build"),
        (&["--set", "light.0.radiance=2"], "lights"),
        (&["--set", "camera.fov=30"], "camera"),
        (&["--ground"], "a scene with other"),
    ];
    for (change, reason) in table {
        drt(dir, &words(&[&resumed, change])).expect(1, &["c: the checkpoint", reason]);
    }
    if drt::accel::Backend::ALL.len() > 1 {
        drt(dir, &words(&[&resumed, &["--backend", "bvh"]])).expect(1, &["render.backend = embree"]);
    }
    // A face turned over moves no camera that frames the mesh.
    fs::write(dir.join("t.obj"), mesh.replace("f 1 3 2", "f 1 2 3")).unwrap();
    drt(dir, &resumed).expect(1, &["a scene with other meshes"]);
    // The same scene in other words, in another place, is the same scene.
    fs::create_dir(dir.join("other")).unwrap();
    fs::write(dir.join("other/u.obj"), format!("# moved\n{mesh}")).unwrap();
    let scene = fs::read_to_string(dir.join("s.toml")).unwrap().replace("t.obj", "other/u.obj");
    fs::write(dir.join("s.toml"), scene).unwrap();
    drt(dir, &resumed).expect(0, &[]);
    fs::write(dir.join("c"), &kept[..kept.len() - 1]).unwrap();
    drt(dir, &resumed).expect(1, &["c: the checkpoint is damaged"]);
    fs::write(dir.join("c"), "something of mine").unwrap();
    for words in [&resumed[..], &base[..]] {
        drt(dir, words).expect(1, &["c: is no checkpoint"]);
    }
    assert_eq!(fs::read(dir.join("c")).unwrap(), b"something of mine");
}

/// The words, the places, and what is said.
#[test]
fn checkpoints_as_users_meet_them() {
    let folder = folder();
    let dir = folder.path();
    drt(dir, &["t.obj", "--every", "5s"]).expect(2, &["--every", "--checkpoint"]);
    drt(dir, &["t.obj", "--checkpoint", "c", "--every", "soon"]).expect(2, &["--every", "60s"]);
    drt(dir, &["t.obj", "--resume", "-o", "/dev/null"]).expect(2, &["--resume", "--checkpoint"]);
    drt(dir, &["t.obj", "--checkpoint", "t.obj"]).expect(1, &["t.obj"]);
    drt(dir, &["t.obj", "--checkpoint", "x.png", "-o", "x.png"]).expect(2, &["named twice"]);
    drt(dir, &["t.obj", "--checkpoint", "no/c"]).expect(1, &["no/c", "does not exist"]);
    fs::write(dir.join("victim"), "precious").unwrap();
    std::os::unix::fs::symlink("victim", dir.join("link")).unwrap();
    drt(dir, &["t.obj", "--checkpoint", "link"]).expect(1, &["link", "symbolic link"]);
    assert_eq!(fs::read(dir.join("victim")).unwrap(), b"precious");
    for name in ["link", "victim"] {
        fs::remove_file(dir.join(name)).unwrap();
    }
    assert_eq!(names(dir), ["s.toml", "t.obj"]);
    let base = ["s.toml", "-o", "x.png", "--checkpoint", "c"];
    drt(dir, &base).expect(0, &[]);
    let again = drt(dir, &base);
    again.expect(0, &[]);
    assert!(again.err.contains("--resume goes on from"), "{}", again.err);
    let resumed = drt(dir, &words(&[&base, &["--resume"]]));
    resumed.expect(0, &[]);
    assert!(resumed.err.contains("c: has 2 of 2 samples a pixel"), "{}", resumed.err);
}

/// A full disk under the checkpoint is no reason to stop: it is said, and the picture is finished.
#[test]
fn d2_a_checkpoint_that_cannot_be_written_stops_nothing() {
    let folder = folder();
    let dir = folder.path();
    let base = ["s.toml", "--spp", "16", "-o", "x.png", "--checkpoint", "c"];
    drt(dir, &base).expect(0, &[]);
    let (kept, picture) = (fs::read(dir.join("c")).unwrap(), fs::read(dir.join("x.png")).unwrap());
    // The picture fits below the limit on file sizes (4 or 8 KiB), the checkpoint does not.
    let limited = words(&[&base, &["--seed", "3"]]);
    let ended = super::universal::Run::new(dir, &limited).limits("ulimit -f 8").check();
    ended.expect(0, &[]);
    assert!(ended.err.contains("warning: c: cannot write: File too large"), "{}", ended.err);
    assert!(fs::read(dir.join("c")).unwrap() == kept, "the old checkpoint is as it was");
    assert!(fs::read(dir.join("x.png")).unwrap() != picture);
    drt(dir, &words(&[&base, &["--resume"]])).expect(0, &[]);
    assert!(fs::read(dir.join("x.png")).unwrap() == picture);
}
