//! The panorama camera: all directions from one point, on a map like that of environment pictures.

use super::{Camera, CameraRay};
use crate::math::approx::sin_cos_turn;

impl Camera {
    /// The ray through (`x`, `y`) of the picture, both in [0, 1]: x goes round the up axis, y from above to below. The
    /// middle looks along the view; looking along +z with +y up, the picture is an environment map of what is there:
    /// x = atan2(dx, −dz)/2π mod 1, y = arccos(dy)/π.
    #[inline(always)]
    pub(super) fn panorama_ray(&self, x: f32, y: f32) -> CameraRay {
        let (s, c) = sin_cos_turn(x);
        let (sin, cos) = sin_cos_turn(0.5 * y);
        let d = self.right * (-sin * s) + self.up * cos + self.forward * (-sin * c);
        CameraRay { o: self.eye, d: d.normalize() }
    }
}
