//! Meshes of every format: the same mesh gives the same picture, and what is damaged is skipped or refused.

mod ring;
mod shared;

use super::{Ended, drt};
use assert_cmd::Command;
use drt::load::{FORMATS, Options, scene};
use ring::Ring;
use std::fs;
use std::io::Write as _;
use std::path::Path;
use tempfile::TempDir;

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut packer = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::fast());
    packer.write_all(bytes).unwrap();
    packer.finish().unwrap()
}

fn zstd(bytes: &[u8]) -> Vec<u8> {
    ruzstd::encoding::compress_to_vec(bytes, ruzstd::encoding::CompressionLevel::Fastest)
}

const SMALL: [&str; 6] = ["--size", "48x36", "--spp", "2", "--quiet", "-o"];

/// The bytes of the picture of a file.
#[track_caller]
fn picture(dir: &Path, file: &str) -> Vec<u8> {
    let words: Vec<&str> = SMALL.into_iter().chain(["out.exr", file]).collect();
    drt(dir, &words).expect(0, &[]);
    fs::read(dir.join("out.exr")).unwrap()
}

/// Runs drt with `input` on its standard input.
fn piped(dir: &Path, input: &[u8], words: &[&str]) -> Ended {
    let mut command = Command::cargo_bin("drt").expect("the binary");
    let output = command.current_dir(dir).args(words).write_stdin(input).output().expect("it runs");
    Ended {
        code: output.status.code(),
        out: String::from_utf8_lossy(&output.stdout).into_owned(),
        err: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

#[test]
fn every_format_gives_the_same_picture() {
    let folder = TempDir::new().unwrap();
    let dir = folder.path();
    let ring = Ring::new();
    for smooth in [false, true] {
        let (text, data) = ring.gltf(smooth, Some("ring%20data.bin"));
        fs::write(dir.join("ring data.bin"), data).unwrap();
        let mut files = vec![
            ("a.obj", ring.obj(smooth)),
            ("ascii.ply", ring.ply("ascii", smooth)),
            ("little.ply", ring.ply("binary_little_endian", smooth)),
            ("big.PLY", ring.ply("binary_big_endian", smooth)),
            ("a.glb", ring.glb(smooth)),
            ("a.gltf", text),
            ("a.obj.gz", gzip(&ring.obj(smooth))),
            ("a.ply.zst", zstd(&ring.ply("ascii", smooth))),
            ("a.glb.zst", zstd(&ring.glb(smooth))),
            ("packed.obj", gzip(&ring.obj(smooth))),
            ("ring.gz", gzip(&ring.ply("binary_big_endian", smooth))),
        ];
        if !smooth {
            files.push(("text.stl", ring.stl(true)));
            files.push(("binary.stl", ring.stl(false)));
            files.push(("a.stl.gz", gzip(&ring.stl(false))));
        }
        files.iter().for_each(|(name, bytes)| fs::write(dir.join(name), bytes).unwrap());
        let first = picture(dir, "a.obj");
        for (name, bytes) in &files {
            assert!(picture(dir, name) == first, "{name}, smooth: {smooth}");
            let words: Vec<&str> = SMALL.into_iter().chain(["stdin.exr", "-"]).collect();
            piped(dir, bytes, &words).expect(0, &[]);
            assert!(
                fs::read(dir.join("stdin.exr")).unwrap() == first,
                "{name} on standard input, smooth: {smooth}"
            );
        }
    }
    // A scene file names them as well; the facets of an STL are those of an OBJ with flat normals.
    let mut pictures = Vec::new();
    for (file, normals) in [("binary.stl", "file"), ("a.obj", "flat"), ("a.glb.zst", "flat")] {
        let text = format!(
            "[[mesh]]\nfile = \"{file}\"\nnormals = \"{normals}\"\n[[light]]\ntype = \"environment\"\n"
        );
        fs::write(dir.join("s.toml"), text).unwrap();
        pictures.push(picture(dir, "s.toml"));
    }
    assert!(pictures[1..].iter().all(|picture| *picture == pictures[0]));
}

#[test]
fn the_format_can_be_stated_and_a_wrong_one_is_refused() {
    let folder = TempDir::new().unwrap();
    let dir = folder.path();
    let ring = Ring::new();
    fs::write(dir.join("scan.dat"), ring.ply("ascii", false)).unwrap();
    fs::write(dir.join("s.toml"), "[[mesh]]\nfile = \"-\"\n").unwrap();
    let words = |more: &[&'static str]| {
        SMALL.into_iter().chain(["o.png"]).chain(more.iter().copied()).collect::<Vec<_>>()
    };
    drt(dir, &words(&["scan.dat", "--format", "ply"])).expect(0, &[]);
    drt(dir, &words(&["scan.dat"])).expect(1, &["scan.dat", ".dat", "known: gltf, glb, ply, stl, obj, toml"]);
    drt(dir, &words(&["scan.dat", "--format", "gltf"]))
        .expect(1, &["scan.dat:1:1:", "not a whole JSON document"]);
    drt(dir, &words(&["scan.dat", "--format", "plyy"])).expect(2, &["--format", "did you mean \"ply\"?"]);
    drt(dir, &words(&["scan.dat", "--max-unpacked", "much"])).expect(2, &["--max-unpacked"]);
    drt(dir, &words(&["s.toml"])).expect(1, &["s.toml:2:8:", "standard input"]);
    piped(dir, b"\x7fELF\0\0", &words(&["-"])).expect(1, &["stdin: its first bytes", "--format"]);
    let ended = piped(dir, &ring.obj(false), &["-", "--size", "8x8", "--spp", "1"]);
    ended.expect(0, &[]);
    assert!(dir.join("stdin.png").exists(), "{}", ended.err);
    let help = drt(dir, &["--help"]).out;
    for format in FORMATS {
        assert!(help.contains(format.meaning), "{}", format.name);
    }
}

#[test]
fn check_knows_every_format() {
    let folder = TempDir::new().unwrap();
    let dir = folder.path();
    let ring = Ring::new();
    for (name, bytes) in [
        ("a.ply", ring.ply("binary_big_endian", true)),
        ("a.stl", ring.stl(false)),
        ("a.glb", ring.glb(true)),
        ("a.obj.zst", zstd(&ring.obj(true))),
    ] {
        fs::write(dir.join(name), bytes).unwrap();
        let ended = drt(dir, &["check", "--json", name]);
        ended.expect(0, &[]);
        let report: serde_json::Value = serde_json::from_str(&ended.out).unwrap();
        assert_eq!((&report["triangles"], &report["vertices"]), (&192.into(), &96.into()), "{name}");
        let volume = report["meshes"][0]["volume"].as_f64();
        assert!(volume.is_some_and(|v| v > 0.0), "{name} is closed and not inside out: {volume:?}");
    }
    fs::write(dir.join("cloud.ply"), "ply\nformat ascii 1.0\nelement vertex 1\nproperty int x\nproperty int y\nproperty int z\nend_header\n1 2 3\n").unwrap();
    drt(dir, &["check", "cloud.ply"]).expect(1, &["cloud.ply", "no faces"]);
    drt(dir, &["cloud.ply"]).expect(1, &["cloud.ply", "a cloud of 1 points"]);
}

#[test]
fn a17_bombs_of_every_format_end_at_the_limit() {
    let folder = TempDir::new().unwrap();
    let dir = folder.path();
    let many = 40 << 20;
    let ply = "ply\nformat ascii 1.0\nelement vertex 9\nproperty int x\nproperty int y\nproperty int z\nend_header\n";
    for (name, start, filling) in
        [("a.obj", "", b'\n'), ("a.ply", ply, b' '), ("a.stl", "solid bomb\n", b'\n'), ("a.gltf", "{", b' ')]
    {
        let mut bytes = start.as_bytes().to_vec();
        bytes.resize(many, filling);
        for (packed, extension) in [(gzip(&bytes), "gz"), (zstd(&bytes), "zst")] {
            assert!(packed.len() < many / 100);
            let name = format!("{name}.{extension}");
            fs::write(dir.join(&name), packed).unwrap();
            let limit = ["--max-unpacked", "16M", name.as_str()];
            drt(dir, &limit).expect(1, &[&name, "unpacks to more than 16 MiB", "--max-unpacked"]);
            let ended = drt(dir, &["--max-unpacked", "64M", name.as_str()]);
            ended.expect(1, &[&name]);
            assert!(!ended.err.contains("unpacks to"), "{}", ended.err);
        }
    }
}

/// Every file of every format, cut and changed anywhere, is read without a panic, and nothing wild gets into a mesh.
#[test]
fn a14_a18_damaged_files_of_every_format_are_safe() {
    let folder = TempDir::new().unwrap();
    let ring = Ring::new();
    let (text, data) = ring.gltf(true, Some("d.bin"));
    fs::write(folder.path().join("d.bin"), data).unwrap();
    let rounds = if std::env::var_os("DRT_HEAVY_TESTS").is_some() { 4000 } else { 400 };
    let mut all_refused = 0;
    let mut state = 1u64;
    let mut below = |n: usize| {
        state = state.wrapping_mul(0x5851_f42d_4c95_7f2d).wrapping_add(0x1405_7b7e_f767_814f);
        (state >> 33) as usize % n
    };
    for (name, bytes) in [
        ("a.ply", ring.ply("ascii", true)),
        ("l.ply", ring.ply("binary_little_endian", true)),
        ("b.ply", ring.ply("binary_big_endian", true)),
        ("t.stl", ring.stl(true)),
        ("b.stl", ring.stl(false)),
        ("a.gltf", text),
        ("a.glb", ring.glb(true)),
        ("a.obj.gz", gzip(&ring.obj(true))),
        ("a.ply.zst", zstd(&ring.ply("ascii", true))),
    ] {
        let file = folder.path().join(name);
        let (mut read, mut refused) = (0, 0);
        for round in 0..rounds {
            let mut damaged = bytes.clone();
            if round % 4 == 0 {
                damaged.truncate(below(bytes.len()));
            }
            // Mostly near the beginning, where headers are.
            for _ in 0..round % 5 {
                let within = if below(2) == 0 { damaged.len() } else { damaged.len().min(1500) };
                if let Some(byte) = damaged.get_mut(below(within.max(1))) {
                    *byte =
                        if below(2) == 0 { below(256) as u8 } else { b"0123456789-.e {}[]\"\n"[below(20)] };
                }
            }
            fs::write(&file, damaged).unwrap();
            match scene(&file, Options::default()) {
                Err(_) => refused += 1,
                Ok(loaded) => {
                    read += 1;
                    for mesh in &loaded.scene.meshes {
                        let count = mesh.positions.len() as u32;
                        assert!(mesh.indices.iter().flatten().all(|i| *i < count), "{name} {round}");
                        assert!(mesh.positions.iter().flatten().all(|x| x.is_finite()), "{name} {round}");
                    }
                }
            }
        }
        // Every fifth is whole unless it is cut.
        assert!(read > rounds / 10, "{name}: {read} read, {refused} refused");
        all_refused += refused;
    }
    assert!(all_refused > rounds, "{all_refused} refused");
}
