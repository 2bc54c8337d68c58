//! Backends and the judge agree about soups, needles, any small mesh, far from the origin, tiny and huge.

use super::*;
use proptest::prelude::*;

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
