//! The order of a rule: the slope of log error against log N, by least squares.

/// A fitted slope.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slope {
    /// The exponent of N: −½ for Monte Carlo.
    pub value: f64,
    /// Half the width of the 95 % confidence interval; `None` with two points, through which every line goes.
    pub half_width: Option<f64>,
    /// How many points it was fitted to.
    pub points: usize,
}

/// Student's t at 97.5 % for 1, 2, … degrees of freedom.
const STUDENT: [f64; 20] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131,
    2.120, 2.110, 2.101, 2.093, 2.086,
];

/// The slope through `points` (N, error), all of them positive; `None` with fewer than two different N.
///
/// With x = ln N and y = ln error: b = Σ(x−x̄)(y−ȳ)/Σ(x−x̄)², and its standard error from the residuals with
/// n − 2 degrees of freedom.
pub fn slope(points: &[(f64, f64)]) -> Option<Slope> {
    let logs: Vec<(f64, f64)> = points.iter().map(|(n, error)| (libm::log(*n), libm::log(*error))).collect();
    let count = logs.len() as f64;
    let mean_x = logs.iter().map(|p| p.0).sum::<f64>() / count;
    let mean_y = logs.iter().map(|p| p.1).sum::<f64>() / count;
    let spread: f64 = logs.iter().map(|p| (p.0 - mean_x) * (p.0 - mean_x)).sum();
    let common: f64 = logs.iter().map(|p| (p.0 - mean_x) * (p.1 - mean_y)).sum();
    let value = common / spread;
    if !value.is_finite() {
        return None;
    }
    let residual = |p: &(f64, f64)| (p.1 - mean_y) - value * (p.0 - mean_x);
    let squares: f64 = logs.iter().map(|p| residual(p) * residual(p)).sum();
    let half_width = logs.len().checked_sub(3).map(|row| {
        // Beyond the table t changes by less than 7 %, and the last row errs on the safe side.
        let t = STUDENT.get(row).or(STUDENT.last()).copied().unwrap_or(f64::NAN);
        t * (squares / (count - 2.0) / spread).sqrt()
    });
    Some(Slope { value, half_width, points: logs.len() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_power_law_is_found_exactly() {
        let points: Vec<(f64, f64)> =
            (0..6).map(|k| 4.0_f64.powi(k)).map(|n| (n, 3.0 * n.powf(-1.5))).collect();
        let slope = slope(&points).unwrap();
        assert!((slope.value + 1.5).abs() < 1e-14 && slope.half_width.unwrap() < 1e-13, "{slope:?}");
        assert_eq!(slope.points, 6);
    }

    /// Five points with residuals worked out by hand: x = 0 … 4 (ln N), y = 0, −1, −1, −2, −3.
    #[test]
    fn the_interval_is_students() {
        let points: Vec<(f64, f64)> = [0.0_f64, -1.0, -1.0, -2.0, -3.0]
            .iter()
            .zip(0..)
            .map(|(y, x)| (f64::from(x).exp(), y.exp()))
            .collect();
        let slope = slope(&points).unwrap();
        // Σ(x−x̄)² = 10, Σ(x−x̄)(y−ȳ) = −7, Σ residuals² = 5.2 − 4.9 = 0.3; t(3) = 3.182.
        assert!((slope.value + 0.7).abs() < 1e-14);
        assert!((slope.half_width.unwrap() - 3.182 * (0.3_f64 / 3.0 / 10.0).sqrt()).abs() < 1e-12);
    }

    #[test]
    fn too_few_points_are_said() {
        assert_eq!(slope(&[]), None);
        assert_eq!(slope(&[(4.0, 1.0)]), None);
        assert_eq!(slope(&[(4.0, 1.0), (4.0, 2.0)]), None);
        let two = slope(&[(1.0, 1.0), (4.0, 0.25)]).unwrap();
        assert!((two.value + 1.0).abs() < 1e-15 && two.half_width.is_none());
    }

    /// 95 of 100 intervals around lines with normal noise hold the true slope.
    #[test]
    fn the_interval_covers_the_truth() {
        use crate::quadrature::{Density, Gaussian, numbers};
        let noise = Gaussian::new(2.0, 1.0, 0.1).unwrap();
        let mut random = numbers(1, 1);
        let hits = (0..4000).filter(|_| {
            let point = |k: i32| {
                let log = -0.5 * f64::from(k) * 4.0_f64.ln() + noise.inverse(random()) - 1.0;
                (4.0_f64.powi(k), log.exp())
            };
            let slope = slope(&(0..5).map(point).collect::<Vec<_>>()).unwrap();
            (slope.value + 0.5).abs() <= slope.half_width.unwrap()
        });
        let share = hits.count() as f64 / 4000.0;
        assert!((share - 0.95).abs() < 0.015, "{share}");
    }
}
