//! What every tree has: all triangles within their boxes, few levels, the same bits on any number of threads.

use super::*;

/// Depth of the tree, having checked that every triangle is in exactly one leaf, inside all boxes above.
pub fn check(tree: &Built) -> usize {
    fn visit(tree: &Built, child: Child, lo: [f32; 3], hi: [f32; 3], seen: &mut Vec<u64>) -> usize {
        if child.is_leaf() {
            for block in &tree.blocks[child.blocks()] {
                for lane in (0..4).filter(|&lane| block.mesh[lane] != u32::MAX) {
                    seen.push((block.mesh[lane] as u64) << 32 | block.triangle[lane] as u64);
                    for k in 0..3 {
                        let x = block.corners.map(|corner| corner[k][lane]);
                        assert!(x.iter().all(|x| lo[k] <= *x && *x <= hi[k]), "outside of its box");
                    }
                }
            }
            return 0;
        }
        let node = &tree.nodes[child.index()];
        let used = (0..8).filter(|&slot| node.children[slot] != Child::NONE);
        let depths = used.map(|slot| {
            let (lo, hi) =
                ([0, 1, 2].map(|k| node.planes[k][0][slot]), [0, 1, 2].map(|k| node.planes[k][1][slot]));
            visit(tree, node.children[slot], lo, hi, seen)
        });
        1 + depths.collect::<Vec<_>>().into_iter().max().unwrap_or(0)
    }
    let mut seen = Vec::new();
    let (lo, hi) = ([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]);
    let depth = visit(tree, Child::node(0), lo, hi, &mut seen);
    let all = seen.len();
    seen.sort_unstable();
    seen.dedup();
    assert_eq!(seen.len(), all, "a triangle in two leaves");
    assert!(depth <= MAX_DEPTH);
    depth
}

#[test]
fn the_same_tree_on_any_number_of_threads() {
    let n = PARALLEL as u32 + 1000;
    // Medium sorts whole boxes, so the needles are for the one that does not; few of them share a code.
    let cases = [
        (Quality::Medium, soup(n, 0.01, |p| p)),
        (Quality::Low, soup(n, 0.01, |p| p.map(|x| x * x * x * x * x * x * x))),
        (Quality::High, needles(n)),
    ];
    for (quality, mesh) in cases {
        let mesh = Arc::new(mesh);
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            pool.install(|| built_as(&mesh, quality))
        };
        let one = on(1);
        for threads in [2, 5] {
            let other = on(threads);
            let text = |b: &Built| (format!("{:?}", b.nodes), format!("{:?}", b.blocks));
            assert!(text(&one) == text(&other), "{quality:?} on {threads} threads");
        }
    }
}

/// Checks that every point of every triangle is in a leaf that holds the triangle and in all boxes above, with
/// the margin that the triangle's own coordinates ask for. Returns the depth and the number of references.
fn check_covered(mesh: &Mesh, tree: &Built) -> (usize, usize) {
    type Boxes = std::collections::BTreeMap<u32, Vec<([f32; 3], [f32; 3])>>;
    fn visit(tree: &Built, child: Child, lo: [f32; 3], hi: [f32; 3], boxes: &mut Boxes) -> usize {
        if child.is_leaf() {
            for block in &tree.blocks[child.blocks()] {
                for lane in (0..4).filter(|&lane| block.mesh[lane] != u32::MAX) {
                    boxes.entry(block.triangle[lane]).or_default().push((lo, hi));
                }
            }
            return 0;
        }
        let node = &tree.nodes[child.index()];
        let mut depth = 0;
        for slot in (0..8).filter(|&slot| node.children[slot] != Child::NONE) {
            let lo = [0, 1, 2].map(|k| lo[k].max(node.planes[k][0][slot]));
            let hi = [0, 1, 2].map(|k| hi[k].min(node.planes[k][1][slot]));
            depth = depth.max(visit(tree, node.children[slot], lo, hi, boxes));
        }
        1 + depth
    }
    let mut boxes = Boxes::new();
    let (lo, hi) = ([f32::NEG_INFINITY; 3], [f32::INFINITY; 3]);
    let depth = visit(tree, Child::node(0), lo, hi, &mut boxes);
    assert!(depth <= MAX_DEPTH);
    let mut random = random(3);
    for (triangle, _) in mesh.indices.iter().enumerate() {
        let corners = mesh.triangle(triangle).map(|p| p.as_dvec3());
        if !crate::accel::brute::has_area(mesh.triangle(triangle)) {
            continue;
        }
        let mine = &boxes[&(triangle as u32)];
        let largest = corners.iter().fold(0.0, |l: f64, p| l.max(p.abs().max_element()));
        // 14 of the 16 units of rounding that a margin has are needed.
        let need = largest * 14.0 / (1 << 24) as f64;
        for i in 0..12 {
            let (u, v) = (random.unit() as f64, random.unit() as f64);
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            let p = match i {
                0..3 => corners[i],
                _ => corners[0] + (corners[1] - corners[0]) * u + (corners[2] - corners[0]) * v,
            };
            let holds = |(lo, hi): &([f32; 3], [f32; 3])| {
                (0..3).all(|k| lo[k] as f64 + need <= p[k] && p[k] <= hi[k] as f64 - need)
            };
            assert!(mine.iter().any(holds), "a point of triangle {triangle} is in no box");
        }
    }
    (depth, boxes.values().map(Vec::len).sum())
}

#[test]
fn boxes_cover_their_triangles_in_every_quality() {
    let place = |scale: f32, offset: f32| move |p: [f32; 3]| p.map(|x| x * scale + offset);
    let meshes = [
        soup(3000, 0.3, |p| p),
        needles(3000),
        soup(1000, 0.3, place(1e-3, 1e3)),
        soup(1000, 0.3, place(4e17, 0.0)),
        soup(1000, 0.3, |p| p.map(|x| (x * 4.0).round())),
        soup(1000, 0.3, |[x, y, z]| [x, y, z * 1e-6]),
    ];
    for (i, mesh) in meshes.into_iter().enumerate() {
        let mesh = Arc::new(mesh);
        let sound = mesh.indices.iter().enumerate();
        let sound = sound.filter(|(t, _)| crate::accel::brute::has_area(mesh.triangle(*t))).count();
        for quality in QUALITIES {
            let tree = built_as(&mesh, quality);
            let (_, references) = check_covered(&mesh, &tree);
            assert_eq!((tree.leaves_of_one * sound as f64).round() as usize, references);
            let most = if quality == Quality::High { 2 * sound } else { sound };
            assert!((sound..=most).contains(&references), "mesh {i}, {quality:?}: {references}");
            if i == 1 && quality == Quality::High {
                assert!(references > sound, "nothing was split in space");
            }
        }
    }
}

#[test]
fn ordinary_and_degenerate_trees_are_shallow() {
    let same = Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]; 30_000]);
    // Each triangle twice as large as all before it: the heuristic peels them off one by one.
    let mut positions = Vec::new();
    for i in 0..4000u32 {
        let s = f32::from_bits((i / 20 + 20) << 23) * (1.0 + (i % 20) as f32 * 0.04);
        positions.extend([[s, 0.0, 0.0], [0.0, s, 0.0], [s, s, s]]);
    }
    let n = positions.len() as u32 / 3;
    let growing = Mesh::new(positions, (0..n).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect());
    let cases = [(soup(50_000, 0.01, |p| p), 9), (same, 9), (growing, MAX_DEPTH)];
    for (mesh, most) in cases {
        let mesh = Arc::new(mesh);
        for quality in QUALITIES {
            let (depth, _) = check_covered(&mesh, &built_as(&mesh, quality));
            assert!(depth <= most, "{quality:?}: {depth} levels");
        }
    }
}
