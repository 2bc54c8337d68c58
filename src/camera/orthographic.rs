//! The orthographic camera: parallel rays that start on the plane through the eye.

use super::{Camera, CameraRay};

impl Camera {
    /// The ray through (α, β), both in metres.
    #[inline(always)]
    pub(super) fn orthographic_ray(&self, alpha: f32, beta: f32) -> CameraRay {
        CameraRay { o: self.eye + self.right * alpha + self.up * beta, d: self.forward }
    }
}
