//! What every backend promises: lanes, threads, bits, cancelling.

use super::*;

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
