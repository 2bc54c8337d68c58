//! The perspective camera: a pinhole, or a thin lens.

use super::{Camera, CameraRay};
use crate::math::Vec3;

impl Camera {
    /// p = (α, β, f), from the eye.
    #[inline(always)]
    pub(super) fn through(&self, alpha: f32, beta: f32) -> Vec3 {
        self.right * alpha + self.up * beta + self.forward * self.distance
    }

    /// The notes' eq. (5), d = (p − e)/‖p − e‖, with p = (α, β, f) in camera coordinates. Rays start at the
    /// eye, not on the image plane, so that nothing nearer than f is lost. With a lens, the ray goes from a
    /// point of it through the point in focus.
    #[inline(always)]
    pub(super) fn perspective_ray(&self, alpha: f32, beta: f32, lens: [f32; 2]) -> CameraRay {
        let p = self.through(alpha, beta);
        if self.aperture.radius <= 0.0 {
            return CameraRay { o: self.eye, d: p.normalize() };
        }
        let on_lens = self.aperture.point(lens);
        let shift = self.right * on_lens.x + self.up * on_lens.y;
        let in_focus = p * (self.focus_distance / self.distance);
        CameraRay { o: self.eye + shift, d: (in_focus - shift).normalize() }
    }
}
