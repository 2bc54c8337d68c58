//! A scene becomes a picture: [`build`] an acceleration structure, [`render`] with it, [`render_kept`] to go on after an
//! interruption. With progress and cancellation.

mod keep;
mod picture;
mod record;

pub use crate::integrator::RenderStats;
pub use keep::Keep;

use crate::accel::{Backend, BuildOptions, Intersector};
use crate::camera::Camera;
use crate::checkpoint::Checkpoint;
use crate::error::{Error, Result};
use crate::film::Image;
use crate::integrator::{Ao, Distribution, Normals, Path};
use crate::light::Light;
use crate::load::cache::Cache;
use crate::math::isa::Isa;
use crate::scene::{Compact, IntegratorKind, Scene, Settings};
use picture::Picture;

/// How far a phase is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Progress {
    /// Building the acceleration structure: share done, 0 to 1.
    Build(f64),
    /// Rendering.
    Render {
        /// Pixel samples done.
        done: u64,
        /// Pixel samples to do.
        total: u64,
        /// Share of the work done, 0 to 1; samples cost more or less.
        share: f64,
    },
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

/// A rendered picture.
#[derive(Debug)]
pub struct Rendering {
    /// The picture, with its settings and the samples done.
    pub image: Image,
    /// What was counted; of a render that went on from a checkpoint, since then.
    pub stats: RenderStats,
    /// Samples of a pixel, in the mean.
    pub samples: f64,
    /// False when it was stopped before the last sample.
    pub complete: bool,
}

/// Builds the acceleration structure that `settings` ask for. `isa`: pins the instruction set.
///
/// # Errors
/// Out of memory, coordinates beyond the backend's range, its own error, or [`crate::accel::cancelled`].
pub fn build(
    scene: &Scene,
    settings: &Settings,
    isa: Option<Isa>,
    hooks: &Hooks<'_>,
) -> Result<Box<dyn Intersector>> {
    build_through(None, scene, settings, isa, hooks)
}

/// As [`build`]; a structure that `cache` has is taken from there.
///
/// # Errors
/// As [`build`].
pub fn build_through(
    cache: Option<&Cache>,
    scene: &Scene,
    settings: &Settings,
    isa: Option<Isa>,
    hooks: &Hooks<'_>,
) -> Result<Box<dyn Intersector>> {
    let progress = |share: f64| {
        (hooks.progress)(Progress::Build(share));
        !(hooks.stop)()
    };
    let options = BuildOptions {
        quality: settings.quality(scene.triangles()),
        compact: settings.compact.resolve(|| settings.backend.is_memory_short(scene.triangles())),
        isa,
        threads: rayon::current_num_threads(),
        progress: &progress,
    };
    settings.backend.check_range(&scene.meshes)?;
    settings.backend.check_range(&scene.instances.meshes)?;
    let rests = scene.instances.places.is_empty();
    match cache.filter(|_| rests && settings.backend == Backend::Bvh) {
        Some(cache) => Ok(Box::new(cache.bvh(&scene.meshes, &options)?)),
        None => settings.backend.build_all(&scene.geometry(), &options),
    }
}

/// The settings that a whole picture of `scene` will tell, as JSON.
pub fn attribute(scene: &Scene, settings: &Settings, accel: &dyn Intersector) -> String {
    record::attribute(settings, scene, accel, (settings.spp, settings.spp))
}

/// Renders `scene` with a structure that [`build`] made.
///
/// # Errors
/// A camera that cannot be, more directions than can be followed, a grid of pixel points that `spp` does not
/// fit, or not enough memory for the film.
pub fn render(
    scene: &Scene,
    settings: &Settings,
    accel: &dyn Intersector,
    isa: Option<Isa>,
    hooks: &Hooks<'_>,
) -> Result<Rendering> {
    render_kept(scene, settings, accel, isa, hooks, None)
}

/// As [`render`], with progress kept on disk, and going on from what was kept there before.
///
/// # Errors
/// Besides those of [`render`]: a checkpoint of another render, or of one whose points depend on the number of samples
/// where that is another now; stopped before the first sample ([`crate::load::cancelled`]).
pub fn render_kept(
    scene: &Scene,
    settings: &Settings,
    accel: &dyn Intersector,
    isa: Option<Isa>,
    hooks: &Hooks<'_>,
    keep: Option<&Keep<'_>>,
) -> Result<Rendering> {
    let max_depth = settings.max_depth;
    let path = |max_depth| Path { max_depth, lights: settings.lights, roulette: settings.roulette };
    let job = Picture { scene, settings, accel, isa: isa.unwrap_or(Isa::best()), hooks, keep };
    match settings.integrator {
        IntegratorKind::Path => job.render(&path(max_depth)),
        IntegratorKind::Direct => job.render(&path(max_depth.min(1))),
        IntegratorKind::Ao { distance } => job.render(&Ao { distance }),
        IntegratorKind::Normals => job.render(&Normals),
        IntegratorKind::Distribution { rule, directions } => {
            job.render(&Distribution::new(rule, &directions, settings)?)
        }
    }
}

/// Refuses, before a structure is built for it, a checkpoint of other settings than these; what was chosen
/// automatically is chosen as it was then.
///
/// # Errors
/// What differs.
pub fn adopt(checkpoint: &Checkpoint, scene: &Scene, settings: &mut Settings) -> Result<()> {
    let compact =
        checkpoint.header().identity.pointer("/drt/render/compact").and_then(|value| value.as_bool());
    if let (Compact::Auto, Some(was)) = (settings.compact, compact) {
        settings.compact = if was { Compact::Yes } else { Compact::No };
    }
    checkpoint.belongs_to(&record::identity(settings, scene, None))
}

/// The distance along the viewing axis of what the middle of `pixel` sees through a pinhole, as
/// [`crate::camera::CameraSpec::focus_distance`] wants it.
///
/// # Errors
/// A pixel outside the picture, a camera without a lens, or nothing to see there.
pub fn focus(scene: &Scene, settings: &Settings, accel: &dyn Intersector, pixel: [u32; 2]) -> Result<f64> {
    let [x, y] = pixel;
    let [width, height] = settings.size;
    if x >= width || y >= height {
        return Err(Error::usage(format!(
            "--focus: pixel {x},{y} is outside the picture of {width}x{height}"
        )));
    }
    let camera = Camera::new(&scene.camera, scene.origin)?;
    if !camera.has_lens() {
        return Err(Error::usage("--focus: the camera has no lens, so everything is in focus")
            .advise("give a perspective camera an aperture, e.g. --set camera.aperture=0.05"));
    }
    let place = |i: u32, n: u32| ((f64::from(i) + 0.5) / f64::from(n)) as f32;
    let ray = camera.clone().pinhole().ray(place(x, width), place(y, height), [0.5; 2], 0.0);
    let hit = accel.closest_one(ray.o, ray.d, 0.0, f32::INFINITY).map(|hit| hit.t);
    let lamps = scene.lights.iter().filter_map(|light| match light {
        Light::Sphere(s) => s.intersect(ray.o, ray.d, 0.0, f32::INFINITY),
        _ => None,
    });
    let nearest = lamps.chain(hit).fold(f32::INFINITY, f32::min);
    let depth = camera.depth(ray.d, nearest);
    if !(depth > 0.0 && depth.is_finite()) {
        return Err(Error::usage(format!("--focus: pixel {x},{y} sees nothing to focus on"))
            .advise("choose a pixel on a surface"));
    }
    Ok(depth)
}
