//! The OBJ reader against `tobj`, an independent one, on files that both can read.

use drt::load::obj::{ObjFile, ReadOptions, read_from};
use std::path::Path;

/// A corner: position, texture coordinate, normal.
type Corner = ([f32; 3], Option<[f32; 2]>, Option<[f32; 3]>);
/// A triangle with the name of its material.
type Triangle = ([Corner; 3], String);

struct Random(u64);

impl Random {
    fn below(&mut self, n: u64) -> u64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 33) % n
    }
    fn coordinate(&mut self) -> f64 {
        self.below(2_000_001) as f64 / 1e6 - 1.0
    }
}

/// A file of triangles and convex quads in every way of writing an index, with groups and materials.
fn generate(seed: u64) -> String {
    let mut r = Random(seed);
    let mut text = String::from("mtllib m.mtl\no first\n");
    let mut counts = [0u64; 3];
    for part in 0..6 {
        for _ in 0..20 {
            let [x, y, z] = [r.coordinate(), r.coordinate(), r.coordinate()];
            // A slanted square: convex, so that both readers split it along the same diagonal.
            for (dx, dy) in [(0.0, 0.0), (0.5, 0.0), (0.5, 0.5), (0.0, 0.5)] {
                text += &format!("v {} {:.7} {:.4e}\n", x + dx, y + dy, z + dx - dy);
            }
            text += &format!("vt {:.5} {:.5}\nvt 0 1\nvn {:.4} {:.4} 1\nvn 0 0 1\n", x, y, x, z);
            counts = [counts[0] + 4, counts[1] + 2, counts[2] + 2];
        }
        if part > 0 {
            text += &format!("g part{part} more\ns 1\nusemtl mat{}\n", r.below(3));
        }
        let style = r.below(4);
        let relative = r.below(2) == 0;
        for square in 0..counts[0] / 4 {
            let corners: &[u64] = if r.below(2) == 0 { &[1, 2, 3, 4] } else { &[2, 3, 4] };
            text += "f";
            for corner in corners {
                let [v, vt, vn] = [4 * square + corner, r.below(counts[1]) + 1, r.below(counts[2]) + 1]
                    .into_iter()
                    .zip(counts)
                    .map(|(i, count)| if relative { i as i64 - count as i64 - 1 } else { i as i64 })
                    .collect::<Vec<_>>()
                    .try_into()
                    .unwrap();
                text += &match style {
                    0 => format!(" {v}"),
                    1 => format!(" {v}/{vt}"),
                    2 => format!(" {v}//{vn}"),
                    _ => format!(" {v}/{vt}/{vn}"),
                };
            }
            text += "\n";
        }
    }
    text
}

fn ours(file: &ObjFile) -> Vec<Triangle> {
    let m = &file.mesh;
    let index = |own: &Option<Vec<[u32; 3]>>, t: usize, k: usize| match own {
        Some(list) => list[t][k],
        None => m.indices[t][k],
    };
    (0..m.indices.len())
        .map(|t| {
            let corners = std::array::from_fn(|k| {
                let uv = m.uvs.as_ref().and_then(|a| a.values.get(index(&a.indices, t, k) as usize).copied());
                let n =
                    m.normals.as_ref().and_then(|a| a.values.get(index(&a.indices, t, k) as usize).copied());
                (m.positions[m.indices[t][k] as usize], uv, n)
            });
            (corners, String::from_utf8(file.material_names[m.materials.get(t) as usize].clone()).unwrap())
        })
        .collect()
}

fn theirs(text: &str) -> Vec<Triangle> {
    let options = tobj::LoadOptions { triangulate: true, ..Default::default() };
    let mtl = "newmtl mat0\nnewmtl mat1\nnewmtl mat2\n";
    let (models, materials) =
        tobj::load_obj_buf(&mut text.as_bytes(), &options, |_| tobj::load_mtl_buf(&mut mtl.as_bytes()))
            .unwrap();
    let materials = materials.unwrap();
    let mut triangles = Vec::new();
    for m in models.iter().map(|m| &m.mesh) {
        let three = |list: &[f32], i: u32| <[f32; 3]>::try_from(&list[3 * i as usize..][..3]).unwrap();
        for t in 0..m.indices.len() / 3 {
            let corners = std::array::from_fn(|k| {
                let at = |list: &[u32]| list.get(3 * t + k).copied().filter(|&i| i != u32::MAX);
                let uv = at(&m.texcoord_indices)
                    .map(|i| [m.texcoords[2 * i as usize], m.texcoords[2 * i as usize + 1]]);
                let normal = at(&m.normal_indices).map(|i| three(&m.normals, i));
                (three(&m.positions, m.indices[3 * t + k]), uv, normal)
            });
            triangles.push((corners, m.material_id.map_or(String::new(), |id| materials[id].name.clone())));
        }
    }
    triangles
}

#[test]
fn the_same_triangles_as_tobj() {
    for seed in 0..40 {
        let text = generate(seed);
        let options = ReadOptions { block_bytes: 500 << (seed % 6), ..Default::default() };
        let file = read_from(text.as_bytes(), Path::new("generated.obj"), None, &options).unwrap();
        assert_eq!(file.counts.skipped_faces, 0);
        // Copies are dropped by us alone: the first of each remains.
        let mut expected: Vec<Triangle> = Vec::new();
        for triangle in theirs(&text) {
            let places = |t: &Triangle| t.0.map(|c| c.0);
            let copy = |e: &Triangle| {
                let [a, b, c] = places(e);
                e.1 == triangle.1 && [[a, b, c], [b, c, a], [c, a, b]].contains(&places(&triangle))
            };
            if !expected.iter().any(copy) {
                expected.push(triangle);
            }
        }
        let ours = ours(&file);
        assert_eq!(ours.len(), expected.len(), "seed {seed}");
        for (k, (ours, expected)) in ours.iter().zip(&expected).enumerate() {
            assert_eq!(ours, &without_fillers(expected, ours), "seed {seed}, triangle {k}");
        }
    }
}

/// Where a corner has no attribute, tobj fills in the model's first one.
fn without_fillers(theirs: &Triangle, ours: &Triangle) -> Triangle {
    let mut theirs = theirs.clone();
    for (theirs, ours) in theirs.0.iter_mut().zip(&ours.0) {
        theirs.1 = theirs.1.filter(|_| ours.1.is_some());
        theirs.2 = theirs.2.filter(|_| ours.2.is_some());
    }
    theirs
}
