//! Row names (A1 …) are those of the table of inputs that go wrong; each test is that row's behaviour.

use super::*;
use crate::error::Severity;
use crate::shape::{FaceMaterials, NO_INDEX};
use proptest::prelude::*;

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
fn a1_bad_position_indices_skip_the_face() {
    let good = parse(with_square(""));
    for bad in ["0", "5", "-5", "-99"] {
        let f = parse(with_square(&format!("f 1 {bad} 3")));
        assert_eq!(f.mesh.indices, good.mesh.indices, "{bad}");
        assert_eq!((f.counts.skipped_faces, f.counts.faces), (1, 2), "{bad}");
        let finding = f.findings.kept().next().unwrap();
        assert_eq!((finding.kind, finding.line), ("face-index-out-of-range", 12), "{bad}");
        assert_eq!(finding.severity, Severity::Error);
        same_in_any_blocks(with_square(&format!("f 1 {bad} 3\nf 2 3 4")).as_bytes());
    }
}

#[test]
fn a1_bad_attribute_indices_keep_the_face() {
    for bad in ["0", "4", "-4", "99999999999999999999"] {
        let f = parse(with_square(&format!("f 1/{bad}/1 3/1/1 4/1/1")));
        assert_eq!(f.mesh.indices, [[0, 1, 2], [0, 2, 3]], "{bad}");
        let uvs = f.mesh.uvs.unwrap().indices.unwrap();
        assert_eq!(uvs, [[NO_INDEX; 3], [NO_INDEX, 0, 0]]);
        assert_eq!(f.findings.count("uv-index-out-of-range"), 1, "{bad}");
        assert_eq!(f.findings.kept().next().unwrap().line, 12);

        let f = parse(with_square(&format!("f 1//{bad} 3//1 4//1")));
        assert_eq!(f.mesh.normals.unwrap().indices.unwrap()[1], [NO_INDEX, 0, 0], "{bad}");
        assert_eq!(f.findings.count("normal-index-out-of-range"), 1, "{bad}");
        assert_eq!(f.counts.skipped_faces, 0);
        same_in_any_blocks(with_square(&format!("f 1/{bad}/{bad} 3/1/1 4/1/1")).as_bytes());
    }
}

#[test]
fn a2_huge_indices_do_not_wrap() {
    let good = parse(with_square(""));
    for bad in [
        "2147483648",
        "4294967296",
        "4294967297",
        "4294967298",
        "9223372036854775808",
        "18446744073709551617",
    ] {
        for sign in ["", "-", "+"] {
            for bad in [format!("{sign}{bad}"), format!("{sign}{}", "1234567890".repeat(4))] {
                let f = parse(with_square(&format!("f 1 {bad} 3")));
                assert_eq!(f.mesh.indices, good.mesh.indices, "{bad}");
                assert_eq!(f.findings.count("face-index-out-of-range"), 1, "{bad}");
            }
        }
    }
}

#[test]
fn a3_forward_references_are_fine_when_in_range_at_the_end() {
    let text =
        "f 1//1 2//2 3//1\nf 1 2 9\nf 4 3 2 1\nv 0 0 0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\nv .4 .5 0\nvn 0 1 1\n";
    let f = parse(text);
    assert_eq!(f.mesh.indices[0], [0, 1, 2]);
    assert_eq!(f.mesh.normals.as_ref().unwrap().indices.as_ref().unwrap()[0], [0, 1, 0]);
    assert_eq!(f.mesh.indices.len(), 3);
    assert_eq!(f.counts.skipped_faces, 1);
    let finding = f.findings.kept().next().unwrap();
    assert_eq!((finding.kind, finding.line), ("face-index-out-of-range", 2));
    same_in_any_blocks(text.as_bytes());
}

#[test]
fn a4_numbers_and_what_is_none() {
    let spellings = [
        ".5",
        "5.",
        "+3",
        "1e+05",
        "1E-5",
        "-0",
        "0.1",
        "123456.789012345",
        "1e-46",
        "1e18",
        "16777217",
        "-.5e-3",
        "0.30000001192092896",
        "3.4e-39",
    ];
    for text in spellings {
        let f = parse(format!("v {text} 0 0\nv 1 2 3\nv 3 2 7\nf 1 2 3"));
        let ours = f64::from(f.mesh.positions[0][0]) + f.origin.x;
        assert_eq!(
            (ours as f32).to_bits() & !(1 << 31),
            text.parse::<f32>().unwrap().to_bits() & !(1 << 31),
            "{text}"
        );
    }
    let kinds = |text: &str| {
        let f = parse(format!("v 0 0 {text}\n{SQUARE}f 1 2 3\nf 2 3 4"));
        assert_eq!((f.mesh.indices.len(), f.counts.skipped_faces), (1, 1), "{text}");
        assert_eq!(f.findings.count("face-vertex-unusable"), 1, "{text}");
        let first = f.findings.kept().find(|f| f.kind.starts_with("vertex")).unwrap().clone();
        assert_eq!(first.line, 1);
        first.kind
    };
    for text in ["nan", "NaN", "inf", "-inf", "infinity", "1e39", "1e38", "1.1e18", "1e999"] {
        assert_eq!(kinds(text), "vertex-too-large", "{text}");
    }
    for text in ["1,5", "1.#INF", "-1.#IND", "0x10", "1e", "--1", "1.2.3", "abc", "", "1f", "1_0", "٣", "."]
    {
        assert_eq!(kinds(text), "vertex-unreadable", "{text}");
    }
}

#[test]
fn a5_triangles_without_area_and_copies_are_dropped_and_counted() {
    let text = format!(
        "{SQUARE}v 2 0 0\nv 1 0 0\nf 1 2 3\nf 1 2 2\nf 1 1 1\nf 1 2 5\nf 2 3 1\nf 3 2 1\nf 1 6 3\nusemtl a\nf 1 2 3\n"
    );
    let f = parse(&text);
    // 1 2 3, its back side, and the one of another material; vertex 6 lies where vertex 2 does.
    assert_eq!(f.mesh.indices, [[0, 1, 2], [2, 1, 0], [0, 1, 2]]);
    assert_eq!((f.counts.triangles, f.counts.zero_area, f.counts.duplicates), (8, 3, 2));
    assert_eq!(f.findings.count("face-zero-area"), 3);
    assert_eq!(f.findings.count("face-duplicate"), 2);
    assert_eq!(f.mesh.materials, FaceMaterials::PerFace(vec![0, 0, 1]));
    check_invariants(&f);
    same_in_any_blocks(text.as_bytes());
}

#[test]
fn a5_300k_coincident_faces_become_one() {
    let f = parse(format!("{SQUARE}{}", "f 1 2 3\n".repeat(300_000)));
    assert_eq!((f.mesh.indices.len(), f.counts.duplicates), (1, 299_999));
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

#[test]
fn a7_encodings_of_one_file_are_one_file() {
    let lf =
        "# a\nmtllib x y.mtl\nv 0 0 0\nv 1 0 0\n\nv 1 1 0\nv 0 1 0\nusemtl red\nf 1 2 3\nf 1 3 9\nf 1 3 4";
    let expected = shown(&Ok(parse(lf)));
    let variants = [
        lf.replace('\n', "\r\n"),
        lf.replace('\n', "\r"),
        lf.replace(' ', "\t"),
        lf.replace(' ', "   "),
        lf.replace('\n', "  \t\n"),
        format!("{lf}\n"),
        format!("\u{feff}{lf}"),
        lf.replace("v ", " \tv "),
    ];
    for variant in variants {
        // Blanks inside a name are the name's own.
        let variant = variant.replace("x\ty", "x y").replace("x   y", "x y");
        assert_eq!(shown(&Ok(parse(&variant))), expected, "{variant:?}");
        same_in_any_blocks(variant.as_bytes());
    }
}

#[test]
fn a7_nul_and_utf16_are_named() {
    let text = with_square("f 1 3 4");
    let little: Vec<u8> = text.encode_utf16().flat_map(u16::to_le_bytes).collect();
    let big: Vec<u8> = text.encode_utf16().flat_map(u16::to_be_bytes).collect();
    for utf16 in [
        &little,
        &big,
        &[&[0xff, 0xfe], little.as_slice()].concat(),
        &[&[0xfe, 0xff], big.as_slice()].concat(),
    ] {
        assert!(error(utf16).contains("looks like UTF-16"));
    }
    for (line, text) in [
        (1, "v 0\0 0 0\n"),
        (2, "v 0 0 0\n# \0\n"),
        (1, "usemtl a\0b"),
        (3, "\n\r\nfoo\0"),
        (1, "mtllib \0"),
        (1, "v \0\n\0 f"),
        (1, "# \0\r\0 f"),
    ] {
        let text = format!("{text}{SQUARE}f 1 2 3\n");
        let message = error(&text);
        assert!(message.starts_with(&format!("test.obj:{line}: a NUL byte")), "{message}");
        assert!(same_in_any_blocks(text.as_bytes()).starts_with("error"));
    }
}

#[test]
fn a8_continued_lines_are_joined() {
    for end in ["\n", "\r\n", "\r"] {
        let text = format!(
            "v 0 \\{end}0 0{end}v 1 0 0{end}v 1 \\{end}\\{end} 1 0{end}v 0 1 0{end}f\\{end} 1 2 \\{end}3{end}f 1 3 77{end}f 1 3 4 \\"
        );
        let f = parse(&text);
        assert_eq!(f.mesh.indices, [[0, 1, 2], [0, 2, 3]]);
        assert_eq!(f.findings.kept().next().unwrap().line, 11, "{end:?}");
        assert_eq!(f.counts.lines, 12);
        same_in_any_blocks(text.as_bytes());
    }
    // A comment's `\` is part of the comment.
    assert_eq!(parse(format!("# c:\\dir\\\n{SQUARE}f 1 2 3")).counts.vertices, 4);
    assert_eq!(parse(format!("{SQUARE}usemtl a \\\n b\nf 1 2 3")).material_names, [b"a   b".to_vec()]);
}

#[test]
fn a9_names_are_bytes() {
    let text = [
        SQUARE.as_bytes(),
        b"# caf\xe9 \x83\x8f\nmtllib caf\xe9 noir.mtl\nusemtl \x83\x8f\x5c\xb8\nf 1 2 3 # \xff\n",
    ]
    .concat();
    let f = parse(&text);
    assert_eq!(f.libraries, [Library { line: 6, names: b"caf\xe9 noir.mtl".to_vec() }]);
    assert_eq!(f.material_names, [b"\x83\x8f\x5c\xb8".to_vec()]);
    assert!(f.findings.is_empty());
}

#[test]
fn a10_polygons() {
    let f = parse(format!("{SQUARE}f 1 2\nf 1\nf\nf 1 2 3 4\n"));
    assert_eq!((f.counts.skipped_faces, f.mesh.indices.len()), (3, 2));
    assert_eq!(f.findings.count("face-too-few-corners"), 3);

    // A concave quad in each of its four rotations, its reflex corner being 4.
    for corners in ["1 2 3 4", "2 3 4 1", "3 4 1 2", "4 1 2 3"] {
        let f = parse(format!("v 0 0 0\nv 4 0 0\nv 0 4 0\nv 1 1 0\nf {corners}\n"));
        assert_eq!(area(&f.mesh), 6.0, "{corners}");
    }
    let mut star = String::new();
    let mut face = String::from("f");
    for i in 0..200_000 {
        let (r, a) = ([1.0, 0.5][i % 2], i as f64 * std::f64::consts::TAU / 200_000.0);
        star += &format!("v {:.9} {:.9} 0\n", r * a.cos(), r * a.sin());
        face += &format!(" -{}", 200_000 - i);
    }
    let f = parse(star + &face);
    let expected = 0.5 * 0.5 * (std::f64::consts::TAU / 200_000.0).sin() * 200_000.0;
    assert!((area(&f.mesh) / expected - 1.0).abs() < 1e-5, "{}", area(&f.mesh) / expected);
}

fn area(mesh: &Mesh) -> f64 {
    let corner = |i: u32| DVec3::from_array(mesh.positions[i as usize].map(f64::from));
    mesh.indices
        .iter()
        .map(|t| (corner(t[1]) - corner(t[0])).cross(corner(t[2]) - corner(t[0])).length() / 2.0)
        .sum()
}

#[test]
fn a11_corner_grammar() {
    let corners = [
        "1", "1/1", "1//1", "1/1/1", "1/", "1//", "1/1/", "+1", "-4/-3/-3", "1/2/3/4", "/1", "//", "/",
        "1.0", "1/1.0/1", "1/a", "a", "1-", "1//1/", "//1", "1/ /1", "1,2", "++1", "-",
    ];
    for (k, corner) in corners.iter().enumerate() {
        let f = parse(with_square(&format!("f {corner} 3/1/1 4\n")));
        let good = k < 9;
        assert_eq!(
            (f.mesh.indices.len(), f.counts.skipped_faces),
            if good { (2, 0) } else { (1, 1) },
            "{corner}"
        );
        assert_eq!(f.findings.count("face-malformed"), u64::from(!good), "{corner}");
        if good {
            assert_eq!(f.mesh.indices[1], [0, 2, 3], "{corner}");
            let own = f.mesh.uvs.unwrap().indices.unwrap()[1];
            let has_uv = ["1/1", "1/1/1", "1/1/", "-4/-3/-3"].contains(corner);
            assert_eq!(own, [if has_uv { 0 } else { NO_INDEX }, 0, NO_INDEX], "{corner}");
        }
    }
    assert_eq!(parse(with_square("f 1 3 4#comment\nf 2 3 4 # f 1 2 3\n")).mesh.indices.len(), 3);
}

#[test]
fn a12_other_statements_are_ignored() {
    let long = "x".repeat(65_536);
    let text = format!(
        "{SQUARE}o\ng\ns\nusemtl\nmtllib\ng a b c\ns off\ncurv 1 2 3\ncstype bezier\ncall /bin/sh\ncsh rm -rf /\nfoo bar\nBAR\nl 1 2\nvp 1 2\no {long}\nusemtl {long}\nf 1 2 3\nusemtl\nf 1 3 4\n"
    );
    let f = parse(&text);
    assert_eq!(f.material_names, [b"".to_vec(), long.into_bytes()]);
    assert_eq!(f.mesh.materials, FaceMaterials::PerFace(vec![1, 0]));
    let counts: Vec<_> = f.findings.counts().map(|(kind, n, _)| (kind, n)).collect();
    assert_eq!(
        counts,
        [
            ("command-ignored", 2),
            ("free-form-ignored", 2),
            ("material-name-missing", 2),
            ("mtllib-name-missing", 1),
            ("points-and-lines-ignored", 1),
            ("unknown-statement", 2)
        ]
    );
    assert_eq!(f.findings.at_least(Severity::Warning), 0);
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
fn a13_endless_lines_end_at_the_limit() {
    for byte in *b" 1x#\\" {
        let e = read_from(Endless(byte, 0), Path::new("e"), None, &ReadOptions::default())
            .unwrap_err()
            .to_string();
        assert!(e.starts_with("e:1: a line beyond the limit"), "{e}");
    }
    let text = format!("{SQUARE}\n# {}\nf 1 2 3\n", "x".repeat(5000));
    for block_bytes in [1, 100, 4096, 1 << 20] {
        let read = |max_line_bytes| {
            parse_with(text.as_bytes(), &ReadOptions { max_line_bytes, block_bytes, ..Default::default() })
        };
        let e = read(5000).unwrap_err().to_string();
        assert!(e.starts_with("test.obj:6: a line beyond"), "{e}");
        assert!(read(6000).is_ok());
    }
}

#[test]
fn a14_every_prefix_is_safe() {
    let mut text = with_square(
        "usemtl café\nf -1/-1/-1 -2/2/2 -3//3 \\\r\n 1\r\nf 4 3 2 1\nv 1e5 nan 2\nf 9 1 2\nmtllib a b\n",
    );
    while text.len() < 3000 {
        text += &format!("v {} {:.3} 7e-3\nf -1 -2/1 -3//2 # x\n", text.len(), text.len() as f64 / 7.0);
    }
    for end in 0..=text.len() {
        let prefix = &text.as_bytes()[..end];
        if let Ok(f) = parse_with(prefix, &ReadOptions { block_bytes: 97, ..Default::default() }) {
            check_invariants(&f);
        }
    }
    same_in_any_blocks(text.as_bytes());
}

#[test]
fn a15_more_elements_than_indices_address_are_refused() {
    let most = ReadOptions::default().max_elements;
    assert_eq!(most, (1 << 32) / 3);
    assert!(refuse::check_limit("vertices", most, most).is_ok());
    let e = refuse::check_limit("vertices", most + 1, most).unwrap_err().to_string();
    assert!(e.contains("1431655765 vertices (2^32/3, 16 GiB)"), "{e}");

    // Each kind is counted, over all blocks; six of any are fine.
    let good = with_square("f 1 2 3 4\nf 1 2 4\nf 2 3 4\nf 1 3 2");
    for (text, what) in [
        (good.clone(), None),
        (format!("{good}v 2 0 0\nv 3 0 0\nv 4 0 0\n"), Some("vertices")),
        (format!("{good}vt 0 0\nvt 0 0\nvt 0 0\nvt 0 0\n"), Some("texture coordinates")),
        (format!("{good}vn 0 0 1\nvn 0 0 1\nvn 0 0 1\nvn 0 0 1\n"), Some("normals")),
        (format!("{good}f 1 2 3\n"), Some("triangles")),
    ] {
        for block_bytes in [1, 16, 1 << 20] {
            let options = ReadOptions { max_elements: 6, block_bytes, ..Default::default() };
            let e = parse_with(text.as_bytes(), &options).err().map(|e| e.to_string());
            let expected = what.map(|what| format!("test.obj: more than 6 {what} in one mesh; "));
            assert_eq!(e.is_some(), expected.is_some(), "{e:?}");
            assert!(e.unwrap_or_default().starts_with(&expected.unwrap_or_default()));
        }
    }
}

#[test]
fn a16_optional_components() {
    let text = "v 0 0 0 1 0 0\nv 1 0 0 1.0\nv 1 1 0 nan # c\nv 0 1 0 x\nvt .5\nvt .5 .25\nvt .5 .25 7\nvt nan 0\nvt\nvn 0 0 5\nvn 0 0 0\nvn inf 0 0\nvn 1 x 0\nf 1/1/1 2/2/2 3/3/3\nf 1/4/4 3/5/1 4/1/1\n";
    let f = parse(text);
    check_invariants(&f);
    let uvs = f.mesh.uvs.as_ref().unwrap();
    assert_eq!(uvs.values[..3], [[0.5, 0.0], [0.5, 0.25], [0.5, 0.25]]);
    assert_eq!(uvs.indices.as_ref().unwrap()[..], [[0, 1, 2], [NO_INDEX, NO_INDEX, 0]]);
    let normals = f.mesh.normals.as_ref().unwrap();
    assert_eq!(normals.indices.as_ref().unwrap()[..], [[0, NO_INDEX, NO_INDEX], [NO_INDEX, 0, 0]]);
    assert_eq!(f.findings.count("normal-zero"), 2);
    assert_eq!(f.findings.count("normal-unreadable"), 1);
    assert_eq!(f.findings.count("uv-unreadable"), 2);
    assert_eq!(f.counts.skipped_faces, 0);
    same_in_any_blocks(text.as_bytes());
}

#[test]
fn equal_indices_are_not_listed() {
    let vertices = format!("{SQUARE}vn 0 0 1\nvn 0 0 1\nvn 0 0 1\nvn 0 0 1\n");
    for (faces, listed) in [
        ("f 1//1 2//2 3//3\nf 1//1 3//3 4//4", false),
        ("f -4//-4 -3//-3 -2//-2\nf 1//1 -2//-2 4//4", false),
        ("f 1//1 2//2 3//3 4//4", false),
        ("f 1//1 2//2 3//3\nf 1//1 3//3 4//1", true),
        ("f 1//1 2//2 3//3\nf 1 3 4", true),
        ("f 1 2 3\nf 1//1 3//3 4//4", true),
    ] {
        let text = format!("{vertices}{faces}\n");
        assert_eq!(parse(&text).mesh.normals.unwrap().indices.is_some(), listed, "{faces}");
        same_in_any_blocks(text.as_bytes());
    }
}

#[test]
fn relative_indices_are_compared_only_when_absolute() {
    // Five positions and four normals: −4 is 2 of the former and 1 of the latter.
    let text = format!(
        "v 9 9 9\n{SQUARE}vn 0 0 1\nvn 0 0 1\nvn 0 0 1\nvn 0 0 1\nf -4//-4 -3//-3 -2//-2\nf -4//-4 -2//-2 -1//-1\n"
    );
    let f = parse(&text);
    assert_eq!(f.mesh.indices, [[1, 2, 3], [1, 3, 4]]);
    assert_eq!(f.mesh.normals.unwrap().indices.unwrap(), [[0, 1, 2], [0, 2, 3]]);
    same_in_any_blocks(text.as_bytes());
}

#[test]
fn the_last_normal_of_an_earlier_block_is_one() {
    // In a block of its own, −1 is one before the block's first normal.
    let text = format!("{SQUARE}vn 0 0 1\nvt 1 1\nf 1//-1 2//-1 3//-1\nf 1/-1 3/-1 4/-1\n");
    let f = parse(&text);
    assert_eq!(f.mesh.normals.unwrap().indices.unwrap(), [[0; 3], [NO_INDEX; 3]]);
    assert_eq!(f.mesh.uvs.unwrap().indices.unwrap(), [[NO_INDEX; 3], [0; 3]]);
    same_in_any_blocks(text.as_bytes());
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

fn token() -> impl Strategy<Value = String> {
    let fixed = [
        "v",
        "vn",
        "vt",
        "f",
        "usemtl",
        "mtllib",
        "o",
        "#",
        "\n",
        "\n",
        "\n",
        "\r\n",
        "\r",
        "\\\n",
        "\\",
        "/",
        "//",
        "1",
        "2",
        "3",
        "-1",
        "-2",
        "-3",
        "0",
        "1.5",
        "-2e3",
        "nan",
        "1e99",
        ".",
        "1/1/1",
        "2//2",
        "-1/-1",
        "\0",
        "a",
        "é",
        "f 1 2 3\n",
        "v 1 2 3\n",
        "v 0 0 1\n",
        "v 7 1 0\n",
        "f -1 -2 -3\n",
        "f 1 2 3 4 5\n",
        "99999999999",
    ];
    proptest::sample::select(fixed.to_vec()).prop_map(String::from)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    /// Row A18: whatever the text, no panic, and what comes out holds its promises, in any blocks.
    #[test]
    fn a18_token_soup(tokens in proptest::collection::vec((token(), any::<bool>()), 0..120), block_bytes in 1usize..200) {
        let text: String = tokens.into_iter().map(|(t, blank)| if blank { t + " " } else { t }).collect();
        let whole = parse_with(text.as_bytes(), &ReadOptions::default());
        if let Ok(f) = &whole { check_invariants(f); }
        let blocks = parse_with(text.as_bytes(), &ReadOptions { block_bytes, ..Default::default() });
        prop_assert_eq!(shown(&whole), shown(&blocks));
    }

    #[test]
    fn a18_random_bytes(text in proptest::collection::vec(any::<u8>(), 0..300)) {
        if let Ok(f) = parse_with(&text, &ReadOptions::default()) { check_invariants(&f); }
    }
}
