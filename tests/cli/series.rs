//! `--turntable`, `--frames` and `--resume`: which files, which pictures, which are left out.

use super::{drt, folder, names};
use std::fs;
use std::path::Path;

fn bytes(folder: &Path, name: &str) -> Vec<u8> {
    fs::read(folder.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"))
}

/// The first picture of a turntable is the ordinary view but for its settings; the others differ, and a full turn has as many.
#[test]
fn a_turntable_goes_around_once() {
    let folder = folder();
    let dir = folder.path();
    drt(dir, &["s.toml", "--turntable", "4", "-o", "a-##.pfm", "-o", "a-##.png"]).expect(0, &[]);
    drt(dir, &["s.toml", "-o", "one.pfm"]).expect(0, &[]);
    assert_eq!(bytes(dir, "a-00.pfm"), bytes(dir, "one.pfm"));
    let all: Vec<_> = (0..4).map(|i| bytes(dir, &format!("a-0{i}.pfm"))).collect();
    assert!((0..4).all(|i| (0..i).all(|k| all[i] != all[k])), "four views");
    let made = names(dir).iter().filter(|name| name.starts_with("a-")).count();
    assert_eq!(made, 8);
    // Half of the views of another turntable are these.
    drt(dir, &["s.toml", "--turntable", "2", "-o", "b-#.pfm"]).expect(0, &[]);
    assert_eq!(bytes(dir, "b-1.pfm"), all[2]);
}

/// Frame f is the still scene whose shutter is f/fps later.
#[test]
fn frames_are_the_scene_with_a_later_shutter() {
    let folder = folder();
    let dir = folder.path();
    let scene = "[camera]\nposition = [0, 0, 9]\nlook_at = [0, 0, 0]\nshutter = [0, 0.25]\nfps = 2\n\
                 [film]\nsize = [16, 12]\n[render]\nspp = 4\n\
                 [[mesh]]\nfile = \"t.obj\"\nmotion = [{ time = 0 }, { time = 2, translate = [4, 0, 0] }]\n\
                 [[light]]\ntype = \"environment\"\n";
    fs::write(dir.join("m.toml"), scene).unwrap();
    drt(dir, &["m.toml", "--frames", "0..3", "-o", "f-###.pfm"]).expect(0, &[]);
    for (frame, shutter) in [("000", "[0, 0.25]"), ("003", "[1.5, 1.75]")] {
        let set = format!("camera.shutter={shutter}");
        drt(dir, &["m.toml", "--set", &set, "-o", "still.pfm"]).expect(0, &[]);
        assert_eq!(bytes(dir, "still.pfm"), bytes(dir, &format!("f-{frame}.pfm")), "frame {frame}");
    }
    assert_ne!(bytes(dir, "f-000.pfm"), bytes(dir, "f-001.pfm"));
}

/// What is whole and has the same settings is left out; what is cut, of other settings or missing is made again.
#[test]
fn an_interrupted_series_goes_on_where_it_was() {
    let folder = folder();
    let dir = folder.path();
    for extension in ["png", "exr"] {
        let name = format!("r-##.{extension}");
        let words = ["s.toml", "--turntable", "4", "-o", &name];
        drt(dir, &words).expect(0, &[]);
        let file = |i: u32| format!("r-0{i}.{extension}");
        let whole: Vec<_> = (0..4).map(|i| bytes(dir, &file(i))).collect();
        fs::remove_file(dir.join(file(1))).unwrap();
        fs::write(dir.join(file(2)), &whole[2][..whole[2].len() / 2]).unwrap();
        // Another picture of the series is whole, but not this one.
        fs::write(dir.join(file(3)), &whole[1]).unwrap();
        let stamp = |i: u32| fs::metadata(dir.join(file(i))).unwrap().modified().unwrap();
        let before = stamp(0);
        let ended = drt(dir, &["s.toml", "--turntable", "4", "-o", &name, "--resume"]);
        ended.expect(0, &[]);
        assert!(
            ended.err.contains("wrote 3 pictures") && ended.err.contains("(1 were there)"),
            "{}",
            ended.err
        );
        for i in 0..4 {
            assert_eq!(bytes(dir, &file(i)), whole[i as usize], "{}", file(i));
        }
        assert_eq!(stamp(0), before);
        let other = drt(dir, &["s.toml", "--turntable", "4", "-o", &name, "--resume", "--seed", "1"]);
        assert!(other.expect(0, &[]).err.contains("wrote 4 pictures"), "{}", other.err);
    }
}

#[test]
fn words_that_make_no_series() {
    let folder = folder();
    let dir = folder.path();
    let before = names(dir);
    let table: &[(&[&str], &[&str])] = &[
        (&["--turntable", "4", "-o", "a.png"], &["a.png", "frame-####.png"]),
        (&["--turntable", "0"], &["--turntable", "from 1"]),
        (&["--turntable", "x"], &["--turntable"]),
        (&["--frames", "5..2"], &["--frames 5..2", "A..B"]),
        (&["--frames", "-1..2"], &["--frames -1..2"]),
        (&["--frames", "1..2", "--turntable", "3"], &["--turntable"]),
        (&["--frames", "0..1", "-o", "-"], &["-", "number"]),
    ];
    for (words, expected) in table {
        let words: Vec<&str> = ["t.obj"].iter().chain(words.iter()).copied().collect();
        drt(dir, &words).expect(2, expected);
    }
    assert_eq!(names(dir), before);
    // Nobody's input is written over, whichever picture it would be.
    fs::hard_link(dir.join("t.obj"), dir.join("t-1.png")).unwrap();
    let ended = drt(dir, &["t.obj", "--turntable", "3", "-o", "t-#.png"]);
    ended.expect(1, &["t-1.png", "both input and output"]);
}

/// The whole series in one report, read and built once.
#[test]
fn statistics_are_of_the_whole_series() {
    let folder = folder();
    let dir = folder.path();
    drt(dir, &["s.toml", "--turntable", "3", "-o", "a-#.png", "--stats", "s.json"]).expect(0, &[]);
    let stats: serde_json::Value = serde_json::from_slice(&bytes(dir, "s.json")).unwrap();
    assert_eq!(stats["rays"]["camera"], 3 * 16 * 12 * 2);
    assert!(["load", "build", "render", "write"].iter().all(|phase| stats["seconds"][phase].is_number()));
}
