//! Daylight: Preetham, Shirley and Smits 1999, "A Practical Analytic Model for Daylight".
//!
//! The sky's luminance and chromaticity follow Perez' formula with the paper's coefficients (A.2). The sun is a black
//! body of 5772 K at its distance, dimmed on its way through the air as in A.1: by Rayleigh scattering, aerosol
//! (Ångström) and ozone. Water vapour and mixed gases, which absorb almost only beyond 690 nm, are left out. Photometric
//! values become radiometric by 179 lm/W, the efficacy of an even spectrum over the visible range, as in Radiance.

use crate::math::{DVec3, Rgb};
use std::f64::consts::PI;

/// Lumens a watt.
const EFFICACY: f64 = 179.0;
/// Sine of the sun's angular radius at one astronomical unit: 695,700 km over 149,597,871 km.
pub const SIN_SUN: f64 = 695_700.0 / 149_597_870.7;

/// A clear sky with a sun in it.
#[derive(Clone, Copy, Debug)]
pub struct Daylight {
    turbidity: f64,
    /// Angle of the sun from the zenith.
    theta: f64,
    /// Zenith luminance in kcd/m², zenith chromaticity x and y, each over Perez' value there.
    zenith: [f64; 3],
    /// Perez' A to E for luminance, x and y.
    perez: [[f64; 5]; 3],
}

impl Daylight {
    /// The sky of `turbidity` (2 clear … 10 hazy) with the sun `elevation` radians above the horizon, 0 to π/2.
    pub fn new(turbidity: f64, elevation: f64) -> Daylight {
        let (t, theta) = (turbidity, PI / 2.0 - elevation);
        let perez = [
            [
                0.1787 * t - 1.4630,
                -0.3554 * t + 0.4275,
                -0.0227 * t + 5.3251,
                0.1206 * t - 2.5771,
                -0.0670 * t + 0.3703,
            ],
            [
                -0.0193 * t - 0.2592,
                -0.0665 * t + 0.0008,
                -0.0004 * t + 0.2125,
                -0.0641 * t - 0.8989,
                -0.0033 * t + 0.0452,
            ],
            [
                -0.0167 * t - 0.2608,
                -0.0950 * t + 0.0092,
                -0.0079 * t + 0.2102,
                -0.0441 * t - 1.6537,
                -0.0109 * t + 0.0529,
            ],
        ];
        let chi = (4.0 / 9.0 - t / 120.0) * (PI - 2.0 * theta);
        let luminance = (4.0453 * t - 4.9710) * libm::tan(chi) - 0.2155 * t + 2.4192;
        let chromaticity = |m: [[f64; 4]; 3]| {
            let row = |r: [f64; 4]| ((r[0] * theta + r[1]) * theta + r[2]) * theta + r[3];
            (row(m[0]) * t + row(m[1])) * t + row(m[2])
        };
        let x = chromaticity([
            [0.00166, -0.00375, 0.00209, 0.0],
            [-0.02903, 0.06377, -0.03202, 0.00394],
            [0.11693, -0.21196, 0.06052, 0.25886],
        ]);
        let y = chromaticity([
            [0.00275, -0.00610, 0.00317, 0.0],
            [-0.04214, 0.08970, -0.04153, 0.00516],
            [0.15346, -0.26756, 0.06670, 0.26688],
        ]);
        let zenith = [luminance.max(0.0), x, y];
        let over = |i: usize| zenith[i] / formula(&perez[i], 1.0, theta);
        Daylight { turbidity, theta, zenith: [over(0), over(1), over(2)], perez }
    }

    /// Radiance from a direction whose angle from the zenith has the cosine `cos` (from the horizon where it is not
    /// positive), at the angle `gamma` from the sun.
    pub fn sky(&self, cos: f64, gamma: f64) -> Rgb {
        // At the horizon Perez' formula divides by 0; half a degree above it is the horizon of a picture.
        let cos = cos.max(0.01);
        let [luminance, x, y] = [0, 1, 2].map(|i| self.zenith[i] * formula(&self.perez[i], cos, gamma));
        let xyz = DVec3::new(x / y, 1.0, (1.0 - x - y) / y) * luminance.max(0.0);
        rgb(xyz * (1000.0 / EFFICACY))
    }

    /// Irradiance of the sun on a plane that faces it, below the air.
    pub fn sun(&self) -> Rgb {
        let degrees = self.theta.to_degrees();
        // Relative optical mass of the air.
        let mass = 1.0 / (libm::cos(self.theta) + 0.15 * libm::pow(93.885 - degrees, -1.253));
        let beta = 0.04608 * self.turbidity - 0.04586;
        let mut xyz = DVec3::ZERO;
        const STEP: f64 = 5.0;
        for nm in (0..80).map(|i| 382.5 + STEP * f64::from(i)) {
            let um = nm / 1000.0;
            let rayleigh = libm::exp(-0.008735 * mass * libm::pow(um, -4.08));
            let aerosol = libm::exp(-beta * mass * libm::pow(um, -1.3));
            let ozone = libm::exp(-ozone(nm) * 0.35 * mass);
            xyz +=
                observer(nm) * (black_body(nm) * PI * SIN_SUN * SIN_SUN * rayleigh * aerosol * ozone * STEP);
        }
        rgb(xyz * (683.0 / EFFICACY))
    }
}

/// Perez: (1 + A·exp(B/cos θ))·(1 + C·exp(D·γ) + E·cos²γ).
fn formula([a, b, c, d, e]: &[f64; 5], cos: f64, gamma: f64) -> f64 {
    let cos_gamma = libm::cos(gamma);
    (1.0 + a * libm::exp(b / cos)) * (1.0 + c * libm::exp(d * gamma) + e * cos_gamma * cos_gamma)
}

/// Planck's radiance of 5772 K in W/(m²·sr·nm).
fn black_body(nm: f64) -> f64 {
    let m = nm * 1e-9;
    let (c1, c2) = (1.191_042_97e-16, 1.438_776_88e-2);
    c1 / libm::pow(m, 5.0) / (libm::exp(c2 / (m * 5772.0)) - 1.0) * 1e-9
}

/// Absorption of ozone in 1/cm, every 50 nm from 400 nm, linear between: the Chappuis band.
fn ozone(nm: f64) -> f64 {
    const TABLE: [f64; 8] = [0.0, 0.003, 0.03, 0.085, 0.125, 0.067, 0.023, 0.01];
    let at = ((nm - 400.0) / 50.0).clamp(0.0, 6.999);
    let i = at as usize;
    TABLE[i] + (TABLE[i + 1] - TABLE[i]) * (at - i as f64)
}

/// The CIE 1931 colour-matching functions as sums of lobes (Wyman, Sloan and Shirley 2013).
fn observer(nm: f64) -> DVec3 {
    let lobe = |mean: f64, below: f64, above: f64| {
        let t = (nm - mean) / if nm < mean { below } else { above };
        libm::exp(-0.5 * t * t)
    };
    DVec3::new(
        1.056 * lobe(599.8, 37.9, 31.0) + 0.362 * lobe(442.0, 16.0, 26.7) - 0.065 * lobe(501.1, 20.4, 26.2),
        0.821 * lobe(568.8, 46.9, 40.5) + 0.286 * lobe(530.9, 16.3, 31.1),
        1.217 * lobe(437.0, 11.8, 36.0) + 0.681 * lobe(459.0, 26.0, 13.8),
    )
}

/// Linear Rec.709 of an XYZ colour; what lies outside is cut off.
fn rgb(c: DVec3) -> Rgb {
    DVec3::new(
        3.240_970 * c.x - 1.537_383 * c.y - 0.498_611 * c.z,
        -0.969_244 * c.x + 1.875_968 * c.y + 0.041_555 * c.z,
        0.055_630 * c.x - 0.203_977 * c.y + 1.056_972 * c.z,
    )
    .max(DVec3::ZERO)
    .as_vec3()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::luminance;

    /// Zenith luminances by the paper's formula, worked out by hand, and the sky's order of magnitude outdoors.
    #[test]
    fn the_zenith_is_as_bright_as_the_formula_says() {
        for (turbidity, degrees) in [(2.0f64, 60.0f64), (3.0, 30.0), (6.0, 80.0)] {
            let day = Daylight::new(turbidity, degrees.to_radians());
            let theta = (90.0 - degrees).to_radians();
            let chi = (4.0 / 9.0 - turbidity / 120.0) * (PI - 2.0 * theta);
            let kcd = (4.0453 * turbidity - 4.9710) * chi.tan() - 0.2155 * turbidity + 2.4192;
            let zenith = luminance(day.sky(1.0, theta));
            assert!(
                (f64::from(zenith) * EFFICACY / 1000.0 / kcd - 1.0).abs() < 1e-3,
                "{turbidity} {degrees}"
            );
            assert!((0.5..40.0).contains(&kcd), "{kcd}");
        }
    }

    /// A high sun in clear air: some 100 klx; low it is dim and red, and its disc has the right size.
    #[test]
    fn the_sun_is_bright_high_and_red_low() {
        let lux = |turbidity, degrees: f64| {
            let sun = Daylight::new(turbidity, degrees.to_radians()).sun();
            (f64::from(luminance(sun)) * EFFICACY, sun)
        };
        let (high, white) = lux(2.0, 80.0);
        assert!((90_000.0..120_000.0).contains(&high), "{high}");
        assert!(white.x > white.z && white.z > 0.6 * white.x, "{white}");
        let (low, red) = lux(3.0, 4.0);
        assert!((500.0..20_000.0).contains(&low), "{low}");
        assert!(red.x > 3.0 * red.z, "{red}");
        assert!(lux(6.0, 40.0).0 < lux(2.0, 40.0).0);
        assert!((SIN_SUN.asin().to_degrees() - 0.2665).abs() < 1e-3);
        // Without air: the solar constant of the illuminance, some 130 klx.
        let space: DVec3 =
            (0..80).map(|i| 382.5 + 5.0 * f64::from(i)).map(|nm| observer(nm) * black_body(nm)).sum();
        let space = space.y * PI * SIN_SUN * SIN_SUN * 5.0 * 683.0;
        assert!((125_000.0..138_000.0).contains(&space), "{space}");
    }

    #[test]
    fn skies_are_blue_and_brightest_at_the_sun() {
        let day = Daylight::new(2.5, 0.8);
        let zenith = day.sky(1.0, PI / 2.0 - 0.8);
        assert!(zenith.z > 1.3 * zenith.x, "{zenith}");
        let at = |gamma| luminance(day.sky(libm::sin(0.8), gamma));
        assert!(at(0.05) > 2.0 * at(0.5) && at(0.5) > at(1.2));
        for i in 0..100 {
            let c = day.sky(f64::from(i) / 100.0 - 0.3, f64::from(i) * 0.03);
            assert!(c.is_finite() && c.min_element() >= 0.0);
        }
    }
}
