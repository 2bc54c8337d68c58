//! Rows C of the table of failures: the command line's words, inputs and outputs.

use super::universal::{Run, tiny};
use super::{drt, folder};
use std::fs;
use std::process::{Command, Stdio};

#[test]
fn c1_sizes_beyond_the_limit_allocate_nothing() {
    let folder = folder();
    let sizes = [
        "0x0",
        "0x5",
        "-1x5",
        "1000000000x1000000000",
        "4294967296x1",
        "4294967297x4294967297",
        "65536x65536",
    ];
    for size in sizes {
        // Not even one channel of the picture would fit in this address space.
        let words = ["t.obj", "--size", size, "-o", "x.exr"];
        let limited = Run::new(folder.path(), &words).limits("ulimit -v 300000").check();
        limited.expect(2, &["--size", "from 1 to 1048576"][..1 + usize::from(size != "65536x65536")]);
    }
    for size in ["1x1", "1x100000", "100000x1"] {
        let words = ["t.obj", "--size", size, "--spp", "1", "--backend", "bvh", "-o", "x.exr"];
        Run::new(folder.path(), &words).check().expect(0, &[]);
    }
}

/// The long flags that `drt render --help` lists.
fn flags() -> Vec<String> {
    let folder = folder();
    let help = drt(folder.path(), &["render", "--help"]).out;
    let words = help.lines().map(str::trim_start).filter(|line| line.starts_with('-'));
    let words = words.flat_map(|line| line.split_whitespace().take(2));
    let flags: Vec<String> = words.filter(|w| w.starts_with("--")).map(ToString::to_string).collect();
    assert!(flags.len() >= 18 && flags.contains(&"--spp".to_string()), "{flags:?}");
    flags
}

/// Every flag times every kind of nonsense; a new flag is in it the day it is listed. What is not refused must be
/// listed here as meant.
#[test]
fn c2_every_flag_refuses_nonsense_and_names_itself() {
    const MEANT: &[(&str, &str)] = &[
        ("--seed", "0"),
        ("--max-depth", "0"),
        ("--exposure", "0"),
        ("--exposure", "-1"),
        ("--max-texture-bytes", "0"), // no picture at all
        ("--max-unpacked", "0"),      // no packed file
        ("--frames", "0"),            // the first one
    ];
    for flag in flags() {
        for value in
            ["0", "-1", "nan", "inf", "1000000000000000000000000000000", "", "text", "٣", "1,0", "1e999"]
        {
            let folder = folder();
            let word = format!("{flag}={value}");
            println!("{word}");
            let ended = drt(folder.path(), &["s.toml", &word]);
            assert!(
                !ended.err.contains("panicked") && !ended.err.contains("internal"),
                "{word}: {}",
                ended.err
            );
            // Any name may be that of a file of statistics or of progress, or of a folder.
            let is_name =
                ["--stats", "--checkpoint", "--cache"].contains(&flag.as_str()) && !value.is_empty();
            if MEANT.contains(&(flag.as_str(), value)) || is_name {
                ended.expect(0, &[]);
            } else if flag == "--output" && !value.is_empty() {
                // A name without a known extension is a file that cannot be written.
                ended.expect(1, &[]);
            } else {
                ended.expect(2, &[&flag]);
            }
        }
    }
}

#[test]
fn c2_cameras_that_cannot_be() {
    let folder = folder();
    let camera = "camera.position=[0,0,4]";
    for (set, words) in [
        ("camera.fov=0", "camera.fov"),
        ("camera.fov=180", "camera.fov"),
        ("camera.fov=nan", "camera.fov"),
        ("camera.look_at=[0,0,4]", "same point"),
        ("camera.up=[0,0,1]", "parallel"),
        ("camera.up=[0,0,0]", "camera.up"),
        ("camera.position=[inf,0,0]", "camera.position"),
    ] {
        let words_of =
            ["s.toml", "--set", camera, "--set", "camera.look_at=[0,0,0]", "--set", set, "-o", "x.exr"];
        Run::new(folder.path(), &words_of).check().expect(2, &[words]);
    }
}

/// Depth 0 is emitted light alone: the sky in every pixel that sees it, black on what does not shine.
#[test]
fn c2_depth_zero_is_emission_only() {
    let folder = folder();
    Run::new(folder.path(), &tiny(&["s.toml", "--max-depth", "0", "-o", "x.exr"], &[]))
        .check()
        .expect(0, &[]);
    let picture = drt::load::picture::read(&folder.path().join("x.exr")).unwrap().image;
    let pixels = picture.rgb_pixels();
    assert!(pixels.iter().all(|p| *p == [0.0; 3] || *p == [1.0; 3]));
    assert!(pixels.contains(&[0.0; 3]) && pixels.contains(&[1.0; 3]));
}

#[test]
fn c3_inputs_with_awkward_names_and_unreadable_ones() {
    let folder = folder();
    let dir = folder.path();
    for name in [
        "with space.obj",
        "line\nbreak.obj",
        "--.obj",
        "-o.obj",
        "ünïcode.obj",
        "a;b|c&d.obj",
        ".obj.obj",
        "UPPER.OBJ",
    ] {
        fs::copy(dir.join("t.obj"), dir.join(name)).unwrap();
        let output = ["--size", "16x12", "--spp", "1", "-o", "x.exr", "--", name];
        let ended = Run::new(dir, &output).check();
        ended.expect(0, &[]);
        fs::remove_file(dir.join("x.exr")).unwrap();
    }
    Run::new(dir, &["-o", "x.exr", "--", ""]).check().expect(2, &["MESH|SCENE.toml"]);
    for name in [" ", "-", "--", "missing", "missing.obj", "missing.toml", "/", "."] {
        let ended = Run::new(dir, &["-o", "x.exr", "--", name]).check();
        ended.expect(1, &[]);
    }
    use std::os::unix::fs::PermissionsExt;
    fs::set_permissions(dir.join("UPPER.OBJ"), fs::Permissions::from_mode(0o000)).unwrap();
    if fs::File::open(dir.join("UPPER.OBJ")).is_ok() {
        eprintln!("SKIPPED a part of this test: this user may read anything");
    } else {
        Run::new(dir, &["UPPER.OBJ", "-o", "x.exr"]).check().expect(1, &["UPPER.OBJ", "ermission denied"]);
    }
}

/// With work for days ahead, an output that cannot be written is refused at once: before the first ray.
#[test]
fn c4_outputs_are_checked_before_the_work() {
    let folder = folder();
    let dir = folder.path();
    fs::create_dir(dir.join("d.exr")).unwrap();
    // Nobody, not even root, may make files here.
    for output in ["no/x.exr", "d.exr", "x.gif", "x", "/proc/x.exr", "t.obj/x.exr", "x.exr/"] {
        let words = ["s.toml", "--size", "4096x4096", "--spp", "1048576", "-o", output];
        let ended = Run::new(dir, &words).check();
        ended.expect(1, &[]);
        assert!(ended.err.contains(output), "{}", ended.err);
        let words = ["s.toml", "--size", "4096x4096", "--spp", "1048576", "-o", "good.exr", "-o", output];
        Run::new(dir, &words).check().expect(1, &[]);
    }
}

/// Runs drt with standard output going to a pipe that nobody reads.
fn unread(words: &[&str]) -> (Option<i32>, String) {
    let folder = folder();
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let mut command = Command::new(assert_cmd::cargo::cargo_bin("drt"));
    let command = command.args(words).current_dir(folder.path()).stdout(writer).stderr(Stdio::piped());
    let output = command.spawn().unwrap().wait_with_output().unwrap();
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

#[test]
fn c5_a_reader_that_went_away_is_no_panic() {
    for words in
        [vec!["--help"], vec!["--version"], tiny(&["s.toml", "-q", "--stats", "-", "-o", "x.exr"], &[])]
    {
        assert_eq!(unread(&words), (Some(0), String::new()), "{words:?}");
    }
    // A picture that nobody took is lost, and that is a failure.
    let (code, err) = unread(&tiny(&["s.toml", "-q", "-o", "-"], &[]));
    assert_eq!(code, Some(1));
    assert!(err.starts_with("error: ") && err.lines().count() == 1, "{err}");
}
