//! Faces: their corners, indices and triangles.

use super::*;

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
