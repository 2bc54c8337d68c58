//! Small meshes whose answers are known.

use super::*;
use crate::error::Severity;
use crate::load::obj::{Counts, ReadOptions, read_from};
use crate::math::DVec3;
use crate::shape::{Attribute, Mesh};

/// A cube of edge 2 around the origin, wound counter-clockwise seen from outside; every vertex once.
fn cube() -> (Vec<[f32; 3]>, Vec<[u32; 3]>) {
    let sign = |bit: usize| if bit == 0 { -1.0 } else { 1.0 };
    let positions = (0..8usize).map(|i| [sign(i & 1), sign(i & 2), sign(i & 4)]).collect();
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    (positions, triangles)
}

/// Line k + 1 for triangle k.
fn examine(mesh: &Mesh, origin: DVec3) -> (MeshReport, Findings) {
    let lines: Vec<u32> = (1..=mesh.indices.len() as u32).collect();
    check_mesh(Path::new("m.obj"), mesh, origin, &lines, Counts::default()).unwrap()
}

fn report((positions, triangles): (Vec<[f32; 3]>, Vec<[u32; 3]>)) -> (MeshReport, Findings) {
    examine(&Mesh::new(positions, triangles), DVec3::ZERO)
}

fn kinds(findings: &Findings) -> Vec<(&'static str, u64)> {
    findings.counts().map(|(kind, count, _)| (kind, count)).collect()
}

fn lines_of(findings: &Findings, kind: &str) -> Vec<u64> {
    findings.kept().filter(|f| f.kind == kind).map(|f| f.line).collect()
}

#[test]
fn a_closed_cube_has_nothing_wrong() {
    let (cube, findings) = report(cube());
    assert!(findings.is_empty(), "{findings:?}");
    assert_eq!((cube.area, cube.volume), (24.0, Some(8.0)));
    assert_eq!(cube.bounds, Some(Bounds { min: DVec3::splat(-1.0), max: DVec3::ONE }));
    assert!(cube.welded.watertight && cube.welded.oriented);
    assert_eq!(cube.by_index, cube.welded);
}

#[test]
fn an_open_cube_has_one_rim() {
    let (positions, mut triangles) = cube();
    triangles.truncate(10);
    let (open, findings) = report((positions, triangles));
    assert_eq!((open.welded.boundary_edges, open.welded.boundary_loops), (4, 1));
    assert!(!open.welded.watertight);
    assert_eq!(open.volume, None);
    assert_eq!(kinds(&findings), [("surface-open", 1)]);
    assert_eq!(findings.at_least(Severity::Warning), 0);
}

#[test]
fn holes_are_counted_one_by_one_and_the_largest_comes_first() {
    let (positions, triangles) = cube();
    // Without the first face and one triangle of the second, which lies opposite.
    let (open, findings) = report((positions, triangles[3..].to_vec()));
    assert_eq!((open.welded.boundary_edges, open.welded.boundary_loops), (7, 2));
    let messages: Vec<_> = findings.kept().map(|f| f.message.clone()).collect();
    assert!(messages[0].contains("a rim of 4 edges"), "{messages:?}");
    assert!(messages[1].contains("a rim of 3 edges"), "{messages:?}");
}

#[test]
fn a_moebius_strip_has_one_rim_and_no_consistent_winding() {
    let n = 12u32;
    let mut positions = Vec::new();
    for i in 0..n {
        let turn = f64::from(i) / f64::from(n) * std::f64::consts::TAU;
        for side in [-0.3, 0.3] {
            let radius = 1.0 + side * (turn / 2.0).cos();
            let p = [radius * turn.cos(), radius * turn.sin(), side * (turn / 2.0).sin()];
            positions.push(p.map(|x| x as f32));
        }
    }
    let mut triangles = Vec::new();
    for i in 0..n {
        let (a, b) = (2 * i, 2 * i + 1);
        // The last step joins the sides crosswise: that is the twist.
        let (c, d) = if i + 1 < n { (2 * i + 2, 2 * i + 3) } else { (1, 0) };
        triangles.extend([[a, c, b], [b, c, d]]);
    }
    let (strip, findings) = report((positions, triangles));
    assert_eq!((strip.welded.boundary_edges, strip.welded.boundary_loops), (u64::from(2 * n), 1));
    assert_eq!(strip.welded.non_manifold_edges, 0);
    assert_eq!(strip.welded.mixed_edges, 1, "where the strip closes");
    assert_eq!(kinds(&findings), [("surface-open", 1), ("winding-mixed", 1)]);
}

#[test]
fn two_cubes_that_share_an_edge_are_not_manifold_there() {
    let (mut positions, mut triangles) = cube();
    let (second, more) = cube();
    // The second stands diagonally: its edge at (−1, −1) is the first one's at (1, 1).
    positions.extend(second.iter().map(|[x, y, z]| [x + 2.0, y + 2.0, *z]));
    triangles.extend(more.into_iter().map(|t| t.map(|i| i + 8)));
    let (cubes, findings) = report((positions, triangles));
    assert_eq!(cubes.by_index.non_manifold_edges, 0);
    assert_eq!(cubes.coincident_vertices, 2);
    assert_eq!(cubes.welded.non_manifold_edges, 1);
    assert!(cubes.welded.watertight);
    assert_eq!(cubes.volume, Some(16.0));
    assert_eq!(kinds(&findings), [("edge-non-manifold", 1), ("vertices-coincident", 1)]);
    let finding = findings.kept().next().unwrap();
    assert!(finding.message.contains("(1 1 -1) to (1 1 1)"), "{}", finding.message);
}

#[test]
fn three_pages_of_a_book_are_not_manifold_at_its_spine() {
    let positions = vec![[0.0; 3], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]];
    let (book, findings) = report((positions, vec![[0, 1, 2], [0, 1, 3], [0, 1, 4]]));
    assert_eq!((book.welded.non_manifold_edges, book.welded.mixed_edges), (1, 0));
    assert_eq!((book.welded.boundary_edges, book.welded.watertight), (6, false));
    assert_eq!(lines_of(&findings, "edge-non-manifold"), [1]);
}

#[test]
fn a_turned_face_is_named_by_its_line() {
    let (positions, mut triangles) = cube();
    triangles[7].swap(1, 2);
    let (turned, findings) = report((positions, triangles));
    assert_eq!(turned.welded.mixed_edges, 3);
    assert!(turned.welded.watertight && !turned.welded.oriented);
    assert_eq!(turned.volume, None);
    assert_eq!(kinds(&findings), [("winding-mixed", 3)]);
    assert!(lines_of(&findings, "winding-mixed").contains(&7), "it shares a diagonal with line 8");
}

#[test]
fn a_cube_turned_inside_out_says_so() {
    let (positions, mut triangles) = cube();
    triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let (turned, findings) = report((positions, triangles));
    assert_eq!(turned.volume, Some(-8.0));
    assert_eq!(kinds(&findings), [("inside-out", 1)]);
}

#[test]
fn a_soup_is_closed_once_it_is_welded() {
    let (positions, triangles) = cube();
    let mut soup: Vec<[f32; 3]> = triangles.iter().flatten().map(|i| positions[*i as usize]).collect();
    // Zeros of either sign are one place.
    soup.iter_mut().flatten().for_each(|x| *x = (*x + 1.0) * 0.5);
    soup[0] = soup[0].map(|x| if x == 0.0 { -0.0 } else { x });
    let triangles = (0..12).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let (soup, findings) = report((soup, triangles));
    assert_eq!((soup.by_index.boundary_edges, soup.by_index.boundary_loops), (36, 12));
    assert!(soup.welded.watertight && soup.welded.oriented);
    assert_eq!((soup.coincident_vertices, soup.volume), (36 - 8, Some(1.0)));
    assert_eq!(kinds(&findings), [("vertices-coincident", 1)]);
}

#[test]
fn normals_that_all_point_back_are_found_and_others_are_not() {
    let (positions, triangles) = cube();
    let mut mesh = Mesh::new(positions, triangles);
    // Smooth outward normals, of which face 5 gets the opposite.
    let mut values: Vec<[f32; 3]> = mesh.positions.to_vec();
    let outward: Vec<[u32; 3]> = mesh.indices.clone();
    let mut indices = outward;
    values.extend(mesh.positions.iter().map(|p| p.map(|x| -x)));
    indices[5] = indices[5].map(|i| i + 8);
    indices[6][0] += 8;
    mesh.normals = Some(Attribute { values, indices: Some(indices) });
    let (flipped, findings) = examine(&mesh, DVec3::ZERO);
    assert_eq!(flipped.flipped_normals, 1);
    assert_eq!(lines_of(&findings, "normals-flipped"), [6]);
}

#[test]
fn far_meshes_keep_their_bounds_in_f64() {
    let far = DVec3::new(3e7, 0.0, -2e7);
    let (positions, triangles) = cube();
    let (report, findings) = examine(&Mesh::new(positions, triangles), far);
    assert_eq!(report.bounds, Some(Bounds { min: far - 1.0, max: far + 1.0 }));
    assert_eq!(report.volume, Some(8.0));
    assert_eq!(kinds(&findings), [("coordinates-huge", 1), ("far-from-origin", 1)]);
}

#[test]
fn vertices_without_a_face_are_counted_and_not_welded() {
    let (mut positions, triangles) = cube();
    positions.extend([[-1.0; 3], [5.0; 3]]);
    let (report, findings) = report((positions, triangles));
    assert_eq!((report.vertices, report.unreferenced_vertices, report.coincident_vertices), (10, 2, 0));
    assert_eq!(kinds(&findings), [("vertices-unreferenced", 1)]);
    assert_eq!(report.bounds.unwrap().max, DVec3::ONE);
}

#[test]
fn nothing_to_render_is_an_error_and_has_no_box() {
    let (report, findings) = report((vec![[0.0; 3]], Vec::new()));
    assert_eq!((report.bounds, report.volume, report.area), (None, None, 0.0));
    assert!(!report.welded.watertight);
    assert_eq!(findings.at_least(Severity::Error), 1);
}

#[test]
fn long_lists_are_counted_in_full() {
    // 300 separate triangles, each a rim of its own.
    let positions = (0..300).flat_map(|i| {
        let x = i as f32 * 2.0;
        [[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x, 1.0, 0.0]]
    });
    let triangles = (0..300).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
    let (report, findings) = report((positions.collect(), triangles));
    assert_eq!(report.welded.boundary_loops, 300);
    assert_eq!(findings.count("surface-open"), 300);
    assert_eq!(findings.kept().count(), Findings::KEPT);
}

/// A grid of many chunks with some holes, judged by a table of all edges.
#[test]
fn large_meshes_agree_with_a_plain_count() {
    let n = 300u32;
    let positions: Vec<[f32; 3]> = (0..n * n).map(|i| [(i % n) as f32, (i / n) as f32, 0.0]).collect();
    let mut triangles = Vec::new();
    for y in 0..n - 1 {
        for x in 0..n - 1 {
            let a = y * n + x;
            let hash = a.wrapping_mul(0x9e37_79b9) >> 24;
            if hash > 3 {
                triangles.push([a, a + 1, a + n + 1]);
            }
            triangles.push(if hash < 250 { [a, a + n + 1, a + n] } else { [a, a + n, a + n + 1] });
        }
    }
    let mut edges = std::collections::BTreeMap::<[u32; 2], [u64; 2]>::new();
    for [a, b, c] in &triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            edges.entry([*from.min(to), *from.max(to)]).or_default()[usize::from(from > to)] += 1;
        }
    }
    assert!(triangles.len() > 2 * topology::CHUNK);
    let (report, findings) = report((positions, triangles.clone()));
    let count = |what: [u64; 2]| edges.values().filter(|uses| **uses == what).count() as u64;
    assert_eq!(report.welded.boundary_edges, count([1, 0]) + count([0, 1]));
    assert_eq!(report.welded.mixed_edges, count([2, 0]) + count([0, 2]));
    // Every line that is named has such an edge.
    for line in lines_of(&findings, "winding-mixed") {
        let [a, b, c] = triangles[line as usize - 1];
        let mixed = |f: u32, t: u32| edges[&[f.min(t), f.max(t)]].contains(&2);
        assert!(mixed(a, b) || mixed(b, c) || mixed(c, a), "line {line}");
    }
}

/// A turned triangle beyond the first chunk: each of its edges is named by the first face that has it.
#[test]
fn faces_of_later_chunks_are_named_by_their_lines() {
    let n = 300u32;
    let positions = (0..n * n).map(|i| [(i % n) as f32, (i / n) as f32, 0.0]).collect();
    let corners = (0..n * (n - 1)).filter(|a| a % n + 1 < n);
    let mut triangles: Vec<_> =
        corners.flat_map(|a| [[a, a + 1, a + n + 1], [a, a + n + 1, a + n]]).collect();
    let turned = 2 * 70_000 + 1;
    assert!(turned > 2 * topology::CHUNK && triangles.len() > turned);
    triangles[turned].swap(1, 2);
    let (grid, findings) = report((positions, triangles));
    assert_eq!(grid.welded.mixed_edges, 3);
    let mut lines = lines_of(&findings, "winding-mixed");
    lines.sort_unstable();
    // To the left the square before it, along the diagonal its own square's other half, below itself.
    let line = turned as u64 + 1;
    assert_eq!(lines, [line - 3, line - 1, line]);
}

/// Lines come with every triangle, whatever was skipped, split, deferred or dropped, at any block size.
#[test]
fn the_reader_keeps_the_lines_of_faces() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n# comment\nf 1 2 3 4\nf 1 2 99\nf 1 2 5\n\
                f -1 -2 -3\nf 1 1 2\nf 1 2 5\nf 1 x 2\nf 1 2 \\\n 5 6 3\nf 1 9 2\nv 0 0 1\nv 2 2 2\nf 4 3 5\n";
    for block_bytes in [1, 16, 40, 1 << 20] {
        let options = ReadOptions { block_bytes, face_lines: true, ..ReadOptions::default() };
        let file = read_from(text.as_bytes(), Path::new("m.obj"), None, &options).unwrap();
        assert_eq!(file.face_lines.unwrap(), [6, 6, 8, 9, 13, 13, 13, 18], "blocks of {block_bytes}");
        assert_eq!(lines_of(&file.findings, "face-zero-area"), [10]);
        assert_eq!(lines_of(&file.findings, "face-duplicate"), [11]);
        assert_eq!(lines_of(&file.findings, "face-index-out-of-range"), [7, 15]);
    }
}

#[test]
fn numbers_are_short() {
    for (x, text) in [
        (0.0, "0"),
        (-0.0, "0"),
        (1.0, "1"),
        (-1.5, "-1.5"),
        (f64::from(0.1f32), "0.1"),
        (123456.75, "123456.8"),
        (1e-5, "1.00000e-5"),
        (3e7, "3.00000e7"),
        (9_999_999.9, "10000000"),
    ] {
        assert_eq!(short(x), text);
    }
}
