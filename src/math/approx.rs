//! Elementary functions with the same bits on every machine: plain additions and multiplications only
//! (division and square root are exact everywhere as well).

use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};

/// (sin 2πu, cos 2πu) for `u` in [0, 1], absolute error below 2e-7.
///
/// The angle is reduced to the nearest quarter turn, exact in f32, and the rest in [−π/4, π/4] goes through
/// the minimax polynomials of Cephes' `sinf` and `cosf` (Moshier 1989).
#[inline(always)]
pub fn sin_cos_turn(u: f32) -> (f32, f32) {
    let quarter = (4.0 * u + 0.5) as i32;
    let r = (u - 0.25 * quarter as f32) * std::f32::consts::TAU;
    let z = r * r;
    let s = ((-1.951_529_6e-4 * z + 8.332_161e-3) * z - 1.666_665_5e-1) * z * r + r;
    let c = ((2.443_315_7e-5 * z - 1.388_731_6e-3) * z + 4.166_664_6e-2) * z * z - 0.5 * z + 1.0;
    let (sin, cos) = if quarter & 1 == 0 { (s, c) } else { (c, s) };
    let sin = if quarter & 2 == 0 { sin } else { -sin };
    let cos = if (quarter + 1) & 2 == 0 { cos } else { -cos };
    (sin, cos)
}

/// arcsin x for |x| ≤ 1 (beyond it the end's value), relative error below 4e-7.
///
/// Cephes' `asinf` (Moshier 1989): a polynomial up to ½, and beyond it arcsin x = π/2 − 2·arcsin √((1−x)/2).
#[inline(always)]
pub fn asin(x: f32) -> f32 {
    let a = x.abs().min(1.0);
    let far = a > 0.5;
    let z = if far { 0.5 * (1.0 - a) } else { a * a };
    let r = if far { z.sqrt() } else { a };
    let p =
        (((4.216_32e-2 * z + 2.418_131e-2) * z + 4.547_002_6e-2) * z + 7.495_300_3e-2) * z + 1.666_675_2e-1;
    let near = p * z * r + r;
    (if far { FRAC_PI_2 - 2.0 * near } else { near }).copysign(x)
}

/// The angle of (x, y) from the x axis for y ≥ 0, in [0, π], relative error below 3e-7; 0 for (0, 0).
///
/// Cephes' `atanf` (Moshier 1989) on the smaller of the two ratios, reduced once more above tan 22.5°.
#[inline(always)]
pub fn angle(y: f32, x: f32) -> f32 {
    let a = x.abs();
    let (low, high) = (a.min(y), a.max(y));
    // The smaller over the larger is tan of at most 45°; (r − 1)/(r + 1) takes 45° off.
    let steep = low > 0.414_213_57 * high;
    let r = if steep { (low - high) / (low + high) } else { low / high.max(f32::MIN_POSITIVE) };
    let z = r * r;
    let p = ((8.053_744_4e-2 * z - 1.387_768_6e-1) * z + 1.997_771_1e-1) * z - 3.333_295e-1;
    let octant = p * z * r + r + if steep { FRAC_PI_4 } else { 0.0 };
    let quadrant = if y > a { FRAC_PI_2 - octant } else { octant };
    if x < 0.0 { PI - quadrant } else { quadrant }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sine_and_cosine_are_close_to_exact_everywhere() {
        for i in 0..=1_000_000u32 {
            let u = i as f32 / 1_000_000.0;
            let (s, c) = sin_cos_turn(u);
            let exact = f64::from(u) * std::f64::consts::TAU;
            assert!((f64::from(s) - exact.sin()).abs() < 2e-7, "sin at {u}");
            assert!((f64::from(c) - exact.cos()).abs() < 2e-7, "cos at {u}");
        }
    }

    #[test]
    fn inverse_functions_are_close_to_exact() {
        for i in -100_000..=100_000i32 {
            let x = i as f32 / 100_000.0;
            let exact = f64::from(x).asin();
            assert!((f64::from(asin(x)) - exact).abs() <= 4e-7 * exact.abs(), "asin {x}");
            let (y, x) = (f64::from(i.abs()) / 1e5, f64::from(i) / 3e4 * f64::from(i.signum() * (i % 7 - 3)));
            let (y, x) = (y as f32, x as f32);
            let exact = f64::from(y).atan2(f64::from(x));
            assert!((f64::from(angle(y, x)) - exact).abs() <= 3e-7 * exact, "angle {y} {x}");
        }
        assert_eq!([asin(2.0), asin(-1.0)], [FRAC_PI_2, -FRAC_PI_2]);
        assert_eq!(
            [angle(0.0, 0.0), angle(0.0, 1.0), angle(0.0, -1.0), angle(1.0, 0.0)],
            [0.0, 0.0, PI, FRAC_PI_2]
        );
    }
}
