mod materials;

use crate::bsdf::{Bsdf, Parameter};
use crate::error::Result;
use crate::load::format::{self, Reading, read_bytes};
use crate::load::framing::Lens;
use crate::load::obj::ReadOptions;
use crate::load::object::Object;
use crate::load::scene_file::LightPlan;
use crate::load::texture::Slot;
use crate::math::{DVec3, Rgb};
use crate::texture::{Channel, Transfer, Wrap};
use serde_json::{Value, json};

/// RFC 4648, as exporters write it.
fn base64(bytes: &[u8]) -> String {
    const DIGITS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut out = String::new();
    for three in bytes.chunks(3) {
        let bits = three.iter().fold(0u32, |bits, b| bits << 8 | u32::from(*b)) << (8 * (3 - three.len()));
        let digit = |i: usize| char::from(DIGITS[(bits >> (18 - 6 * i) & 63) as usize]);
        out.extend((0..4).map(|i| if i <= three.len() { digit(i) } else { '=' }));
    }
    out
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|x| x.to_le_bytes()).collect()
}

/// A buffer with the views in it, one after the other.
fn buffer(views: &[Vec<u8>]) -> (Value, Value) {
    let mut at = 0;
    let list = views.iter().map(|view| {
        at += view.len();
        json!({ "buffer": 0, "byteOffset": at - view.len(), "byteLength": view.len() })
    });
    let list: Vec<Value> = list.collect();
    let uri = format!("data:application/octet-stream;base64,{}", base64(&views.concat()));
    (json!([{ "byteLength": at, "uri": uri }]), json!(list))
}

/// A unit square in the plane z = 0 of four vertices, with indices of two triangles.
fn square() -> Value {
    let positions = floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
    let uvs = floats(&[0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0]);
    let (buffers, views) = buffer(&[positions, uvs, vec![0, 1, 2, 0, 2, 3]]);
    json!({
        "asset": { "version": "2.0" },
        "buffers": buffers,
        "bufferViews": views,
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2" },
            { "bufferView": 2, "componentType": 5121, "count": 6, "type": "SCALAR" },
        ],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 1 }, "indices": 2 }] }],
        "nodes": [{ "mesh": 0 }],
        "scenes": [{ "nodes": [0] }],
    })
}

fn read(document: &Value) -> Result<Object> {
    read_bytes("m.gltf", document.to_string().as_bytes())
}

fn corners(object: &Object) -> Vec<[[f32; 3]; 3]> {
    let mesh = &object.mesh;
    mesh.indices.iter().map(|t| t.map(|i| mesh.positions[i as usize])).collect()
}

/// The document with `patch` laid over it: tables are joined, the rest replaced.
fn with(mut document: Value, patch: Value) -> Value {
    fn lay(into: &mut Value, patch: Value) {
        match (into, patch) {
            (Value::Object(into), Value::Object(patch)) => {
                patch.into_iter().for_each(|(key, value)| lay(into.entry(key).or_insert(Value::Null), value));
            }
            (into, patch) => *into = patch,
        }
    }
    lay(&mut document, patch);
    document
}

#[test]
fn a_square_in_text_and_in_one_file() {
    let document = square();
    let object = read(&document).unwrap();
    assert_eq!(object.mesh.indices, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(object.mesh.positions[2], [1.0, 1.0, 0.0]);
    assert_eq!(object.mesh.uvs.as_ref().unwrap().values, [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]);
    let data = [
        floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0, 1.0, 0.0]),
        vec![0; 32],
        vec![0, 1, 2, 0, 2, 3, 0, 0],
    ]
    .concat();
    let mut text = with(document, json!({ "buffers": [{ "byteLength": data.len() }] })).to_string();
    while !text.len().is_multiple_of(4) {
        text.push(' ');
    }
    let mut glb = b"glTF\x02\0\0\0".to_vec();
    glb.extend((28 + text.len() as u32 + data.len() as u32).to_le_bytes());
    glb.extend((text.len() as u32).to_le_bytes());
    glb.extend(b"JSON");
    glb.extend(text.bytes());
    glb.extend((data.len() as u32).to_le_bytes());
    glb.extend(b"BIN\0");
    glb.extend(&data);
    assert_eq!(read_bytes("m.glb", &glb).unwrap().mesh.indices, object.mesh.indices);
    // Cut anywhere, it is refused and nothing else.
    for end in (0..glb.len()).step_by(11) {
        assert!(read_bytes("m.glb", &glb[..end]).is_err(), "{end}");
    }
}

#[test]
fn nodes_move_turn_and_mirror() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let document = with(
        square(),
        json!({
            "nodes": [
                { "children": [1, 2], "translation": [10, 0, 0] },
                { "mesh": 0, "rotation": [0, 0, half, half], "scale": [2, 1, 1] },
                { "mesh": 0, "matrix": [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1, 0, 0, 0, 5, 1] },
                { "mesh": 0 },
            ],
        }),
    );
    let object = read(&document).unwrap();
    let all = corners(&object);
    assert_eq!(all.len(), 4, "node 3 is in no scene");
    // (1, 0, 0) is doubled, turned to (0, 2, 0), and moved.
    let origin = object.origin;
    let turned = DVec3::from(all[0][1].map(f64::from)) + origin;
    assert!((turned - DVec3::new(10.0, 2.0, 0.0)).length() < 1e-6, "{turned}");
    let normal = |t: [[f32; 3]; 3]| {
        let [a, b, c] = t.map(|p| DVec3::from(p.map(f64::from)));
        (b - a).cross(c - a).normalize()
    };
    assert!(normal(all[0]).z > 0.99 && normal(all[2]).z < -0.99, "a mirrored node faces the other way");
    for (nodes, words) in [
        (json!([{ "children": [0] }]), "nodes[0] is below two other nodes, or below itself"),
        (json!([{ "children": [7] }]), "nodes[7] does not exist"),
        (json!([{ "mesh": 1 }]), "meshes[1] does not exist"),
        (json!([{ "mesh": 0, "scale": [1, 2] }]), "nodes[0].scale must be a list of 3 numbers"),
    ] {
        let error = read(&with(square(), json!({ "nodes": nodes }))).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
}

#[test]
fn strips_fans_and_lists_without_indices() {
    let triangles = |primitive: Value| -> Result<Vec<[u32; 3]>> {
        let object = read(&with(square(), json!({ "meshes": [{ "primitives": [primitive] }] })))?;
        Ok(object.mesh.indices.clone())
    };
    let attributes = json!({ "POSITION": 0 });
    assert_eq!(triangles(json!({ "attributes": attributes })).unwrap(), [[0, 1, 2]]);
    let strip = triangles(json!({ "attributes": attributes, "mode": 5 })).unwrap();
    assert_eq!(strip, [[0, 1, 2], [1, 3, 2]]);
    let fan = triangles(json!({ "attributes": attributes, "mode": 6 })).unwrap();
    assert_eq!(fan, [[1, 2, 0], [2, 3, 0]]);
    let error = triangles(json!({ "attributes": attributes, "mode": 1 })).unwrap_err().to_string();
    assert!(error.contains("no renderable faces"), "{error}");
}

#[test]
fn sparse_and_normalized_accessors() {
    let places = vec![1u8, 3];
    let values = floats(&[5.0, 0.0, 0.0, 0.0, 7.0, 0.0]);
    let shares: Vec<u8> = [0i16, 0, 0, 0, 32767, 0, 0, 0, -32768, 32767, 0, 0, 0, -16384, 0, 0]
        .iter()
        .flat_map(|x| x.to_le_bytes())
        .collect();
    let (buffers, views) = buffer(&[places, values, shares]);
    let mut document = with(
        square(),
        json!({ "buffers": buffers, "bufferViews": views, "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "mode": 6 }] }] }),
    );
    document["accessors"] = json!([{
        "componentType": 5126, "count": 4, "type": "VEC3",
        "sparse": {
            "count": 2,
            "indices": { "bufferView": 0, "componentType": 5121 },
            "values": { "bufferView": 1 },
        },
    }]);
    let object = read(&document).unwrap_err().to_string();
    assert!(object.contains("none of its 2 faces has an area"), "two vertices are at the origin: {object}");
    document["accessors"][0]["sparse"] = Value::Null;
    document["bufferViews"][2]["byteStride"] = json!(8);
    document["accessors"] =
        json!([{ "bufferView": 2, "componentType": 5122, "normalized": true, "count": 4, "type": "VEC3" }]);
    let object = read(&document).unwrap();
    assert_eq!(
        object.mesh.positions[1..],
        [[1.0, 0.0, 0.0], [-1.0, 1.0, 0.0], [0.0, -16384.0 / 32767.0, 0.0]]
    );
}

#[test]
fn counts_that_lie_are_refused_before_anything_is_allocated() {
    for (accessor, words) in [
        (
            json!({ "bufferView": 0, "componentType": 5126, "count": 5, "type": "VEC3" }),
            "accessors[0] says 5 elements",
        ),
        (
            json!({ "bufferView": 0, "byteOffset": 4, "componentType": 5126, "count": 4, "type": "VEC3" }),
            "do not fit",
        ),
        (json!({ "bufferView": 0, "componentType": 5126, "count": u64::MAX, "type": "VEC3" }), "do not fit"),
        (json!({ "componentType": 5126, "count": 4097, "type": "VEC3" }), "4097 elements of no bytes"),
        (
            json!({ "bufferView": 9, "componentType": 5126, "count": 4, "type": "VEC3" }),
            "bufferViews[9] does not exist",
        ),
        (
            json!({ "bufferView": 0, "componentType": 1, "count": 4, "type": "VEC3" }),
            "unknown \"componentType\"",
        ),
        (
            json!({ "bufferView": 0, "componentType": 5126, "count": -4, "type": "VEC3" }),
            "must be a whole number",
        ),
        (json!({ "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC9" }), "unknown \"type\""),
    ] {
        let mut document = square();
        document["accessors"][0] = accessor;
        let error = read(&document).unwrap_err().to_string();
        assert!(error.contains(words), "{error}");
    }
    // As many zeros as the longest buffer has bytes, for instance for a sparse accessor.
    let mut document = square();
    document["accessors"][1] = json!({ "componentType": 5126, "count": 5000, "type": "VEC2" });
    let refused = |d: &Value| read(d).is_err_and(|error| error.to_string().contains("of no bytes"));
    assert!(refused(&document));
    let uri = format!("data:;base64,{}", base64(&[0; 5000]));
    document["buffers"].as_array_mut().unwrap().push(json!({ "byteLength": 5000, "uri": uri }));
    assert_eq!(read(&document).unwrap().mesh.indices.len(), 2);
    document["accessors"][1]["count"] = json!(5001);
    assert!(refused(&document), "one more than the longest buffer has bytes");
    let error = |patch: Value| read(&with(square(), patch)).unwrap_err().to_string();
    let huge = json!({ "bufferViews": [{ "buffer": 0, "byteOffset": u64::MAX, "byteLength": 48 }] });
    assert!(error(huge).contains("bufferViews[0] does not fit into its buffer"));
    let short = json!({ "buffers": [{ "byteLength": 1u64 << 50, "uri": "data:;base64,AAAA" }] });
    assert!(error(short).contains("says 1125899906842624 bytes, and there are 3"));
    let missing = json!({ "buffers": [{ "byteLength": 8, "uri": "nowhere.bin" }] });
    assert!(error(missing).contains("is in a file that was not found"));
}

#[test]
fn an_index_beyond_the_vertices_skips_its_triangle() {
    let mut document = square();
    document["accessors"][0]["count"] = json!(3);
    let object = read(&document).unwrap();
    assert_eq!((object.mesh.indices.len(), object.skipped_faces), (1, 1));
    let found = object.findings.kept().find(|f| f.kind == "face-index-out-of-range").unwrap();
    assert!(found.message.starts_with("face 1 (from 0): face skipped: vertex 4"), "{}", found.message);
}

#[test]
fn what_cannot_be_read_says_so() {
    let error = |patch: Value| read(&with(square(), patch)).unwrap_err().to_string();
    let draco = error(json!({ "extensionsRequired": ["KHR_draco_mesh_compression"] }));
    assert!(
        draco.contains("requires KHR_draco_mesh_compression") && draco.contains("gltf-transform"),
        "{draco}"
    );
    assert!(error(json!({ "asset": { "version": "1.0" } })).contains("not version 2"));
    assert!(error(json!({ "asset": { "version": "2.1", "minVersion": "2.1" } })).contains("not version 2"));
    assert!(read(&with(square(), json!({ "asset": { "version": "2.1", "minVersion": "2.0" } }))).is_ok());
    assert!(read(&json!({ "scenes": [] })).unwrap_err().to_string().contains("has no \"asset\""));
    let error = read_bytes("m.gltf", b"{\n \"asset\": }").unwrap_err().to_string();
    assert!(error.contains("m.gltf:2:") && error.contains("not a whole JSON document"), "{error}");
    assert!(read(&with(square(), json!({ "extensionsRequired": ["KHR_materials_variants"] }))).is_ok());
}

#[test]
fn cameras_and_lights_stand_where_their_nodes_do() {
    let document = with(
        square(),
        json!({
            "cameras": [{ "type": "perspective", "perspective": { "yfov": 0.5, "znear": 0.1 } }],
            "extensions": { "KHR_lights_punctual": { "lights": [
                { "type": "point", "intensity": 3, "color": [1, 0.5, 0] },
                { "type": "spot", "spot": { "innerConeAngle": 0.1, "outerConeAngle": 0.2 } },
                { "type": "directional", "intensity": 2 },
            ] } },
            "nodes": [
                { "mesh": 0, "children": [1, 2, 3, 4] },
                { "camera": 0, "translation": [0, 1, 5] },
                { "extensions": { "KHR_lights_punctual": { "light": 0 } }, "translation": [1, 2, 3] },
                { "extensions": { "KHR_lights_punctual": { "light": 1 } }, "rotation": [1, 0, 0, 0] },
                { "extensions": { "KHR_lights_punctual": { "light": 2 } } },
            ],
        }),
    );
    let object = read(&document).unwrap();
    let camera = object.camera.unwrap();
    assert_eq!(
        (camera.position, camera.forward, camera.up),
        (DVec3::new(0.0, 1.0, 5.0), -DVec3::Z, DVec3::Y)
    );
    assert_eq!(camera.lens, Lens::Fov(0.5f64.to_degrees()));
    let [point, spot, sun] = object.lights.as_slice() else { panic!("three lights") };
    let position = DVec3::new(1.0, 2.0, 3.0);
    assert_eq!(*point, LightPlan::Point { position, intensity: Rgb::new(3.0, 1.5, 0.0) });
    let LightPlan::Spot { direction, cos_outer, cos_inner, .. } = spot else { panic!("a spot") };
    assert_eq!((*direction, *cos_outer, *cos_inner), (DVec3::Z, libm::cos(0.2), libm::cos(0.1)));
    assert_eq!(*sun, LightPlan::Directional { direction: -DVec3::Z, irradiance: Rgb::splat(2.0) });
}

/// What is kept once counts as well: a mesh of many primitives on one accessor is no way round the limit.
#[test]
fn shared_meshes_are_bounded_like_copies() {
    let folder = tempfile::TempDir::new().unwrap();
    let file = folder.path().join("m.gltf");
    let read = |primitives: usize, most_copied| {
        let mut document = square();
        let primitive = document["meshes"][0]["primitives"][0].clone();
        document["meshes"][0]["primitives"] = json!(vec![primitive; primitives]);
        document["nodes"] = json!([{ "mesh": 0 }, { "mesh": 0, "translation": [0, 0, 1] }]);
        document["scenes"] = json!([{ "nodes": [0, 1] }]);
        std::fs::write(&file, document.to_string()).unwrap();
        let usual = Reading::new(&|_| true);
        let options = ReadOptions { max_elements: 200, ..usual.options };
        format::read(&file, &Reading { options, most_copied, ..usual })
    };
    // Two places, and six corners of each primitive in each.
    for most_copied in [0, u64::MAX] {
        let places = read(10, most_copied).unwrap().parts.iter().map(|part| part.places.len()).sum::<usize>();
        assert_eq!(places, usize::from(most_copied == 0));
        let error = read(30, most_copied).unwrap_err();
        assert!(error.message.contains("again and again"), "{error}");
    }
}

#[test]
fn copies_skins_and_morphs() {
    let offsets = floats(&[0.0, 0.0, 0.0, 0.0, 0.0, 3.0]);
    let positions = floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    let (joints, shares) = ([0u8, 1, 0, 0].repeat(3), floats(&[0.25, 0.75, 0.0, 0.0].repeat(3)));
    let lift = floats(&[0.0, 0.0, 2.0].repeat(3));
    let (buffers, views) = buffer(&[offsets, positions, joints, shares, lift]);
    let accessor = |view: usize, kind: u32, count: usize, of: &str| json!({ "bufferView": view, "componentType": kind, "count": count, "type": of });
    let mut document = square();
    (document["buffers"], document["bufferViews"]) = (buffers, views);
    document["accessors"] = json!([
        accessor(0, 5126, 2, "VEC3"),
        accessor(1, 5126, 3, "VEC3"),
        accessor(2, 5121, 3, "VEC4"),
        accessor(3, 5126, 3, "VEC4"),
        accessor(4, 5126, 3, "VEC3"),
    ]);
    document["meshes"] = json!([
        { "primitives": [{ "attributes": { "POSITION": 1 } }] },
        { "primitives": [{ "attributes": { "POSITION": 1, "JOINTS_0": 2, "WEIGHTS_0": 3 } }] },
        { "primitives": [{ "attributes": { "POSITION": 1 }, "targets": [{ "POSITION": 4 }] }], "weights": [0.5] },
    ]);
    document["skins"] = json!([{ "joints": [1, 2] }]);
    let copies = json!({ "EXT_mesh_gpu_instancing": { "attributes": { "TRANSLATION": 0 } } });
    let heights = |nodes: Value| {
        let mut document = document.clone();
        document["nodes"] = nodes;
        document["scenes"] = json!([{ "nodes": [0, 1, 2] }]);
        let object = read(&document).unwrap();
        corners(&object).iter().map(|t| f64::from(t[0][2]) + object.origin.z).collect::<Vec<f64>>()
    };
    assert_eq!(heights(json!([{ "mesh": 0, "extensions": copies }, {}, {}])), [0.0, 3.0]);
    let joints = |z: f64| json!({ "translation": [0, 0, z] });
    assert_eq!(
        heights(json!([{ "mesh": 1, "skin": 0, "scale": [9, 9, 9] }, joints(4.0), joints(8.0)])),
        [7.0]
    );
    assert_eq!(heights(json!([{ "mesh": 2 }, {}, {}])), [1.0]);
}
