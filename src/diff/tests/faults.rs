//! Planted faults are found, blamed on the right one, and reproduced.

use super::*;
use crate::load::open::Reach;

#[test]
fn planted_faults_are_real_and_blamed_on_the_faulty() {
    let faults = [
        Fault::Drops(seen_corner()),
        Fault::Stretches(1e-3),
        Fault::Stretches(-1e-5),
        Fault::Swaps,
        Fault::Endless,
    ];
    for fault in faults {
        let (report, ..) = found(fault);
        assert!(report.of(Class::Real) > 0, "{fault:?}");
        assert!(report.cases.iter().all(|case| case.wrong == [false, true]), "{fault:?}: {:?}", report.cases);
        assert!(
            report::table(&report).contains("REAL") && report.sentence(&report.cases[0]).contains("faulty")
        );
        let blocked = report.cases.iter().all(|case| matches!(case.answers, Answers::Blocked(_)));
        assert_eq!(blocked, fault == Fault::Endless);
    }
}

/// Files and back, with every bit; asked again, the same two disagree.
#[test]
fn reproducers_fail_on_their_own() {
    let corner = seen_corner();
    for (fault, most) in
        [(Fault::Drops(corner), 2), (Fault::Stretches(1e-3), 1), (Fault::DropsInLarge(corner, 9), 10)]
    {
        let (report, scene, contestants) = found(fault);
        let court = Court::new(&scene.meshes);
        let case = &report.cases[0];
        let made = minimal(case, &court, &scene.meshes, &contestants).unwrap();
        let triangles: usize = made.meshes.iter().map(|m| m.indices.len()).sum();
        assert!(made.fails && triangles <= most, "{fault:?}: {triangles} triangles");
        let folder = tempfile::TempDir::new().unwrap();
        let path = made.write(folder.path(), 1, &report.sentence(case)).unwrap();
        let read = Reproducer::read(&path, &Reach::Anywhere).unwrap().expect("a case");
        let corners = |r: &Reproducer| -> Vec<[u32; 3]> {
            let all = r.meshes.iter().flat_map(|m| (0..m.indices.len()).flat_map(|t| m.triangle(t)));
            all.map(|p| p.to_array().map(f32::to_bits)).collect()
        };
        assert_eq!(corners(&read), corners(&made));
        let ray = |r: &Reproducer| {
            let rays = &r.rays.chunks[0].rays;
            (rays.o(0), rays.d(0), rays.tmin[0], rays.tmax[0])
        };
        assert_eq!(ray(&read), (case.o, case.d, case.tmin, case.tmax));
        let again = |contestants: &[Contestant]| {
            let all: Vec<&Contestant> = contestants.iter().collect();
            ask(&read.meshes, std::slice::from_ref(&read.rays), &all, &Hooks::NONE).unwrap()
        };
        assert!(again(&contestants).of(Class::Real) > 0, "{fault:?}");
        assert_eq!(again(&pair(Fault::None)).of(Class::Real), 0);
    }
}
