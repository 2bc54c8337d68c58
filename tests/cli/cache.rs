//! `--cache DIR`: the same picture and words with it and without it, whatever is in the folder.

use super::universal::Run;
use super::{Ended, drt, folder, names};
use serde_json::Value;
use std::fs;
use std::path::Path;
use tempfile::TempDir;

/// A folder with a mesh that has materials, texture coordinates and a bad face.
fn scene() -> TempDir {
    let folder = folder();
    let mesh = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nusemtl red\nf 1/1 3/3 2/2\nf 1 2 4\n\
                usemtl blue\nf 1 4 3\nf 2 3 4\nf 1 2 77\n";
    fs::write(folder.path().join("m.obj"), mesh).unwrap();
    fs::write(folder.path().join("m.mtl"), "newmtl red\nKd .8 .1 .1\nnewmtl blue\nKd .1 .1 .8\n").unwrap();
    folder
}

/// Renders the mesh; its warnings and faces skipped, and the picture's bytes.
fn render(dir: &Path, more: &[&str]) -> (Ended, Value, Vec<u8>) {
    let words =
        [&["m.obj", "-o", "p.exr", "--stats", "s.json", "--size", "16x12", "--spp", "2"], more].concat();
    let ended = Run::new(dir, &words).check();
    ended.expect(0, &[]);
    let stats: Value = serde_json::from_slice(&fs::read(dir.join("s.json")).unwrap()).unwrap();
    let counted =
        ["triangles", "vertices", "skipped_faces", "warnings", "materials"].map(|key| stats[key].clone());
    (ended, Value::from(counted.to_vec()), fs::read(dir.join("p.exr")).unwrap())
}

/// The only entry.
fn entry(dir: &Path) -> std::path::PathBuf {
    let all = names(&dir.join("c"));
    let entries: Vec<&String> = all.iter().filter(|name| name.ends_with(".mesh")).collect();
    assert_eq!(entries.len(), 1, "{all:?}");
    dir.join("c").join(entries[0])
}

#[test]
fn pictures_and_warnings_are_those_without_the_cache() {
    let folder = scene();
    let dir = folder.path();
    let (_, counted, picture) = render(dir, &[]);
    for hits in ["had 0 of 1", "had 1 of 1"] {
        let (ended, from_cache, same) = render(dir, &["--cache", "c", "-v"]);
        assert!(ended.err.contains(&format!("the cache {hits} mesh files")), "{}", ended.err);
        assert!(ended.err.contains("m.obj:15: face skipped: vertex 77"), "{}", ended.err);
        assert_eq!((&from_cache, &same), (&counted, &picture));
    }
    for more in [vec!["--cache", "c"], vec![]] {
        let strict = drt(dir, &[vec!["m.obj", "--strict", "-o", "q.png"], more].concat());
        strict.expect(1, &["m.obj:15", "--strict"]);
    }
    // Libraries are read anew.
    fs::write(dir.join("m.mtl"), "newmtl red\nKd .1 .8 .1\nnewmtl blue\nKd .1 .8 .8\n").unwrap();
    let (_, _, changed) = render(dir, &["--cache", "c"]);
    assert_eq!(changed, render(dir, &[]).2);
    assert!(changed != picture);
    // And so is a mesh that was changed.
    let text = fs::read_to_string(dir.join("m.obj")).unwrap();
    fs::write(dir.join("m.obj"), text.replace("v 1 0 0", "v 2 0 0")).unwrap();
    assert_eq!(render(dir, &["--cache", "c"]).2, render(dir, &[]).2);
}

#[test]
fn damaged_entries_are_said_and_written_anew() {
    let folder = scene();
    let dir = folder.path();
    let (_, counted, picture) = render(dir, &["--cache", "c"]);
    let entry = entry(dir);
    let whole = fs::read(&entry).unwrap();
    let mut flipped = whole.clone();
    flipped[whole.len() / 2] ^= 1;
    for damaged in [
        flipped.as_slice(),
        &whole[..100],
        b"",
        b"drtmesh\n",
        b"something else that is long enough to be one",
    ] {
        fs::write(&entry, damaged).unwrap();
        let (ended, from_cache, same) = render(dir, &["--cache", "c"]);
        assert!(ended.err.contains("read anew"), "{}", ended.err);
        assert_eq!((&from_cache, &same), (&with_note(&counted), &picture));
        assert_eq!(fs::read(&entry).unwrap(), whole);
    }
}

/// The counts with the note about the entry among the warnings.
fn with_note(counted: &Value) -> Value {
    let mut counted = counted.clone();
    counted[3]["cache-entry-unusable"] = 1.into();
    counted
}

#[test]
fn a_cache_that_is_no_folder_is_refused_and_one_that_cannot_be_written_is_not() {
    let folder = scene();
    let dir = folder.path();
    drt(dir, &["m.obj", "--cache", "t.obj"]).expect(1, &["t.obj", "cannot use the cache", "--cache"]);
    drt(dir, &["m.obj", "--cache", "t.obj/c"]).expect(1, &["t.obj/c"]);
    render(dir, &["--cache", "c"]);
    let entry = entry(dir);
    fs::remove_file(&entry).unwrap();
    fs::create_dir_all(entry.join("full")).unwrap();
    let (ended, _, _) = render(dir, &["--cache", "c"]);
    assert!(ended.err.contains("the mesh is not kept"), "{}", ended.err);
}

/// With the BVH the structure is kept too; what is wrong with an entry is said, and the picture the same.
#[test]
fn structures_are_kept_and_checked() {
    let folder = scene();
    let dir = folder.path();
    let bvh = |more: &[&str]| render(dir, &[&["--backend", "bvh", "-v"], more].concat());
    let (_, _, picture) = bvh(&[]);
    for (tree, threads) in [("files\n", "1"), ("files and the acceleration structure", "2")] {
        let (ended, _, same) = bvh(&["--cache", "c", "--threads", threads]);
        assert!(ended.err.contains(&format!("mesh {tree}")), "{}", ended.err);
        assert_eq!(same, picture);
    }
    let trees =
        || names(&dir.join("c")).into_iter().filter(|name| name.ends_with(".tree")).collect::<Vec<_>>();
    let path = dir.join("c").join(&trees()[0]);
    let whole = fs::read(&path).unwrap();
    for at in (0..whole.len()).step_by(97).chain([whole.len() - 1]) {
        let mut damaged = whole.clone();
        damaged[at] ^= 2;
        fs::write(&path, damaged).unwrap();
        let (ended, _, same) = bvh(&["--cache", "c"]);
        assert!(ended.err.contains("the structure was built anew"), "byte {at}: {}", ended.err);
        assert!(same == picture && fs::read(&path).unwrap() == whole);
    }
    // Another quality is another structure; a moved mesh as well.
    bvh(&["--cache", "c", "--set", "render.build=high"]);
    assert_eq!(trees().len(), 2);
    bvh(&["--cache", "c", "--set", "mesh.0.transform.scale=2"]);
    assert_eq!(trees().len(), 3);
}
