use super::*;
use proptest::prelude::*;

fn split(points: &[DVec3]) -> Vec<[u32; 3]> {
    let mut t = Triangulator { points: points.to_vec(), ..Default::default() };
    t.split().unwrap().to_vec()
}

fn on_plane(points: impl IntoIterator<Item = (f64, f64)>) -> Vec<DVec3> {
    points.into_iter().map(|(x, y)| DVec3::new(x, 2.0 * x - 3.0 * y, y)).collect()
}

/// Sum of the triangles' absolute areas over the polygon's area: 1 exactly when none overlaps or is turned.
fn area_ratio(points: &[DVec3]) -> f64 {
    let triangles = split(points);
    assert_eq!(triangles.len(), points.len() - 2);
    let at = |i: u32| points[i as usize];
    let sum: f64 = triangles.iter().map(|&[a, b, c]| (at(b) - at(a)).cross(at(c) - at(a)).length()).sum();
    sum / newell_normal(points).length()
}

/// Every edge of the polygon is an edge of just one triangle, in its direction; inner edges are paired.
fn check_edges(points: usize, triangles: &[[u32; 3]]) {
    let mut edges = std::collections::BTreeMap::new();
    for &[a, b, c] in triangles {
        for (from, to) in [(a, b), (b, c), (c, a)] {
            *edges.entry((from, to)).or_insert(0) += 1;
            *edges.entry((to, from)).or_insert(0) -= 1;
        }
    }
    for ((from, to), count) in edges {
        let outer = (from + 1) % points as u32 == to;
        let inner = (to + 1) % points as u32 == from;
        assert_eq!(count, i32::from(outer) - i32::from(inner), "{from}-{to}");
    }
}

#[test]
fn a10_simple_polygons_keep_their_area() {
    let l = vec![(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)];
    let collinear =
        vec![(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (3.0, 0.0), (3.0, 2.0), (1.5, 2.0), (0.0, 2.0), (0.0, 1.0)];
    let comb: Vec<(f64, f64)> = (0..200)
        .map(|i| (f64::from(i / 2), if i % 4 < 2 { 0.0 } else { 10.0 }))
        .chain([(100.0, -1.0), (0.0, -1.0)])
        .collect();
    let spiral: Vec<(f64, f64)> = (0..300)
        .map(|i| (f64::from(i) * 0.1, 1.0 + f64::from(i) * 0.02))
        .chain((0..300).rev().map(|i| (f64::from(i) * 0.1, 0.9 + f64::from(i) * 0.02)))
        .map(|(a, r)| (r * a.cos(), r * a.sin()))
        .collect();
    let duplicates = vec![(0.0, 0.0), (0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (4.0, 4.0), (2.0, 1.0), (0.0, 4.0)];
    // An outer square joined to a hole by a bridge that is walked twice.
    let hole = vec![
        (0.0, 0.0),
        (4.0, 0.0),
        (4.0, 4.0),
        (0.0, 4.0),
        (0.0, 0.0),
        (1.0, 1.0),
        (1.0, 3.0),
        (3.0, 3.0),
        (3.0, 1.0),
        (1.0, 1.0),
    ];
    for polygon in [l, collinear, comb, spiral, duplicates, hole] {
        let n = polygon.len();
        for start in 0..n {
            let mut turned = polygon.clone();
            turned.rotate_left(start);
            let points = on_plane(turned);
            assert!((area_ratio(&points) - 1.0).abs() < 1e-9, "{n} from {start}: {}", area_ratio(&points));
            check_edges(n, &split(&points));
            let backwards: Vec<_> = points.into_iter().rev().collect();
            assert!((area_ratio(&backwards) - 1.0).abs() < 1e-9, "{n} backwards from {start}");
        }
    }
}

#[test]
fn a10_collinear_corners_make_no_triangle_without_area() {
    // A triangle fan from corner 0 would have made some: T-junctions, through which light leaks.
    let points = on_plane([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 2.0), (0.0, 2.0)]);
    for [a, b, c] in split(&points).into_iter().map(|t| t.map(|i| points[i as usize])) {
        assert!((b - a).cross(c - a).length() > 0.1);
    }
    let quad = on_plane([(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (0.0, 2.0)]);
    assert!(split(&quad).into_iter().all(|t| t != [0, 1, 2]));
}

#[test]
fn only_polygons_that_go_around_once_are_convex() {
    let convex = |turns: f64| {
        let points = on_plane((0..5).map(|i| (f64::from(i) * turns * std::f64::consts::TAU / 5.0).sin_cos()));
        let mut t = Triangulator { points, ..Default::default() };
        t.flatten().unwrap() && t.strictly_convex()
    };
    assert!(convex(1.0));
    assert!(!convex(2.0), "a pentagram");
}

#[test]
fn a10_self_crossing_and_degenerate_polygons_end() {
    let pentagram = on_plane((0..5).map(|i| (f64::from(i) * 4.0 * std::f64::consts::PI / 5.0).sin_cos()));
    check_edges(5, &split(&pentagram));
    for points in [vec![DVec3::ZERO; 9], on_plane((0..50).map(|i| (f64::from(i % 7), 0.0)))] {
        assert_eq!(split(&points).len(), points.len() - 2);
    }
    let huge = on_plane([(0.0, 0.0), (1e18, 0.0), (1e18, 1e18), (1e17, 1e17), (0.0, 1e18)]);
    assert_eq!(split(&huge).len(), 3);
}

#[test]
fn a10_a_million_corners() {
    // Rounded to six digits, as exporters write it: neither convex nor free of duplicates.
    let n = 1_000_000;
    let circle: Vec<DVec3> = (0..n)
        .map(|i| f64::from(i) * std::f64::consts::TAU / f64::from(n))
        .map(|a| DVec3::new((a.cos() * 1e6).round() / 1e6, (a.sin() * 1e6).round() / 1e6, 0.0))
        .collect();
    let ratio = area_ratio(&circle);
    assert!((ratio - 1.0).abs() < 1e-5, "{ratio}");
    let noise: Vec<DVec3> = (0..200_000u64)
        .map(|i| DVec3::new((i * 7919 % 10007) as f64, (i * 104_729 % 9973) as f64, (i % 3) as f64))
        .collect();
    assert_eq!(split(&noise).len(), noise.len() - 2);
}

proptest! {
    /// Star-shaped polygons are simple, whatever the radii.
    #[test]
    fn a10_random_star_shapes(radii in proptest::collection::vec(0.1f64..1.0, 4..120), turn in 0.0f64..6.0) {
        let n = radii.len() as f64;
        let points = on_plane(radii.iter().enumerate().map(|(i, r)| {
            let (sin, cos) = (turn + i as f64 * std::f64::consts::TAU / n).sin_cos();
            (r * cos, r * sin)
        }));
        // A corner may see more than half a turn only below five corners.
        prop_assume!(radii.len() > 4);
        prop_assert!((area_ratio(&points) - 1.0).abs() < 1e-9);
        check_edges(points.len(), &split(&points));
    }

    #[test]
    fn a10_any_points_end(points in proptest::collection::vec((-3i32..3, -3i32..3, -1i32..1), 3..60)) {
        let points: Vec<_> = points.into_iter().map(|(x, y, z)| DVec3::new(x.into(), y.into(), z.into())).collect();
        check_edges(points.len(), &split(&points));
        prop_assert_eq!(split(&points).len(), points.len() - 2);
    }
}
