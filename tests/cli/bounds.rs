//! No input of n bytes takes more than O(n log n): what once took the square takes longer here than any run may
//! (`universal.rs` ends one after two minutes), and what once went as deep as the file says does not fit on a stack.

use super::universal::Run;
use super::{Ended, folder};
use std::fs;
use std::path::Path;

/// `drt check` of `text` as the file `name`.
fn check(dir: &Path, name: &str, text: &str) -> Ended {
    fs::write(dir.join(name), text).unwrap();
    Run::new(dir, &["check", name]).check()
}

#[test]
fn mixtures_within_each_other() {
    let folder = folder();
    let chain = |length: usize, mesh: &str| {
        let head = "[[light]]\ntype = \"environment\"\n[[mesh]]\nfile = \"t.obj\"\nmaterial = \"m0\"\n";
        let mix = |i: usize| {
            format!(
                "[materials.m{i}]\ntype = \"mix\"\nmaterials = [\"m{0}\", \"m{0}\"]\namount = 0.5\n",
                i + 1
            )
        };
        let last = format!("[materials.m{length}]\ntype = \"diffuse\"\n");
        [head, mesh, &(0..length).map(mix).collect::<String>(), &last].concat()
    };
    check(folder.path(), "a.toml", &chain(90, "")).expect(0, &[]);
    // Each part is asked for its pictures once, not once a way that leads to it.
    check(folder.path(), "a.toml", &chain(90, "instance = true\n")).expect(0, &[]);
    check(folder.path(), "a.toml", &chain(100_000, "")).expect(1, &["a.toml:", "too many other mixtures"]);
}

#[test]
fn a_scene_on_one_line() {
    let folder = folder();
    let items = "{ file = \"t.obj\" }, ".repeat(500_000);
    check(folder.path(), "a.toml", &format!("meshes = [{items}]\n"))
        .expect(1, &["a.toml:1:1:", "did you mean"]);
    // Places on it are counted in characters.
    check(folder.path(), "a.toml", &format!("mesh = [{{ file = \"{}\" }}, {{ x = 1 }}]", "é".repeat(1000)))
        .expect(1, &["a.toml:1:1024:"]);
}

#[test]
fn options_almost_to_the_end_of_a_line() {
    let folder = folder();
    let dir = folder.path();
    let options = "-s 1 ".repeat(500_000);
    fs::write(dir.join("m.mtl"), format!("newmtl a\nmap_Kd name {options} end\n")).unwrap();
    let mesh = fs::read_to_string(dir.join("t.obj")).unwrap();
    let ended = check(dir, "a.obj", &format!("mtllib m.mtl\nusemtl a\n{mesh}"));
    ended.expect(0, &[]);
    assert!(ended.out.contains("map_Kd"), "{}", ended.out);
}

/// A library is read once, however many names it has.
#[test]
fn one_library_by_many_names() {
    let folder = folder();
    let dir = folder.path();
    let definitions: String = (0..100_000).map(|i| format!("newmtl m{i}\nKd 0.5 0.5 0.5\n")).collect();
    fs::write(dir.join("m.mtl"), definitions).unwrap();
    for name in ["a", "b"] {
        fs::create_dir(dir.join(name)).unwrap();
    }
    let mut mesh = fs::read_to_string(dir.join("t.obj")).unwrap();
    for i in 0..4000 {
        let way: String = (0..12).map(|bit| if i >> bit & 1 == 0 { "a/../" } else { "b/../" }).collect();
        mesh += &format!("mtllib {way}m.mtl\n");
    }
    let ended = check(dir, "a.obj", &mesh);
    ended.expect(0, &[]);
    assert!(!ended.out.contains("material-redefined"), "{}", ended.out);
}

#[test]
fn many_libraries_and_materials() {
    let folder = folder();
    let dir = folder.path();
    let definitions: String = (0..100_000).map(|i| format!("newmtl m{i}\nKd 0.5 0.5 0.5\n")).collect();
    fs::write(dir.join("m.mtl"), definitions).unwrap();
    let mut mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_string();
    for i in 0..100_000 {
        mesh += &format!("mtllib none{i}.mtl m.mtl\nusemtl m{i}\nf 1 2 3\n");
    }
    check(dir, "a.obj", &mesh).expect(0, &[]);
}
