//! `drt check`: the page, the JSON, exit codes.

use super::{Ended, drt, folder};
use serde_json::Value;
use std::fs;
use std::process::{Command, Stdio};

const BAD: &str = "mtllib m.mtl nowhere.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 7 7 7\nusemtl lamp\nf 1 3 2\n\
                   f 1 2 4\nf 1 4 99\nusemtl stone\nf 1 4 3\nf 2 3 4\nf 1 2\n";
const LIBRARY: &str = "newmtl lamp\nKe 3 3 3\nmap_Kd here.png\nmap_Ks secret-name.png\n";

fn json(ended: &Ended) -> Value {
    serde_json::from_str(&ended.out).expect("JSON on standard output")
}

fn finding<'v>(report: &'v Value, kind: &str) -> &'v Value {
    let all = report["findings"].as_array().expect("a list");
    all.iter().find(|f| f["kind"] == kind).unwrap_or_else(|| panic!("no {kind} in {report:#}"))
}

#[test]
fn a_good_mesh_is_called_good() {
    let folder = folder();
    let ended = drt(folder.path(), &["check", "t.obj"]);
    ended.expect(0, &[]);
    assert_eq!(ended.err, "");
    for words in ["4 of 4 faces", "watertight   yes", "volume       0.166667", "emission     none"] {
        assert!(ended.out.contains(words), "{words:?} not in\n{}", ended.out);
    }
    assert_eq!(ended.out.lines().last(), Some("nothing wrong"));
    drt(folder.path(), &["check", "--strict", "t.obj"]).expect(0, &[]);
}

#[test]
fn the_json_says_what_is_in_a_file_and_what_is_wrong_by_line() {
    let folder = folder();
    let dir = folder.path();
    fs::write(dir.join("bad.obj"), BAD).unwrap();
    fs::write(dir.join("m.mtl"), LIBRARY).unwrap();
    fs::write(dir.join("here.png"), "no picture is read").unwrap();
    let ended = drt(dir, &["check", "bad.obj", "--json"]);
    ended.expect(1, &["bad.obj:10:", "vertex 99 does not exist"]);
    let report = json(&ended);
    assert_eq!(report["triangles"], 4);
    assert_eq!(report["vertices"], 5);
    assert_eq!(report["skipped_faces"], 2);
    assert_eq!(report["emitting_triangles"], 2);
    assert_eq!(report["bounds"]["min"], serde_json::json!([0.0, 0.0, 0.0]));
    assert_eq!(report["bounds"]["max"], serde_json::json!([1.0, 1.0, 1.0]));
    assert_eq!(report["meshes"][0]["watertight"], true);
    assert_eq!(report["meshes"][0]["unreferenced_vertices"], 1);
    let index = finding(&report, "face-index-out-of-range");
    assert_eq!((&index["line"], &index["severity"]), (&10.into(), &"error".into()));
    assert_eq!(index["file"], "bad.obj");
    assert_eq!(finding(&report, "face-too-few-corners")["line"], 14);
    assert_eq!(finding(&report, "mtllib-missing")["line"], 1);
    let texture = finding(&report, "texture-missing");
    assert_eq!((&texture["file"], &texture["line"]), (&"m.mtl".into(), &4.into()));
    assert!(texture["message"].as_str().is_some_and(|m| m.contains("\"lamp\"") && m.contains("map_Ks")));
    let materials = report["materials"].as_array().unwrap();
    let about = |i: usize| (&materials[i]["name"], &materials[i]["triangles"], &materials[i]["emits"]);
    assert_eq!(about(0), (&"lamp".into(), &2.into(), &true.into()));
    assert_eq!(about(1), (&"stone".into(), &2.into(), &false.into()));
    assert_eq!(materials[0]["defined"], serde_json::json!({ "file": "m.mtl", "line": 1 }));
    assert_eq!(materials[1]["defined"], Value::Null);
    assert_eq!(report["textures"][0]["path"], "here.png");
    assert_eq!(report["textures"][1]["path"], Value::Null);
    assert_eq!(report["textures"][1]["material"], "lamp");
    assert_eq!(report["finding_counts"]["material-unknown"], 1);
    assert_eq!(report["errors"], 1);
    assert!(!ended.out.contains("secret-name"), "a library is never quoted");
}

/// Named, in use, defined: three counts that differ.
#[test]
fn materials_are_counted_as_named_as_used_and_as_defined() {
    let folder = folder();
    let dir = folder.path();
    let mesh = "mtllib three.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nusemtl a\nf 1 3 2\nusemtl b\n\
                usemtl nowhere\nf 3 2 1\nusemtl a\nf 2 1 3\n";
    fs::write(dir.join("m.obj"), mesh).unwrap();
    fs::write(dir.join("three.mtl"), "newmtl a\nnewmtl b\nnewmtl c\nnewmtl d\nnewmtl a\n").unwrap();
    let report = json(&drt(dir, &["check", "m.obj", "--json"]));
    let materials = report["materials"].as_array().unwrap();
    let of = |key: &str| materials.iter().map(|m| m[key].clone()).collect::<Vec<_>>();
    assert_eq!(of("name"), ["", "a", "b", "nowhere"]);
    assert_eq!(of("triangles"), [1, 1, 0, 1], "the second `a` repeats the first");
    assert_eq!(of("defined").iter().map(Value::is_null).collect::<Vec<_>>(), [true, false, false, true]);
    assert_eq!(report["materials_in_use"], 3);
    assert_eq!(report["meshes"][0]["library_materials"], 4);
    let page = drt(dir, &["check", "m.obj"]);
    assert!(page.out.contains("materials (4, 3 of them in use; the libraries define 4)"), "{}", page.out);
}

#[test]
fn the_page_has_the_worst_first_and_the_verdict_last() {
    let folder = folder();
    let dir = folder.path();
    fs::write(dir.join("bad.obj"), BAD).unwrap();
    fs::write(dir.join("m.mtl"), LIBRARY).unwrap();
    let ended = drt(dir, &["check", "bad.obj"]);
    ended.expect(1, &["bad.obj:10:"]);
    let lines: Vec<&str> = ended.out.lines().collect();
    assert_eq!(lines[0], "bad.obj");
    assert!(lines[1].starts_with("  error        bad.obj:10: face skipped"), "{}", lines[1]);
    assert!(lines.last().unwrap().starts_with("1 error, "), "{}", ended.out);
    assert!(!ended.out.contains("secret-name"));
}

#[test]
fn warnings_fail_only_when_strict_and_notes_never() {
    let folder = folder();
    let dir = folder.path();
    fs::write(dir.join("open.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").unwrap();
    fs::write(dir.join("odd.obj"), "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3\nf 2 3 4\n").unwrap();
    drt(dir, &["check", "open.obj", "--strict"]).expect(0, &[]);
    drt(dir, &["check", "odd.obj"]).expect(0, &[]);
    drt(dir, &["check", "odd.obj", "--strict"]).expect(1, &["odd.obj:5:", "turned over"]);
}

#[test]
fn what_cannot_be_read_or_rendered_ends_with_one_error() {
    let folder = folder();
    let dir = folder.path();
    fs::write(dir.join("empty.obj"), "").unwrap();
    fs::write(dir.join("bad.obj"), "v 0 0 0\nf 1 2 3\n").unwrap();
    fs::write(dir.join("nul.obj"), b"v 0 0 0\n\0").unwrap();
    drt(dir, &["check", "missing.obj"]).expect(1, &["missing.obj", "No such file"]);
    drt(dir, &["check", "."]).expect(1, &["directory"]);
    drt(dir, &["check", "nul.obj"]).expect(1, &["nul.obj:2:", "NUL"]);
    drt(dir, &["check", "empty.obj"]).expect(1, &["empty.obj", "nothing to render"]);
    let ended = drt(dir, &["check", "bad.obj", "--json"]);
    ended.expect(1, &["bad.obj:2:"]);
    assert_eq!(json(&ended)["bounds"], Value::Null);
    assert_eq!(json(&ended)["finding_counts"]["no-renderable-faces"], 1);
    drt(dir, &["check"]).expect(2, &[]);
    drt(dir, &["check", "t.obj", "--against", "assimp"]).expect(2, &["--against", "tobj"]);
}

#[test]
fn scenes_are_checked_with_their_meshes() {
    let folder = folder();
    let dir = folder.path();
    let scene = "[[mesh]]\nfile = \"t.obj\"\n[[mesh]]\nfile = \"t.obj\"\ntransform = { translate = [4, 0, 0] }\n\
                 [[mesh]]\nfile = \"bad.obj\"\n[materials.unused]\ntype = \"mirror\"\n";
    fs::write(dir.join("two.toml"), scene).unwrap();
    fs::write(dir.join("bad.obj"), BAD).unwrap();
    fs::write(dir.join("m.mtl"), LIBRARY).unwrap();
    let ended = drt(dir, &["check", "two.toml", "--json"]);
    ended.expect(1, &["bad.obj:10:"]);
    let report = json(&ended);
    assert_eq!(report["triangles"], 12);
    assert_eq!(report["skipped_faces"], 2);
    assert_eq!(report["bounds"]["max"], serde_json::json!([5.0, 1.0, 1.0]));
    assert_eq!(report["meshes"].as_array().unwrap().len(), 2);
    assert_eq!(report["finding_counts"]["face-index-out-of-range"], 1, "told once");
    assert_eq!(finding(&report, "material-not-used")["line"], 8);
    assert_eq!(report["emitting_triangles"], 2);
    drt(dir, &["check", "s.toml"]).expect(0, &[]);
    fs::write(dir.join("typo.toml"), "[film]\nsiez = 3\n").unwrap();
    drt(dir, &["check", "typo.toml"]).expect(1, &["typo.toml:2:1:"]);
}

#[test]
fn a_reader_that_went_away_is_no_error() {
    let folder = folder();
    for words in [&["check", "t.obj"][..], &["check", "t.obj", "--json"]] {
        let mut command = Command::new(assert_cmd::cargo::cargo_bin("drt"));
        command.current_dir(folder.path()).args(words).stdout(Stdio::piped()).stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        drop(child.stdout.take());
        let ended = child.wait_with_output().unwrap();
        assert_eq!(ended.status.code(), Some(0), "{}", String::from_utf8_lossy(&ended.stderr));
        assert!(ended.stderr.is_empty());
    }
}

#[test]
fn another_reader_is_asked_where_it_is_built_in() {
    let folder = folder();
    let ended = drt(folder.path(), &["check", "t.obj", "--against", "tobj"]);
    if cfg!(feature = "tobj") {
        ended.expect(0, &[]);
        assert!(ended.out.contains("tobj reads the same 4 triangles"), "{}", ended.out);
    } else {
        ended.expect(2, &["--features tobj"]);
    }
}

/// Where the two readers differ, it is said in what: a concave polygon, which tobj splits as a fan, and a face whose
/// vertex is no number.
#[test]
#[cfg(feature = "tobj")]
fn another_reader_that_reads_otherwise_is_named_with_lines() {
    let folder = folder();
    let dir = folder.path();
    let corners = "v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 0\nusemtl m\n";
    let compare = |text: &str| {
        fs::write(dir.join("o.obj"), format!("{corners}{text}")).unwrap();
        json(&drt(dir, &["check", "o.obj", "--against", "tobj", "--json"]))
    };
    let concave = compare("f 2 3 4\nf 1 2 3 4\n");
    assert_eq!(finding(&concave, "tobj-triangle-differs")["line"], 7);
    assert_eq!(concave["finding_counts"]["tobj-agrees"], Value::Null);
    assert_eq!(concave["finding_counts"]["tobj-counts-differ"], Value::Null, "both have three triangles");
    let skipped = compare("v nan 0 0\nf 1 2 4\nf 1 2 5\n");
    let message = finding(&skipped, "tobj-counts-differ")["message"].as_str().unwrap().to_string();
    assert!(message.contains("1 triangles here, 2 in tobj"), "{message}");
    assert_eq!(compare("f 2 3 4\n")["finding_counts"]["tobj-agrees"], 1);
    assert_eq!(finding(&compare("f 2 3 4\nf 0 1 2\n"), "tobj-cannot-read")["severity"], "note");
}
