//! Loads, builds, renders and replays one scene.

use crate::Args;
use crate::scenes::Bench;
use drt::accel::{Hits, Intersector};
use drt::compare::relative_square;
use drt::diff::rays::{self, Kind, RaySet};
use drt::error::{Error, Result};
use drt::film::Image;
use drt::load::{self, Options, Override};
use drt::render::{self, Hooks};
use drt::scene::{Scene, Settings};
use rustix::time::{ClockId, clock_gettime};
use serde_json::{Value, json};

/// So many rays of a kind are replayed at most.
const REPLAYED: u64 = 1 << 20;

/// The figures of one scene with one backend. Seconds are of CPU.
#[derive(Clone, Debug, Default)]
pub struct Measured {
    /// Reading the files.
    pub load: f64,
    /// Building the structure.
    pub build: f64,
    /// Rendering: the median of the runs.
    pub render: f64,
    /// Pixels times samples a pixel.
    pub samples: f64,
    /// Camera, bounce and shadow rays of the last run.
    pub rays: [u64; 3],
    /// Share of the waves' time inside the intersector.
    pub inside: f64,
    /// What those rays would take if nothing else were to do.
    pub replayed: f64,
    /// A replayed ray's share of that, by kind.
    pub nanoseconds: [f64; 3],
    /// relMSE, the median of the runs.
    pub error: f64,
    /// Bytes a triangle of the meshes and of the structure.
    pub bytes: [f64; 2],
}

impl Measured {
    /// For programs.
    pub fn json(&self, bench: &Bench, backend: &str) -> Value {
        json!({
            "scene": bench.name,
            "backend": backend,
            "cpu_seconds": { "load": self.load, "build": self.build, "render": self.render },
            "rays": { "camera": self.rays[0], "bounce": self.rays[1], "shadow": self.rays[2] },
            "inside_the_intersector": self.inside,
            "replayed_seconds": self.replayed,
            "nanoseconds_a_replayed_ray": self.nanoseconds,
            "relmse": self.error,
            "efficiency": 1.0 / (self.error * self.render),
            "bytes_a_triangle": { "mesh": self.bytes[0], "structure": self.bytes[1] },
        })
    }
}

/// CPU seconds of all threads so far.
fn cpu() -> f64 {
    let t = clock_gettime(ClockId::ProcessCPUTime);
    t.tv_sec as f64 + t.tv_nsec as f64 * 1e-9
}

/// CPU seconds of `work`, and what it returned.
fn timed<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let begin = cpu();
    let done = work();
    (cpu() - begin, done)
}

/// Everything about one scene with one backend.
///
/// # Errors
/// A file that cannot be read, a backend that this build has not, or a reference of another size.
pub fn measure(bench: &Bench, backend: &str, args: &Args) -> Result<Measured> {
    let overrides = [
        ("film.size", format!("[{0}, {0}]", args.size)),
        ("render.spp", args.spp.to_string()),
        ("render.max_depth", bench.max_depth.to_string()),
        ("render.backend", format!("\"{backend}\"")),
    ];
    let overrides = overrides
        .into_iter()
        .map(|(key, value)| Override::parse(&format!("{key}={value}")))
        .collect::<Result<_>>()?;
    let (load, loaded) = timed(|| load::scene(&bench.file, Options { overrides, ..Options::default() }));
    let load::Loaded { scene, mut settings, .. } = loaded?;
    settings.seed = args.seed;
    let (build, accel) = timed(|| render::build(&scene, &settings, None, &Hooks::NONE));
    let accel = accel?;
    let (reference, noise) = reference(bench, args, &scene, &settings, accel.as_ref())?;

    let mut m = Measured { load, build, ..Measured::default() };
    let (mut seconds, mut errors) = (Vec::new(), Vec::new());
    for _ in 0..args.runs.max(1) {
        let (time, done) = timed(|| render::render(&scene, &settings, accel.as_ref(), None, &Hooks::NONE));
        let done = done?;
        seconds.push(time);
        // A long run's own noise is a known share of what is measured.
        errors.push(relative_error(&done.image, &reference, bench.hides_lamp)? / (1.0 + noise));
        let s = done.stats;
        m.rays = [s.camera_rays, s.bounce_rays, s.shadow_rays];
        m.inside = s.intersect_seconds / (s.intersect_seconds + s.shade_seconds + s.rest_seconds);
        settings.seed += 1;
    }
    (m.render, m.error) = (median(seconds), median(errors));
    m.samples = f64::from(args.size).powi(2) * f64::from(args.spp);
    if let Some(sets) = rays::record(&scene, &settings, accel.as_ref(), REPLAYED, &|| false)? {
        for set in &sets {
            let i = [Kind::Camera, Kind::Bounce, Kind::Shadow].iter().position(|kind| *kind == set.kind);
            if let Some(i) = i
                && !set.is_empty()
            {
                m.nanoseconds[i] = 1e9 * replay(set, accel.as_ref()) / set.len() as f64;
            }
        }
    }
    m.replayed = m.rays.iter().zip(m.nanoseconds).map(|(n, ns)| *n as f64 * ns * 1e-9).sum();
    let triangles = scene.triangles().max(1) as f64;
    let meshes: usize = scene.meshes.iter().map(|mesh| mesh.bytes()).sum();
    m.bytes = [meshes as f64 / triangles, accel.bytes() as f64 / triangles];
    Ok(m)
}

/// The least CPU seconds of three times asking for the rays of `set` and nothing else.
fn replay(set: &RaySet, accel: &dyn Intersector) -> f64 {
    let ask = || {
        let (mut hits, mut blocked) = (Hits::default(), 0);
        for chunk in &set.chunks {
            let rays = chunk.rays.check(chunk.mask);
            match set.kind {
                Kind::Shadow => blocked += accel.occluded(rays, set.coherence()).count_ones(),
                _ => accel.closest(rays, set.coherence(), &mut hits),
            }
        }
        std::hint::black_box((hits, blocked));
    };
    (0..3).map(|_| timed(ask).0).fold(f64::INFINITY, f64::min)
}

/// A picture to compare with, and its own error as a share of the error of what is measured.
fn reference(
    bench: &Bench,
    args: &Args,
    scene: &Scene,
    settings: &Settings,
    accel: &dyn Intersector,
) -> Result<(Image, f64)> {
    if let Some(folder) = &args.references {
        let path = folder.join(format!("{}.exr", bench.name));
        let image = load::picture::read(&path)?.image;
        return Ok((image, 0.0));
    }
    let long = args.longer.max(1);
    let settings =
        Settings { spp: settings.spp * long, seed: settings.seed ^ 0xa5a5_0000, ..settings.clone() };
    let image = render::render(scene, &settings, accel, None, &Hooks::NONE)?.image;
    Ok((image, 1.0 / f64::from(long)))
}

/// mean((x − r)²/(r² + 0.01)); `hides_lamp`: without pixels brighter than 2 and two around them, whose edges would be
/// all there is.
pub fn relative_error(image: &Image, reference: &Image, hides_lamp: bool) -> Result<f64> {
    let (w, h) = (reference.width as usize, reference.height as usize);
    if [image.width, image.height] != [reference.width, reference.height] {
        return Err(Error::new(format!(
            "the reference has {w}x{h} pixels, the picture {}x{}",
            image.width, image.height
        )));
    }
    let bright: Vec<bool> =
        (0..w * h).map(|i| hides_lamp && reference.rgb(i).iter().any(|c| *c > 2.0)).collect();
    let hidden = |i: usize| {
        let (x, y) = (i % w, i / w);
        let around = |a: usize, n: usize| a.saturating_sub(2)..(a + 3).min(n);
        around(y, h).any(|y| around(x, w).any(|x| bright[y * w + x]))
    };
    let (mut sum, mut count) = (0.0, 0.0);
    for i in (0..w * h).filter(|i| !hidden(*i)) {
        for (a, b) in image.rgb(i).into_iter().zip(reference.rgb(i)) {
            sum += relative_square(f64::from(a), f64::from(b));
            count += 1.0;
        }
    }
    Ok(sum / f64::max(count, 1.0))
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
