//! The spot light.

use crate::math::{Rgb, Vec3};

/// A point that sends light into a cone; it cannot be hit, only sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spot {
    /// Where it is, in scene coordinates.
    pub position: Vec3,
    /// Unit direction of its axis, the way the light travels.
    pub direction: Vec3,
    /// W/sr on the axis.
    pub intensity: Rgb,
    /// Cosine of the cone's half angle; nothing is sent beyond.
    pub cos_outer: f32,
    /// Cosine of the angle up to which the intensity is that of the axis; at least `cos_outer`.
    pub cos_inner: f32,
}

impl Spot {
    /// W/sr in a direction whose angle from the axis has this cosine: between the two angles a smoothstep in the
    /// cosine, 3t² − 2t³.
    #[inline(always)]
    pub fn intensity_at(&self, cos: f32) -> Rgb {
        if cos >= self.cos_inner {
            return self.intensity;
        }
        let t = ((cos - self.cos_outer) / (self.cos_inner - self.cos_outer)).max(0.0);
        self.intensity * (t * t * (3.0 - 2.0 * t))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_edge_is_soft_between_the_two_angles_only() {
        let mut spot = Spot {
            position: Vec3::ZERO,
            direction: Vec3::Z,
            intensity: Rgb::splat(2.0),
            cos_outer: 0.5,
            cos_inner: 0.9,
        };
        let at = |spot: &Spot, cos| spot.intensity_at(cos).x;
        assert_eq!([1.0, 0.9, 0.7, 0.5, 0.4, -1.0].map(|c| at(&spot, c)), [2.0, 2.0, 1.0, 0.0, 0.0, 0.0]);
        spot.cos_inner = 0.5;
        assert_eq!([1.0, 0.5, 0.499].map(|c| at(&spot, c)), [2.0, 2.0, 0.0]);
    }
}
