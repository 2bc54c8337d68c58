//! Meshes of every format: the same mesh gives the same picture, and what is damaged is skipped or refused.

use super::{Ended, drt};
use assert_cmd::Command;
use drt::load::{self, FORMATS, Options, scene};
use std::fmt::Write as _;
use std::fs;
use std::io::Write as _;
use std::path::Path;
use tempfile::TempDir;

/// A dented ring of triangles; numbers that decimals and f32 hold exactly.
struct Ring {
    positions: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    triangles: Vec<[usize; 3]>,
}

impl Ring {
    fn new() -> Ring {
        const AROUND: usize = 12;
        const ACROSS: usize = 8;
        let dyadic = |x: f64| (x * 256.0).round() as f32 / 256.0;
        let turn = |i: usize, n: usize| std::f64::consts::TAU * i as f64 / n as f64;
        let (mut positions, mut normals, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
        for i in 0..AROUND {
            for j in 0..ACROSS {
                let (a, b) = (turn(i, AROUND), turn(j, ACROSS));
                let out = 1.0 + (0.4 + 0.1 * (3.0 * a).sin()) * b.cos();
                positions.push([out * a.cos(), 0.4 * b.sin(), out * a.sin()].map(dyadic));
                normals.push([b.cos() * a.cos(), b.sin(), b.cos() * a.sin()].map(dyadic));
                let at = |i: usize, j: usize| i % AROUND * ACROSS + j % ACROSS;
                triangles.push([at(i, j), at(i, j + 1), at(i + 1, j)]);
                triangles.push([at(i + 1, j), at(i, j + 1), at(i + 1, j + 1)]);
            }
        }
        Ring { positions, normals, triangles }
    }

    fn obj(&self, smooth: bool) -> Vec<u8> {
        let mut out = String::new();
        self.positions.iter().for_each(|[x, y, z]| writeln!(out, "v {x} {y} {z}").unwrap());
        if smooth {
            self.normals.iter().for_each(|[x, y, z]| writeln!(out, "vn {x} {y} {z}").unwrap());
        }
        for t in &self.triangles {
            let [a, b, c] = t.map(|i| if smooth { format!("{0}//{0}", i + 1) } else { (i + 1).to_string() });
            writeln!(out, "f {a} {b} {c}").unwrap();
        }
        out.into_bytes()
    }

    fn ply(&self, format: &str, smooth: bool) -> Vec<u8> {
        let mut header = format!("ply\nformat {format} 1.0\nelement vertex {}\n", self.positions.len());
        for name in if smooth { ["x", "y", "z", "nx", "ny", "nz"].as_slice() } else { &["x", "y", "z"] } {
            writeln!(header, "property float {name}").unwrap();
        }
        writeln!(header, "element face {}\nproperty list uchar int vertex_indices", self.triangles.len())
            .unwrap();
        let mut out = (header + "end_header\n").into_bytes();
        for (position, normal) in self.positions.iter().zip(&self.normals) {
            let row: Vec<f32> = position.iter().chain(normal.iter().filter(|_| smooth)).copied().collect();
            match format {
                "ascii" => row.iter().for_each(|x| write!(out, "{x} ").unwrap()),
                "binary_big_endian" => out.extend(row.iter().flat_map(|x| x.to_be_bytes())),
                _ => out.extend(row.iter().flat_map(|x| x.to_le_bytes())),
            }
        }
        for t in &self.triangles {
            let row = t.map(|i| i as i32);
            match format {
                "ascii" => write!(out, "\n3 {} {} {}", row[0], row[1], row[2]).unwrap(),
                "binary_big_endian" => {
                    out.extend([3].into_iter().chain(row.iter().flat_map(|i| i.to_be_bytes())))
                }
                _ => out.extend([3].into_iter().chain(row.iter().flat_map(|i| i.to_le_bytes()))),
            }
        }
        out
    }

    fn stl(&self, is_text: bool) -> Vec<u8> {
        let mut out = if is_text { b"solid ring\n".to_vec() } else { vec![b' '; 80] };
        if !is_text {
            out.extend((self.triangles.len() as u32).to_le_bytes());
        }
        for t in &self.triangles {
            let corners = t.map(|i| self.positions[i]);
            if is_text {
                out.extend(b"facet normal 0 0 0\nouter loop\n");
                corners.iter().for_each(|[x, y, z]| writeln!(out, "vertex {x} {y} {z}").unwrap());
                out.extend(b"endloop\nendfacet\n");
            } else {
                out.extend([0; 12]);
                out.extend(corners.iter().flatten().flat_map(|x| x.to_le_bytes()));
                out.extend([0; 2]);
            }
        }
        out
    }

    /// The JSON of a document whose buffer is `uri`, or behind it, and the buffer.
    fn gltf(&self, smooth: bool, uri: Option<&str>) -> (Vec<u8>, Vec<u8>) {
        let vectors =
            |list: &[[f32; 3]]| list.iter().flatten().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
        let indices = self.triangles.iter().flatten().flat_map(|i| (*i as u16).to_le_bytes());
        let data = [vectors(&self.positions), vectors(&self.normals), indices.collect()].concat();
        let (count, size) = (self.positions.len(), 12 * self.positions.len());
        let indices = 3 * self.triangles.len();
        let normal = if smooth { ", \"NORMAL\": 1" } else { "" };
        let uri = uri.map(|uri| format!(", \"uri\": \"{uri}\"")).unwrap_or_default();
        let text = format!(
            "{{ \"asset\": {{ \"version\": \"2.0\" }}, \"buffers\": [{{ \"byteLength\": {}{uri} }}],
            \"bufferViews\": [
                {{ \"buffer\": 0, \"byteLength\": {size} }},
                {{ \"buffer\": 0, \"byteOffset\": {size}, \"byteLength\": {size} }},
                {{ \"buffer\": 0, \"byteOffset\": {}, \"byteLength\": {} }}],
            \"accessors\": [
                {{ \"bufferView\": 0, \"componentType\": 5126, \"count\": {count}, \"type\": \"VEC3\" }},
                {{ \"bufferView\": 1, \"componentType\": 5126, \"count\": {count}, \"type\": \"VEC3\" }},
                {{ \"bufferView\": 2, \"componentType\": 5123, \"count\": {indices}, \"type\": \"SCALAR\" }}],
            \"meshes\": [{{ \"primitives\": [
                {{ \"attributes\": {{ \"POSITION\": 0{normal} }}, \"indices\": 2 }}] }}],
            \"nodes\": [{{ \"mesh\": 0 }}], \"scenes\": [{{ \"nodes\": [0] }}] }}",
            data.len(),
            2 * size,
            2 * indices,
        );
        (text.into_bytes(), data)
    }

    fn glb(&self, smooth: bool) -> Vec<u8> {
        let (mut text, mut data) = self.gltf(smooth, None);
        text.resize(text.len().next_multiple_of(4), b' ');
        data.resize(data.len().next_multiple_of(4), 0);
        let mut out = b"glTF\x02\0\0\0".to_vec();
        out.extend((28 + text.len() as u32 + data.len() as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", text), (b"BIN\0", data)] {
            out.extend((chunk.len() as u32).to_le_bytes());
            out.extend(kind);
            out.extend(chunk);
        }
        out
    }
}

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

/// A document that shows a mesh in several places, mirrored, stretched, turned and flattened: it is the same picture
/// whether the mesh is kept once or copied, as is what a scene file does with the document.
#[test]
fn a_mesh_that_gltf_nodes_repeat_is_kept_once() {
    let folder = TempDir::new().unwrap();
    let dir = folder.path();
    let (text, data) = Ring::new().gltf(true, Some("d.bin"));
    fs::write(dir.join("d.bin"), data).unwrap();
    let text = String::from_utf8(text).unwrap();
    let one = "\"nodes\": [{ \"mesh\": 0 }], \"scenes\": [{ \"nodes\": [0] }]";
    let many = "\"nodes\": [
        { \"mesh\": 0, \"translation\": [-3, 0, 0] },
        { \"mesh\": 0, \"scale\": [-1, 1, 1], \"translation\": [0, 0.5, 0] },
        { \"translation\": [3, 0, 0], \"rotation\": [0.6, 0, 0, 0.8], \"children\": [3] },
        { \"mesh\": 0, \"scale\": [1, 2, 0.5] },
        { \"mesh\": 0, \"scale\": [1, 0, 1], \"translation\": [0, -1, 2] }], \"scenes\": [{ \"nodes\": [0, 1, 2, 4] }]";
    assert!(text.contains(one));
    fs::write(dir.join("a.gltf"), text.replace(one, many)).unwrap();
    for (more, places) in [
        ("", 4),
        ("transform = { scale = 0.5, rotate = { axis = [0, 0, 1], angle = 20 } }\nmaterial = \"red\"\n", 4),
        (
            "motion = [{ time = 0 }, { time = 1, translate = [0, 1, 0], rotate = { axis = [0, 1, 0], angle = 30 } }]\n",
            4,
        ),
        ("instances = [{ translate = [0, 2, 0] }, { translate = [0, -2, 0], material = \"red\" }]\n", 8),
    ] {
        let picture = |instance: bool| {
            let scene = format!(
                "[camera]\nposition = [2, 5, 9]\nlook_at = [0, 0, 0]\nfov = 50\nshutter = [0.5, 0.5]\n\
                 [render]\nmax_depth = 3\n[[mesh]]\nfile = \"a.gltf\"\ninstance = {instance}\n{more}\
                 [materials.red]\ntype = \"diffuse\"\nreflectance = [0.8, 0.1, 0.1]\n\
                 [[light]]\ntype = \"environment\"\n[[light]]\ntype = \"directional\"\ndirection = [1, -2, -1]\nirradiance = 3\n"
            );
            fs::write(dir.join("s.toml"), scene).unwrap();
            picture(dir, "s.toml");
            let image = drt::load::picture::read(&dir.join("out.exr")).unwrap().image;
            (load::scene(&dir.join("s.toml"), Options::default()).unwrap(), image.rgb_pixels())
        };
        let ((kept, once), (copied, each)) = (picture(true), picture(false));
        // Three places, and what is flattened: that is the mesh that every file has.
        assert_eq!(kept.scene.instances.places.len(), places, "{more}");
        assert_eq!(kept.triangles, copied.triangles, "{more}");
        let all = |l: &load::Loaded| {
            let instances = &l.scene.instances;
            let of = |mesh: &drt::shape::Mesh| mesh.indices.len();
            l.scene.meshes.iter().map(|m| of(m)).sum::<usize>()
                + instances.meshes.iter().map(|m| of(m)).sum::<usize>()
        };
        assert!(all(&kept) < all(&copied), "{more}: {} {}", all(&kept), all(&copied));
        let differ =
            once.iter().zip(&each).filter(|(a, b)| (0..3).any(|c| (a[c] - b[c]).abs() > 1e-3 + 0.01 * b[c]));
        let differ = differ.count();
        // Corners are rounded in other places, and a few samples go other ways.
        assert!(differ < once.len() / 25, "{more}: {differ} of {} pixels differ", once.len());
        let mean =
            |image: &[[f32; 3]]| image.iter().map(|p| f64::from(p[1])).sum::<f64>() / image.len() as f64;
        let ratio = mean(&once) / mean(&each);
        assert!((ratio - 1.0).abs() < 5e-4, "{more}: {ratio} of the brightness");
        assert!(once.iter().any(|p| p[0] > 1.1), "{more}: nothing is lit by the sun");
    }
    // Where all could be kept once, one place is that mesh.
    let all = many
        .replace(",\n        { \"mesh\": 0, \"scale\": [1, 0, 1], \"translation\": [0, -1, 2] }", "")
        .replace(", 4]", "]");
    fs::write(dir.join("a.gltf"), text.replace(one, &all)).unwrap();
    fs::write(dir.join("s.toml"), "[[mesh]]\nfile = \"a.gltf\"\ninstance = true\n").unwrap();
    let loaded = load::scene(&dir.join("s.toml"), Options::default()).unwrap();
    assert_eq!((loaded.scene.instances.places.len(), loaded.triangles), (3, 3 * 192));
    // Few triangles are copied unless it is asked for.
    let bare = load::scene(&dir.join("a.gltf"), Options::default()).unwrap();
    assert_eq!((bare.scene.instances.places.len(), bare.triangles), (0, 3 * 192));
}
