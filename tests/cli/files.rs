//! Inputs that cannot be read and outputs that cannot be written: refused with 1, before the work.

use super::{drt, folder, names};
use std::fs;

#[test]
fn inputs_that_are_none() {
    let folder = folder();
    let dir = folder.path();
    fs::create_dir(dir.join("d.obj")).unwrap();
    fs::write(dir.join("empty.obj"), "").unwrap();
    fs::write(dir.join("m.fbx"), "solid").unwrap();
    fs::write(dir.join("m.stl"), "solid").unwrap();
    fs::write(dir.join("bad.toml"), "[film]\nsize = [1, 1]\nsiez = 3\n").unwrap();
    fs::write(dir.join("none.toml"), "").unwrap();
    fs::write(dir.join("lost.toml"), "[[mesh]]\nfile = \"lost.obj\"\n").unwrap();
    fs::write(dir.join("latin.toml"), b"[film]\n# \xe4\n").unwrap();
    let table: &[(&str, &[&str])] = &[
        ("missing.obj", &["missing.obj", "No such file"]),
        ("missing\nline.obj", &["missing\\nline.obj", "No such file"]),
        ("-", &["stdin", "is empty"]),
        ("d.obj", &["d.obj", "directory"]),
        ("empty.obj", &["empty.obj"]),
        ("m.fbx", &["m.fbx", "obj, toml"]),
        ("m.stl", &["m.stl", "no renderable faces"]),
        ("bad.toml", &["bad.toml:3:1:", "did you mean \"size\"?"]),
        ("none.toml", &["none.toml", "[[mesh]]"]),
        ("lost.toml", &["lost.obj", "No such file"]),
        ("latin.toml", &["latin.toml:2:", "UTF-8"]),
    ];
    let before = names(dir);
    for (input, words) in table {
        drt(dir, &["-o", "out.png", "--", input]).expect(1, words);
    }
    assert_eq!(names(dir), before);
}

#[test]
fn outputs_that_cannot_be_are_refused_before_rendering() {
    let folder = folder();
    let dir = folder.path();
    fs::create_dir(dir.join("folder.png")).unwrap();
    let before = names(dir);
    // So many samples that rendering first would be noticed.
    let huge = ["t.obj", "--spp", "1048576", "-o"];
    for (output, words) in [
        ("no/such/folder.png", ["no/such/folder.png", "does not exist"]),
        ("folder.png", ["folder.png", "folder"]),
        ("a.gif", ["a.gif", "known"]),
        ("a", ["extension", "known"]),
        ("t.obj", ["t.obj", "known"]),
    ] {
        let words_with: Vec<&str> = huge.iter().copied().chain([output]).collect();
        drt(dir, &words_with).expect(1, &words);
    }
    drt(dir, &["t.obj", "--spp", "1048576", "--stats", "no/s.json"]).expect(1, &["no/s.json"]);
    assert_eq!(names(dir), before);
}

#[test]
fn an_input_is_never_written_over() {
    let folder = folder();
    let dir = folder.path();
    fs::rename(dir.join("t.obj"), dir.join("t.png")).unwrap();
    std::os::unix::fs::symlink("t.png", dir.join("t.obj")).unwrap();
    std::os::unix::fs::symlink("s.toml", dir.join("s.png")).unwrap();
    let mesh = fs::read(dir.join("t.obj")).unwrap();
    drt(dir, &["t.obj"]).expect(1, &["t.png", "both input and output"]);
    drt(dir, &["s.toml"]).expect(1, &["s.png", "both input and output"]);
    drt(dir, &["s.toml", "-o", "t.png"]).expect(1, &["t.png", "both input and output"]);
    drt(dir, &["s.toml", "-o", "x.png", "--stats", "t.obj"]).expect(1, &["t.obj", "both input and output"]);
    assert_eq!(fs::read(dir.join("t.obj")).unwrap(), mesh);
}
