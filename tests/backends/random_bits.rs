//! Meshes and rays of random bits: not-a-numbers, infinities, magnitudes from denormal to beyond every limit, corners
//! that coincide. Every backend builds and traces them on every instruction set; what it answers is in range.
//!
//! `DRT_HEAVY_TESTS=1` takes 100,000 meshes; otherwise 1,000.

use super::meshes::Random;
use drt::accel::{Backend, BuildOptions, Coherence, Hits, LANES, MISS, Mask, Quality, Rays};
use drt::math::isa::Isa;
use drt::shape::Mesh;
use std::sync::Arc;

/// Numbers at which arithmetic turns into something else.
const ODD: [f32; 20] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    1e-45,
    f32::MIN_POSITIVE,
    1e-20,
    1e-9,
    f32::EPSILON,
    16_777_216.0,
    1e9,
    // The gate's limit, Embree's own, and what is just beyond them.
    1e18,
    1.000_001e18,
    -1.844e18,
    1.845e18,
    f32::MAX,
    f32::MIN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::NAN,
];

/// How the numbers of a mesh or of a ray are chosen.
#[derive(Clone, Copy)]
enum Style {
    Bits,
    Odd,
    Grid,
    Unit,
}

fn style(random: &mut Random) -> Style {
    [Style::Bits, Style::Odd, Style::Grid, Style::Unit][random.below(4)]
}

fn number(random: &mut Random, style: Style) -> f32 {
    match style {
        // One in sixteen all the same: a sound mesh with one bad number is the likelier accident.
        _ if random.below(16) == 0 => ODD[random.below(ODD.len())],
        Style::Bits => f32::from_bits(random.below(1 << 32) as u32),
        Style::Odd => ODD[random.below(ODD.len())],
        Style::Grid => random.below(3) as f32 - 1.0,
        Style::Unit => random.unit() * 2.0 - 1.0,
    }
}

fn mesh(random: &mut Random) -> Mesh {
    let style = style(random);
    let mut positions: Vec<[f32; 3]> = Vec::new();
    for _ in 0..random.below(13) {
        let again = random.below(4) == 0 && !positions.is_empty();
        let copy = again.then(|| positions[random.below(positions.len())]);
        positions.push(copy.unwrap_or_else(|| std::array::from_fn(|_| number(random, style))));
    }
    let triangles = if positions.is_empty() { 0 } else { random.below(21) };
    let corner = |random: &mut Random| random.below(positions.len()) as u32;
    let indices = (0..triangles).map(|_| std::array::from_fn(|_| corner(random))).collect();
    Mesh::new(positions, indices)
}

/// Sixteen rays; half of them leave from and aim at what may be near the meshes.
fn rays(random: &mut Random, meshes: &[Arc<Mesh>]) -> Rays {
    let mut rays = Rays::default();
    for lane in 0..LANES {
        let style = style(random);
        let o: [f32; 3] = std::array::from_fn(|_| number(random, style));
        let mesh = &meshes[random.below(meshes.len())];
        let aimed = lane % 2 == 0 && !mesh.positions.is_empty();
        let target = if aimed { mesh.positions[random.below(mesh.positions.len())] } else { [0.0; 3] };
        let d: [f32; 3] = std::array::from_fn(|axis| match aimed {
            true => target[axis] - o[axis],
            false => number(random, style),
        });
        let (tmin, tmax) = match random.below(3) {
            0 => (number(random, style), number(random, style)),
            1 => (0.0, number(random, style).abs()),
            _ => (0.0, f32::INFINITY),
        };
        rays.set(lane, o.into(), d.into(), tmin, tmax);
    }
    rays
}

/// Finite coordinates below 1e9, so that no product of three overflows.
fn tame(mesh: &Mesh) -> bool {
    mesh.positions.iter().flatten().all(|x| x.abs() < 1e9)
}

#[test]
fn meshes_and_rays_of_random_bits_are_safe_everywhere() {
    let count = if super::effort() > 1 { 100_000 } else { 1_000 };
    let isas: Vec<Isa> = Isa::ALL.into_iter().filter(|isa| *isa <= Isa::best()).collect();
    let (mut asked, mut found) = (0u64, 0u64);
    for seed in 0..count {
        let random = &mut Random(seed);
        let meshes: Vec<Arc<Mesh>> = (0..random.below(3) + 1).map(|_| Arc::new(mesh(random))).collect();
        let chunks: Vec<Rays> = (0..2).map(|_| rays(random, &meshes)).collect();
        let quality = [Quality::Low, Quality::Medium, Quality::High][random.below(3)];
        let compact = random.below(4) == 0;
        for (&backend, &isa) in Backend::ALL.iter().flat_map(|b| isas.iter().map(move |isa| (b, isa))) {
            let options =
                BuildOptions { quality, compact, isa: Some(isa), threads: 1, ..BuildOptions::default() };
            let built = backend.build(&meshes, &options).expect("builds");
            for (turn, rays) in chunks.iter().enumerate() {
                let coherence = [Coherence::Coherent, Coherence::Incoherent][turn % 2];
                let checked =
                    rays.check(if random.below(2) == 0 { Mask::MAX } else { random.below(1 << 16) as Mask });
                let mut hits = Hits::default();
                built.closest(checked, coherence, &mut hits);
                built.occluded(checked, coherence);
                for lane in (0..LANES).filter(|lane| checked.active() >> lane & 1 == 1) {
                    asked += 1;
                    if hits.mesh[lane] == MISS {
                        continue;
                    }
                    found += 1;
                    let what = format!("mesh {seed}, {} {isa:?} {quality:?}, lane {lane}", backend.name());
                    let indices = meshes.get(hits.mesh[lane] as usize).map(|mesh| mesh.indices.len());
                    assert!(
                        indices.is_some_and(|n| (hits.triangle[lane] as usize) < n),
                        "{what}: no such triangle"
                    );
                    let [t, u, v] = [hits.t[lane], hits.u[lane], hits.v[lane]];
                    assert!(!t.is_nan(), "{what}: no distance");
                    // Where no product overflows or loses all of its digits.
                    let largest = [rays.o(lane), rays.d(lane)].map(|x| x.abs().max_element());
                    let ray_is_tame = largest.iter().all(|x| *x < 1e9)
                        && largest[1] > 1e-9
                        && (rays.tmin[lane] == 0.0 || rays.tmin[lane] > 1e-9);
                    if ray_is_tame && tame(&meshes[hits.mesh[lane] as usize]) {
                        assert!(rays.tmin[lane] <= t && t <= rays.tmax[lane], "{what}: t = {t}");
                        assert!(u.is_finite() && v.is_finite(), "{what}: {u}, {v}");
                    }
                }
            }
        }
    }
    // Not a test of empty space.
    assert!(found * 100 > asked, "only {found} of {asked} rays hit anything");
}

/// What reaches from one end of f32 to the other has a finite middle and no finite size.
#[test]
fn triangles_as_large_as_f32_are_left_out() {
    let (far, near) = (f32::MAX, 1.0);
    let mut positions = vec![[0.0; 3], [near, 0.0, 0.0], [0.0, near, 0.0]];
    positions.extend((0..15).map(|i| [far, -far, near].map(|x| if i % 2 == 0 { x } else { -x })));
    positions.iter_mut().skip(3).enumerate().for_each(|(i, p)| p[i % 3] *= 0.5);
    let indices = (0..16).map(|i| [i, i + 1, i + 2]).collect();
    let meshes = [Arc::new(Mesh::new(positions, indices))];
    for backend in Backend::ALL {
        for quality in [Quality::Low, Quality::Medium, Quality::High] {
            let built = backend.build(&meshes, &BuildOptions { quality, ..BuildOptions::default() });
            let mut rays = Rays::default();
            rays.set(0, [0.25, 0.25, -1.0].into(), [0.0, 0.0, 1.0].into(), 0.0, f32::INFINITY);
            let mut hits = Hits::default();
            built.expect("builds").closest(rays.check(1), Coherence::Incoherent, &mut hits);
            assert_eq!((hits.triangle[0], hits.t[0]), (0, 1.0), "{} {quality:?}", backend.name());
        }
    }
}
