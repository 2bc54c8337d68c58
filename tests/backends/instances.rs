//! Instances and motion: the two levels give the answers of copies, ray by ray.

use super::*;
use drt::accel::Geometry;
use drt::math::DVec3;
use drt::shape::{Instance, Instances, Motion, Pose, Stage};
use glam::{DAffine3, DMat3};

/// Meshes with affine transforms of all kinds: rotations, stretches, mirrors, shears, of sizes around 1.
fn anywhere(random: &mut Random) -> DAffine3 {
    let mut column = || random.ball().as_dvec3();
    loop {
        let linear = DMat3::from_cols(column(), column(), column());
        if linear.determinant().abs() > 0.05 {
            return DAffine3 { matrix3: linear, translation: column() * 4.0 };
        }
    }
}

/// A soup at rest, and two meshes in `places` places, every third of them moving.
fn scene(places: usize, seed: u64) -> (Vec<Arc<Mesh>>, Instances) {
    let mut random = Random(seed);
    let meshes = vec![Arc::new(soup(40, seed)), Arc::new(uv_sphere(6))];
    let place = |i: usize| {
        let mut stages = vec![Stage::Fixed(anywhere(&mut random))];
        if i.is_multiple_of(3) {
            let axis = random.ball().as_dvec3().normalize();
            let shift = random.cube().as_dvec3();
            let poses =
                [(0.0, Pose::IDENTITY), (2.0, Pose::new(DVec3::splat(1.5), Some((axis, 250.0)), shift))];
            stages.push(Stage::Moving(Arc::new(Motion::new(&poses).unwrap())));
        }
        Instance::new((i % 2) as u32, None, stages)
    };
    let places = (0..places).map(place).collect();
    (vec![Arc::new(soup(60, seed + 1))], Instances { meshes, places })
}

fn flattened(meshes: &[Arc<Mesh>], instances: &Instances, time: f64) -> Vec<Arc<Mesh>> {
    meshes.iter().cloned().chain(instances.copies(time).map(Arc::new)).collect()
}

/// Every backend over two levels, and the judge in f64, against every backend over copies and each other.
#[test]
fn two_levels_answer_like_copies() {
    for (places, seed) in [(1, 1), (2, 2), (7, 3), (60, 4)] {
        let (meshes, instances) = scene(places, seed);
        let geometry = Geometry { meshes: &meshes, instances: &instances, shutter: [0.5, 1.5] };
        for time in [0.0f32, 0.37, 1.0] {
            let copies = flattened(&meshes, &instances, 0.5 + f64::from(time));
            let all = bounds_of(&copies);
            let chunks = chunks(&random_rays(&all, 3000 * effort(), seed));
            let times = [time; LANES];
            let mut answers: Vec<(String, Vec<Hits>)> = Vec::new();
            for backend in Backend::ALL {
                let two = backend.build_all(&geometry, &BuildOptions::default()).unwrap();
                let hits: Vec<Hits> = chunks
                    .iter()
                    .map(|rays| {
                        let mut hits = Hits::default();
                        let checked = rays.check(Mask::MAX).at(&times);
                        two.closest(checked, Coherence::Incoherent, &mut hits);
                        let blocked = two.occluded(checked, Coherence::Incoherent);
                        let hit = (0..LANES).fold(0, |m, i| m | ((hits.mesh[i] != MISS) as Mask) << i);
                        assert_eq!(blocked, hit, "{}: occluded against closest", backend.name());
                        hits
                    })
                    .collect();
                answers.push((format!("{} on two levels", backend.name()), hits));
                answers.push((backend.name().to_string(), trace(&*build(*backend, &copies), &chunks)));
            }
            answers.push(("judge".to_string(), trace(&Brute::of(&geometry, time), &chunks)));
            let judge = Judge::thorough(&copies);
            let mut found = Tally::default();
            for (i, (first, a)) in answers.iter().enumerate() {
                for (second, b) in &answers[i + 1..] {
                    let mut tally = Tally::default();
                    for ((rays, a), b) in chunks.iter().zip(a).zip(b) {
                        judge.compare(rays.check(Mask::MAX), a, b, &mut tally);
                    }
                    let why = tally.kept.first();
                    assert_eq!(tally.real, 0, "{places} places: {first} against {second}: {why:#?}");
                    found.merge(tally);
                }
            }
            let hits = answers[0].1.iter().flat_map(|h| h.mesh).filter(|m| *m != MISS && *m > 0).count();
            assert!(hits > 30, "{places} places: only {hits} rays met instances");
        }
    }
}

/// A box around all, as a mesh that [`random_rays`] can be aimed at.
fn bounds_of(meshes: &[Arc<Mesh>]) -> Mesh {
    let bounds = meshes.iter().fold(drt::math::Aabb::EMPTY, |b, m| b.union(m.bounds()));
    Mesh::new(vec![bounds.min.to_array(), bounds.max.to_array(), bounds.center().to_array()], vec![[0, 1, 2]])
}

/// Each lane has its own time: together they answer what each does alone, and another shutter other things.
#[test]
fn every_ray_is_traced_at_its_own_time() {
    let (meshes, instances) = scene(9, 11);
    let geometry = Geometry { meshes: &meshes, instances: &instances, shutter: [0.0, 2.0] };
    let rays = chunks(&random_rays(&bounds_of(&flattened(&meshes, &instances, 0.0)), 4000, 5));
    let times: [f32; LANES] = std::array::from_fn(|i| i as f32 / LANES as f32);
    for backend in Backend::ALL {
        let mut two = backend.build_all(&geometry, &BuildOptions::default()).unwrap();
        let ask = |two: &dyn Intersector, rays: &Rays, mask: Mask, times: &[f32; LANES]| {
            let mut hits = Hits::default();
            two.closest(rays.check(mask).at(times), Coherence::Incoherent, &mut hits);
            hits
        };
        let together: Vec<Hits> = rays.iter().map(|r| ask(&*two, r, Mask::MAX, &times)).collect();
        let same = |hits: &Hits, other: &Hits, lane: usize| {
            (hits.mesh[lane], hits.triangle[lane]) == (other.mesh[lane], other.triangle[lane])
                && (hits.t[lane] - other.t[lane]).abs() <= 1e-5 * hits.t[lane].abs()
                || hits.mesh[lane] == MISS && other.mesh[lane] == MISS
        };
        let mut moved = 0;
        for (rays, hits) in rays.iter().zip(&together) {
            let opening = ask(&*two, rays, Mask::MAX, &[0.0; LANES]);
            for (lane, time) in times.iter().enumerate() {
                let alone = ask(&*two, rays, 1 << lane, &[*time; LANES]);
                assert!(same(hits, &alone, lane), "{} lane {lane}", backend.name());
                moved += usize::from(!same(hits, &opening, lane));
            }
        }
        assert!(moved > 50, "only {moved} answers depend on the time");
        // The middle of the shutter is the opening of one that opens there.
        two.set_shutter([1.0, 1.0]);
        for (rays, _) in rays.iter().zip(&together) {
            let there = ask(&*two, rays, Mask::MAX, &[0.7; LANES]);
            two.set_shutter([0.0, 2.0]);
            let middle = ask(&*two, rays, Mask::MAX, &[0.5; LANES]);
            two.set_shutter([1.0, 1.0]);
            assert!((0..LANES).all(|lane| same(&there, &middle, lane)), "{}", backend.name());
        }
    }
}

/// A closed body in motion stays closed: rays from inside hit it at every time, and from where they leave it, too.
#[test]
fn moving_bodies_do_not_leak() {
    let ball = Arc::new(uv_sphere(24));
    let poses = [
        (0.0, Pose::new(DVec3::new(1.0, 0.2, 3.0), Some((DVec3::X, 0.0)), DVec3::new(1000.0, 0.0, 0.0))),
        (1.0, Pose::new(DVec3::new(2.0, 0.3, 1.0), Some((DVec3::X, 300.0)), DVec3::new(1010.0, 5.0, 0.0))),
    ];
    let motion = Arc::new(Motion::new(&poses).unwrap());
    let place = Instance::new(0, None, vec![Stage::Moving(motion.clone())]);
    let instances = Instances { meshes: vec![ball], places: vec![place] };
    let geometry = Geometry { meshes: &[], instances: &instances, shutter: [0.0, 1.0] };
    let mut random = Random(8);
    for backend in Backend::ALL {
        let two = backend.build_all(&geometry, &BuildOptions::default()).unwrap();
        for _ in 0..400 * effort() {
            let times: [f32; LANES] = std::array::from_fn(|_| random.unit());
            let mut rays = Rays::default();
            for (lane, time) in times.iter().enumerate() {
                let o = motion.at(f64::from(*time)).transform_point3(random.ball().as_dvec3() * 0.3);
                rays.set(lane, o.as_vec3(), random.ball().normalize(), 0.0, f32::INFINITY);
            }
            let mut hits = Hits::default();
            two.closest(rays.check(Mask::MAX).at(&times), Coherence::Incoherent, &mut hits);
            assert!(hits.mesh.iter().all(|m| *m == 0), "{}: a ray escaped", backend.name());
            assert_eq!(two.occluded(rays.check(Mask::MAX).at(&times), Coherence::Incoherent), Mask::MAX);
        }
    }
}
