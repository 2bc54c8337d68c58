//! Every backend against the f64 judge and against every other.
//!
//! `DRT_HEAVY_TESTS=1` traces fifty times as many rays. Mutants of the hierarchy and who catches them ("unit" is
//! `src/accel/bvh/tests.rs`; where all or most fail, the sharpest are named):
//!
//! | mutant | caught by |
//! |---|---|
//! | edges exclusive, in the exact test | integer_grid, rays_aimed_at_vertices_and_edges |
//! | edges exclusive, in the f32 sieve | the same, axis_parallel…, any_small_mesh, unit |
//! | edge functions decided in f32 alone | hits_of_the_hierarchy_lie_on_their_triangles, unit |
//! | only one side hit | 11 tests |
//! | boxes and origins without margin | integer_grid, rays_aimed_at_vertices_and_edges, any_small_mesh |
//! | origin moved inwards | closed_surfaces_do_not_leak, integer_grid, axis_parallel…, 5 more |
//! | −0.0 counted as +0.0 by the slabs | axis_parallel…, intervals_include_their_ends, rays_aimed_at… |
//! | near side from the wrong sign; shear with the wrong sign | 11 tests each |
//! | u and v swapped; u of the first corner | soups, closed_surfaces_do_not_leak, 7 more |
//! | tmin exclusive | intervals_include_their_ends, axis_parallel… |
//! | tmax exclusive | intervals_include_their_ends, identical_triangles |
//! | ties culled on pop | intervals_include_their_ends |
//! | the last of equal hits wins | identical_triangles, unit |
//! | occluded ignores tmax | soups, any_small_mesh, needles…, far_from_the_origin… |
//! | t of unnormalised directions not scaled back | 7 tests |
//! | edge-on triangles (det = 0) not sorted out | rays_in_the_plane_of_triangles |
//! | triangles without area kept | collinear_corners_are_never_hit |
//! | inactive lanes traced | inactive_and_invalid_lanes |
//! | weights left at 0 where Embree gives up on them | small_triangles_and_short_directions… |
//! | hits at edges not settled; the ray moved outwards; the nearest hider not asked in turn | rays_from_… |
//! | last triangle of a leaf lost; a split's right box taken from the left | soups, closed…, 8 more |
//! | coinciding middles not halved | identical_triangles, unit |
//! | partition depends on the number of threads | unit (no answer changes, so no test here can see it) |
//!
//! Not caught, and rightly so: children in another order (only slower); t not kept inside its own box and 1/0
//! left infinite (the margins prevent both cases already; each line is the second safeguard).

mod meshes;
mod random_bits;
mod silhouettes;

use drt::accel::brute::Brute;
use drt::accel::judge::{Judge, Tally};
use drt::accel::{Backend, BuildOptions, Coherence, Hits, Intersector, LANES, MISS, Mask, Quality, Rays};
use drt::math::Vec3;
use drt::math::isa::Isa;
use drt::shape::Mesh;
use meshes::*;
use proptest::prelude::*;
use std::sync::Arc;

/// How many times more rays than usual.
fn effort() -> usize {
    if std::env::var_os("DRT_HEAVY_TESTS").is_some_and(|v| v == "1") { 50 } else { 1 }
}

fn build(backend: Backend, meshes: &[Arc<Mesh>]) -> Box<dyn Intersector> {
    backend.build(meshes, &BuildOptions::default()).expect("builds")
}

/// Every backend by name, and the judge.
fn all(meshes: &[Arc<Mesh>]) -> Vec<(&'static str, Box<dyn Intersector>)> {
    let mut all: Vec<(&'static str, Box<dyn Intersector>)> =
        Backend::ALL.iter().map(|b| (b.name(), build(*b, meshes))).collect();
    all.push(("judge", Box::new(Brute::new(meshes))));
    all
}

fn trace(backend: &dyn Intersector, chunks: &[Rays]) -> Vec<Hits> {
    let trace = |rays: &Rays| {
        let mut hits = Hits::default();
        backend.closest(rays.check(Mask::MAX), Coherence::Incoherent, &mut hits);
        hits
    };
    chunks.iter().map(trace).collect()
}

/// The bits of all answers.
fn bits(hits: &[Hits]) -> Vec<[u32; 5]> {
    let lane =
        |h: &Hits, i: usize| [h.t[i].to_bits(), h.u[i].to_bits(), h.v[i].to_bits(), h.mesh[i], h.triangle[i]];
    hits.iter().flat_map(|h| (0..LANES).map(move |i| lane(h, i))).collect()
}

fn missed(hits: &[Hits], rays: usize) -> usize {
    hits.iter().flat_map(|h| h.mesh).take(rays).filter(|m| *m == MISS).count()
}

/// Compares all pairs on `rays`: nothing real, and shadow rays blocked just where there is a closest hit.
/// Returns the sums over all pairs.
fn agree(what: &str, meshes: &[Arc<Mesh>], rays: &[Ray]) -> Tally {
    let judge = Judge::thorough(meshes);
    let chunks = chunks(rays);
    let answers: Vec<(&str, Vec<Hits>)> = all(meshes)
        .iter()
        .map(|(name, backend)| {
            let hits = trace(&**backend, &chunks);
            for (rays, hits) in chunks.iter().zip(&hits) {
                let blocked = backend.occluded(rays.check(Mask::MAX), Coherence::Incoherent);
                let hit = (0..LANES).fold(0, |m, i| m | ((hits.mesh[i] != MISS) as Mask) << i);
                assert_eq!(blocked, hit, "{what}: {name}: occluded against closest");
            }
            (*name, hits)
        })
        .collect();
    let mut sum = Tally::default();
    for (i, (first, a)) in answers.iter().enumerate() {
        for (second, b) in &answers[i + 1..] {
            let mut tally = Tally::default();
            for ((rays, a), b) in chunks.iter().zip(a).zip(b) {
                judge.compare(rays.check(Mask::MAX), a, b, &mut tally);
            }
            assert_eq!(
                tally.real,
                0,
                "{what}: {first} against {second}: {:#?} of {tally:?}",
                tally.kept.first()
            );
            sum.merge(tally);
        }
    }
    sum
}

#[test]
fn soups() {
    for seed in 0..4 {
        let mesh = soup(400, seed);
        let rays = random_rays(&mesh, 4000 * effort(), seed + 100);
        let tally = agree("soup", &one(mesh), &rays);
        assert!(tally.same * 1000 > tally.rays * 995, "{tally:?}");
    }
}

#[test]
fn needles_of_a_million_to_one() {
    for aspect in [1e2, 1e4, 1e6] {
        let mesh = slivers(300, aspect, 5);
        let mut rays = random_rays(&mesh, 2000 * effort(), 6);
        let mut random = Random(7);
        // Random rays rarely meet a needle: aim at points of them.
        for _ in 0..2000 * effort() {
            let [a, b, c] = mesh.triangle(random.below(mesh.indices.len()));
            let (u, v) = (random.unit(), random.unit());
            let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
            rays.push(towards(random.cube() * 3.0, a + (b - a) * u + (c - a) * v));
        }
        agree("needles", &one(mesh), &rays);
    }
}

/// The hierarchy takes t from the corners, not from the normal, so that even a needle's hit lies within a few
/// ε·W of the triangle's plane and of the point its barycentrics stand for.
#[test]
fn hits_of_the_hierarchy_lie_on_their_triangles() {
    for mesh in [soup(400, 1), slivers(400, 1e3, 2), slivers(400, 1e6, 3), mapped(&soup(400, 4), |p| p + 1e3)]
    {
        let mut rays = random_rays(&mesh, 2000 * effort(), 21);
        let mut random = Random(22);
        for _ in 0..2000 * effort() {
            let [a, b, c] = mesh.triangle(random.below(mesh.indices.len()));
            rays.push(towards(mesh.bounds().center() + random.cube() * 3.0, (a + b + c) / 3.0));
        }
        let chunks = chunks(&rays);
        let hits = trace(&*build(Backend::Bvh, &one(mesh.clone())), &chunks);
        for (rays, hits) in chunks.iter().zip(&hits) {
            for lane in (0..LANES).filter(|&lane| hits.mesh[lane] != MISS) {
                let [a, b, c] = mesh.triangle(hits.triangle[lane] as usize).map(|p| p.as_dvec3());
                let (u, v) = (hits.u[lane] as f64, hits.v[lane] as f64);
                let on_triangle = a * (1.0 - u - v) + b * u + c * v;
                let on_ray = rays.o(lane).as_dvec3() + rays.d(lane).as_dvec3() * hits.t[lane] as f64;
                let largest = [a, b, c, rays.o(lane).as_dvec3()].map(|p| p.abs().max_element()).into_iter();
                let unit = f32::EPSILON as f64 * largest.fold(0.0, f64::max);
                let off = (on_triangle - on_ray).length() / unit;
                assert!(off <= 16.0, "off by {off} ε·W: {} {}", rays.o(lane), rays.d(lane));
            }
        }
    }
}

#[test]
fn far_from_the_origin_tiny_and_huge() {
    for (offset, scale) in [(1e6, 1.0), (1e6, 1e3), (0.0, 1e-6), (0.0, 1e6), (-3e4, 10.0), (0.0, 1e12)] {
        let place = |p: Vec3| p * scale + offset;
        for mesh in [mapped(&soup(300, 1), place), mapped(&uv_sphere(12), place)] {
            let rays = random_rays(&mesh, 2000 * effort(), 3);
            agree(&format!("offset {offset} scale {scale}"), &one(mesh), &rays);
        }
    }
}

/// A hit's weights are its point's, however small the triangle is and however short the direction: Embree gives up on
/// them below 1e-18.
#[test]
fn small_triangles_and_short_directions_keep_their_weights() {
    for length in [1.0f32, 1e-3, 1e-6] {
        for scale in [1.0f32, 1e-3, 1e-6, 1e-8] {
            let mesh = one(mapped(&uv_sphere(6), |p| p * scale));
            for (name, built) in all(&mesh) {
                let mut rays = Rays::default();
                let d = Vec3::new(0.31, 0.52, 0.77) * length;
                rays.set(0, Vec3::ZERO, d, 0.0, f32::INFINITY);
                let mut hits = Hits::default();
                built.closest(rays.check(1), Coherence::Incoherent, &mut hits);
                let [a, b, c] = mesh[0].triangle(hits.triangle[0] as usize);
                let p = a * (1.0 - hits.u[0] - hits.v[0]) + b * hits.u[0] + c * hits.v[0];
                let off = (p - d * hits.t[0]).length() / scale;
                assert!(off < 1e-5, "{name}: off by {off} at scale {scale}, |d| {length}");
            }
        }
    }
}

/// Closed surfaces, with points inside and the radius of a ball around them that lies inside.
fn closed() -> Vec<(&'static str, Mesh, Vec<Vec3>, f32)> {
    let middle = vec![Vec3::ZERO];
    let ring = (0..8).map(|i| Vec3::new((i as f32).cos(), 0.0, (i as f32).sin())).collect();
    vec![
        ("uv sphere", uv_sphere(24), middle.clone(), 0.9),
        ("octasphere", octasphere(4), middle, 0.9),
        ("torus", torus(32), ring, 0.3),
        ("cube", cube(9), vec![Vec3::splat(4.5)], 4.4),
    ]
}

#[test]
fn closed_surfaces_do_not_leak() {
    for (name, mesh, inside, radius) in closed() {
        let mut random = Random(11);
        let far = mesh.bounds().extent().length() * 2.0;
        let n = 4000 * effort();
        let mut rays: Vec<Ray> = (0..n)
            .map(|i| {
                (
                    inside[i % inside.len()] + random.ball() * radius,
                    random.ball().normalize(),
                    0.0,
                    f32::INFINITY,
                )
            })
            .collect();
        rays.extend((0..n).map(|i| {
            let target = inside[i % inside.len()] + random.ball() * radius;
            towards(inside[0] + random.ball().normalize() * far, target)
        }));
        let count = rays.len();
        let meshes = one(mesh);
        let tally = agree(name, &meshes, &rays);
        assert_eq!(tally.hit_miss, 0, "{name}: {tally:?}");
        for (backend, built) in all(&meshes) {
            assert_eq!(missed(&trace(&*built, &chunks(&rays)), count), 0, "{name}: {backend} leaks");
        }
    }
}

/// Rays from within to vertices and to points of edges: where cracks are. The hierarchy has none; what other
/// backends are known to lose (2.2 % of Embree's vertex-aimed rays) is bounded, not hidden.
#[test]
fn rays_aimed_at_vertices_and_edges() {
    for (name, mesh, inside, radius) in closed() {
        let mut random = Random(13);
        let (mut at_vertices, mut at_edges) = (Vec::new(), Vec::new());
        for i in 0..3000 * effort() {
            let corners = mesh.triangle(random.below(mesh.indices.len()));
            // From the middle of a torus' tube the far side is hidden, but a ray always meets something.
            let o = inside[i % inside.len()] + random.ball() * radius * if i % 4 == 0 { 0.0 } else { 1.0 };
            at_vertices.push(towards(o, corners[0]));
            at_edges.push(towards(o, corners[1].lerp(corners[2], random.unit())));
        }
        let meshes = one(mesh);
        for (backend, built) in all(&meshes) {
            let lost = |rays: &[Ray]| missed(&trace(&*built, &chunks(rays)), rays.len());
            let (vertices, edges) = (lost(&at_vertices), lost(&at_edges));
            let allowed = if backend == "bvh" { 0 } else { at_vertices.len() / 20 };
            assert!(
                vertices <= allowed && edges <= allowed / 10,
                "{name}: {backend}: {vertices}, {edges} lost"
            );
        }
    }
}

/// Perspective rays at the vertices, edges and middles of a flat integer grid's inner triangles.
#[test]
fn integer_grid() {
    let meshes = one(grid(20));
    let eyes = [Vec3::new(10.0, 10.0, 7.0), Vec3::new(3.3, -8.1, 5.7), Vec3::new(10.0, 9.0, 1e4)];
    for (i, eye) in eyes.into_iter().enumerate() {
        for (kind, shift) in [
            ("vertices", [0.0, 0.0]),
            ("edges", [0.5, 0.0]),
            ("diagonals", [0.5, 0.5]),
            ("inside", [0.25, 0.5]),
        ] {
            let target =
                |k: usize| Vec3::new((k % 18 + 1) as f32 + shift[0], (k / 18 + 1) as f32 + shift[1], 0.0);
            let rays: Vec<Ray> = (0..18 * 18).map(|k| (eye, target(k) - eye, 0.0, f32::INFINITY)).collect();
            for (backend, built) in all(&meshes) {
                let lost = missed(&trace(&*built, &chunks(&rays)), rays.len());
                let allowed = if backend == "bvh" || kind == "inside" { 0 } else { rays.len() / 10 };
                assert!(lost <= allowed, "eye {i}, {kind}: {backend} lost {lost} of {}", rays.len());
            }
        }
    }
}

#[test]
fn axis_parallel_rays_and_origins_on_box_planes() {
    let mut rays = Vec::new();
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    for axis in 0..3 {
        for zero in [0.0f32, -0.0] {
            for sign in [1.0, -1.0] {
                for k in 0..400 {
                    let mut d = Vec3::splat(zero);
                    d[axis] = sign;
                    // Through vertices, edges and middles of faces; starting outside, inside, and on a face.
                    let (i, j) = ((k % 20) as f32 * 0.5 - 0.25, (k / 20) as f32 * 0.5 - 0.25);
                    for start in [-3.0, 0.0, 4.0, 9.0, 12.0] {
                        let across = axes[(axis + 1) % 3] * i + axes[(axis + 2) % 3] * j;
                        rays.push((axes[axis] * start + across, d, 0.0, f32::INFINITY));
                    }
                }
            }
        }
    }
    let tally = agree("axis-parallel", &one(cube(9)), &rays);
    assert_eq!(tally.hit_miss, 0, "{tally:?}");
}

#[test]
fn rays_in_the_plane_of_triangles() {
    let mut random = Random(17);
    let mut rays = Vec::new();
    for i in 0..2000 {
        let point = |r: &mut Random| Vec3::new(r.unit() * 30.0 - 10.0, r.unit() * 30.0 - 10.0, 0.0);
        let (o, target) = (point(&mut random), point(&mut random));
        // Exactly in the plane, and next to it.
        let lift = Vec3::Z * [0.0, 1e-7, -1e-6][i % 3];
        rays.push(towards(o + lift, target));
    }
    let meshes = one(grid(20));
    let tally = agree("in the plane", &meshes, &rays);
    assert!(tally.rays > 0);
    let flat: Vec<Ray> = rays.iter().step_by(3).copied().collect();
    for (backend, built) in all(&meshes) {
        assert_eq!(missed(&trace(&*built, &chunks(&flat)), flat.len()), flat.len(), "{backend} hits edge-on");
    }
}

#[test]
fn intervals_include_their_ends() {
    let up = |x: f32| f32::from_bits(x.to_bits() + 1);
    let down = |x: f32| f32::from_bits(x.to_bits() - 1);
    let (o, d) = (Vec3::new(3.25, 4.5, 3.0), -Vec3::Z);
    let cases = [
        (3.0, 3.0, true),
        (0.0, 3.0, true),
        (3.0, f32::INFINITY, true),
        (up(3.0), f32::INFINITY, false),
        (0.0, down(3.0), false),
        (0.0, 0.0, false),
        (0.0, -1.0, false),
        (5.0, 4.0, false),
    ];
    let rays: Vec<Ray> = cases.iter().map(|&(tmin, tmax, _)| (o, d, tmin, tmax)).collect();
    for (backend, built) in all(&one(grid(20))) {
        let hits = &trace(&*built, &chunks(&rays))[0];
        for (i, (tmin, tmax, expected)) in cases.into_iter().enumerate() {
            assert_eq!(hits.mesh[i] == 0, expected, "{backend}: {tmin} ..= {tmax}");
        }
        assert_eq!((hits.t[0], hits.t[1]), (3.0, 3.0), "{backend}");
    }
}

#[test]
fn nothing_and_nearly_nothing() {
    let triangle = |a: [f32; 3], b: [f32; 3], c: [f32; 3]| Mesh::new(vec![a, b, c], vec![[0, 1, 2]]);
    let unit = triangle([0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let empty = Mesh::new(vec![], vec![]);
    let flat = [
        triangle([1.0; 3], [1.0; 3], [1.0; 3]),
        triangle([0.0; 3], [1.0; 3], [3.0; 3]),
        Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 1], [2, 2, 0], [1, 1, 1]]),
    ];
    let mut rays = random_rays(&unit, 200, 1);
    rays.push(towards(Vec3::new(1.0, 1.0, 5.0), Vec3::ONE));
    rays.push((Vec3::ZERO, Vec3::ZERO, 0.0, f32::INFINITY));
    let nothing: Vec<Vec<Arc<Mesh>>> =
        [vec![], one(empty.clone()), (0..3).map(|_| Arc::new(empty.clone())).collect()]
            .into_iter()
            .chain(flat.iter().cloned().map(one))
            .collect();
    for meshes in &nothing {
        let tally = agree("nothing", meshes, &rays);
        assert_eq!(tally.same, tally.rays);
        for (backend, built) in all(meshes) {
            assert_eq!(missed(&trace(&*built, &chunks(&rays)), rays.len()), rays.len(), "{backend}");
        }
    }
    // One triangle among all of that, named by the right ids.
    let mut meshes: Vec<Arc<Mesh>> = flat.into_iter().map(Arc::new).collect();
    meshes.extend([Arc::new(empty), Arc::new(unit)]);
    agree("one triangle", &meshes, &rays);
    for (backend, built) in all(&meshes) {
        let hits =
            &trace(&*built, &chunks(&[towards(Vec3::new(0.2, 0.3, 5.0), Vec3::new(0.2, 0.3, 0.0))]))[0];
        assert_eq!((hits.mesh[0], hits.triangle[0]), (4, 0), "{backend}");
        assert!((hits.u[0] - 0.2).abs() < 1e-5 && (hits.v[0] - 0.3).abs() < 1e-5, "{backend}");
    }
}

/// Exactly collinear corners, which rounding in a sheared frame can pull apart into a triangle with area.
#[test]
fn collinear_corners_are_never_hit() {
    let mut random = Random(31);
    let mut positions = Vec::new();
    for _ in 0..300 {
        // Multiples of 2⁻¹⁰ below 2¹³: every sum is exact.
        let mut grid = || (random.cube() * 4096.0).round() / 1024.0;
        let (p, e) = (grid(), grid());
        positions.extend([p, p + e, p - e * 2.0].map(|p| p.to_array()));
    }
    let n = positions.len() as u32 / 3;
    let mesh = Mesh::new(positions, (0..n).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect());
    let aim = |_| {
        let [_, b, c] = mesh.triangle(random.below(mesh.indices.len()));
        towards(random.cube() * 30.0, b.lerp(c, random.unit()))
    };
    let rays: Vec<Ray> = (0..5000).map(aim).collect();
    for (backend, built) in all(&one(mesh.clone())) {
        assert_eq!(missed(&trace(&*built, &chunks(&rays)), rays.len()), rays.len(), "{backend}");
    }
}

#[test]
fn identical_triangles() {
    let same = |n| Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]; n]);
    let mesh = same(1000);
    let rays = random_rays(&mesh, 500, 2);
    agree("identical", &[Arc::new(mesh.clone()), Arc::new(mesh)], &rays);
    // A tree of coinciding middles must not degenerate; its lowest id wins.
    let built = build(Backend::Bvh, &one(same(300_000)));
    let hits = &trace(&*built, &chunks(&[towards(Vec3::new(0.2, 0.3, 5.0), Vec3::new(0.2, 0.3, 0.0))]))[0];
    assert_eq!((hits.mesh[0], hits.triangle[0]), (0, 0));
}

#[test]
fn inactive_and_invalid_lanes() {
    let meshes = one(uv_sphere(8));
    let mut rays = Rays::default();
    for lane in 0..LANES {
        rays.set(lane, Vec3::ZERO, Vec3::new(0.3, 0.2, 1.0), 0.0, f32::INFINITY);
    }
    rays.ox[1] = f32::NAN;
    rays.dy[2] = f32::INFINITY;
    rays.tmin[3] = f32::NEG_INFINITY;
    rays.tmax[4] = f32::NAN;
    rays.dz[5] = 1.5e18;
    let asked: Mask = 0b0000_0111_1111_1111;
    let sound: Mask = 0b0000_0111_1100_0001;
    let checked = rays.check(asked);
    assert_eq!((checked.active(), checked.rejected()), (sound, 5));
    for (backend, built) in all(&meshes) {
        for coherence in [Coherence::Coherent, Coherence::Incoherent] {
            let mut hits =
                Hits { t: [7.0; LANES], mesh: [77; LANES], triangle: [777; LANES], ..Hits::default() };
            built.closest(checked, coherence, &mut hits);
            for lane in 0..LANES {
                let traced = sound >> lane & 1 == 1;
                assert_eq!(hits.mesh[lane] == 0, traced, "{backend} lane {lane}");
                assert_eq!(
                    (hits.t[lane], hits.triangle[lane]) == (7.0, 777),
                    !traced,
                    "{backend} lane {lane}"
                );
            }
            assert_eq!(built.occluded(checked, coherence), sound, "{backend}");
        }
    }
}

#[test]
fn same_bits_on_any_number_of_threads() {
    let mesh = uv_sphere(300);
    let rays = chunks(&random_rays(&mesh, 2000, 8));
    let meshes = one(mesh);
    for backend in Backend::ALL {
        let on = |threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            bits(&trace(&*pool.install(|| build(*backend, &meshes)), &rays))
        };
        let one = on(1);
        assert!(on(2) == one && on(5) == one, "{}", backend.name());
    }
}

/// A hit of the hierarchy depends on the ray and the triangle alone.
#[test]
fn hierarchy_gives_the_same_bits_for_every_instruction_set_and_quality() {
    for mesh in [soup(3000, 3), slivers(1000, 1e5, 4), mapped(&grid(40), |p| p + 1e5), cube(12)] {
        let rays = chunks(&random_rays(&mesh, 5000 * effort(), 9));
        let meshes = one(mesh);
        let with = |isa, quality| {
            let options = BuildOptions { isa: Some(isa), quality, ..BuildOptions::default() };
            let built = Backend::Bvh.build(&meshes, &options).expect("builds");
            assert_eq!(built.isa(), "generic");
            bits(&trace(&*built, &rays))
        };
        let baseline = with(Isa::Baseline, Quality::Medium);
        for isa in Isa::ALL.into_iter().filter(|isa| *isa <= Isa::best()) {
            for quality in [Quality::Low, Quality::Medium, Quality::High] {
                assert!(with(isa, quality) == baseline, "{isa:?} {quality:?}");
            }
        }
    }
}

#[test]
fn builds_can_be_cancelled() {
    let meshes = one(uv_sphere(100));
    for backend in Backend::ALL {
        let options = BuildOptions { progress: &|_| false, ..BuildOptions::default() };
        let Err(error) = backend.build(&meshes, &options) else { panic!("{} goes on", backend.name()) };
        assert_eq!(error, drt::accel::cancelled());
        let in_range = |share: f64| (0.0..=1.0).contains(&share);
        let options = BuildOptions { progress: &in_range, ..BuildOptions::default() };
        assert!(backend.build(&meshes, &options).is_ok(), "{}", backend.name());
    }
}

/// Coordinates from few values, so that corners, edges and planes of triangles coincide again and again.
fn coordinate() -> impl Strategy<Value = f32> {
    prop_oneof![4 => (-2i8..=2).prop_map(f32::from), 1 => -2.0f32..2.0]
}

fn point() -> impl Strategy<Value = [f32; 3]> {
    [coordinate(), coordinate(), coordinate()]
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 300 * effort() as u32,
        failure_persistence: None,
        rng_seed: proptest::test_runner::RngSeed::Fixed(1),
        ..ProptestConfig::default()
    })]

    #[test]
    fn any_small_mesh(
        triangles in prop::collection::vec([point(), point(), point()], 0..24),
        rays in prop::collection::vec((point(), point(), 0f32..2.0), 16),
    ) {
        let n = triangles.len() as u32;
        let mesh = Mesh::new(triangles.concat(), (0..n).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect());
        let rays: Vec<Ray> = rays
            .into_iter()
            .map(|(o, d, tmax)| (Vec3::from(o), Vec3::from(d), 0.0, if tmax < 1.0 { f32::INFINITY } else { tmax }))
            .collect();
        agree("small mesh", &one(mesh), &rays);
    }
}
