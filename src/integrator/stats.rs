//! What waves count.

/// What a render counted.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RenderStats {
    /// Rays from the camera.
    pub camera_rays: u64,
    /// Rays that extend a path.
    pub bounce_rays: u64,
    /// Rays that ask whether a light is visible.
    pub shadow_rays: u64,
    /// Rays that the gate in front of the backend refused (not finite).
    pub rejected_rays: u64,
    /// Samples dropped because they were NaN, infinite or negative.
    pub invalid_samples: u64,
    /// Thread seconds inside the intersector.
    pub intersect_seconds: f64,
    /// Thread seconds in shading: surfaces, materials, lights, sampling.
    pub shade_seconds: f64,
    /// Thread seconds in the rest of the waves: camera rays, film.
    pub rest_seconds: f64,
}

impl RenderStats {
    /// The sums of both.
    #[must_use]
    pub fn plus(&self, other: &RenderStats) -> RenderStats {
        RenderStats {
            camera_rays: self.camera_rays + other.camera_rays,
            bounce_rays: self.bounce_rays + other.bounce_rays,
            shadow_rays: self.shadow_rays + other.shadow_rays,
            rejected_rays: self.rejected_rays + other.rejected_rays,
            invalid_samples: self.invalid_samples + other.invalid_samples,
            intersect_seconds: self.intersect_seconds + other.intersect_seconds,
            shade_seconds: self.shade_seconds + other.shade_seconds,
            rest_seconds: self.rest_seconds + other.rest_seconds,
        }
    }
}
