//! The sRGB transfer function (IEC 61966-2-1), the same on every machine.

/// Encoded value in [0, 1] to linear.
pub fn srgb_to_linear(encoded: f64) -> f64 {
    if encoded <= 0.04045 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}

/// Linear value in [0, 1] to encoded.
pub fn linear_to_srgb(linear: f64) -> f64 {
    if linear <= 0.0031308 { linear * 12.92 } else { 1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055 }
}

#[cfg(test)]
mod tests {
    use super::{linear_to_srgb, srgb_to_linear};

    #[test]
    fn codes_have_their_known_linear_values() {
        for (code, linear) in
            [(128.0, 0.215861), (64.0, 0.0512695), (188.0, 0.502886), (0.0, 0.0), (255.0, 1.0)]
        {
            assert!((srgb_to_linear(code / 255.0) - linear).abs() < 1e-6, "{code}");
        }
    }

    #[test]
    fn the_two_directions_are_inverse() {
        for i in 0..=1000 {
            let encoded = f64::from(i) / 1000.0;
            assert!((linear_to_srgb(srgb_to_linear(encoded)) - encoded).abs() < 1e-6);
        }
    }
}
