//! Rows A and B of the table of failures, through the program: hostile OBJ and MTL files.

use super::universal::{Run, engines, installed, tiny};
use super::{drt, folder, names};
use std::fs;
use std::path::Path;

/// A cube's corner and a face across it: what `t.obj` is, with room for bad faces.
const GOOD: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

fn render(dir: &Path, name: &str, bytes: &[u8], engine: &[&str]) -> Vec<u8> {
    fs::write(dir.join(name), bytes).unwrap();
    let picture = format!("{name}.exr");
    let ended = Run::new(dir, &tiny(&[name, "-o", &picture], engine)).check();
    ended.expect(0, &[]);
    fs::read(dir.join(&picture)).unwrap()
}

/// A bad index leaves its face out: the picture is that of the file without the face, byte for byte.
#[test]
fn a1_a2_bad_indices_are_as_if_the_face_was_not_there() {
    let folder = folder();
    let dir = folder.path();
    let bad = [
        "0",
        "5",
        "-5",
        "2147483648",
        "4294967297",
        "9223372036854775808",
        "18446744073709551617",
        "-4294967295",
        "1111111111111111111111111111111111111111",
    ];
    for engine in engines() {
        let clean = render(dir, "clean.obj", GOOD.as_bytes(), &engine);
        for index in bad {
            let text = format!("{GOOD}f 1 2 {index}\n");
            assert!(render(dir, "bad.obj", text.as_bytes(), &engine) == clean, "{index} on {engine:?}");
        }
        let all: String = bad.iter().map(|i| format!("f {i} 2 3\n")).collect();
        fs::write(dir.join("all.obj"), format!("{GOOD}{all}")).unwrap();
        let words = tiny(&["all.obj", "-o", "all.exr", "--stats", "all.json"], &engine);
        let ended = Run::new(dir, &words).check();
        assert!(ended.err.contains("all.obj:9:") && ended.err.contains("9 in all"), "{}", ended.err);
        let stats: serde_json::Value =
            serde_json::from_slice(&fs::read(dir.join("all.json")).unwrap()).unwrap();
        assert_eq!(stats["skipped_faces"].as_u64(), Some(9));
        let strict = [words.as_slice(), &["--strict"]].concat();
        Run::new(dir, &strict).check().expect(1, &["all.obj:9:", "--strict"]);
    }
}

/// A bad `vt` or `vn` costs the face that attribute and nothing else.
#[test]
fn a1_bad_texture_and_normal_indices_keep_the_face() {
    let folder = folder();
    let dir = folder.path();
    let clean = render(dir, "clean.obj", GOOD.as_bytes(), &["--backend", "bvh"]);
    for corner in ["2/9", "2//9", "2/0", "2//-7", "2/9/9", "2/4294967297", "2//4294967297"] {
        let text = GOOD.replace("f 1 3 2", &format!("f 1 3 {corner}"));
        assert!(render(dir, "bad.obj", text.as_bytes(), &["--backend", "bvh"]) == clean, "{corner}");
    }
}

#[test]
fn a3_faces_before_their_vertices() {
    let folder = folder();
    let dir = folder.path();
    let (vertices, faces) = GOOD.split_at(GOOD.find('f').unwrap());
    for engine in engines() {
        let clean = render(dir, "clean.obj", GOOD.as_bytes(), &engine);
        let forward = render(dir, "forward.obj", format!("{faces}{vertices}").as_bytes(), &engine);
        assert!(forward == clean, "{engine:?}");
    }
}

/// An empty black picture would be a lie.
#[test]
fn a6_nothing_to_render_is_an_error() {
    let folder = folder();
    let dir = folder.path();
    for text in [
        "",
        "\n\n",
        "# a comment\n",
        "v 0 0 0\nv 1 0 0\nv 0 1 0\n",
        "v 0 0 0\nv 1 1 1\nl 1 2\np 1\n",
        "v 0 0 0\nf 1 2 3\nf 0 0 0\n",
        "v 0 0 0\nv 1 0 0\nf 1 2\n",
        "v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
        "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 1 1\n",
    ] {
        for engine in engines() {
            fs::write(dir.join("none.obj"), text).unwrap();
            let ended = Run::new(dir, &tiny(&["none.obj", "-o", "none.exr"], &engine)).check();
            ended.expect(1, &["none.obj", "no renderable faces"]);
        }
    }
}

/// However the lines end and words are set apart, it is the same picture, byte for byte.
#[test]
fn a7_eight_encodings_of_one_file() {
    let folder = folder();
    let dir = folder.path();
    let encodings = [
        GOOD.replace('\n', "\r\n"),
        GOOD.replace('\n', "\r"),
        GOOD.replace(' ', "\t"),
        GOOD.replace(' ', "     "),
        GOOD.replace('\n', "  \t\n"),
        GOOD.trim_end().to_string(),
        format!("\u{feff}{GOOD}"),
        GOOD.replace(' ', " \\\r\n "),
    ];
    for engine in engines() {
        let clean = render(dir, "clean.obj", GOOD.as_bytes(), &engine);
        for (i, text) in encodings.iter().enumerate() {
            assert!(
                render(dir, "other.obj", text.as_bytes(), &engine) == clean,
                "encoding {i} on {engine:?}"
            );
        }
    }
    let utf16: Vec<u8> = format!("\u{feff}{GOOD}").encode_utf16().flat_map(u16::to_le_bytes).collect();
    fs::write(dir.join("wide.obj"), utf16).unwrap();
    Run::new(dir, &["wide.obj", "-o", "x.png"]).check().expect(1, &["wide.obj", "looks like UTF-16"]);
    fs::write(dir.join("nul.obj"), GOOD.replace("v 1", "v\0 1")).unwrap();
    Run::new(dir, &["nul.obj", "-o", "x.png"]).check().expect(1, &["nul.obj:2:", "NUL"]);
}

/// `call` and `csh` are neither run nor opened; unknown statements and endless names are passed over.
#[test]
fn a12_nothing_is_executed_and_unknown_statements_are_ignored() {
    let folder = folder();
    let dir = folder.path();
    let clean = render(dir, "clean.obj", GOOD.as_bytes(), &["--backend", "bvh"]);
    fs::write(dir.join("called.obj"), "v 9 9 9\nf 1 2 5\n").unwrap();
    let long = "n".repeat(1 << 16);
    let text = format!(
        "call called.obj\ncsh touch pwned\ncsh -touch pwned\n! touch pwned\nshadow_obj called.obj\ntrace_obj called.obj\n\
         o\ng\ns\no {long}\ng {long}\nsurf 0 1 0 1 1 2 3\ncurv 0 1 1 2\nparm u 0 1\nend\nfrobnicate 1 2 3\n{GOOD}"
    );
    assert!(render(dir, "calls.obj", text.as_bytes(), &["--backend", "bvh"]) == clean);
    assert!(!names(dir).contains(&"pwned".to_string()));
    if installed("strace") {
        let mut command = std::process::Command::new("strace");
        command.args(["-f", "-e", "trace=execve,openat,open", "-o", "trace.txt"]);
        command.arg(assert_cmd::cargo::cargo_bin("drt"));
        command.args(tiny(&["calls.obj", "-q", "-o", "y.exr"], &[])).current_dir(dir);
        // Where tracing is forbidden strace itself fails, and that is not for this test to judge.
        if command.status().unwrap().success() {
            let trace = fs::read_to_string(dir.join("trace.txt")).unwrap();
            assert!(trace.contains("calls.obj") && !trace.contains("called.obj"));
            assert_eq!(trace.matches("execve(").count(), 1, "{trace}");
        } else {
            eprintln!("SKIPPED the traced part: strace may not trace here");
        }
    }
}

/// 4 GiB without an end of line: refused at the limit on lines, in an address space that could not hold it.
#[test]
fn a13_an_endless_line_is_refused_in_constant_memory() {
    let folder = folder();
    let dir = folder.path();
    fs::File::create(dir.join("huge.obj")).unwrap().set_len(4 << 30).unwrap();
    let words = ["huge.obj", "-o", "x.png", "--threads", "2"];
    let ended = Run::new(dir, &words).limits("ulimit -v 1500000").check();
    ended.expect(1, &["huge.obj:1:"]);
    fs::write(dir.join("spaces.obj"), [GOOD.as_bytes(), &vec![b' '; 20 << 20]].concat()).unwrap();
    let words = ["spaces.obj", "-o", "x.png"];
    Run::new(dir, &words).check().expect(1, &["spaces.obj:9:", "16 MiB"]);
}

/// Cut anywhere, a file renders or is refused.
#[test]
fn a14_prefixes_of_a_file() {
    let folder = folder();
    let dir = folder.path();
    let text = format!(
        "# caf\u{e9}\nmtllib m.mtl\n{}vt 0 0\nvt 1 0.5\nvn 0 0 1\nusemtl a\nf 1/1/1 2/2/1 3//1 \\\n 4\n",
        GOOD.replace('\n', " # comment\r\n")
    );
    let library = "newmtl a\nKd 0.5 0.25 1e-3\nmap_Kd -s 1 2 3 my picture.png\nNs 20\nKe 0 0 1\n";
    let engine = ["--backend", "bvh", "-q"];
    for cut in (0..text.len()).step_by(5) {
        fs::write(dir.join("cut.obj"), &text.as_bytes()[..cut]).unwrap();
        fs::write(dir.join("m.mtl"), &library.as_bytes()[..cut * library.len() / text.len()]).unwrap();
        Run::new(dir, &tiny(&["cut.obj", "-o", "cut.png"], &engine)).check();
    }
}

/// One warning a missing picture, not one a use; the render goes on, unless `--strict`.
/// A material of the scene file needs no library; one that nobody defines is said.
#[test]
fn b1_a_material_of_the_scene_file_needs_no_library() {
    let folder = folder();
    let dir = folder.path();
    let mesh = "usemtl a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nusemtl b\nv 0 0 1\nf 1 2 4\n";
    std::fs::write(dir.join("ab.obj"), mesh).unwrap();
    let scene = "[film]\nsize = [8, 8]\n[render]\nspp = 1\n[[mesh]]\nfile = \"ab.obj\"\n\
                 [materials.a]\ntype = \"mirror\"\n[[light]]\ntype = \"environment\"\n";
    std::fs::write(dir.join("ab.toml"), scene).unwrap();
    for words in [["render", "ab.toml"], ["check", "ab.toml"]] {
        let ended = drt(dir, &words);
        let said = format!("{}{}", ended.out, ended.err);
        assert!(said.contains("no library defines \"b\"") && !said.contains("\"a\""), "{said}");
    }
}

#[test]
fn b3_a_missing_texture_is_said_once() {
    let folder = folder();
    let dir = folder.path();
    let mesh = "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nusemtl a\nf 1/1 3/1 2/1\nusemtl b\n\
                f 1/1 2/1 4/1\nusemtl c\nf 1/1 4/1 3/1\nf 2/1 3/1 4/1\n";
    fs::write(dir.join("tex.obj"), mesh).unwrap();
    let library = "newmtl a\nKd 1 0 0\nmap_Kd gone.png\nnewmtl b\nmap_Kd gone.png\nnewmtl c\nKd 1 1 1\n";
    fs::write(dir.join("m.mtl"), library).unwrap();
    for engine in engines() {
        let ended = Run::new(dir, &tiny(&["tex.obj", "-o", "t.exr"], &engine)).check();
        ended.expect(0, &[]);
        let warnings: Vec<&str> = ended.err.lines().filter(|l| l.starts_with("warning: ")).collect();
        let [warning] = *warnings else { panic!("not one warning: {}", ended.err) };
        for word in ["m.mtl:3: ", "material \"a\"", "map_Kd", "not found", "from the folder .)"] {
            assert!(warning.contains(word), "{word:?} not in {warning}");
        }
        assert!(!warning.contains("gone.png"), "a library is never quoted: {warning}");
    }
    let strict = Run::new(dir, &tiny(&["tex.obj", "-o", "s.exr", "--strict"], &[])).check();
    strict.expect(1, &["m.mtl:3:", "--strict"]);
}

/// What a scene names may be a pipe, a device, a folder or a secret: none blocks, and none is quoted.
#[test]
fn b10_pipes_devices_and_secrets() {
    let folder = folder();
    let dir = folder.path();
    let secret = "HUNTER2";
    fs::write(dir.join("secret"), format!("root:{secret}:0:0\nnewmtl {secret}\nKd {secret}\n{secret} 1\n"))
        .unwrap();
    let made = std::process::Command::new("mkfifo").arg(dir.join("pipe")).status().unwrap();
    assert!(made.success());
    fs::create_dir(dir.join("sub")).unwrap();
    std::os::unix::fs::symlink("loop", dir.join("loop")).unwrap();
    let targets = [
        "pipe",
        "/dev/zero",
        "/dev/stdin",
        "/dev/tty",
        "sub",
        "loop",
        "secret",
        "/proc/self/environ",
        "../../../../../../../../etc/passwd",
    ];
    for target in targets {
        let mesh = format!("mtllib {target}\nmtllib m.mtl\nusemtl a\n{GOOD}");
        fs::write(dir.join("names.obj"), mesh).unwrap();
        let maps: String =
            ["map_Kd", "map_Ks", "map_d", "bump", "norm"].iter().map(|m| format!("{m} {target}\n")).collect();
        fs::write(dir.join("m.mtl"), format!("newmtl a\n{maps}")).unwrap();
        let words = tiny(&["names.obj", "-o", "n.exr"], &["--threads", "2"]);
        let ended =
            Run::new(dir, &words).limits(&format!("ulimit -v 4000000; export PASSWORD={secret}")).check();
        ended.expect(0, &[]);
        let picture = fs::read(dir.join("n.exr")).unwrap();
        let quoted = |bytes: &[u8]| bytes.windows(secret.len()).any(|w| w == secret.as_bytes());
        assert!(
            !quoted(ended.err.as_bytes()) && !quoted(ended.out.as_bytes()) && !quoted(&picture),
            "{target}"
        );
        assert!(!ended.err.contains("root:"), "{}", ended.err);
        fs::write(dir.join("scene.toml"), format!("[[mesh]]\nfile = \"{target}\"\n")).unwrap();
        let ended = Run::new(dir, &["scene.toml", "-o", "n.exr"]).limits("ulimit -v 4000000").check();
        ended.expect(1, &[]);
        assert!(!quoted(ended.err.as_bytes()), "{}", ended.err);
    }
    fs::rename(dir.join("pipe"), dir.join("pipe.obj")).unwrap();
    Run::new(dir, &["pipe.obj", "-o", "n.exr"]).check().expect(1, &["pipe.obj", "not a regular file"]);
    fs::rename(dir.join("pipe.obj"), dir.join("pipe.toml")).unwrap();
    Run::new(dir, &["pipe.toml", "-o", "n.exr"]).check().expect(1, &["pipe.toml", "not a regular file"]);
}
