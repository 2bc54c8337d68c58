use super::*;
use crate::film::Filter;

fn points(rule: PixelRule, filter: &str) -> PixelPoints {
    PixelPoints::new(rule, FilterSampler::new(Filter::from_name(filter).unwrap())).unwrap()
}

/// A well-spread point of the unit square for rules that leave a choice.
fn u(i: u32) -> [f32; 2] {
    [0.754_877_7, 0.569_840_3].map(|a: f64| ((0.5 + a * f64::from(i + 1)).fract() as f32).min(0.999_999_9))
}

/// (mean weight, mean of f·weight) over the points of a rule.
fn mean(points: &PixelPoints, n: u32, f: impl Fn([f64; 2]) -> f64) -> (f64, f64) {
    let (mut weights, mut sum) = (0.0, 0.0);
    for i in 0..n {
        let p = points.point(i, u(i));
        weights += f64::from(p.weight);
        sum += f64::from(p.weight) * f(p.offset.map(f64::from));
    }
    (weights / f64::from(n), sum / f64::from(n))
}

/// Every rule under every filter has the filter's mean of a polynomial as its limit.
#[test]
fn every_rule_converges_under_every_filter() {
    let f = |[x, y]: [f64; 2]| 1.0 + x - 0.5 * y + x * x + 0.3 * x * y;
    for (name, rule) in PixelRule::TABLE.iter().map(|row| (row.0, row.2)) {
        for per_cell in [0, 2] {
            let grid = Grid { cells: [180, 150], per_cell };
            for (filter_name, _) in Filter::NAMES {
                let filter = Filter::from_name(filter_name).unwrap();
                let r = f64::from(filter.radius());
                let steps = 20_000;
                let at = |i: usize| r * (2.0 * (i as f64 + 0.5) / steps as f64 - 1.0);
                let moment = |k: i32| (0..steps).map(|i| filter.profile(at(i)) * at(i).powi(k)).sum::<f64>();
                let exact = 1.0 + moment(2) / moment(0);
                let rule = rule.over(grid);
                let n = rule.grid().map_or(60_000, |g| g.points() as u32);
                let points = points(rule, filter_name);
                let (weight, mut value) = mean(&points, n, f);
                if points.is_signed() {
                    value /= weight; // as the film does
                }
                // The left edges are half a cell off: x and −y/2 by r/180 and r/150.
                let shift = if name == "uniform-corner" { -r / 180.0 + 0.5 * r / 150.0 } else { 0.0 };
                // A whole cell takes the sign of its middle.
                let signs = if points.is_signed() { 2e-2 } else { 1e-3 };
                assert!((weight - 1.0).abs() < signs, "{name} {filter_name}: mean weight {weight}");
                assert!(
                    (value - exact - shift).abs() < 6e-3 * r * r,
                    "{name} {filter_name}: {value}, not {exact}"
                );
            }
        }
    }
}

/// Eq. (12)–(14) by hand: M×N points, the first on the pixel's upper left corner, all of the same weight.
#[test]
fn the_corner_grid_starts_at_the_corner() {
    let points = points(PixelRule::UniformCorner(Grid { cells: [4, 3], per_cell: 0 }), "box");
    let all: Vec<PixelPoint> = (0..12).map(|i| points.point(i, [0.9; 2])).collect();
    assert_eq!(all[0].offset, [-0.5, -0.5]);
    assert_eq!(all[1].offset, [-0.25, -0.5]);
    assert!((all[11].offset[0] - 0.25).abs() < 1e-7 && (all[11].offset[1] - 1.0 / 6.0).abs() < 1e-7);
    assert!(all.iter().all(|p| p.weight == 1.0));
}

/// 13.8: under the box, importance sampling is simple Monte Carlo, bit for bit.
#[test]
fn importance_with_a_constant_density_is_simple_monte_carlo() {
    let (random, importance) = (points(PixelRule::Random, "box"), points(PixelRule::Importance, "box"));
    assert_eq!(random.numbers(), importance.numbers());
    assert!((0..1000).all(|i| random.point(i, u(i)) == importance.point(i, u(i))));
}

/// Every cell of a stratified or jittered rule gets J points, and regions cover the support.
#[test]
fn cells_get_their_points() {
    let grid = Grid { cells: [5, 3], per_cell: 4 };
    for rule in [PixelRule::Stratified(grid), PixelRule::Nonuniform(grid)] {
        for filter in ["box", "gaussian"] {
            let points = points(rule, filter);
            let quantile = |k: u32, n: u32| match rule {
                PixelRule::Nonuniform(_) => points.filter.offset(k as f32 / n as f32),
                _ => (2.0 * k as f32 / n as f32 - 1.0) * points.filter.radius(),
            };
            let mut counts = [0; 15];
            for i in 0..60 {
                let [x, y] = points.point(i, u(i)).offset;
                let column = (1..5).filter(|k| x >= quantile(*k, 5)).count();
                let row = (1..3).filter(|k| y >= quantile(*k, 3)).count();
                counts[5 * row + column] += 1;
            }
            assert_eq!(counts, [4; 15], "{} {filter}", rule.name());
        }
    }
}

/// A filter with negative lobes divides by the sum of the weights: a constant stays what it is on every grid that has
/// a sum, and a grid without one is refused.
#[test]
fn grids_under_a_signed_filter_keep_constants() {
    for (m, n) in [(2, 2), (5, 2), (4, 2), (6, 2), (7, 3), (16, 16)] {
        for rule in [PixelRule::Uniform, PixelRule::Nonuniform] {
            let points = points(rule(Grid { cells: [m, n], per_cell: 0 }), "mitchell");
            let (weight, _) = mean(&points, m * n, |_| 1.0);
            assert!((weight - 1.0).abs() < 1e-5, "{m}×{n}: {weight}");
        }
    }
    let corner = PixelRule::UniformCorner(Grid { cells: [1, 1], per_cell: 0 });
    let mitchell = FilterSampler::new(Filter::from_name("mitchell").unwrap());
    assert!(PixelPoints::new(corner, mitchell).is_err());
}

/// Several points at once are what each is by itself.
#[test]
fn points_are_those_of_their_lanes() {
    for (name, rule) in PixelRule::TABLE.iter().map(|row| (row.0, row.2)) {
        for (filter, _) in Filter::NAMES {
            let points = points(rule.over(Grid { cells: [3, 2], per_cell: 1 }), filter);
            let indices: [u32; 16] = std::array::from_fn(|i| 3 * i as u32);
            let us = [0, 1].map(|k| indices.map(|i| u(i)[k]));
            let (offsets, weights) = points.points(&indices, &us);
            for lane in 0..16 {
                let one = points.point(indices[lane], [us[0][lane], us[1][lane]]);
                assert_eq!([offsets[0][lane], offsets[1][lane]], one.offset, "{name} {filter}");
                assert_eq!(weights[lane], one.weight, "{name} {filter}");
            }
        }
    }
}
