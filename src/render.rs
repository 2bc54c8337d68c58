//! The render loop: tiles × blocks of samples in parallel, pass by pass, with progress and cancellation.

use crate::accel::{BuildOptions, Intersector};
use crate::error::Result;
use crate::film::Image;
use crate::math::isa::Isa;
use crate::scene::{Scene, Settings};

/// How far a phase is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress {
    /// Building the acceleration structure: share done, 0 to 1.
    Build(f64),
    /// Rendering: (pixel samples done, of how many).
    Render(u64, u64),
}

/// What the caller hears and says while work goes on. Called from several threads.
pub struct Hooks<'a> {
    /// Told now and then how far the work is.
    pub progress: &'a (dyn Fn(Progress) + Sync),
    /// Asked often; `true` ends the work: a build fails, a render stops after the tiles under way.
    pub stop: &'a (dyn Fn() -> bool + Sync),
}

impl Hooks<'_> {
    /// Hears nothing and never stops.
    pub const NONE: Hooks<'static> = Hooks { progress: &|_| (), stop: &|| false };
}

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

/// A rendered picture.
#[derive(Debug)]
pub struct Rendering {
    /// The picture, with its settings and the samples done.
    pub image: Image,
    /// What was counted.
    pub stats: RenderStats,
    /// False when it was stopped before the last sample.
    pub complete: bool,
}

/// Builds the acceleration structure that `settings` ask for. `isa`: pins the instruction set.
///
/// # Errors
/// Out of memory, a backend's own error, or [`crate::accel::cancelled`].
pub fn build(scene: &Scene, settings: &Settings, isa: Option<Isa>, hooks: &Hooks<'_>) -> Result<Box<dyn Intersector>> {
    let samples = u64::from(settings.size[0]) * u64::from(settings.size[1]) * u64::from(settings.spp);
    let progress = |share: f64| {
        (hooks.progress)(Progress::Build(share));
        !(hooks.stop)()
    };
    let options = BuildOptions {
        quality: settings.build.resolve(scene.triangles(), samples),
        compact: settings.compact,
        isa,
        progress: &progress,
    };
    settings.backend.build(&scene.meshes, &options)
}
