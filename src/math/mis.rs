//! Multiple importance sampling weights (Veach 1997, chapter 9).

/// Power heuristic with exponent 2 for one sample of each of two techniques: the weight of the one with
/// density `a`. An infinite density (a delta) wins; zero against zero is zero.
#[inline(always)]
pub fn power(a: f32, b: f32) -> f32 {
    if a <= 0.0 {
        return 0.0;
    }
    // b/a first: a² would overflow for densities above 1.8e19.
    let ratio = b / a;
    1.0 / (1.0 + ratio * ratio)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_of_the_two_techniques_add_up_to_one() {
        for (a, b) in [(1.0, 1.0), (0.1, 7.0), (1e-20, 1e20), (3e30, 1e25)] {
            assert!((power(a, b) + power(b, a) - 1.0).abs() < 1e-6, "{a} {b}");
        }
        assert_eq!(power(f32::INFINITY, 2.0), 1.0);
        assert_eq!(power(0.0, 0.0), 0.0);
        assert_eq!(power(2.0, f32::INFINITY), 0.0);
    }
}
