//! Rays in planes, ends of intervals, no triangles, triangles without area, the same triangle many times.

use super::*;

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
        // No reader lets these through; a caller of the library may bring them.
        triangle([0.0; 3], [1.0, 1.0, 0.0], [f32::NAN, 0.0, 0.0]),
        triangle([0.0; 3], [1.0, 1.0, 0.0], [f32::INFINITY, 0.0, 0.0]),
    ];
    let last = flat.len() as u32 + 1;
    let mut rays = random_rays(&unit, 200, 1);
    rays.push(towards(Vec3::new(0.05, 0.9, 1.0), Vec3::new(0.05, 0.9, 0.0)));
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
        assert_eq!((hits.mesh[0], hits.triangle[0]), (last, 0), "{backend}");
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
