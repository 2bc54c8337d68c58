//! The compact layout, and builds that run out of memory.

use super::*;
use crate::accel::Backend;
use crate::accel::need::Extent;

/// Smaller, and otherwise the same surface: hits of rays between the edges agree within rounding.
#[test]
fn compact_scenes_are_smaller_and_answer_the_same() {
    let meshes = [Arc::new(terrain(64, 15)), triangle(0.5)];
    for (isa, quality) in isas().flat_map(|isa| QUALITIES.map(|q| (isa, q))) {
        let with = |compact| {
            let options = BuildOptions { quality, compact, ..BuildOptions::default() };
            Embree::build_as(&meshes, &options, isa, true, None).unwrap()
        };
        let (usual, compact) = (with(false), with(true));
        assert!(compact.compact() && !usual.compact());
        assert!(compact.bytes() < usual.bytes() * 8 / 10, "{isa}: {} {}", compact.bytes(), usual.bytes());
        let mut random = ChaCha8Rng::seed_from_u64(16);
        for _ in 0..50 {
            let rays = rays_at_terrain(&mut random, 64.0);
            // Every third ray is aimed at a point between the edges.
            let inner = 0b0100_1001_0010_0100;
            let (mut a, mut b) = (Hits::default(), Hits::default());
            usual.closest(rays.check(inner), Coherence::Incoherent, &mut a);
            compact.closest(rays.check(inner), Coherence::Incoherent, &mut b);
            assert_eq!(usual.occluded(rays.check(inner), Coherence::Incoherent), inner);
            assert_eq!(compact.occluded(rays.check(inner), Coherence::Incoherent), inner);
            for lane in (0..LANES).filter(|lane| inner >> lane & 1 == 1) {
                assert!(
                    (a.t[lane] - b.t[lane]).abs() <= 1e-5 * a.t[lane],
                    "{isa}: {} {}",
                    a.t[lane],
                    b.t[lane]
                );
            }
        }
    }
}

/// The prediction is no less than what builds take at their peak, and no more than half as much again.
#[test]
fn what_a_build_takes_is_what_was_predicted() {
    let mesh = [Arc::new(terrain(400, 17))];
    let triangles = mesh[0].indices.len() as u64;
    for quality in QUALITIES {
        let peak = build(&mesh, best(), quality).device.peak() as u64;
        let is_short = |bytes| Backend::Embree.is_short(triangles, Some(bytes));
        assert!(is_short(peak) && !is_short(peak * 3 / 2), "{quality:?}: {} a triangle", peak / triangles);
        let over = Extent { triangles, vertices: mesh[0].positions.len() as u64, meshes: 1 };
        for compact in [false, true] {
            let options = BuildOptions { quality, compact, ..BuildOptions::default() };
            let peak = Embree::build_as(&mesh, &options, best(), true, None).unwrap().device.peak() as u64;
            let need = Backend::Embree.need(over, quality, compact);
            assert!((peak..peak * 3 / 2).contains(&need), "{quality:?} {compact}: {peak} {need}");
        }
    }
}

/// Refused at any point, Embree ends with a clear error and gives everything back.
#[test]
fn a_build_that_runs_out_of_memory_is_a_clear_error() {
    let meshes = [Arc::new(terrain(150, 18)), Arc::new(terrain(30, 19))];
    for quality in QUALITIES {
        let options = BuildOptions { quality, ..BuildOptions::default() };
        let with = |memory| Embree::build_as(&meshes, &options, best(), true, memory);
        let peak = with(None).unwrap().device.peak() as u64;
        let refused = (0..40).filter(|step| match with(Some(peak * step / 32)) {
            Ok(_) => false,
            Err(error) => {
                assert!(error.message.contains("not enough memory for Embree to"), "{error}");
                assert!(error.message.contains("MB are free"), "{error}");
                assert!(error.to_string().contains("render.compact"), "{error}");
                true
            }
        });
        let refused = refused.count();
        assert!((20..36).contains(&refused), "{quality:?}: {refused} of 40 refused");
        let device = Device::new(best(), 1, Some(1 << 16)).unwrap();
        let mut uncommitted = scene::Uncommitted::new(&device, quality, true, false).unwrap();
        let shared = Shared::new(&meshes[..1]).unwrap();
        uncommitted.attach(0, shared.buffers().next().unwrap()).unwrap();
        assert!(uncommitted.commit(&|_| true).is_err());
        assert_eq!(device.bytes(), 0, "{quality:?}: not everything was given back");
    }
}
