//! Rows D of the table of failures: outputs that are replaced whole or not at all, full disks, signals.

use super::universal::{Run, engines, installed, tiny};
use super::{folder, names};
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::os::unix::fs::{MetadataExt, PermissionsExt};
use std::path::Path;
use std::process::{Child, Command, Stdio};

#[test]
fn d1_an_existing_output_is_replaced_whole() {
    let folder = folder();
    let dir = folder.path();
    for name in ["x.exr", "x.png", "x.jpg", "x.hdr", "x.pfm"] {
        fs::write(dir.join(name), "old").unwrap();
        fs::set_permissions(dir.join(name), fs::Permissions::from_mode(0o640)).unwrap();
        fs::hard_link(dir.join(name), dir.join("linked")).unwrap();
        let before = fs::metadata(dir.join(name)).unwrap();
        Run::new(dir, &tiny(&["s.toml", "-o", name], &[])).check().expect(0, &[]);
        let after = fs::metadata(dir.join(name)).unwrap();
        assert_ne!(before.ino(), after.ino(), "{name} was written in place");
        assert_eq!(after.permissions().mode() & 0o777, 0o640, "{name}");
        assert_eq!(fs::read(dir.join("linked")).unwrap(), b"old", "{name}");
        fs::remove_file(dir.join("linked")).unwrap();
    }
}

/// The disk is full, or the file-size limit is reached: one error, the old bytes, no temporary file.
#[test]
fn d2_no_space_left_keeps_the_old_file() {
    let folder = folder();
    let dir = folder.path();
    Run::new(dir, &tiny(&["s.toml", "-o", "/dev/full"], &[]))
        .check()
        .expect(1, &["/dev/full", "No space left"]);
    Run::new(dir, &tiny(&["s.toml", "-o", "x.exr", "--stats", "/dev/full"], &[]))
        .check()
        .expect(1, &["/dev/full", "No space left"]);
    for name in ["y.exr", "y.png", "y.hdr", "y.pfm"] {
        fs::write(dir.join(name), "old").unwrap();
        // One block of 512 bytes or 1 KiB, and 64×48 pixels of noise: SIGXFSZ must not end the program.
        let words = ["t.obj", "--ground", "--size", "64x48", "--spp", "1", "-o", name];
        let ended = Run::new(dir, &words).limits("ulimit -f 1").check();
        ended.expect(1, &[name, "File too large"]);
        assert_eq!(fs::read(dir.join(name)).unwrap(), b"old");
    }
    if installed("strace") {
        each_failing_call(dir);
    }
}

/// Lets the k-th call of every kind that writing needs fail, for the first few k.
fn each_failing_call(dir: &Path) {
    let program = assert_cmd::cargo::cargo_bin("drt");
    let calls = [
        ("write", "ENOSPC"),
        ("write", "EIO"),
        ("fsync", "EIO"),
        ("linkat", "ENOSPC"),
        ("rename", "ENOSPC"),
        ("fchmod", "EIO"),
    ];
    for (call, error) in calls {
        for k in 1..=3 {
            fs::write(dir.join("z.exr"), "old").unwrap();
            fs::set_permissions(dir.join("z.exr"), fs::Permissions::from_mode(0o600)).unwrap();
            let inject = format!("inject={call}:error={error}:when={k}");
            let mut command = Command::new("strace");
            command.args(["-f", "-qq", "-o", "/dev/null", "-e", &format!("trace={call}"), "-e", &inject]);
            command
                .arg(&program)
                .args(tiny(&["s.toml", "-q", "-o", "z.exr", "--threads", "1"], &["--backend", "bvh"]));
            let output = command.current_dir(dir).output().unwrap();
            let err = String::from_utf8_lossy(&output.stderr).into_owned();
            if err.contains("strace:") {
                eprintln!("SKIPPED a part of this test: strace may not trace here: {err}");
                return;
            }
            assert!(matches!(output.status.code(), Some(0 | 1)), "{inject}: {err}");
            let bytes = fs::read(dir.join("z.exr")).unwrap();
            // A fault that does not happen proves nothing: every output is renamed, by this very call.
            assert!((call, k) != ("rename", 1) || output.status.code() == Some(1), "{inject} did not happen");
            if output.status.code() == Some(1) {
                assert_eq!(bytes, b"old", "{inject}: {err}");
            } else {
                drt::load::picture::read(&dir.join("z.exr")).unwrap();
            }
            assert!(names(dir).iter().all(|n| !n.starts_with(".drt-")), "{inject}: a temporary file is left");
        }
    }
}

/// Starts a render that would take days.
fn endless(dir: &Path, input: &str, engine: &[&str]) -> (Child, BufReader<std::process::ChildStderr>) {
    let mut command = Command::new(assert_cmd::cargo::cargo_bin("drt"));
    let words = [input, "--size", "64x48", "--spp", "1048576", "--progress", "json", "-o", "x.exr"];
    command.args(words).args(engine).current_dir(dir).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    let err = BufReader::new(child.stderr.take().unwrap());
    (child, err)
}

pub fn send(child: &Child, signal: rustix::process::Signal) {
    rustix::process::kill_process(rustix::process::Pid::from_child(child), signal).unwrap();
}

/// Reads what the program says until it has begun `phase`.
fn wait_for(err: &mut impl BufRead, phase: &str) -> String {
    let (said, begun) = said_until(err, phase);
    assert!(begun, "{said}");
    said
}

/// What the program says until it has begun `phase`, and whether it came so far at all.
pub fn said_until(err: &mut impl BufRead, phase: &str) -> (String, bool) {
    let mut said = String::new();
    loop {
        if said.contains(&format!("\"phase\":\"{phase}\"")) {
            return (said, true);
        }
        if err.read_line(&mut said).unwrap() == 0 {
            return (said, false);
        }
    }
}

/// A mesh large enough that loading and building take a while.
fn large(dir: &Path) {
    let side = 400;
    let mut text = String::with_capacity(16 << 20);
    for i in 0..side * side {
        let (x, y) = (i % side, i / side);
        text += &format!("v {x} {y} {}\n", (x * 7919 + y * 104_729) % 13);
    }
    for i in 0..side * (side - 1) - 1 {
        text += &format!("f {} {} {} {}\n", i + 1, i + 2, i + side + 2, i + side + 1);
    }
    fs::write(dir.join("large.obj"), text).unwrap();
}

/// Whatever phase it is in: the first signal ends the program, with its code; a picture is whole and marked, or
/// not there. The render itself would take days, so that a signal that is not obeyed is noticed.
#[test]
fn d4_the_first_signal_ends_every_phase() {
    let folder = folder();
    let dir = folder.path();
    large(dir);
    use rustix::process::Signal;
    for engine in engines() {
        for phase in ["load", "build", "render"] {
            for (signal, code) in [(Signal::INT, 130), (Signal::TERM, 143)] {
                let (mut child, mut err) = endless(dir, "large.obj", &engine);
                let mut said = wait_for(&mut err, phase);
                send(&child, signal);
                err.read_to_string(&mut said).unwrap();
                assert_eq!(child.wait().unwrap().code(), Some(code), "{phase}: {said}");
                let errors = said.lines().filter(|l| l.starts_with("error: stopped by SIG")).count();
                assert_eq!(errors, 1, "{phase}: {said}");
                assert!(names(dir).iter().all(|n| !n.starts_with(".drt-")));
                if dir.join("x.exr").exists() {
                    drt::load::picture::read(&dir.join("x.exr")).unwrap();
                    let bytes = fs::read(dir.join("x.exr")).unwrap();
                    let mark = b"\"complete\":false";
                    assert!(bytes.windows(mark.len()).any(|w| w == mark), "the picture is not marked");
                    fs::remove_file(dir.join("x.exr")).unwrap();
                }
            }
        }
    }
}

/// Two signals at once: the second does not wait for anything.
#[test]
fn d4_the_second_signal_ends_at_once() {
    let folder = folder();
    let dir = folder.path();
    use rustix::process::Signal;
    let (mut child, mut err) = endless(dir, "t.obj", &["--backend", "bvh"]);
    wait_for(&mut err, "render");
    // Stopped, so that both are there when it goes on.
    send(&child, Signal::STOP);
    send(&child, Signal::INT);
    send(&child, Signal::TERM);
    send(&child, Signal::CONT);
    let mut said = String::new();
    err.read_to_string(&mut said).unwrap();
    let code = child.wait().unwrap().code();
    assert!(matches!(code, Some(130 | 143)), "{code:?}: {said}");
    assert_eq!(names(dir), ["s.toml", "t.obj"], "the second signal writes nothing");
}
