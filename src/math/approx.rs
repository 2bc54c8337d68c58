//! Elementary functions with the same bits on every machine: plain additions and multiplications only.

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
}
