//! The sun: a disc at infinity.

use crate::math::{Frame, Rgb, Vec3, warp};
use std::f32::consts::TAU;

/// A disc of constant radiance, infinitely far away; rays that meet nothing else see it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Unit direction to its middle.
    pub direction: Vec3,
    /// Radiance of the disc.
    pub radiance: Rgb,
    /// Sine of its angular radius, in (0, 1).
    pub sin_radius: f32,
}

impl Sun {
    /// 1 − cos of the angular radius, as sin²/(1 + cos): the difference itself has no digits for a small disc.
    #[inline(always)]
    fn height(&self) -> f32 {
        let sin2 = self.sin_radius * self.sin_radius;
        sin2 / (1.0 + (1.0 - sin2).sqrt())
    }

    /// Solid angle of the disc.
    #[inline(always)]
    pub fn solid_angle(&self) -> f32 {
        TAU * self.height()
    }

    /// W/m² on a plane that faces it: π·L·sin².
    pub fn irradiance(&self) -> Rgb {
        self.radiance * (std::f32::consts::PI * self.sin_radius * self.sin_radius)
    }

    /// True when the unit direction `d` meets the disc.
    #[inline(always)]
    pub fn contains(&self, d: Vec3) -> bool {
        d.dot(self.direction) > 0.0
            && d.cross(self.direction).length_squared() <= self.sin_radius * self.sin_radius
    }

    /// A direction of the disc, uniform in solid angle.
    #[inline(always)]
    pub fn sample(&self, u: [f32; 2]) -> Vec3 {
        Frame::new(self.direction).to_world(warp::cap(u, self.height()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_fill_the_disc_and_no_more() {
        let sun = Sun { direction: Vec3::new(0.48, 0.6, -0.64), radiance: Rgb::ONE, sin_radius: 4.65e-3 };
        let exact = std::f64::consts::TAU * (1.0 - (1.0 - 4.65e-3f64 * 4.65e-3).sqrt());
        assert!((f64::from(sun.solid_angle()) / exact - 1.0).abs() < 1e-6);
        let mut half = 0;
        for i in 0..10_000 {
            let d = sun.sample([(i as f32 + 0.5) / 10_000.0, (i as f32 * 0.618_034).fract()]);
            let sin = d.cross(sun.direction).length();
            assert!(sin <= 1.0001 * sun.sin_radius, "{sin}");
            half += usize::from(sin < sun.sin_radius * 0.5f32.sqrt());
        }
        assert!((half as i32 - 5000).abs() < 5, "half of the area gets half of the samples: {half}");
        assert!(sun.contains(sun.direction) && !sun.contains(-sun.direction) && !sun.contains(Vec3::Y));
    }
}
