//! Ten million rays from inside closed surfaces (`DRT_HEAVY_TESTS=1`; otherwise 200,000): none may get out. The
//! hierarchy loses none; Embree's losses are counted, printed (`--nocapture`) and bounded.

use super::*;

/// A closed surface, points inside, and the radius of a ball around each that is inside as well.
type Body = (&'static str, Mesh, Vec<Vec3>, f32);

fn bodies() -> Vec<Body> {
    let ring: Vec<Vec3> = (0..8).map(|i| Vec3::new((i as f32).cos(), 0.0, (i as f32).sin())).collect();
    let far = |p: Vec3| p + 1e6;
    // 1e6 away, an f32 is a multiple of 1/16: bodies must be large to be bodies.
    let large = |p: Vec3| p * 1e3 + 1e6;
    vec![
        ("sphere", uv_sphere(120), vec![Vec3::ZERO], 0.9),
        ("rough torus", rough(&torus(120), 0.003), ring, 0.3),
        ("cube on a grid", cube(40), vec![Vec3::splat(20.0)], 19.5),
        ("cube on a grid, 1e6 away", mapped(&cube(40), far), vec![Vec3::splat(1e6 + 20.0)], 19.0),
        ("sphere on a grid", mapped(&uv_sphere(60), |p| (p * 300.0).round()), vec![Vec3::ZERO], 250.0),
        ("sphere 1e6 away", mapped(&uv_sphere(60), large), vec![Vec3::splat(1e6)], 900.0),
    ]
}

/// At random, at corners, at points of edges; from anywhere inside, from one point, and from a grid's points.
fn rays(body: &Body, kind: usize, n: usize) -> Vec<Ray> {
    let (_, mesh, inside, radius) = body;
    let mut random = Random(500 + kind as u64);
    let ray = |i: usize| {
        let middle = inside[i % inside.len()];
        let o = match i % 4 {
            0 => middle,
            1 => (middle + random.ball() * *radius).round(),
            _ => middle + random.ball() * *radius,
        };
        // Rounding may have taken it out of a small body.
        let o = if (o - middle).length() < *radius { o } else { middle };
        let [a, b, _] = mesh.triangle(random.below(mesh.indices.len()));
        match kind {
            0 => (o, random.ball().normalize(), 0.0, f32::INFINITY),
            1 => towards(o, a),
            _ => towards(o, a.lerp(b, random.unit())),
        }
    };
    (0..n).map(ray).collect()
}

#[test]
fn nothing_gets_out_of_a_closed_surface() {
    const KINDS: [&str; 3] = ["random", "vertices", "edges"];
    let each = if effort() > 1 { 556_000 } else { 11_200 };
    let mut total = 0;
    for body in bodies() {
        let meshes = one(body.1.clone());
        let built: Vec<_> = Backend::ALL.iter().map(|backend| (*backend, build(*backend, &meshes))).collect();
        for (kind, name) in KINDS.iter().enumerate() {
            let rays = rays(&body, kind, each);
            let chunks = chunks(&rays);
            total += rays.len();
            for (backend, built) in &built {
                let lost = missed(&trace(&**built, &chunks), rays.len());
                println!("{:26} {name:9} {:7} lost {lost:6} of {}", body.0, backend.name(), rays.len());
                let allowed = if *backend == Backend::Bvh { 0 } else { [0, each / 20, each / 100][kind] };
                assert!(lost <= allowed, "{}, {name}: {} lost {lost}", body.0, backend.name());
            }
        }
    }
    println!("{total} rays");
}
