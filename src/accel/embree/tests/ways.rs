//! Packets and single rays, and the quick look at what they hit.

use super::*;
use crate::accel::settle::{in_doubt, is_in_doubt};

/// The packet width is the device's own: Debian's Embree aborts in an assertion where a packet is wider.
#[test]
fn packets_are_as_wide_as_the_kernels() {
    for isa in isas() {
        let width = match isa {
            "sse2" | "sse4.2" => Width::Four,
            "avx" | "avx2" => Width::Eight,
            _ => Width::Sixteen,
        };
        assert_eq!(build(&[triangle(0.0)], isa, Quality::Medium).width, width, "{isa}");
    }
}

/// Camera rays go as packets with the coherent flag, all others without it, shadow rays always so, a few one by one (the table is
/// in `trace.rs`).
#[test]
fn ways_are_those_of_the_table() {
    use trace::Way;
    let (coherent, other) = (Coherence::Coherent, Coherence::Incoherent);
    assert_eq!(Way::for_closest(!0, coherent), Way::CoherentPacket);
    assert_eq!(Way::for_closest(!0, other), Way::Packet);
    assert_eq!(Way::for_closest(0b1001_0001, coherent), Way::Single);
    for width in [Width::Four, Width::Eight, Width::Sixteen] {
        let expected = if width == Width::Four { Way::Single } else { Way::Packet };
        assert_eq!(Way::for_occluded(width, !0), expected);
        assert_eq!(Way::for_occluded(width, 0b11), Way::Single);
    }
}

/// Every way gives the same answers, one ray of a packet or sixteen, and the bare loop does too.
#[test]
fn all_ways_agree() {
    use bare::Way;
    let mesh = Arc::new(terrain(32, 11));
    for (isa, quality) in isas().flat_map(|isa| QUALITIES.map(|q| (isa, q))) {
        let embree = build(std::slice::from_ref(&mesh), isa, quality);
        let mut random = ChaCha8Rng::seed_from_u64(12);
        for _ in 0..50 {
            let mut rays = rays_at_terrain(&mut random, 32.0);
            rays.tmax = std::array::from_fn(|lane| if lane % 2 == 0 { f32::INFINITY } else { 0.9 });
            let mask = random.next_u32() as Mask;
            let mut bare = embree.bare(&[(rays.clone(), mask)]);
            bare.closest();
            bare.occluded();
            assert_eq!(bare.len(), mask.count_ones() as usize);
            for way in Way::ALL {
                let mut hits = Hits::default();
                embree.closest_by(way, rays.check(mask), &mut hits);
                let hit = hits.mesh.iter().filter(|&&m| m != MISS).count();
                assert_eq!(hit, bare.hits()[0], "{isa} {way:?}");
                // Never for any-hit, where Embree may loop for ever: see `Way::for_occluded`.
                if way != Way::CoherentPacket {
                    let blocked = embree.occluded_by(way, rays.check(mask)).count_ones() as usize;
                    assert_eq!(blocked, bare.hits()[1], "{isa} {way:?}");
                }
            }
        }
    }
}

/// The quick look passes no hit over that the closer one would change: far, near, small, large, at edges and corners.
#[test]
fn the_quick_look_changes_nothing() {
    let (mut looked, mut all) = (0, 0);
    for (scale, offset) in [(1.0, 0.0), (1e-9, 0.0), (1e9, 0.0), (1.0, 3e5), (1e3, -1e4), (1e-4, 1.0)] {
        let mut mesh = terrain(64, 13);
        for p in mesh.positions.iter_mut() {
            *p = p.map(|x| x * scale + offset);
        }
        let mesh = Arc::new(mesh);
        for (isa, quality) in isas().flat_map(|isa| QUALITIES.map(|q| (isa, q))) {
            // With a triangle aside, and without.
            let beside = if offset == 0.0 { aside::ground(0.5, scale) } else { Arc::new(terrain(4, 18)) };
            let embree = build(&[mesh.clone(), beside], isa, quality);
            assert_eq!(embree.aside.is_some(), offset == 0.0);
            let mut random = ChaCha8Rng::seed_from_u64(14);
            for _ in 0..100 {
                let mut rays = rays_at_terrain(&mut random, 64.0);
                for lane in 0..LANES {
                    let (o, d) = (rays.o(lane) * scale + offset, rays.d(lane) * scale);
                    rays.set(lane, o, d * 2f32.powi(lane as i32 - 8), 0.0, f32::INFINITY);
                }
                let (mut got, mut expected) = (Hits::default(), Hits::default());
                embree.closest(rays.check(!0), Coherence::Incoherent, &mut got);
                let doubtful = embree.trace(rays.check(!0), Coherence::Incoherent, &mut expected);
                let hit = expected.mesh.iter().filter(|&&m| m != MISS).count() as u32;
                for lane in (0..LANES).filter(|&lane| expected.mesh[lane] != MISS) {
                    let corners = embree.hit(&expected, lane);
                    // At 1e9 it overflows, and doubts everything.
                    let in_doubt = scale < 1e9 && {
                        let uv = [expected.u[lane], expected.v[lane]];
                        is_in_doubt(rays.o(lane), rays.d(lane), uv, corners)
                    };
                    assert!(doubtful >> lane & 1 == 1 || !in_doubt, "{isa} {quality:?} {scale} {offset}");
                }
                looked += doubtful.count_ones();
                all += hit;
                weights::weigh(|hits, lane| embree.hit(hits, lane), &rays, !0, &mut expected);
                let all_in_doubt = in_doubt(&embree, &rays, !0, &expected);
                settle(&embree, &rays, all_in_doubt, &mut expected);
                assert_eq!(bits(&got), bits(&expected), "{isa} {quality:?} {scale} {offset}");
            }
        }
    }
    // Two thirds of the rays are aimed at edges.
    assert!(
        looked < all * 9 / 10,
        "{looked} of {all} hits were looked at twice: the quick look spares nothing"
    );
}
