//! Bytes, lines, numbers and statements.

use super::*;
use proptest::prelude::*;

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
