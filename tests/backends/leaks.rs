//! Closed surfaces are closed: at vertices, at edges, on integer grids, along axes.

use super::*;

/// Closed surfaces, with points inside and the radius of a ball around them that lies inside.
fn closed() -> Vec<(&'static str, Mesh, Vec<Vec3>, f32)> {
    let middle = vec![Vec3::ZERO];
    let ring = (0..8).map(|i| Vec3::new((i as f32).cos(), 0.0, (i as f32).sin())).collect();
    vec![
        ("uv sphere", uv_sphere(24), middle.clone(), 0.9),
        ("octasphere", octasphere(4), middle, 0.9),
        ("torus", torus(32), ring, 0.3),
        ("cube", cube(9), vec![Vec3::splat(4.5)], 4.4),
    ]
}

#[test]
fn closed_surfaces_do_not_leak() {
    for (name, mesh, inside, radius) in closed() {
        let mut random = Random(11);
        let far = mesh.bounds().extent().length() * 2.0;
        let n = 4000 * effort();
        let mut rays: Vec<Ray> = (0..n)
            .map(|i| {
                (
                    inside[i % inside.len()] + random.ball() * radius,
                    random.ball().normalize(),
                    0.0,
                    f32::INFINITY,
                )
            })
            .collect();
        rays.extend((0..n).map(|i| {
            let target = inside[i % inside.len()] + random.ball() * radius;
            towards(inside[0] + random.ball().normalize() * far, target)
        }));
        let count = rays.len();
        let meshes = one(mesh);
        let tally = agree(name, &meshes, &rays);
        assert_eq!(tally.hit_miss, 0, "{name}: {tally:?}");
        for (backend, built) in all(&meshes) {
            assert_eq!(missed(&trace(&*built, &chunks(&rays)), count), 0, "{name}: {backend} leaks");
        }
    }
}

/// Rays from within to vertices and to points of edges: where cracks are. The hierarchy has none; what other
/// backends are known to lose (2.2 % of Embree's vertex-aimed rays) is bounded, not hidden.
#[test]
fn rays_aimed_at_vertices_and_edges() {
    for (name, mesh, inside, radius) in closed() {
        let mut random = Random(13);
        let (mut at_vertices, mut at_edges) = (Vec::new(), Vec::new());
        for i in 0..3000 * effort() {
            let corners = mesh.triangle(random.below(mesh.indices.len()));
            // From the middle of a torus' tube the far side is hidden, but a ray always meets something.
            let o = inside[i % inside.len()] + random.ball() * radius * if i % 4 == 0 { 0.0 } else { 1.0 };
            at_vertices.push(towards(o, corners[0]));
            at_edges.push(towards(o, corners[1].lerp(corners[2], random.unit())));
        }
        let meshes = one(mesh);
        for (backend, built) in all(&meshes) {
            let lost = |rays: &[Ray]| missed(&trace(&*built, &chunks(rays)), rays.len());
            let (vertices, edges) = (lost(&at_vertices), lost(&at_edges));
            let allowed = if backend == "bvh" { 0 } else { at_vertices.len() / 20 };
            assert!(
                vertices <= allowed && edges <= allowed / 10,
                "{name}: {backend}: {vertices}, {edges} lost"
            );
        }
    }
}

/// Perspective rays at the vertices, edges and middles of a flat integer grid's inner triangles.
#[test]
fn integer_grid() {
    let meshes = one(grid(20));
    let eyes = [Vec3::new(10.0, 10.0, 7.0), Vec3::new(3.3, -8.1, 5.7), Vec3::new(10.0, 9.0, 1e4)];
    for (i, eye) in eyes.into_iter().enumerate() {
        for (kind, shift) in [
            ("vertices", [0.0, 0.0]),
            ("edges", [0.5, 0.0]),
            ("diagonals", [0.5, 0.5]),
            ("inside", [0.25, 0.5]),
        ] {
            let target =
                |k: usize| Vec3::new((k % 18 + 1) as f32 + shift[0], (k / 18 + 1) as f32 + shift[1], 0.0);
            let rays: Vec<Ray> = (0..18 * 18).map(|k| (eye, target(k) - eye, 0.0, f32::INFINITY)).collect();
            for (backend, built) in all(&meshes) {
                let lost = missed(&trace(&*built, &chunks(&rays)), rays.len());
                let allowed = if backend == "bvh" || kind == "inside" { 0 } else { rays.len() / 10 };
                assert!(lost <= allowed, "eye {i}, {kind}: {backend} lost {lost} of {}", rays.len());
            }
        }
    }
}

#[test]
fn axis_parallel_rays_and_origins_on_box_planes() {
    let mut rays = Vec::new();
    let axes = [Vec3::X, Vec3::Y, Vec3::Z];
    for axis in 0..3 {
        for zero in [0.0f32, -0.0] {
            for sign in [1.0, -1.0] {
                for k in 0..400 {
                    let mut d = Vec3::splat(zero);
                    d[axis] = sign;
                    // Through vertices, edges and middles of faces; starting outside, inside, and on a face.
                    let (i, j) = ((k % 20) as f32 * 0.5 - 0.25, (k / 20) as f32 * 0.5 - 0.25);
                    for start in [-3.0, 0.0, 4.0, 9.0, 12.0] {
                        let across = axes[(axis + 1) % 3] * i + axes[(axis + 2) % 3] * j;
                        rays.push((axes[axis] * start + across, d, 0.0, f32::INFINITY));
                    }
                }
            }
        }
    }
    let tally = agree("axis-parallel", &one(cube(9)), &rays);
    assert_eq!(tally.hit_miss, 0, "{tally:?}");
}
