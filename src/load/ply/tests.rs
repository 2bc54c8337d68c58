use crate::load::format::read_bytes;
use crate::load::object::Object;
use crate::shape::Attribute;

const SQUARE: &str = "element vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
                      element face 1\nproperty list uchar int vertex_indices\nend_header\n";

fn read(header: &str, rows: &str) -> Result<Object, String> {
    let text = format!("ply\nformat ascii 1.0\ncomment made by hand\n{header}{rows}");
    read_bytes("m.ply", text.as_bytes()).map_err(|e| e.to_string())
}

fn corners(object: &Object) -> Vec<[[f32; 3]; 3]> {
    let mesh = &object.mesh;
    mesh.indices.iter().map(|t| t.map(|i| mesh.positions[i as usize])).collect()
}

#[test]
fn polygons_are_split_and_every_number_is_used() {
    let remarked = SQUARE.replace("element face", "Created by hand\nelement face");
    let object = read(&remarked, "0 0 0\n1 0 0\n1 1 0\n0 1.5e0 0\n4 0 1 2 3\n").unwrap();
    assert_eq!((object.counts.faces, object.findings.count("unknown-statement")), (1, 1));
    assert_eq!(object.mesh.positions[3], [0.0, 1.5, 0.0]);
    assert_eq!(corners(&object).len(), 2);
    assert!(object.mesh.normals.is_none() && object.mesh.uvs.is_none());
    assert_eq!(object.materials.len(), 1);
}

#[test]
fn bytes_in_both_orders_are_the_numbers_of_the_text() {
    let header = |format: &str| {
        format!(
            "ply\nformat {format} 1.0\nelement other 2\nproperty list ushort double junk\nproperty char c\n\
             element face 2\nproperty uchar flags\nproperty list uint8 uint16 vertex_index\n\
             element vertex 4\nproperty double z\nproperty float ny\nproperty float32 x\nproperty short y\n\
             property float nx\nproperty float nz\nproperty float s\nproperty float t\nend_header\n"
        )
    };
    let mut text = header("ascii");
    text += "2 1.5 2.5 -3\n0 7\n9 3 0 1 2\n9 3 0 2 3\n";
    let (mut little, mut big) = (header("binary_little_endian"), header("binary_big_endian"));
    let (mut little, mut big) =
        (std::mem::take(&mut little).into_bytes(), std::mem::take(&mut big).into_bytes());
    macro_rules! both {
        ($($value:expr),*) => {$(
            little.extend($value.to_le_bytes());
            big.extend($value.to_be_bytes());
        )*};
    }
    both!(2u16, 1.5f64, 2.5f64, -3i8, 0u16, 7i8, 9u8, 3u8, 0u16, 1u16, 2u16, 9u8, 3u8, 0u16, 2u16, 3u16);
    for (z, x, y) in [(0.25f64, 0.0, 0), (0.5, 1.0, 0), (0.125, 1.0, 1), (-1.0, 0.0, 1)] {
        text += &format!("{z} 0 {x} {y} 0 1 {x} 0.5\n");
        both!(z, 0f32, x as f32, y as i16, 0f32, 1f32, x as f32, 0.5f32);
    }
    let text = read_bytes("m.ply", text.as_bytes()).unwrap();
    assert_eq!(&text.mesh.positions[..2], [[0.0, 0.0, 0.25], [1.0, 0.0, 0.5]]);
    assert_eq!(text.mesh.indices, [[0, 1, 2], [0, 2, 3]], "faces before their vertices");
    let Some(Attribute { values, indices: None }) = &text.mesh.normals else { panic!("its normals") };
    assert_eq!(values[..], [[0.0, 0.0, 1.0]; 4]);
    assert_eq!(text.mesh.uvs.as_ref().unwrap().values[2], [1.0, 0.5]);
    for bytes in [little, big] {
        let read = read_bytes("m.ply", &bytes).unwrap();
        assert_eq!(read.mesh.positions[..], text.mesh.positions[..]);
        assert_eq!(read.mesh.indices, text.mesh.indices);
        assert_eq!(read.mesh.normals.as_ref().unwrap().values, *values);
        assert_eq!(read.mesh.uvs.as_ref().unwrap().values, text.mesh.uvs.as_ref().unwrap().values);
    }
}

#[test]
fn strips_turn_every_second_triangle() {
    let header = "element vertex 6\nproperty float x\nproperty float y\nproperty float z\n\
                  element tristrips 1\nproperty list int int vertex_indices\nend_header\n";
    let rows = "0 0 0\n0 1 0\n1 0 0\n1 1 0\n2 0 0\n2 1 0\n9 0 2 1 3 -1 2 4 3 5\n";
    let object = read(header, rows).unwrap();
    assert_eq!(object.mesh.indices, [[0, 2, 1], [1, 2, 3], [2, 4, 3], [3, 4, 5]]);
    for [a, b, c] in corners(&object) {
        let area = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        assert!(area > 0.0, "all of one winding");
    }
}

#[test]
fn corners_have_their_own_coordinates_where_faces_say_so() {
    let header = "comment TextureFile none.png\nelement vertex 3\nproperty float x\nproperty float y\n\
                  property float z\nelement face 1\nproperty list uchar int vertex_indices\n\
                  property list uchar float texcoord\nproperty int texnumber\nend_header\n";
    let object = read(header, "0 0 0\n1 0 0\n0 1 0\n3 0 1 2 6 0.5 0 1 0 0.5 1 0\n").unwrap();
    let uvs = object.mesh.uvs.as_ref().unwrap();
    assert_eq!(uvs.corners(0, object.mesh.indices[0]), Some([[0.5, 0.0], [1.0, 0.0], [0.5, 1.0]]));
    assert_eq!(object.materials[0].name, "texture 0");
    assert_eq!(object.findings.count("texture-missing"), 1);
}

#[test]
fn what_is_wrong_with_a_face_skips_it() {
    let header = SQUARE.replace("face 1", "face 6");
    let rows = "0 0 0\n1 0 0\n1 1 0\nnan 1 0\n3 0 1 2\n3 0 1 4\n3 0 1 -1\n2 0 1\n3 0 1 3\n3 2 1 0.5\n";
    let object = read(&header, rows).unwrap();
    assert_eq!((object.mesh.indices.len(), object.skipped_faces, object.counts.faces), (1, 5, 6));
    let findings = &object.findings;
    assert_eq!(findings.count("face-index-out-of-range"), 3);
    assert_eq!(findings.count("face-too-few-corners"), 1);
    assert_eq!(findings.count("face-vertex-unusable"), 1);
    let lines: Vec<u64> =
        findings.kept().filter(|f| f.kind == "face-index-out-of-range").map(|f| f.line).collect();
    // Three lines of introduction, seven of SQUARE, four vertices; then the second, third and sixth face.
    assert_eq!(lines, [16, 17, 20]);
}

#[test]
fn what_is_no_ply_says_where() {
    for (text, words) in [
        ("ply\nformat ascii 1.0\nelement vertex 4\n", ":4: the header has no end"),
        ("ply\nformat ascii 1.0\nelement vertex many\n", ":3: an element's number"),
        ("ply\nformat ascii 1.0\nproperty float x\n", ":3: a property before any element"),
        ("ply\nformat ascii 1.0\nelement v 1\nproperty real x\n", ":4: an unknown type of numbers"),
        ("ply\nformat ascii 1.0\nelement v 1\nproperty list float int x\n", ":4: the length of a list"),
        ("ply\nformat middle_endian 1.0\n", ":2: an unknown format; known: ascii"),
        ("ply\nelement v 1\nend_header\n", "the header states no format"),
        ("ply\nhello\n", ":3: the header has no end"),
        ("plx\n", ":1: it does not begin"),
    ] {
        let error = read_bytes("m.ply", text.as_bytes()).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    let error = |header: &str, rows: &str| read(header, rows).unwrap_err();
    let cloud = SQUARE.replace("element face 1\nproperty list uchar int vertex_indices\n", "");
    let rows = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n";
    assert!(error(&cloud, rows).contains("no renderable faces; it is a cloud of 4 points"));
    assert!(
        error(&SQUARE.replace("property float z\n", ""), rows)
            .contains(":4: the element vertex has no property z")
    );
    assert!(error(SQUARE, "0 0 0\n1 oops 0\n").contains(":12: not a number"));
    assert!(
        error(SQUARE, "0 0 0\n1 0 0\n")
            .contains("ends after 2 of 4 rows of its element vertex; it is incomplete")
    );
    assert!(error(SQUARE, &format!("{rows}-3 0 1 2\n")).contains(":15: a list cannot have -3 values"));
}

#[test]
fn a_file_that_ends_among_its_faces_keeps_those_it_has() {
    let header = SQUARE.replace("face 1", "face 18446744073709551615").replace("vertex 4", "vertex 3");
    let object = read(&header, "0 0 0\n1 0 0\n1 1 0\n3 0 1 2\n3 0 1\n").unwrap();
    assert_eq!(object.mesh.indices.len(), 1);
    let finding = object.findings.kept().find(|f| f.kind == "file-truncated").unwrap();
    assert!(
        finding.message.contains("after 1 of 18446744073709551615 rows of its element face"),
        "{}",
        finding.message
    );
}
