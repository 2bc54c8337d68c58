//! What only the inside shows: the tree's shape and the claim that boxes never change an answer.

use super::few::Few;
use super::meeting::Meetings;
use super::node::Child;
use super::ray::Prepared;
use super::split::PARALLEL;
use super::traverse::{MAX_DEPTH, Stacks};
use super::tree::{Found, Place, Tree, rank};
use super::{build, build::Built};
use crate::accel::{BuildOptions, LANES, Mask, Quality, Rays, for_lanes};
use crate::math::Vec3;
use crate::math::isa::{self, Isa, Kernel, Set};
use crate::shape::Mesh;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::sync::Arc;

struct Random(ChaCha8Rng);

impl Random {
    fn unit(&mut self) -> f32 {
        (self.0.next_u32() >> 8) as f32 / (1 << 24) as f32
    }

    fn cube(&mut self) -> [f32; 3] {
        [0; 3].map(|_| self.unit() * 2.0 - 1.0)
    }
}

fn random(seed: u64) -> Random {
    Random(ChaCha8Rng::seed_from_u64(seed))
}

fn soup(n: u32, size: f32, map: impl Fn([f32; 3]) -> [f32; 3]) -> Mesh {
    let mut random = random(n as u64);
    let mut positions = Vec::new();
    for _ in 0..n {
        let at = random.cube();
        for _ in 0..3 {
            let off = random.cube();
            positions.push(map([0, 1, 2].map(|k| at[k] + size * off[k])));
        }
    }
    Mesh::new(positions, (0..n).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

fn built(mesh: Mesh) -> Built {
    built_as(&Arc::new(mesh), Quality::Medium)
}

fn built_as(mesh: &Arc<Mesh>, quality: Quality) -> Built {
    let options = BuildOptions { quality, ..BuildOptions::default() };
    build::build(std::slice::from_ref(mesh), &options).expect("builds")
}

const QUALITIES: [Quality; 3] = [Quality::Low, Quality::Medium, Quality::High];

/// Thin triangles across the axes: their boxes overlap, so space is split.
fn needles(n: u32) -> Mesh {
    let mut random = random(n as u64);
    let mut positions = Vec::new();
    for _ in 0..n {
        let (at, along) = (random.cube(), random.cube());
        for s in [0.0, 1.0, 0.5] {
            let off = random.cube();
            positions.push([0, 1, 2].map(|k| at[k] + along[k] * s + off[k] * 0.003));
        }
    }
    Mesh::new(positions, (0..n).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

/// Depth of the tree, having checked that every triangle is in exactly one leaf, inside all boxes above.
fn check(tree: &Built) -> usize {
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

/// Every triangle tested, in an order of its own: distance and rank of the closest hit.
fn linear(tree: &Built, rays: &Prepared, i: usize) -> Option<(u32, u64)> {
    let mut best: Option<(f32, u64)> = None;
    for block in tree.blocks.iter().rev() {
        let (met, t) = block.meet(rays, i, rays.tmax[i]);
        for lane in (0..4).filter(|lane| met >> lane & 1 == 1) {
            let hit = (t[lane], rank(block.ids(lane)));
            if best.is_none_or(|b| hit < b) {
                best = Some(hit);
            }
        }
    }
    best.map(|(t, id)| (t.to_bits(), id))
}

/// Both questions to a tree, or to the filter of few triangles.
struct Ask<'a> {
    tree: Tree<'a>,
    few: Option<&'a Few>,
    rays: &'a Rays,
    prepared: &'a Prepared,
}

impl Kernel for Ask<'_> {
    type Output = (Found, Mask);

    fn run<S: Set>(self) -> (Found, Mask) {
        let Ask { tree, few, rays, prepared } = self;
        let mut stacks = Stacks::new();
        match few {
            Some(few) => {
                (few.closest::<S>(&tree, rays, prepared).0, few.occluded::<S>(&tree, rays, prepared))
            }
            None => (tree.closest::<S>(prepared, &mut stacks), tree.occluded::<S>(prepared, &mut stacks)),
        }
    }
}

/// Asks in every way there is, and compares with `linear`; returns the number of hits.
fn ask_in_every_way(tree: &Built, few: Option<&Few>, rays: &Rays) -> u32 {
    let prepared = Prepared::new(rays, Mask::MAX);
    let expected: Vec<_> = (0..LANES)
        .map(|i| (prepared.live >> i & 1 == 1).then(|| linear(tree, &prepared, i)).flatten())
        .collect();
    let ways = [(None, false), (None, true), (few, false)];
    for ((few, in_turns), isa) in ways.into_iter().flat_map(|way| Isa::ALL.map(|isa| (way, isa))) {
        let view = Tree { nodes: &tree.nodes, blocks: &tree.blocks, in_turns };
        let (found, any) = isa::run(isa, Ask { tree: view, few, rays, prepared: &prepared });
        let meetings = Meetings::of(&view, &found.place, &prepared);
        for (i, expected) in expected.iter().enumerate() {
            let hit = found.hit >> i & 1 == 1;
            let got = hit.then(|| (meetings.t[i].to_bits(), rank(view.ids(found.place[i]))));
            assert_eq!(got, *expected, "{} in turns: {in_turns}, few: {}", isa.name(), few.is_some());
            assert_eq!(any >> i & 1 == 1, hit);
        }
    }
    expected.iter().flatten().count() as u32
}

/// A chunk of rays around and through a box, some of them along the axes.
fn rays_through(center: [f32; 3], half: [f32; 3], random: &mut Random) -> Rays {
    let mut rays = Rays::default();
    for i in 0..LANES {
        let mut point = |spread: f32| {
            let p = random.cube();
            Vec3::from([0, 1, 2].map(|k| center[k] + half[k] * spread * p[k]))
        };
        let (o, target) = (point(if i % 3 == 0 { 1.0 } else { 2.0 }), point(1.0));
        let mut d = (target - o).to_array();
        if i % 4 == 0 {
            d[i / 4 % 3] = if i % 8 == 0 { 0.0 } else { -0.0 };
        }
        let tmax = if i % 5 == 0 { 0.7 } else { f32::INFINITY };
        rays.set(i, o, d.into(), if i % 7 == 0 { 0.2 } else { 0.0 }, tmax);
    }
    rays
}

#[test]
fn neither_tree_nor_filter_nor_instruction_set_changes_an_answer() {
    let place = |scale: f32, offset: f32| move |p: [f32; 3]| p.map(|x| x * scale + offset);
    let meshes = [
        soup(500, 0.2, |p| p),
        soup(500, 0.01, |p| p),
        soup(300, 0.2, |[x, y, z]| [x, y, z * 1e-6]),
        soup(300, 0.2, |p| p.map(|x| (x * 4.0).round())),
        soup(300, 0.2, |[x, y, _]| [(x * 4.0).round(), y, 1.0]),
        soup(300, 0.1, place(1e-3, 1e3)),
        soup(300, 0.1, place(1e-30, 0.0)),
        soup(300, 0.1, place(1e-42, 0.0)),
        soup(300, 0.1, place(4e17, 0.0)),
        soup(40, 1.0, |p| p),
        soup(40, 1.0, |p| p.map(|x| (x * 2.0).round())),
        soup(30, 0.5, place(0.5, 3e3)),
        soup(60, 0.7, |[x, y, z]| [x, y, (z * 2.0).round()]),
        soup(20, 0.7, place(1e9, 0.0)),
    ];
    let mut random = random(1);
    let (mut hits, mut filtered) = (0, 0);
    for mesh in meshes {
        let bounds = mesh.bounds();
        let (center, half) = (bounds.center().to_array(), (bounds.extent() * 0.5).to_array());
        let tree = built(mesh);
        check(&tree);
        let few = Few::new(&tree.blocks);
        filtered += few.is_some() as u32;
        for _ in 0..100 {
            hits += ask_in_every_way(&tree, few.as_ref(), &rays_through(center, half, &mut random));
        }
    }
    assert!(hits > 3000, "{hits} hits show little");
    assert!(filtered >= 4, "{filtered} scenes have a filter");
}

#[test]
fn rays_at_edges_and_corners_of_few_triangles() {
    // A box of six quads on integers: every diagonal and edge is shared, and most distances tie.
    let corners: Vec<[f32; 3]> = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(|x| x as f32)).collect();
    let quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let indices: Vec<[u32; 3]> = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
    let tree = built(Mesh::new(corners, indices));
    let few = Few::new(&tree.blocks);
    assert!(few.is_some());
    let mut random = random(2);
    let mut hits = 0;
    for n in 0..400 {
        let mut rays = Rays::default();
        for i in 0..LANES {
            let step = |random: &mut Random| (random.unit() * 5.0).floor() / 4.0;
            let target = Vec3::new(step(&mut random), step(&mut random), step(&mut random));
            let o = match n % 3 {
                0 => Vec3::new(step(&mut random), step(&mut random), step(&mut random)),
                1 => Vec3::from(random.cube()) * 3.0,
                _ => Vec3::from(random.cube()) * 0.4 + 0.5,
            };
            rays.set(i, o, target - o, 0.0, if i % 2 == 0 { f32::INFINITY } else { 1.0 });
        }
        hits += ask_in_every_way(&tree, few.as_ref(), &rays);
    }
    assert!(hits > 3000, "{hits} hits show little");
}

#[test]
fn nothing_to_prepare() {
    let mut rays = Rays::default();
    rays.set(3, Vec3::ZERO, Vec3::X, 0.0, f32::INFINITY);
    rays.set(4, Vec3::ZERO, Vec3::X, 1.0, 0.5);
    assert_eq!(Prepared::new(&rays, Mask::MAX).live, 1 << 3);
    assert_eq!(Prepared::new(&rays, !(1 << 3)).live, 0);
    let mut seen = Vec::new();
    for_lanes(0b1001_0000_0000_0010, |i| seen.push(i));
    assert_eq!(seen, [1, 12, 15]);
    assert_eq!((Place::new(5, 3).block(), Place::new(5, 3).lane()), (5, 3));
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
            let (_, references) = check_covered(&mesh, &built_as(&mesh, quality));
            let most = if quality == Quality::High { 2 * sound } else { sound };
            assert!((sound..=most).contains(&references), "mesh {i}, {quality:?}: {references}");
            if i == 1 && quality == Quality::High {
                assert!(references > sound, "nothing was split in space");
            }
        }
    }
}

#[test]
fn splits_in_space_never_change_an_answer() {
    let mesh = Arc::new(needles(2000));
    let trees = QUALITIES.map(|quality| built_as(&mesh, quality));
    let mut random = random(9);
    let mut hits = 0;
    for n in 0..1250 {
        let mut rays = Rays::default();
        for i in 0..LANES {
            let (o, mut target) = (Vec3::from(random.cube()) * 3.0, Vec3::from(random.cube()));
            if i % 2 == 0 {
                // At a triangle, so that most are hit.
                target = mesh.triangle((n * LANES + i) / 2 % 2000).iter().sum::<Vec3>() / 3.0;
            }
            rays.set(i, o, target - o, 0.0, f32::INFINITY);
        }
        let prepared = Prepared::new(&rays, Mask::MAX);
        let [low, medium, high] = [&trees[0], &trees[1], &trees[2]].map(|tree| {
            let tree = Tree { nodes: &tree.nodes, blocks: &tree.blocks, in_turns: true };
            let ask = Ask { tree, few: None, rays: &rays, prepared: &prepared };
            let (found, any) = isa::run(Isa::Avx512, ask);
            assert_eq!(found.hit, any);
            let meetings = Meetings::of(&tree, &found.place, &prepared);
            let answer = |i: usize| (meetings.t[i].to_bits(), tree.ids(found.place[i]));
            [0; LANES].map({
                let mut lane = 0..LANES;
                move |_| lane.next().filter(|i| found.hit >> i & 1 == 1).map(answer)
            })
        });
        assert!(low == medium && medium == high, "chunk {n}: {low:?} {medium:?} {high:?}");
        hits += low.iter().flatten().count();
    }
    assert!(hits > 10_000, "{hits} hits show little");
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
