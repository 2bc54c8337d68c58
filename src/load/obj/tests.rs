//! Row names (A1 …) are those of the table of inputs that go wrong; each test is that row's behaviour.

mod faces;
mod text;

use super::*;
use crate::error::Severity;
use crate::shape::{FaceMaterials, NO_INDEX};

fn parse_with(text: &[u8], options: &ReadOptions<'_>) -> Result<ObjFile> {
    read_from(text, Path::new("test.obj"), Some(text.len() as u64), options)
}

fn parse(text: impl AsRef<[u8]>) -> ObjFile {
    parse_with(text.as_ref(), &ReadOptions::default()).unwrap()
}

fn error(text: impl AsRef<[u8]>) -> String {
    parse_with(text.as_ref(), &ReadOptions::default()).unwrap_err().to_string()
}

/// Everything that a reader's caller can see, to compare.
fn shown(result: &Result<ObjFile>) -> String {
    match result {
        Err(e) => format!("error: {e}"),
        Ok(f) => {
            let bits: Vec<_> = f.mesh.positions.iter().map(|p| p.map(f32::to_bits)).collect();
            let counts: Vec<_> = f.findings.counts().collect();
            let kept: Vec<_> = f.findings.kept().collect();
            format!(
                "{bits:?} {:?} {:?} {:?} {:?} {} {:?} {:?} {:?} {counts:?} {kept:?}",
                f.mesh.indices,
                f.mesh.normals,
                f.mesh.uvs,
                f.mesh.materials,
                f.origin,
                f.material_names,
                f.libraries,
                f.counts
            )
        }
    }
}

/// The same file in blocks of 1 to 64 bytes must give the same result.
fn same_in_any_blocks(text: &[u8]) -> String {
    let whole = shown(&parse_with(text, &ReadOptions { keep_empty: true, ..Default::default() }));
    for block_bytes in (1..=64).chain([1000]) {
        let blocks = parse_with(text, &ReadOptions { keep_empty: true, block_bytes, ..Default::default() });
        assert_eq!(shown(&blocks), whole, "blocks of {block_bytes}");
    }
    whole
}

fn check_invariants(f: &ObjFile) {
    let m = &f.mesh;
    assert!(m.indices.iter().flatten().all(|&i| (i as usize) < m.positions.len()));
    assert!(m.positions.iter().flatten().all(|x| x.abs() <= 1e18));
    let attribute = |values: usize, indices: &Option<Vec<[u32; 3]>>| match indices {
        Some(list) => {
            assert_eq!(list.len(), m.indices.len());
            assert!(list.iter().flatten().all(|&i| i == NO_INDEX || (i as usize) < values));
            assert_ne!(list, &m.indices, "equal indices must not be listed");
        }
        None => assert!(m.indices.iter().flatten().all(|&i| (i as usize) < values)),
    };
    if let Some(n) = &m.normals {
        attribute(n.values.len(), &n.indices);
        assert!(n.values.iter().flatten().all(|x| x.is_finite()));
    }
    if let Some(t) = &m.uvs {
        attribute(t.values.len(), &t.indices);
        assert!(t.values.iter().flatten().all(|x| x.is_finite()));
    }
    for triangle in 0..m.indices.len() {
        assert!((m.materials.get(triangle) as usize) < f.material_names.len());
    }
    if let FaceMaterials::PerFace(ids) = &m.materials {
        assert_eq!(ids.len(), m.indices.len());
    }
    assert_eq!(f.counts.triangles, m.indices.len() as u64 + f.counts.zero_area + f.counts.duplicates);
    assert!(f.origin.is_finite());
}

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

fn with_square(faces: &str) -> String {
    format!("{SQUARE}vt 0 0\nvt 1 0\nvt 1 1\nvn 0 0 1\nvn 0 0 2\nvn 0 0 3\nf 1 2 3\n{faces}\n")
}

#[test]
fn a6_nothing_to_render_is_an_error_that_says_why() {
    assert!(error("").contains("no renderable faces; the file is empty"));
    for text in ["# only\n# comments\n", SQUARE, "v 0 0 0\nl 1 1\np 1\n"] {
        assert!(error(text).contains("no renderable faces; it has"), "{text}");
    }
    let all_bad = error(format!("{SQUARE}f 1 2\nf 1 2 77\n"));
    assert!(all_bad.contains("all 2 faces were skipped; line 5: "), "{all_bad}");
    assert!(error(format!("{SQUARE}f 1 1 1\n")).ends_with("none of its 1 faces has an area"));
    let mixed = error(format!("{SQUARE}f 1 1 1\nf 1 2 99\n"));
    assert!(mixed.ends_with("1 of 2 faces were skipped, and the others have no area"), "{mixed}");
    let f = parse_with(b"f 1 2 3\n", &ReadOptions { keep_empty: true, ..Default::default() }).unwrap();
    assert_eq!(f.findings.count("face-index-out-of-range"), 1);
}

/// Delivers one byte for ever, and counts.
struct Endless(u8, u64);

impl std::io::Read for Endless {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        buffer.fill(self.0);
        self.1 += buffer.len() as u64;
        assert!(self.1 < 64 << 20, "must stop at the limit");
        Ok(buffer.len())
    }
}

#[test]
fn materials_follow_usemtl() {
    let text =
        with_square("usemtl b\nf 1 3 4\nusemtl a\nusemtl b\nf 2 3 4\nusemtl a\nf 1 2 4\nusemtl unused");
    let f = parse(&text);
    assert_eq!(f.material_names, [&b""[..], b"b", b"a", b"unused"]);
    assert_eq!(f.mesh.materials, FaceMaterials::PerFace(vec![0, 1, 1, 2]));
    assert_eq!(parse(with_square("f 1 3 4")).mesh.materials, FaceMaterials::Uniform(0));
    let f = parse(format!("{SQUARE}usemtl x\nusemtl y\nf 1 2 3"));
    assert_eq!((f.mesh.materials, f.material_names.len()), (FaceMaterials::Uniform(1), 2));
    same_in_any_blocks(text.as_bytes());
}

/// Row N1: a mesh far away keeps its shape, and a shift by a power of two changes nothing at all.
#[test]
fn n1_far_meshes_are_recentred() {
    let mut random = 1u64;
    let mut next = || {
        random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (random >> 44) as f64 / f64::from(1 << 20)
    };
    let points: Vec<[f64; 3]> = (0..300).map(|_| [next(), next(), next()]).collect();
    let text = |shift: f64, scale: f64| {
        let mut text = String::new();
        for p in &points {
            text += &format!("v {} {} {}\n", p[0] * scale + shift, p[1] * scale, p[2] * scale - shift);
        }
        for i in 1..=298 {
            text += &format!("f {} {} {}\n", i, i + 1, i + 2);
        }
        text
    };
    let near = parse(text(0.0, 1.0));
    assert_eq!(near.origin, DVec3::ZERO);
    for shift in [1024.0, 1048576.0, 1073741824.0] {
        let far = parse(text(shift, 1.0));
        assert_eq!(far.origin, DVec3::new(shift, 0.0, -shift));
        assert_eq!(far.mesh.positions.to_vec(), near.mesh.positions.to_vec(), "{shift}");
        assert_eq!(far.mesh.indices, near.mesh.indices);
    }
    for scale in [1e-6, 1e6] {
        let shift = 1e6 * scale;
        let far = parse(text(shift, scale));
        for (p, q) in points.iter().zip(far.mesh.positions.iter()) {
            assert!((f64::from(q[0]) + far.origin.x - (p[0] * scale + shift)).abs() < 1e-5 * scale);
        }
    }
    same_in_any_blocks(text(1048576.0, 1.0).as_bytes());
}

#[test]
fn reading_can_be_cancelled() {
    let options = ReadOptions { progress: &|share| share < 0.5, block_bytes: 64, ..Default::default() };
    let e = parse_with(with_square("").repeat(100).as_bytes(), &options).unwrap_err();
    assert_eq!(e, cancelled());
}

#[test]
fn findings_are_the_first_by_line_whatever_the_blocks() {
    // Forward references are judged at the end of the file, the others on the way.
    let mut text = String::from("f 1 2 999999\n");
    for i in 0..300 {
        text += &format!(
            "v {i} 0 0\nf 1 2 -{}\nf 1 0 0\nv nan 0 0\nf -1 -2 800\nf 1 2 700\nf 1 2 {}\n",
            2 * i + 9,
            2 * i + 2
        );
    }
    text += "f 1 3 5 7\nf 1 3 9\nv 0 1 0\nf 1 3 -1\n";
    same_in_any_blocks(text.as_bytes());
    let f = parse(&text);
    assert_eq!(f.findings.count("face-index-out-of-range"), 1201);
    let lines: Vec<u64> =
        f.findings.kept().filter(|f| f.kind == "face-index-out-of-range").map(|f| f.line).collect();
    assert_eq!((lines.len(), lines[0], lines[1]), (100, 1, 3));
    assert!(lines.is_sorted());
}

#[test]
fn files_are_read_and_others_refused() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a b.obj");
    std::fs::write(&path, with_square("")).unwrap();
    assert_eq!(read(&path, &ReadOptions::default()).unwrap().mesh.indices.len(), 1);
    let e = read(folder.path(), &ReadOptions::default()).unwrap_err().to_string();
    assert!(e.contains("is a directory"), "{e}");
    let e = read(&folder.path().join("none"), &ReadOptions::default()).unwrap_err().to_string();
    assert!(e.contains("No such file"), "{e}");
    #[cfg(target_os = "linux")]
    for device in ["/dev/zero", "/dev/null"] {
        assert!(
            read(device.as_ref(), &ReadOptions::default())
                .unwrap_err()
                .to_string()
                .contains("not a regular file")
        );
    }
}
