//! `--secure`: an input names files of its own folder, by what paths lead to, and no others.

use super::universal::{Run, installed, tiny};
use super::{drt, folder};
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;

const FACES: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1 2/1 3/1\n";

/// `inside/` with everything that an input may name, and the same things outside of it.
fn folders(dir: &Path) {
    for sub in ["inside", "inside/sub", "outside"] {
        fs::create_dir(dir.join(sub)).unwrap();
        let pixel: [f32; 3] = [1.0, 0.0, 0.0];
        let bytes = pixel.iter().flat_map(|x| x.to_le_bytes());
        let picture: Vec<u8> = b"PF\n1 1\n-1\n".iter().copied().chain(bytes).collect();
        fs::write(dir.join(sub).join("p.pfm"), picture).unwrap();
        fs::write(dir.join(sub).join("m.mtl"), "newmtl a\nKd 0 1 0\n").unwrap();
        fs::write(dir.join(sub).join("t.obj"), FACES).unwrap();
    }
    let inside = dir.join("inside");
    symlink("../outside/m.mtl", inside.join("link.mtl")).unwrap();
    symlink("../outside/p.pfm", inside.join("link.pfm")).unwrap();
    symlink("../outside/t.obj", inside.join("link.obj")).unwrap();
    symlink("../outside", inside.join("door")).unwrap();
    symlink(dir.join("inside/sub"), inside.join("room")).unwrap();
}

/// Names that lead out of the folder, with their extension to come.
const OUT: [&str; 5] = ["../outside/", "sub/../../outside/", "link", "door/", "/"];
/// Names that lead into it, however they look.
const IN: [&str; 5] = ["", "sub/", "sub/../", "../inside/", "room/"];

fn names<'n>(dir: &Path, prefixes: &'n [&'n str], file: &'n str) -> impl Iterator<Item = String> {
    let absolute = dir.join("outside/").to_string_lossy().into_owned();
    let name = move |prefix: &str| match prefix {
        "link" => format!("link{}", &file[1..]),
        "/" => format!("{absolute}{file}"),
        _ => format!("{prefix}{file}"),
    };
    prefixes.iter().map(|prefix| name(prefix)).collect::<Vec<_>>().into_iter()
}

#[test]
fn b10_libraries_and_textures_of_an_obj_stay_in_its_folder() {
    let folder = folder();
    let dir = folder.path();
    folders(dir);
    let inside = dir.join("inside");
    let run = |secure: &[&str]| drt(&inside, &tiny(&["a.obj", "-o", "x.exr"], secure));
    for (prefixes, refused) in [(&OUT, true), (&IN, false)] {
        for name in names(dir, prefixes, "m.mtl") {
            fs::write(inside.join("a.obj"), format!("mtllib {name}\nusemtl a\n{FACES}")).unwrap();
            let ended = run(&["--secure"]);
            ended.expect(0, &[]);
            assert_eq!(ended.err.contains("a.obj:1: material library"), refused, "{name}: {}", ended.err);
            assert_eq!(ended.err.contains("--secure"), refused, "{name}: {}", ended.err);
            run(&["--secure", "--strict"]).expect(i32::from(refused), &[]);
            let free = run(&["--strict"]);
            free.expect(0, &[]);
        }
        for name in names(dir, prefixes, "p.pfm") {
            fs::write(inside.join("a.obj"), format!("mtllib a.mtl\nusemtl a\n{FACES}")).unwrap();
            fs::write(inside.join("a.mtl"), format!("newmtl a\n\nmap_Kd {name}\n")).unwrap();
            let ended = run(&["--secure"]);
            ended.expect(0, &[]);
            assert_eq!(
                ended.err.contains("a.mtl:3: material \"a\": map_Kd"),
                refused,
                "{name}: {}",
                ended.err
            );
            assert_eq!(ended.err.contains("--secure"), refused, "{name}: {}", ended.err);
            run(&["--strict"]).expect(0, &[]);
            let checked = drt(&inside, &["check", "--secure", "--json", "a.obj"]);
            assert_eq!(checked.out.contains("\"path-refused\""), refused, "{name}: {}", checked.out);
        }
    }
}

#[test]
fn b10_files_of_a_scene_stay_in_its_folder() {
    let folder = folder();
    let dir = folder.path();
    folders(dir);
    let inside = dir.join("inside");
    let run = |scene: String, words: &[&str]| {
        fs::write(inside.join("a.toml"), scene).unwrap();
        drt(&inside, &tiny(&["a.toml", "-o", "x.exr"], words))
    };
    for (prefixes, refused) in [(&OUT, true), (&IN, false)] {
        let code = i32::from(refused);
        let words: &[&str] = if refused { &["a.toml:2:", "--secure"] } else { &[] };
        for name in names(dir, prefixes, "t.obj") {
            let scene = format!("[[mesh]]\nfile = \"{name}\"\n");
            run(scene.clone(), &["--secure"]).expect(code, words);
            run(scene, &[]).expect(0, &[]);
        }
        for name in names(dir, prefixes, "p.pfm") {
            let sky = format!("[[light]]\nfile = \"{name}\"\ntype = \"environment\"\n");
            run(sky.clone(), &["--secure"]).expect(code, words);
            run(sky, &[]).expect(0, &[]);
            let textured = format!(
                "[[mesh]]\nfile = \"t.obj\"\nmaterial = \"m\"\n[materials.m]\ntype = \"diffuse\"\nreflectance = {{ texture = \"{name}\" }}\n"
            );
            let ended = run(textured, &["--secure"]);
            ended.expect(0, &[]);
            assert_eq!(ended.err.contains("a.toml:6: materials.m.reflectance"), refused, "{}", ended.err);
        }
    }
}

/// Buffers and pictures that a glTF names, the picture that a PLY names.
#[test]
fn b10_files_of_other_formats_stay_in_its_folder() {
    let folder = folder();
    let dir = folder.path();
    folders(dir);
    let inside = dir.join("inside");
    let corners: [f32; 15] = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0];
    let bytes: Vec<u8> = corners.iter().flat_map(|x| x.to_le_bytes()).collect();
    for sub in ["inside", "inside/sub", "outside"] {
        fs::write(dir.join(sub).join("b.bin"), &bytes).unwrap();
    }
    symlink("../outside/b.bin", inside.join("link.bin")).unwrap();
    let gltf = |buffer: &str, picture: &str| {
        serde_json::json!({
            "asset": { "version": "2.0" }, "nodes": [{ "mesh": 0 }],
            "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "material": 0 }] }],
            "materials": [{ "pbrMetallicRoughness": { "baseColorTexture": { "index": 0 } } }],
            "textures": [{ "source": 0 }], "images": [{ "uri": picture }],
            "accessors": [
                { "bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3" },
                { "bufferView": 1, "componentType": 5126, "count": 3, "type": "VEC2" },
            ],
            "bufferViews": [
                { "buffer": 0, "byteLength": 36 },
                { "buffer": 0, "byteOffset": 36, "byteLength": 24 },
            ],
            "buffers": [{ "uri": buffer, "byteLength": 60 }],
        })
        .to_string()
    };
    let ply = |picture: &str| {
        format!(
            "ply\nformat ascii 1.0\ncomment TextureFile {picture}\nelement vertex 3\nproperty float x\n\
             property float y\nproperty float z\nproperty float s\nproperty float t\nelement face 1\n\
             property list uchar int vertex_indices\nend_header\n0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2\n"
        )
    };
    let run = |name: &str, text: String, words: &[&str]| {
        fs::write(inside.join(name), text).unwrap();
        drt(&inside, &tiny(&[name, "-o", "x.exr"], words))
    };
    for (prefixes, refused) in [(&OUT, true), (&IN, false)] {
        for name in names(dir, prefixes, "b.bin") {
            let words: &[&str] = if refused { &["a.gltf: buffers[0]", "--secure"] } else { &[] };
            run("a.gltf", gltf(&name, "p.pfm"), &["--secure"]).expect(i32::from(refused), words);
            run("a.gltf", gltf(&name, "p.pfm"), &["--strict"]).expect(0, &[]);
        }
        for name in names(dir, prefixes, "p.pfm") {
            for (file, text) in [("a.gltf", gltf("b.bin", &name)), ("a.ply", ply(&name))] {
                let ended = run(file, text.clone(), &["--secure"]);
                ended.expect(0, &[]);
                assert_eq!(ended.err.contains("--secure"), refused, "{file} {name}: {}", ended.err);
                run(file, text, &["--strict"]).expect(0, &[]);
            }
        }
    }
}

/// Decoders have words of their own, and those hold the file's.
#[test]
fn b10_skies_are_not_quoted() {
    let folder = folder();
    let dir = folder.path();
    for secret in [
        "#?HUNTER2\nHUNTER2=1\n\n-Y HUNTER2 +X 4\n",
        "#?RADIANCE\nFORMAT=HUNTER2\n\n-Y 1 +X HUNTER2\n",
        "#?RADIANCE\nEXPOSURE=HUNTER2\nFORMAT=32-bit_rle_rgbe\n\nHUNTER2 1 +X 1\n",
        "PF\nHUNTER2 1\n-1\n",
        "\u{76}\u{2f}\u{31}\u{1}HUNTER2",
        "HUNTER2 = [[",
    ] {
        fs::write(dir.join("secret.hdr"), secret).unwrap();
        fs::write(dir.join("a.toml"), "[[light]]\ntype = \"environment\"\nfile = \"secret.hdr\"\n").unwrap();
        for words in [vec!["check", "a.toml"], tiny(&["a.toml", "-o", "x.exr"], &[])] {
            let ended = Run::new(dir, &words).check();
            ended.expect(1, &["a.toml:3:", "secret.hdr"]);
            assert!(!ended.err.contains("HUNTER2"), "{}", ended.err);
        }
    }
}

/// What the user names himself is read wherever it is: the input through a link, a sky by its flag.
#[test]
fn what_the_user_names_is_no_matter_of_the_input() {
    let folder = folder();
    let dir = folder.path();
    folders(dir);
    let inside = dir.join("inside");
    Run::new(&inside, &tiny(&["link.obj", "--secure", "--sky", "../outside/p.pfm", "-o", "x.exr"], &[]))
        .check()
        .expect(0, &[]);
}

/// Not only is nothing read: nothing outside is opened, not even a folder to look for other spellings in.
#[test]
fn nothing_outside_is_opened() {
    if !installed("strace") {
        return;
    }
    let folder = folder();
    let dir = folder.path();
    folders(dir);
    let inside = dir.join("inside");
    let maps: String = names(dir, &OUT, "p.pfm")
        .chain(["../OUTSIDE/P.pfm".into()])
        .map(|n| format!("map_Kd {n}\nmap_Ks {n}x\n"))
        .collect();
    fs::write(inside.join("a.mtl"), format!("newmtl a\n{maps}norm ../outside/<UDIM>.pfm\n")).unwrap();
    let libraries: String = names(dir, &OUT, "m.mtl").map(|n| format!("mtllib {n}\nmtllib {n}x\n")).collect();
    fs::write(inside.join("a.obj"), format!("mtllib a.mtl\n{libraries}usemtl a\n{FACES}")).unwrap();
    let program = assert_cmd::cargo::cargo_bin("drt");
    for words in [vec!["check", "--secure", "a.obj"], tiny(&["a.obj", "--secure", "-o", "x.exr"], &[])] {
        let mut command = std::process::Command::new("strace");
        command.args(["-f", "-y", "-e", "trace=open,openat,openat2", "-o", "opened"]).arg(&program);
        let output = command.args(&words).current_dir(&inside).output().unwrap();
        let said = String::from_utf8_lossy(&output.stderr).into_owned();
        if said.contains("strace:") {
            eprintln!("SKIPPED a part of this test: strace may not trace here: {said}");
            return;
        }
        assert!(output.status.success(), "{said}");
        let opened = fs::read_to_string(inside.join("opened")).unwrap();
        assert!(opened.contains("a.mtl"), "{opened}");
        assert!(!opened.to_lowercase().contains("outside"), "{opened}");
    }
}
