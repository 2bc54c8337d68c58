//! What the backend promises, on every packet width that the machine has.

mod aside;
mod memory;
mod ways;

use super::*;
use crate::accel::{LANES, MISS, Rays};
use crate::math::Vec3;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};
use std::sync::atomic::{AtomicUsize, Ordering};

/// Every set of kernels that Debian's Embree has and this machine runs.
pub(super) fn isas() -> impl Iterator<Item = &'static str> {
    let has = |name: &&str| match *name {
        #[cfg(target_arch = "x86_64")]
        "sse4.2" => is_x86_feature_detected!("sse4.2"),
        #[cfg(target_arch = "x86_64")]
        "avx" => is_x86_feature_detected!("avx"),
        other => Isa::ALL.into_iter().any(|isa| isa.name() == other && isa <= Isa::best()),
    };
    ["sse2", "sse4.2", "avx", "avx2", "avx512"].into_iter().filter(has)
}

fn best() -> &'static str {
    Isa::best().name()
}

const QUALITIES: [Quality; 3] = [Quality::Low, Quality::Medium, Quality::High];

fn build(meshes: &[Arc<Mesh>], isa: &'static str, quality: Quality) -> Embree {
    let options = BuildOptions { quality, ..BuildOptions::default() };
    Embree::build_as(meshes, &options, isa, true, None).unwrap()
}

/// A right triangle in the plane z = `z`, counter-clockwise seen from +z.
fn triangle(z: f32) -> Arc<Mesh> {
    Arc::new(Mesh::new(vec![[0.0, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]], vec![[0, 1, 2]]))
}

/// `n`×`n` cells of two triangles over [0, n]², heights from a hash.
fn terrain(n: u32, seed: u64) -> Mesh {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let cells = (0..=n).flat_map(|j| (0..=n).map(move |i| (i as f32, j as f32)));
    let positions = cells.map(|(x, y)| [x, y, (random.next_u32() >> 8) as f32 * 2f32.powi(-24)]).collect();
    let corner = |i: u32, j: u32| j * (n + 1) + i;
    let quads = (0..n).flat_map(|j| (0..n).map(move |i| (i, j)));
    let indices = quads.flat_map(|(i, j)| {
        let (a, b, c, d) = (corner(i, j), corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
        [[a, b, c], [a, c, d]]
    });
    Mesh::new(positions, indices.collect())
}

/// Rays from above at the vertices, edges and inner points of a `size`×`size` terrain.
fn rays_at_terrain(random: &mut ChaCha8Rng, size: f32) -> Rays {
    let mut unit = || (random.next_u32() >> 8) as f32 * 2f32.powi(-24);
    let mut rays = Rays::default();
    for lane in 0..LANES {
        let (x, y) = (unit() * size, unit() * size);
        let (x, y) = match lane % 3 {
            0 => (x.floor(), y.floor()),
            1 => (x, y.floor()),
            _ => (x, y),
        };
        let from = Vec3::new(if lane % 2 == 0 { x } else { unit() * size }, y, 3.0);
        rays.set(lane, from, Vec3::new(x, y, 0.0) - from, 0.0, f32::INFINITY);
    }
    rays
}

fn sixteen(o: Vec3, d: Vec3) -> Rays {
    let mut rays = Rays::default();
    (0..LANES).for_each(|lane| rays.set(lane, o, d, 0.0, f32::INFINITY));
    rays
}

/// Every number of `hits`, bit for bit.
fn bits(hits: &Hits) -> Vec<u32> {
    let floats = [hits.t, hits.u, hits.v];
    floats.iter().flatten().map(|x| x.to_bits()).chain(hits.mesh).chain(hits.triangle).collect()
}

#[test]
fn nothing_is_hit_in_empty_scenes() {
    let empty = Arc::new(Mesh::new(vec![], vec![]));
    let lone_vertices = Arc::new(Mesh::new(vec![[0.0; 3]; 3], vec![]));
    for meshes in [vec![], vec![empty.clone()], vec![empty, lone_vertices]] {
        for (isa, quality) in isas().flat_map(|isa| QUALITIES.map(|q| (isa, q))) {
            let embree = build(&meshes, isa, quality);
            let rays = sixteen(Vec3::ZERO, Vec3::Z);
            let mut hits = Hits { mesh: [7; LANES], ..Hits::default() };
            embree.closest(rays.check(!0), Coherence::Incoherent, &mut hits);
            assert_eq!(hits.mesh, [MISS; LANES]);
            assert_eq!(embree.occluded(rays.check(!0), Coherence::Coherent), 0);
        }
    }
}

#[test]
fn a_triangle_is_hit_where_it_is_from_both_sides() {
    for (isa, quality) in isas().flat_map(|isa| QUALITIES.map(|q| (isa, q))) {
        let embree = build(&[triangle(0.0)], isa, quality);
        assert_eq!(embree.isa(), isa);
        assert!(embree.bytes() > 0);
        for (z, coherence) in [(2.0, Coherence::Coherent), (-2.0, Coherence::Incoherent)] {
            // p = (1 − u − v)·v0 + u·v1 + v·v2 = (u, v, 0), every number a power of two.
            let rays = sixteen(Vec3::new(0.25, 0.5, z), Vec3::new(0.0, 0.0, -z / 4.0));
            for active in [1 << 5, 0b11, 0x1fff, !0] {
                let mut hits = Hits::default();
                embree.closest(rays.check(active), coherence, &mut hits);
                for lane in (0..LANES).filter(|lane| active >> lane & 1 == 1) {
                    assert_eq!((hits.mesh[lane], hits.triangle[lane]), (0, 0), "{isa:?}");
                    // Embree divides by Newton iterations from a reciprocal estimate: up to 2 ulps off.
                    let off = |x: f32, exact: f32| ((x - exact) / exact).abs();
                    let worst =
                        off(hits.t[lane], 4.0).max(off(hits.u[lane], 0.25)).max(off(hits.v[lane], 0.5));
                    assert!(worst <= 2.0 * f32::EPSILON, "{isa:?}: {worst}");
                }
                assert_eq!(embree.occluded(rays.check(active), coherence), active);
            }
        }
    }
}

#[test]
fn intervals_end_where_they_say() {
    for isa in isas() {
        let embree = build(&[triangle(0.0)], isa, Quality::Medium);
        let (o, d) = (Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z);
        let mut rays = Rays::default();
        rays.set(0, o, d, 0.0, 0.75); // ends before
        rays.set(1, o, d, 1.5, 9.0); // starts behind
        rays.set(2, o, d, 2.0, 0.5); // empty
        rays.set(3, o, Vec3::ZERO, 0.0, 9.0); // no direction
        rays.set(4, o, d, 0.0, 1.0); // ends on it
        rays.set(5, o, d, 0.5, 1.5);
        rays.set(6, o, d, 0.0, -1.0);
        let mut hits = Hits::default();
        embree.closest(rays.check(0x7f), Coherence::Incoherent, &mut hits);
        let hit: Vec<bool> = hits.mesh[..7].iter().map(|&m| m != MISS).collect();
        assert_eq!(hit, [false, false, false, false, true, true, false], "{isa:?}");
        assert_eq!(embree.occluded(rays.check(0x7f), Coherence::Incoherent), 0b0110000, "{isa:?}");
        for (lane, &expected) in hit.iter().enumerate() {
            let mut alone = Hits::default();
            embree.closest(rays.check(1 << lane), Coherence::Incoherent, &mut alone);
            assert_eq!(alone.mesh[lane], hits.mesh[lane]);
            let blocked = embree.occluded(rays.check(1 << lane), Coherence::Incoherent) != 0;
            assert_eq!(blocked, expected);
        }
    }
}

/// A lane that is off may hold anything; what the gate refuses does not reach Embree, which would abort.
#[test]
fn garbage_in_lanes_that_are_off_is_harmless() {
    let garbage = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 3e38, -1e19];
    for isa in isas() {
        let embree = build(&[Arc::new(terrain(8, 1))], isa, Quality::Medium);
        let mut random = ChaCha8Rng::seed_from_u64(2);
        for turn in 0..2000 {
            let clean = rays_at_terrain(&mut random, 8.0);
            let bad = (random.next_u32() as Mask) & if turn % 8 == 0 { 0 } else { !0 };
            let asked = random.next_u32() as Mask;
            let mut rays = clean.clone();
            for lane in (0..LANES).filter(|lane| bad >> lane & 1 == 1) {
                let value = garbage[random.next_u32() as usize % garbage.len()];
                match random.next_u32() % 8 {
                    0 => rays.ox[lane] = value,
                    1 => rays.oy[lane] = value,
                    2 => rays.oz[lane] = value,
                    3 => rays.dx[lane] = value,
                    4 => rays.dy[lane] = value,
                    5 => rays.dz[lane] = value,
                    6 => rays.tmin[lane] = value,
                    _ => rays.tmax[lane] = f32::NAN,
                }
            }
            // Only asked for half of the time, so that both gate and mask are seen to keep it out.
            let asked = if turn % 2 == 0 { asked } else { asked & !bad };
            let untouched = Hits { t: [-7.0; LANES], mesh: [77; LANES], ..Hits::default() };
            let (mut got, mut expected) = (untouched.clone(), untouched.clone());
            embree.closest(rays.check(asked), Coherence::Incoherent, &mut got);
            embree.closest(clean.check(asked & !bad), Coherence::Incoherent, &mut expected);
            assert_eq!(bits(&got), bits(&expected));
            for lane in (0..LANES).filter(|lane| (asked & !bad) >> lane & 1 == 0) {
                assert_eq!((got.t[lane], got.mesh[lane], got.triangle[lane]), (-7.0, 77, MISS));
            }
            let blocked = embree.occluded(rays.check(asked), Coherence::Incoherent);
            assert_eq!(blocked & !(asked & !bad), 0);
        }
    }
}

#[test]
fn hits_name_mesh_and_triangle() {
    // Empty meshes between the others: ids must not shift.
    let empty = Arc::new(Mesh::new(vec![], vec![]));
    let mut two = Mesh::clone(&triangle(2.0));
    two.indices.insert(0, [0, 0, 0]);
    let meshes =
        [empty.clone(), triangle(0.0), empty.clone(), empty.clone(), Arc::new(two), triangle(1.0), empty];
    for (isa, quality) in isas().flat_map(|isa| QUALITIES.map(|q| (isa, q))) {
        let embree = build(&meshes, isa, quality);
        let mut rays = Rays::default();
        for (lane, (z, dz)) in
            [(0.5, -1.0), (3.0, -1.0), (1.5, -1.0), (-1.0, 1.0), (9.0, 1.0)].into_iter().enumerate()
        {
            rays.set(lane, Vec3::new(0.25, 0.25, z), Vec3::new(0.0, 0.0, dz), 0.0, f32::INFINITY);
        }
        let mut hits = Hits::default();
        embree.closest(rays.check(0x1f), Coherence::Incoherent, &mut hits);
        assert_eq!(hits.mesh[..5], [1, 4, 5, 1, MISS], "{isa:?} {quality:?}");
        assert_eq!(hits.triangle[..5], [0, 1, 0, 0, MISS], "{isa:?} {quality:?}");
    }
}

#[test]
fn indices_out_of_range_and_bad_vertices_are_never_hit() {
    let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [f32::NAN; 3]];
    let broken = Arc::new(Mesh::new(positions, vec![[0, 1, 4], [0, 1, 3], [0, u32::MAX, 2], [0, 1, 2]]));
    for quality in QUALITIES {
        let embree = build(&[broken.clone(), triangle(-1.0)], best(), quality);
        let rays = sixteen(Vec3::new(0.25, 0.25, 1.0), Vec3::NEG_Z);
        let mut hits = Hits::default();
        embree.closest(rays.check(!0), Coherence::Incoherent, &mut hits);
        assert_eq!((hits.mesh, hits.triangle), ([0; LANES], [3; LANES]));
    }
}

/// Collinear corners whose cross product rounds to something else than zero must not be hit either.
#[test]
fn triangles_without_area_are_never_hit() {
    let mut random = ChaCha8Rng::seed_from_u64(3);
    let mut unit = || (random.next_u32() >> 8) as f32 * 2f32.powi(-24);
    let (mut positions, mut rays) = (Vec::new(), Vec::new());
    for _ in 0..20_000 {
        // p, p + d and p + 2d with few enough bits to be exact.
        let coarse = |x: f32| (x * 4096.0).round() / 1024.0;
        let p = Vec3::new(coarse(unit()), coarse(unit()), coarse(unit()));
        let d = Vec3::new(coarse(unit()), coarse(unit()), coarse(unit()));
        let corners = [p, p + d, p + 2.0 * d].map(|v| v.to_array());
        positions.extend(corners);
        let o = Vec3::new(unit() * 9.0, unit() * 9.0, 12.0);
        rays.push((o, p + unit() * 2.0 * d - o));
    }
    let count = positions.len() as u32 / 3;
    let slivers = Arc::new(Mesh::new(positions, (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect()));
    for (isa, quality) in isas().flat_map(|isa| QUALITIES.map(|q| (isa, q))) {
        let embree = build(std::slice::from_ref(&slivers), isa, quality);
        let mut found = 0;
        for chunk in rays.chunks_exact(LANES) {
            let mut question = Rays::default();
            for (lane, &(o, d)) in chunk.iter().enumerate() {
                question.set(lane, o, d, 0.0, f32::INFINITY);
            }
            let mut hits = Hits::default();
            embree.closest(question.check(!0), Coherence::Incoherent, &mut hits);
            found += hits.mesh.iter().filter(|&&m| m != MISS).count();
            found += embree.occluded(question.check(!0), Coherence::Incoherent).count_ones() as usize;
        }
        assert_eq!(found, 0, "{isa:?} {quality:?}");
    }
}

/// The vertex buffer's padding: Embree reads 16 bytes a vertex. (Under valgrind a missing one shows.)
#[test]
fn buffers_of_every_length_near_a_page_end_can_be_read() {
    for vertices in 338..346 {
        let positions = (0..vertices).map(|i| [i as f32, (i % 2) as f32, 0.0]).collect();
        let indices = (0..vertices - 2).map(|i| [i, i + 1, i + 2]).collect();
        let strip = Arc::new(Mesh::new(positions, indices));
        let embree = build(&[strip], best(), Quality::Medium);
        let rays = sixteen(Vec3::new(vertices as f32 - 2.0, 0.5, 1.0), Vec3::NEG_Z);
        assert_eq!(embree.occluded(rays.check(!0), Coherence::Incoherent), !0);
    }
}

#[test]
fn a_build_can_be_cancelled_at_any_call() {
    let meshes = [Arc::new(terrain(128, 4)), Arc::new(terrain(64, 5))];
    for quality in QUALITIES {
        for stop in 0..6 {
            // Says no exactly once: the build must remember it.
            let calls = AtomicUsize::new(0);
            let progress = |_: f64| calls.fetch_add(1, Ordering::Relaxed) != stop;
            let options = BuildOptions { quality, progress: &progress, ..BuildOptions::default() };
            let error = Embree::build(&meshes, &options).err().map(|e| e.message);
            assert!(calls.load(Ordering::Relaxed) > stop, "Embree asks too rarely to be cancelled");
            assert_eq!(error, Some(cancelled().message), "{quality:?}, call {stop}");
        }
    }
}

#[test]
fn a_panic_of_the_progress_function_arrives_at_the_caller() {
    let meshes = [Arc::new(terrain(128, 4))];
    let progress = |share: f64| {
        assert!(share == 0.0, "on purpose");
        true
    };
    let options = BuildOptions { progress: &progress, ..BuildOptions::default() };
    let outcome =
        std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| Embree::build(&meshes, &options).is_ok()));
    let payload = outcome.expect_err("the panic was swallowed");
    assert!(payload.downcast_ref::<&str>().is_some_and(|m| m.contains("on purpose")));
}

#[test]
fn the_backend_keeps_its_meshes_alive() {
    for quality in QUALITIES {
        let mut meshes = vec![Arc::new(terrain(32, 6)), Arc::new(terrain(32, 7))];
        let embree = build(&meshes, best(), quality);
        let rays = rays_at_terrain(&mut ChaCha8Rng::seed_from_u64(8), 32.0);
        let (mut before, mut after) = (Hits::default(), Hits::default());
        embree.closest(rays.check(!0), Coherence::Incoherent, &mut before);
        for mesh in &mut meshes {
            Arc::make_mut(mesh).positions.fill([0.0; 3]);
        }
        drop(meshes);
        embree.closest(rays.check(!0), Coherence::Incoherent, &mut after);
        assert_eq!(bits(&before), bits(&after));
    }
}

/// Builds at the same time, then questions from many threads: the same bits as alone.
#[test]
fn threads_change_nothing() {
    // Each triangle is in three of forty meshes, dealt at random: each ray has a tie for luck to decide.
    let whole = terrain(160, 7);
    let mut parts = vec![Mesh { indices: vec![], ..whole.clone() }; 40];
    let mut random = ChaCha8Rng::seed_from_u64(10);
    for _ in 0..3 {
        for &corners in &whole.indices {
            parts[random.next_u32() as usize % 40].indices.push(corners);
        }
    }
    let meshes: Vec<_> = parts.into_iter().map(Arc::new).collect();
    let ask = |embree: &Embree| {
        let mut random = ChaCha8Rng::seed_from_u64(9);
        let mut all = Vec::new();
        for _ in 0..200 {
            let rays = rays_at_terrain(&mut random, 160.0);
            let mut hits = Hits::default();
            embree.closest(rays.check(!0), Coherence::Incoherent, &mut hits);
            all.extend(bits(&hits));
        }
        all
    };
    for quality in QUALITIES {
        let build = |threads| {
            let options = BuildOptions { quality, threads, ..BuildOptions::default() };
            Embree::build(&meshes, &options).unwrap()
        };
        let expected = ask(&build(1));
        std::thread::scope(|scope| {
            for threads in [0, 1, 2, 3] {
                let (build, ask, expected) = (&build, &ask, &expected);
                scope.spawn(move || {
                    assert!(ask(&build(threads)) == *expected, "{quality:?}, {threads} threads")
                });
            }
            let shared = Arc::new(build(0));
            for _ in 0..3 {
                let (shared, ask, expected) = (shared.clone(), &ask, &expected);
                scope.spawn(move || assert!(ask(&shared) == *expected));
            }
        });
    }
}

#[test]
fn buffers_beyond_the_limits_are_refused_with_numbers() {
    let error = check_limits(3, 1_431_655_764, 10).unwrap_err();
    assert!(error.message.contains("mesh 3") && error.message.contains("17179869192"), "{error}");
    assert!(check_limits(0, 1_431_655_763, 10).is_ok());
    assert!(check_limits(0, 10, u64::from(u32::MAX)).unwrap_err().message.contains("4294967295"));
}

#[test]
fn an_instruction_set_that_is_missing_is_an_error() {
    if Isa::best() < Isa::Avx512 {
        let options = BuildOptions { isa: Some(Isa::Avx512), ..BuildOptions::default() };
        assert!(Embree::build(&[], &options).is_err());
    }
}
