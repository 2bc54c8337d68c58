//! Verdicts by hand: what is sound is called sound, what is not is refuted.

use super::*;

/// Two triangles of a square at z = 0, and one at z = −1 behind it.
fn square() -> Vec<Arc<Mesh>> {
    let positions = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, -1], [1, 0, -1], [1, 1, -1]];
    let positions = positions.map(|p| p.map(|x: i8| f32::from(x))).to_vec();
    vec![Arc::new(Mesh::new(positions, vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [0, 1, 2]]))]
}

/// Every class by a ray for which it is the answer.
#[test]
fn classes_are_what_the_geometry_says() {
    let court = Court::new(&square());
    let down = |x: f32, y: f32| (Vec3::new(x, y, 1.0), -Vec3::Z);
    let hit = |triangle: u32, t: f32, u: f32, v: f32| Some(Answer { t, u, v, mesh: 0, triangle });
    let judge = |(o, d): (Vec3, Vec3), tmax: f32, pair: [Option<Answer>; 2]| {
        let chunk = &aimed::chunks([(o, d, 0.0, tmax)].into_iter())[0];
        court.closest(&chunk.rays, 0, pair).map(|f| (f.class, f.wrong, f.leak))
    };
    let inf = f32::INFINITY;
    // Within the first triangle and its twin: (0.75, 0.25) is u = 0.5, v = 0.25.
    let (inside, front) = (down(0.75, 0.25), hit(0, 1.0, 0.5, 0.25));
    assert_eq!(judge(inside, inf, [front, front]), None);
    assert_eq!(judge(inside, inf, [front, hit(3, 1.0, 0.5, 0.25)]), Some((Class::Tie, [false; 2], false)));
    assert_eq!(judge(inside, inf, [front, None]), Some((Class::Real, [false, true], false)));
    assert_eq!(
        judge(inside, inf, [front, hit(2, 2.0, 0.5, 0.25)]),
        Some((Class::Real, [false, true], false))
    );
    assert_eq!(judge(inside, 0.5, [front, None]), Some((Class::Real, [true, false], false)));
    assert_eq!(judge(inside, 1.0, [front, None]), Some((Class::Tie, [false; 2], false)));
    assert_eq!(judge(inside, inf, [hit(9, 1.0, 0.5, 0.25), None]), Some((Class::Real, [true, true], false)));
    // The diagonal: a surface on all sides, so that a miss is a leak; the border: none.
    let diagonal = hit(0, 1.0, 0.0, 0.5);
    assert_eq!(
        judge(down(0.5, 0.5), inf, [diagonal, hit(1, 1.0, 0.5, 0.0)]),
        Some((Class::Edge, [false; 2], false))
    );
    assert_eq!(judge(down(0.5, 0.5), inf, [diagonal, None]), Some((Class::Edge, [false; 2], true)));
    assert_eq!(
        judge(down(0.5, 0.0), inf, [hit(0, 1.0, 0.5, 0.0), None]),
        Some((Class::Edge, [false; 2], false))
    );
    assert_eq!(
        judge(down(1.0, 0.0), inf, [hit(0, 1.0, 1.0, 0.0), None]),
        Some((Class::Vertex, [false; 2], false))
    );
    let along = (Vec3::new(-1.0, 0.25, 1e-7), Vec3::X);
    assert_eq!(judge(along, inf, [hit(0, 1.5, 0.25, 0.25), None]), Some((Class::Graze, [false; 2], false)));
    let needle = Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.5, 1e-7, 0.0]], vec![[0, 1, 2]]);
    let chunk = &aimed::chunks([(Vec3::new(0.4, 0.0, 1.0), -Vec3::Z, 0.0, inf)].into_iter())[0];
    let sliver = Court::new(&[Arc::new(needle)]).closest(&chunk.rays, 0, [hit(0, 1.0, 0.4, 0.0), None]);
    assert_eq!(sliver.map(|f| f.class), Some(Class::Sliver));
}

/// Past the tip of a triangle of 6 m by 21.8 ε·W and past an edge by 16.7, which is a degree from the ray's direction:
/// Embree meets it. The same misses of a triangle that is seen from the front are wrong.
#[test]
fn edges_along_the_ray_leave_more_of_a_choice() {
    let corners = [[12.956, 12.0926, 16.4147], [12.9472, 12.0982, 16.4034], [17.956, 14.0926, 13.4769]];
    let court = Court::new(&[Arc::new(Mesh::new(corners.to_vec(), vec![[0, 1, 2]]))]);
    let judge = |(o, d): (Vec3, Vec3), pair: [bool; 2]| {
        let chunk = &aimed::chunks([(o, d, 0.0, f32::INFINITY)].into_iter())[0];
        court.blocked(&chunk.rays, 0, pair).map(|f| (f.class, f.wrong))
    };
    let o = Vec3::new(40.790_42, 23.224_88, 0.048_531_532);
    let d = Vec3::new(-0.209_514_62, -0.083_791_17, 0.123_210_02);
    assert_eq!(judge((o, d), [false, true]), Some((Class::Graze, [false; 2])));
    let [a, b, c] = corners.map(Vec3::from);
    let normal = (b - a).cross(c - a).normalize();
    let (front, past) = ((a + c) * 0.5 + normal * 30.0, (c - a).cross(normal).normalize() * -1.2e-4);
    let past = if past.dot(b - a) > 0.0 { -past } else { past };
    assert_eq!(judge((front + past, -normal), [false, true]), Some((Class::Real, [false, true])));
}

/// Settling moves a ray at an edge across by some tens of roundings; the hit is then one of the moved ray.
#[test]
fn settled_hits_stand_and_wrong_distances_do_not() {
    let steep = Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 4.0]], vec![[0, 1, 2]]);
    let court = Court::new(&[Arc::new(steep)]);
    let chunk = &aimed::chunks([(Vec3::new(0.25, 0.0, 5.0), -Vec3::Z, 0.0, f32::INFINITY)].into_iter())[0];
    let judge = |moved: f32, t: f32| {
        let answer = Answer { t, u: 0.25, v: moved, mesh: 0, triangle: 0 };
        court.closest(&chunk.rays, 0, [Some(answer), None]).map(|f| (f.class, f.wrong))
    };
    // ε·W is 6e-7: moved by a hundred of them, up the slope of 4.
    assert_eq!(judge(6e-5, 5.0 - 2.4e-4), Some((Class::Edge, [false; 2])));
    assert_eq!(judge(6e-5, 5.0 + 2.4e-4), Some((Class::Real, [true, false])));
    assert_eq!(judge(6e-4, 5.0 - 2.4e-3), Some((Class::Real, [true, false])));
}

#[test]
fn shadow_rays_are_judged_by_what_is_in_their_way() {
    let court = Court::new(&square());
    let judge = |x: f32, tmax: f32, pair: [bool; 2]| {
        let chunk = &aimed::chunks([(Vec3::new(x, 0.25, 1.0), -Vec3::Z, 0.0, tmax)].into_iter())[0];
        court.blocked(&chunk.rays, 0, pair).map(|f| (f.class, f.wrong))
    };
    assert_eq!(judge(0.75, 3.0, [true, true]), None);
    assert_eq!(judge(0.75, 3.0, [true, false]), Some((Class::Real, [false, true])));
    assert_eq!(judge(0.75, 0.5, [true, false]), Some((Class::Real, [true, false])));
    assert_eq!(judge(0.75, 1.0, [true, false]), Some((Class::Tie, [false; 2])));
    assert_eq!(judge(1.0, 3.0, [false, true]), Some((Class::Edge, [false; 2])));
    assert_eq!(judge(1.5, 3.0, [false, true]), Some((Class::Real, [false, true])));
}

/// Needles in all directions: what the scan cuts in pieces.
fn askew() -> Mesh {
    let mut random = crate::quadrature::numbers(3, 0);
    let mut point = |size: f64| Vec3::from_array([0; 3].map(|_| ((random() - 0.5) * size) as f32));
    let triangle = |_| {
        let (a, along) = (point(4.0), point(4.0));
        [a, a + along + point(0.01), a + along * 0.3 + point(0.02)].map(|p| p.to_array())
    };
    let positions: Vec<[f32; 3]> = (0..200).flat_map(triangle).collect();
    Mesh::new(positions, (0..200).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

/// The scan leaves nothing out: it finds what looking at every triangle finds.
#[test]
fn the_scan_finds_what_every_triangle_says() {
    let (mut scene, _) = scene();
    scene.meshes.push(Arc::new(askew()));
    let brute = crate::accel::brute::Brute::new(&scene.meshes);
    let court = Court::new(&scene.meshes);
    for kind in aimed::KINDS {
        let set = aimed::rays(&scene, kind, 400, 5);
        for chunk in &set.chunks {
            for lane in (0..LANES).filter(|&lane| chunk.mask >> lane & 1 == 1) {
                let ray = crate::accel::brute::Ray64::of(&chunk.rays, lane);
                let slack = crate::accel::judge::ACROSS * f64::from(f32::EPSILON) * 1e-3;
                let mut all = brute.hits_within(&ray, f64::NEG_INFINITY, f64::INFINITY, slack);
                let near: Vec<[u32; 2]> =
                    court.scan().near(&ray).iter().map(|n| [n.mesh, n.triangle]).collect();
                all.retain(|(_, mesh, triangle)| !near.contains(&[*mesh, *triangle]));
                assert!(all.is_empty(), "{}: {all:?}", kind.name());
            }
        }
    }
}

/// A triangle seen edge-on is met where its outline is, and nowhere else in its plane.
#[test]
fn edge_on_hits_stand_on_their_outline_only() {
    let court = Court::new(&square());
    let judge = |y: f32, t: f32, tmax: f32| {
        let o = Vec3::new(-1.0, y, 1e-7);
        let chunk = &aimed::chunks([(o, Vec3::X, 0.0, tmax)].into_iter())[0];
        let answer = Answer { t, u: 0.25, v: 0.25, mesh: 0, triangle: 0 };
        court.closest(&chunk.rays, 0, [Some(answer), None]).map(|f| (f.class, f.wrong))
    };
    let inf = f32::INFINITY;
    for (y, t, tmax) in [(0.25, 1.5, inf), (0.25, 1.0, inf), (0.25, 2.0, 2.0)] {
        assert_eq!(judge(y, t, tmax), Some((Class::Graze, [false; 2])), "{y} {t}");
    }
    for (y, t, tmax) in [(0.25, 0.9, inf), (0.25, 2.1, inf), (3.0, 1.5, inf), (0.25, 1.5, 1.2)] {
        assert_eq!(judge(y, t, tmax), Some((Class::Real, [true, false])), "{y} {t}");
    }
}
