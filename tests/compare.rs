//! `drt compare` from outside: figures, formats, and a disk that takes no more.

use drt::film::Image;
use drt::output;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

fn picture(folder: &Path, name: &str, value: f32) {
    // A hash makes the file larger than a compressed constant would be.
    let noise = |i: u32| (i.wrapping_mul(2_654_435_761) >> 8) as f32 * 1e-9;
    let pixels: Vec<[f32; 3]> = (0..64 * 48).map(|i| [value + noise(i); 3]).collect();
    let image = Image::from_rgb(64, 48, &pixels, String::new());
    output::write(&folder.join(name), &image, &output::Options::default()).unwrap();
}

fn compare(folder: &Path, words: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_drt")).arg("compare").args(words).current_dir(folder).output().unwrap()
}

#[test]
fn json_has_every_figure() {
    let folder = tempfile::tempdir().unwrap();
    picture(folder.path(), "a.exr", 0.75);
    picture(folder.path(), "b.exr", 0.5);
    picture(folder.path(), "b.png", 0.5);
    let out = compare(folder.path(), &["a.exr", "b.exr", "--json"]);
    assert!(out.status.success());
    let figures: serde_json::Value = serde_json::from_slice(&out.stdout).unwrap();
    let number = |key: &str| figures[key].as_f64().unwrap();
    assert!((number("mse") - 0.0625).abs() < 1e-6 && (number("relmse") - 0.0625 / 0.26).abs() < 1e-2);
    assert!((number("psnr") - 12.0412).abs() < 1e-3 && (number("max") - 0.25).abs() < 1e-6);
    assert!((number("mean") - 0.25).abs() < 1e-6 && number("flip") > 0.05);
    assert_eq!((figures["width"].as_u64(), figures["height"].as_u64()), (Some(64), Some(48)));
    assert_eq!(figures["flip_kind"], "HDR");

    let same: serde_json::Value =
        serde_json::from_slice(&compare(folder.path(), &["b.png", "b.png", "--json"]).stdout).unwrap();
    assert!(same["psnr"].is_null() && same["flip_kind"] == "LDR" && same["flip"] == 0.0);
}

#[test]
fn a_limit_on_file_sizes_leaves_the_old_file_and_no_other() {
    let folder = tempfile::tempdir().unwrap();
    picture(folder.path(), "a.exr", 0.75);
    picture(folder.path(), "b.exr", 0.5);
    fs::write(folder.path().join("difference.pfm"), "old").unwrap();
    // The program outlives the signal, so that the write itself fails, half way.
    let script =
        format!("ulimit -f 16; exec '{}' compare a.exr b.exr -o difference.pfm", env!("CARGO_BIN_EXE_drt"));
    let out = Command::new("sh").args(["-c", &script]).current_dir(folder.path()).output().unwrap();
    assert_eq!(out.status.code(), Some(1));
    assert_eq!(String::from_utf8_lossy(&out.stderr), "error: difference.pfm: cannot write: File too large\n");
    assert_eq!(fs::read(folder.path().join("difference.pfm")).unwrap(), b"old");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 3);
}

#[test]
fn wrong_pictures_and_wrong_outputs_are_one_line_on_stderr() {
    let folder = tempfile::tempdir().unwrap();
    picture(folder.path(), "a.exr", 0.75);
    for (words, reason) in [
        (&["a.exr", "missing.exr"][..], "missing.exr"),
        (&["a.exr", "a.exr", "-o", "missing/d.exr"], "does not exist"),
        (&["a.exr", "a.exr", "-o", "d.bmp"], "known: exr"),
        (&["a.exr", "a.exr", "-o", "/dev/full"], "No space left on device"),
    ] {
        let out = compare(folder.path(), words);
        let message = String::from_utf8(out.stderr).unwrap();
        assert_eq!(out.status.code(), Some(1));
        assert!(
            message.contains(reason) && message.lines().count() == 1 && out.stdout.is_empty(),
            "{message}"
        );
    }
}
