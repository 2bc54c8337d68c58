//! The render loop: tiles × blocks of samples in parallel, pass by pass, with progress and cancellation.

use crate::accel::{BuildOptions, Intersector};
use crate::camera::Camera;
use crate::error::{Error, Result};
use crate::film::{Develop, Film, Image, PixelRule, Tile};
pub use crate::integrator::RenderStats;
use crate::integrator::wave::{Job, Wave};
use crate::integrator::{Ao, Context, Distribution, Integrator, Normals, Path};
use crate::light::Light;
use crate::math::isa::{self, Isa, Kernel};
use crate::scene::{IntegratorKind, Quantity, Scene, Settings};
use rayon::prelude::*;
use serde_json::json;
use std::sync::atomic::{AtomicU64, Ordering};

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
/// Out of memory, coordinates beyond the backend's range, its own error, or [`crate::accel::cancelled`].
pub fn build(
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
        quality: settings.build.resolve(scene.triangles(), settings.size, settings.spp),
        compact: settings.compact.resolve(|| settings.backend.is_memory_short(scene.triangles())),
        isa,
        threads: rayon::current_num_threads(),
        progress: &progress,
    };
    settings.backend.check_range(&scene.meshes)?;
    settings.backend.check_range(&scene.instances.meshes)?;
    settings.backend.build_all(&scene.geometry(), &options)
}

/// The settings that a whole picture of `scene` will tell, as JSON.
pub fn attribute(scene: &Scene, settings: &Settings, accel: &dyn Intersector) -> String {
    settings_json(settings, accel, scene, (settings.spp, settings.spp))
}

/// The samples of block `k`: the first sample alone, so that a whole picture exists soon; the other 15 of
/// the first 16; then 16 at a time. Fixed, since waves are part of what a picture's bits depend on.
fn block(k: u32) -> std::ops::Range<u32> {
    match k {
        0 => 0..1,
        1 => 1..16,
        _ => 16 * (k - 1)..16 * k,
    }
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
    let max_depth = settings.max_depth;
    let path = |max_depth| Path { max_depth, lights: settings.lights, roulette: settings.roulette };
    let job = Picture { scene, settings, accel, isa: isa.unwrap_or(Isa::best()), hooks };
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

struct Picture<'a> {
    scene: &'a Scene,
    settings: &'a Settings,
    accel: &'a dyn Intersector,
    isa: Isa,
    hooks: &'a Hooks<'a>,
}

impl Picture<'_> {
    fn render<I: Integrator>(&self, integrator: &I) -> Result<Rendering> {
        let s = self.settings;
        let cx = Context::new(self.scene, s)?;
        if let Some(grid) = s.rule.grid()
            && grid.points() != u64::from(s.spp)
        {
            return Err(Error::new(format!(
                "{} points of the pixel rule do not make {} samples a pixel",
                grid.points(),
                s.spp
            )));
        }
        let film = Film::new(s.size, !s.aovs.is_empty(), cx.pixel.is_signed())?;
        let crop = s.crop.unwrap_or([0, 0, s.size[0], s.size[1]]);
        let tiles = touched_tiles(crop);
        let total = u64::from(crop[2]) * u64::from(crop[3]) * u64::from(s.spp);
        let done = AtomicU64::new(0);
        let mut stats = RenderStats::default();
        let mut complete = true;
        for samples in (0..).map(block).take_while(|b| b.start < s.spp) {
            let samples = samples.start..samples.end.min(s.spp);
            let pass = Pass { cx: &cx, integrator, film: &film, samples, tiles: &tiles, done: &done, total };
            let (pass_stats, pass_complete) = self.pass(&pass);
            stats = stats.plus(&pass_stats);
            complete &= pass_complete;
            if !complete {
                break;
            }
        }
        let settings = settings_json(s, self.accel, self.scene, film.samples_done(crop));
        let area = match s.quantity {
            Quantity::Radiance => 1.0,
            Quantity::Flux => self.scene.camera.window.pixel_area(s.size),
        };
        let image = film.develop(Develop { crop, aovs: &s.aovs, origin: self.scene.origin, area, settings });
        Ok(Rendering { image, stats, complete })
    }

    /// One block of samples over all tiles, in parallel; false when it was stopped.
    fn pass<I: Integrator>(&self, pass: &Pass<'_, I>) -> (RenderStats, bool) {
        let pixels = u64::from(Film::TILE * Film::TILE) * pass.samples.len() as u64;
        let tile = |wave: &mut Wave, tile: &[u32; 2]| {
            if (self.hooks.stop)() {
                return (RenderStats::default(), false);
            }
            let index = tile[1] as usize * pass.film.tiles()[0] as usize + tile[0] as usize;
            let job = Job {
                cx: pass.cx,
                integrator: pass.integrator,
                accel: self.accel,
                tile: *tile,
                samples: pass.samples.clone(),
                layers: !self.settings.aovs.is_empty(),
            };
            pass.film.with_tile(index, |tile| isa::run(self.isa, TileKernel { wave, job: &job, tile }));
            let done = pass.done.fetch_add(pixels, Ordering::Relaxed) + pixels;
            (self.hooks.progress)(Progress::Render(done.min(pass.total), pass.total));
            (wave.take_stats(), true)
        };
        pass.tiles
            .par_iter()
            .map_init(Wave::default, tile)
            .reduce(|| (RenderStats::default(), true), |a, b| (a.0.plus(&b.0), a.1 && b.1))
    }
}

/// One block of samples over the picture.
struct Pass<'a, I> {
    cx: &'a Context<'a>,
    integrator: &'a I,
    film: &'a Film,
    samples: std::ops::Range<u32>,
    tiles: &'a [[u32; 2]],
    done: &'a AtomicU64,
    total: u64,
}

/// A wave, compiled per instruction set.
struct TileKernel<'a, I> {
    wave: &'a mut Wave,
    job: &'a Job<'a, I>,
    tile: &'a mut Tile,
}

impl<I: Integrator> Kernel for TileKernel<'_, I> {
    type Output = ();
    #[inline(always)]
    fn run<S: isa::Set>(self) {
        self.wave.run(self.job, self.tile);
    }
}

/// The tiles that `crop` touches, column and row; whole tiles are traced, so that a crop's pixels are those
/// of the full picture.
fn touched_tiles([x, y, w, h]: [u32; 4]) -> Vec<[u32; 2]> {
    let range = |start: u32, length: u32| start / Film::TILE..(start + length).div_ceil(Film::TILE);
    range(y, h).flat_map(|row| range(x, w).map(move |column| [column, row])).collect()
}

/// The `drt` attribute: canonical JSON with sorted keys of everything that the picture's bits depend on.
/// No threads, paths, host, time or command line.
fn settings_json(s: &Settings, accel: &dyn Intersector, scene: &Scene, samples: (u32, u32)) -> String {
    let parameters = s.filter.parameters().into_iter().map(|(name, value)| (name.to_string(), json!(value)));
    let kind = ("type".to_string(), json!(s.filter.name()));
    let filter: serde_json::Map<String, serde_json::Value> = parameters.chain([kind]).collect();
    json!({
        "version": env!("CARGO_PKG_VERSION"),
        "film": {
            "size": s.size,
            "crop": s.crop,
            "filter": filter,
            "rule": rule_json(s.rule),
            "quantity": s.quantity.name(),
        },
        "render": {
            "integrator": integrator_json(&s.integrator),
            "lights": s.lights.name(),
            "roulette": s.roulette,
            "spp": s.spp,
            "max_depth": s.max_depth,
            "seed": s.seed,
            "sampler": s.sampler.name(),
            "backend": s.backend.name(),
            "isa": accel.isa(),
            "build": s.build.resolve(scene.triangles(), s.size, s.spp).name(),
            "compact": accel.compact(),
        },
        "samples_done": { "min": samples.0, "max": samples.1 },
        "complete": samples.0 == s.spp,
    })
    .to_string()
}

fn integrator_json(kind: &IntegratorKind) -> serde_json::Value {
    match kind {
        IntegratorKind::Ao { distance } if distance.is_finite() => {
            json!({ "type": "ao", "distance": distance })
        }
        IntegratorKind::Distribution { rule, directions } => {
            let cells: Vec<[u32; 2]> = directions.cells().iter().map(|c| [c.theta, c.phi]).collect();
            let mut all = json!({ "type": kind.name(), "rule": rule.name(), "directions": cells });
            if let Some(per_cell) = rule.per_cell() {
                all["per_cell"] = json!(per_cell);
            }
            if let Some(measure) = rule.measure() {
                all["measure"] = json!(measure.name());
            }
            all
        }
        other => json!(other.name()),
    }
}

fn rule_json(rule: PixelRule) -> serde_json::Value {
    match rule.grid() {
        Some(grid) => json!({ "type": rule.name(), "grid": grid.cells, "per_cell": grid.per_cell }),
        None => json!(rule.name()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_follow_each_other_without_gap() {
        let mut next = 0;
        for k in 0..100 {
            assert_eq!(block(k).start, next);
            next = block(k).end;
        }
        assert_eq!(next, 16 * 99);
    }

    #[test]
    fn a_crop_touches_whole_tiles() {
        assert_eq!(touched_tiles([0, 0, 8, 8]), [[0, 0]]);
        assert_eq!(touched_tiles([7, 15, 2, 1]), [[0, 1], [1, 1]]);
    }
}
