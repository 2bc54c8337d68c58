use super::{FORMAT, is_text};
use crate::load::format::read_bytes;

type Facet = [[f32; 3]; 3];

const TETRAHEDRON: [Facet; 4] = [
    [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0]],
    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]],
    [[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, 1.0, 0.0]],
    [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.0, -0.0, 1.0]],
];

/// A binary file with facet normals that are nonsense.
fn binary(title: &[u8], count: u32, facets: &[Facet]) -> Vec<u8> {
    let mut out = title.to_vec();
    out.resize(80, b' ');
    out.extend(count.to_le_bytes());
    for facet in facets {
        out.extend([7.0f32, f32::NAN, -1.0].iter().flat_map(|x| x.to_le_bytes()));
        out.extend(facet.iter().flatten().flat_map(|x| x.to_le_bytes()));
        out.extend([0x12, 0x34]);
    }
    out
}

fn text(facets: &[Facet]) -> String {
    let mut out = "solid a vertex of 1 2 3\n".to_string();
    for facet in facets {
        out += "facet normal 0 0 1\n outer loop\n";
        facet.iter().for_each(|[x, y, z]| out += &format!("  vertex {x} {y:e} {z}\n"));
        out += " endloop\nendfacet\n";
    }
    out + "endsolid a vertex of 1 2 3\n"
}

#[test]
fn corners_at_one_place_are_one_vertex() {
    let files = [
        binary(b"made by hand", 4, &TETRAHEDRON),
        binary(b"solid and binary all the same", 4, &TETRAHEDRON),
        text(&TETRAHEDRON).into_bytes(),
        text(&TETRAHEDRON).to_uppercase().replace('\n', "\r\n").into_bytes(),
        [text(&TETRAHEDRON[..1]), text(&TETRAHEDRON[1..])].concat().into_bytes(),
    ];
    for (i, file) in files.iter().enumerate() {
        let object = read_bytes("m.stl", file).unwrap();
        assert_eq!((object.mesh.positions.len(), object.counts.faces), (4, 4), "{i}");
        assert_eq!(object.mesh.indices, [[0, 1, 2], [0, 2, 3], [0, 3, 1], [2, 1, 3]], "{i}");
        assert!(object.mesh.normals.is_none());
        assert!((FORMAT.begins)(&file[..file.len().min(1024)]), "{i}");
    }
    assert!(!is_text(&files[1]));
}

#[test]
fn facets_that_cannot_be_used_are_skipped() {
    let mut facets = TETRAHEDRON;
    facets[1][2] = [f32::NAN, 0.0, 0.0];
    facets[2][0] = [3e38, 0.0, 0.0];
    let object = read_bytes("m.stl", &binary(b"", 4, &facets)).unwrap();
    assert_eq!((object.mesh.indices.len(), object.skipped_faces), (2, 2));
    let found = object.findings.kept().find(|f| f.kind == "face-vertex-unusable").unwrap();
    assert!(found.message.starts_with("face 1 (from 0): face skipped"), "{}", found.message);
    let broken = text(&TETRAHEDRON).replacen("vertex 1 0e0 0", "vertex 1 zero 0", 1);
    let object = read_bytes("m.stl", broken.as_bytes()).unwrap();
    assert_eq!((object.mesh.indices.len(), object.skipped_faces), (3, 1));
    assert_eq!(object.findings.kept().find(|f| f.kind == "face-vertex-unusable").unwrap().line, 7);
}

#[test]
fn counts_that_lie_and_files_that_end() {
    let object = read_bytes("m.stl", &binary(b"", u32::MAX, &TETRAHEDRON)).unwrap();
    assert_eq!(object.mesh.indices.len(), 4);
    let found = object.findings.kept().find(|f| f.kind == "file-truncated").unwrap();
    assert_eq!(found.message, "the file ends after 4 of 4294967295 facets");
    assert_eq!(read_bytes("m.stl", &binary(b"", 2, &TETRAHEDRON)).unwrap().mesh.indices.len(), 2);
    let cut = text(&TETRAHEDRON);
    let object = read_bytes("m.stl", &cut.as_bytes()[..cut.len() - 80]).unwrap();
    assert_eq!((object.mesh.indices.len(), object.findings.count("file-truncated")), (3, 1));
    for (bytes, words) in [
        (binary(b"", 0, &[]), "neither vertices nor faces"),
        (binary(b"", 5, &[])[..83].to_vec(), "shorter than the header"),
        (b"solid nothing\nendsolid\n".to_vec(), "neither vertices nor faces"),
        (Vec::new(), "shorter than the header"),
    ] {
        let error = read_bytes("m.stl", &bytes).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}
