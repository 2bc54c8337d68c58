//! A few triangles beside a large mesh, at low quality.

use super::*;
use crate::accel::Backend;

/// Two triangles over [−10, 74]² at the height `z`, all times `scale`.
pub(super) fn ground(z: f32, scale: f32) -> Arc<Mesh> {
    let corners = [[-10.0, -10.0, z], [74.0, -10.0, z], [74.0, 74.0, z], [-10.0, 74.0, z]];
    Arc::new(Mesh::new(corners.map(|p| p.map(|x| x * scale)).to_vec(), vec![[0, 1, 2], [0, 2, 3]]))
}

/// A box of edge 1 whose top is `n`×`n` cells; the sides and the bottom, ten triangles, are a mesh of their own.
fn closed_box(n: u32) -> [Arc<Mesh>; 2] {
    let mut top = terrain(n, 0);
    let to = |x: f32| x / n as f32;
    for p in top.positions.iter_mut() {
        *p = [to(p[0]), to(p[1]), 1.0];
    }
    let corner = |i: u32| [(i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32];
    let quads = [[0, 2, 3, 1], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]];
    let indices = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    [Arc::new(top), Arc::new(Mesh::new((0..8).map(corner).collect(), indices))]
}

/// The same names and occlusion as our BVH has, wherever the few triangles stand in the list.
#[test]
fn the_hierarchy_has_the_same_answers() {
    let mut large = terrain(64, 15);
    // Two vertices that no triangle has: the box around the others does not forget them.
    let mut positions = large.positions.to_vec();
    positions.extend([[f32::NAN; 3], [0.0; 3]]);
    large.positions = crate::shape::Positions::new(positions);
    let large = Arc::new(large);
    let few = [ground(-1.0, 1.0), ground(0.5, 1.0)];
    for order in [[0, 1, 2], [1, 0, 2], [1, 2, 0]] {
        let all = [&large, &few[0], &few[1]];
        let meshes = order.map(|i| all[i].clone());
        let bvh = Backend::Bvh.build(&meshes, &BuildOptions::default()).unwrap();
        for isa in isas() {
            let embree = build(&meshes, isa, Quality::Low);
            assert!(embree.aside.is_some() && matches!(embree.geometry, Geometry::Shared(_)));
            let mut random = ChaCha8Rng::seed_from_u64(16);
            let mut counts = [0; 3];
            for round in 0..200 {
                let mut rays = rays_at_terrain(&mut random, 64.0);
                if round % 2 == 0 {
                    // From below.
                    rays.oz.iter_mut().for_each(|z| *z = -*z);
                    rays.dz.iter_mut().for_each(|z| *z = -*z);
                }
                // Every third ray is aimed at a point between the edges.
                let inner = 0b0100_1001_0010_0100;
                let (mut got, mut expected) = (Hits::default(), Hits::default());
                embree.closest(rays.check(inner), Coherence::Incoherent, &mut got);
                bvh.closest(rays.check(inner), Coherence::Incoherent, &mut expected);
                for lane in (0..LANES).filter(|lane| inner >> lane & 1 == 1) {
                    let name = |h: &Hits| [h.mesh[lane], h.triangle[lane]];
                    assert_eq!(name(&got), name(&expected), "{isa} {order:?}");
                    assert!((got.t[lane] - expected.t[lane]).abs() <= 1e-5 * expected.t[lane]);
                    counts[got.mesh[lane] as usize] += 1;
                }
                // Up to a little before the hit there is nothing, up to a little behind it something.
                for (factor, blocked) in [(0.9, 0), (1.1, inner)] {
                    let mut rays = rays.clone();
                    (0..LANES).for_each(|lane| rays.tmax[lane] = expected.t[lane] * factor);
                    assert_eq!(embree.occluded(rays.check(inner), Coherence::Incoherent), blocked);
                }
            }
            assert!(counts.iter().all(|&n| n > 200), "{counts:?}");
        }
    }
}

/// Where a small mesh ends at a large one, a ray could pass between two different tests: nothing is set aside.
#[test]
fn what_shares_an_edge_is_not_set_aside() {
    let [top, sides] = closed_box(48);
    let is_aside = |meshes: &[Arc<Mesh>]| build(meshes, best(), Quality::Medium).aside.is_some();
    assert!(!is_aside(&[top.clone(), sides.clone()]) && !is_aside(&[sides, top.clone()]));
    // The ground's diagonal, which both of its halves have, may run below the top.
    let moved = |mesh: &Mesh, by: Vec3| {
        let mut mesh = mesh.clone();
        mesh.positions.iter_mut().for_each(|p| *p = (Vec3::from(*p) + by).to_array());
        Arc::new(mesh)
    };
    let below = ground(1.0, 1.0);
    assert!(is_aside(&[top.clone(), below.clone()]) && is_aside(&[below.clone(), top.clone()]));
    // Its edge at x = −10 may not, nor may the one that one half has without the other.
    assert!(!is_aside(&[top.clone(), moved(&below, Vec3::new(10.0, 0.0, 0.0))]));
    assert!(is_aside(&[top.clone(), moved(&below, Vec3::new(9.9, 0.0, 0.0))]));
    let half = Arc::new(Mesh::new(below.positions.to_vec(), vec![below.indices[0]]));
    assert!(!is_aside(&[top.clone(), half.clone()]));
    assert!(is_aside(&[top.clone(), moved(&half, Vec3::new(0.0, 0.0, -0.1))]));
    // Nor may that of the half listed twice, from both sides.
    let [a, b, c] = below.indices[0];
    assert!(!is_aside(&[top, Arc::new(Mesh::new(below.positions.to_vec(), vec![[a, b, c], [a, c, b]]))]));
}

/// A closed body of few triangles, which may stand anywhere: rays from outside that are aimed at its edges do not meet its
/// inside. (Not settled, one in 150 does.)
#[test]
fn a_small_body_has_no_inside() {
    let corner =
        |i: u32| [20.0 + 4.0 * (i & 1) as f32, 20.0 + 4.0 * (i >> 1 & 1) as f32, 4.0 * (i >> 2) as f32];
    let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [1, 3, 7, 5], [3, 2, 6, 7], [2, 0, 4, 6]];
    let indices = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    let body = Arc::new(Mesh::new((0..8).map(corner).collect(), indices));
    let mut random = ChaCha8Rng::seed_from_u64(19);
    let mut unit = || (random.next_u32() >> 8) as f32 * 2f32.powi(-24);
    for isa in isas() {
        let embree = build(&[Arc::new(terrain(64, 15)), body.clone()], isa, Quality::Medium);
        assert!(embree.aside.is_some());
        let (mut hit, mut wrong) = (0, 0);
        for _ in 0..2000 {
            let eye =
                Vec3::new(22.0, 22.0, 3.0) + Vec3::new(unit() - 0.5, unit() - 0.5, unit()).normalize() * 12.0;
            let mut rays = Rays::default();
            for lane in 0..LANES {
                // Edges of the upper half: two that meet at a corner of the top, and the upright one below it.
                let top = Vec3::from(corner(4 + (lane as u32 & 3)));
                let along = 0.98 * unit() + 0.01;
                let other = [lane as u32 & 3 ^ 5, lane as u32 & 3 ^ 6, lane as u32 & 3][lane % 3];
                let target = top.lerp(Vec3::from(corner(other)), along);
                rays.set(lane, eye, target - eye, 0.0, f32::INFINITY);
            }
            let mut hits = Hits::default();
            embree.closest(rays.check(!0), Coherence::Incoherent, &mut hits);
            for lane in (0..LANES).filter(|&lane| hits.mesh[lane] == 1) {
                let [a, b, c] = embree.hit(&hits, lane);
                let outside = (b - a).cross(c - a).normalize().dot(rays.d(lane).normalize());
                wrong += usize::from(outside > 1e-7);
                hit += 1;
            }
        }
        assert!(hit > 10_000 && wrong <= hit / 10_000, "{isa}: {wrong} of {hit}");
    }
}
