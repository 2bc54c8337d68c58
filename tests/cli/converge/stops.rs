//! Studies that are stopped: Ctrl-C writes what is finished.

use super::*;

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
