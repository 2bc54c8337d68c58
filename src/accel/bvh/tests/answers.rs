//! No tree, no filter, no order and no instruction set changes an answer.

use super::shape::check;
use super::*;
use crate::math::isa::Everywhere;

/// Every triangle tested, in an order of its own: distance and rank of the closest hit.
fn linear(tree: &Built, rays: &Prepared, i: usize) -> Option<(u32, u64)> {
    let mut best: Option<(f32, u64)> = None;
    for block in tree.blocks.iter().rev() {
        let (met, t) = block.meet::<Everywhere>(rays, i, rays.tmax[i]);
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
        let meetings = Meetings::of::<Everywhere>(&view, &found.place, &prepared);
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

/// A tilted triangle, again and again a little higher: one normal, and no plane twice.
fn sheets(count: u32) -> Mesh {
    let corners = |k: u32| {
        let up = k as f32 / 16.0;
        [[-1.0, -1.0, up], [1.0, -0.5, up + 0.25], [-0.25, 1.0, up]]
    };
    Mesh::new(
        (0..count).flat_map(corners).collect(),
        (0..count).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect(),
    )
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
        sheets(40),
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
    assert!(filtered >= 5, "{filtered} scenes have a filter");
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
    for i in lanes_of(0b1001_0000_0000_0010) {
        seen.push(i);
    }
    assert_eq!(seen, [1, 12, 15]);
    assert_eq!((Place::new(5, 3).block(), Place::new(5, 3).lane()), (5, 3));
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
            let meetings = Meetings::of::<Everywhere>(&tree, &found.place, &prepared);
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
