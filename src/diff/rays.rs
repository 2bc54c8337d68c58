//! The rays: kinds, sets of them, and the recorder that overhears a render.

use crate::accel::{Checked, Coherence, Hits, Intersector, Mask, Rays};
use crate::error::Result;
use crate::film::PixelRule;
use crate::render;
use crate::scene::{IntegratorKind, LightSampling, Scene, Settings};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Where a ray comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// From a render's camera.
    Camera,
    /// A render's path going on from a surface.
    Bounce,
    /// A render's question whether a light is visible.
    Shadow,
    /// Aimed at a vertex.
    Vertex,
    /// Aimed at a point of an edge.
    Edge,
    /// Parallel to an axis, through a vertex, an edge or a face.
    Axis,
    /// Nearly within a triangle's plane.
    Graze,
    /// Out of a reproducer.
    Replay,
}

impl Kind {
    /// Every kind, in the order of the report.
    pub const ALL: [Kind; 8] = [
        Kind::Camera,
        Kind::Bounce,
        Kind::Shadow,
        Kind::Vertex,
        Kind::Edge,
        Kind::Axis,
        Kind::Graze,
        Kind::Replay,
    ];

    /// Its name in the report.
    pub fn name(self) -> &'static str {
        match self {
            Kind::Camera => "camera",
            Kind::Bounce => "bounce",
            Kind::Shadow => "shadow",
            Kind::Vertex => "vertex",
            Kind::Edge => "edge",
            Kind::Axis => "axis",
            Kind::Graze => "graze",
            Kind::Replay => "replay",
        }
    }
}

/// A chunk of rays with the lanes that are asked.
#[derive(Clone, Debug)]
pub struct Chunk {
    /// The rays; lanes that are not asked may hold anything.
    pub rays: Rays,
    /// The lanes asked.
    pub mask: Mask,
}

/// Rays of one kind, in chunks as a render would trace them.
#[derive(Clone, Debug)]
pub struct RaySet {
    /// Where they come from.
    pub kind: Kind,
    /// The rays.
    pub chunks: Vec<Chunk>,
}

impl RaySet {
    /// How many rays there are.
    pub fn len(&self) -> u64 {
        count(&self.chunks)
    }

    /// True when there is none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// What a render says of such rays.
    pub fn coherence(&self) -> Coherence {
        if self.kind == Kind::Camera { Coherence::Coherent } else { Coherence::Incoherent }
    }
}

fn count(chunks: &[Chunk]) -> u64 {
    chunks.iter().map(|chunk| u64::from(chunk.mask.count_ones())).sum()
}

/// At most `most` rays of each kind that a render of `scene` traces, from all of its picture: camera, bounce,
/// shadow. Where the scene's own light sampling needs no shadow rays (a constant sky), they are those of
/// sampling the lights. `accel` answers while they are recorded. `None` when `stop` ended it.
///
/// On one thread the render asks in a fixed order, so that the rays are the same in every run.
///
/// # Errors
/// As [`render::render`].
pub fn record(
    scene: &Scene,
    settings: &Settings,
    accel: &dyn Intersector,
    most: u64,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<Option<Vec<RaySet>>> {
    let mut settings = modest(settings, most);
    let Some(mut sets) = overhear(scene, &settings, accel, most, stop)? else { return Ok(None) };
    if sets[2].is_empty() && settings.lights != LightSampling::Light {
        settings.lights = LightSampling::Light;
        let Some(mut others) = overhear(scene, &settings, accel, most, stop)? else { return Ok(None) };
        sets[2] = others.swap_remove(2);
    }
    Ok(Some(sets))
}

/// The settings of a render of about `most` camera rays: a smaller picture of four samples a pixel, or more samples.
fn modest(settings: &Settings, most: u64) -> Settings {
    const SPP: u64 = 4;
    let mut s = Settings { rule: PixelRule::Sampler, aovs: Vec::new(), ..settings.clone() };
    // Its rays are those of paths, only more at every hit.
    if matches!(s.integrator, IntegratorKind::Distribution { .. }) {
        s.integrator = IntegratorKind::Path;
    }
    let pixels = |[w, h]: [u32; 2]| u64::from(w) * u64::from(h);
    let wanted = most.div_ceil(SPP);
    if s.crop.is_none() && pixels(s.size) > wanted {
        let scale = (wanted as f64 / pixels(s.size) as f64).sqrt();
        s.size = s.size.map(|side| ((f64::from(side) * scale).ceil() as u32).clamp(1, side));
    }
    let shown = s.crop.map_or(s.size, |[_, _, w, h]| [w, h]);
    s.spp = most.div_ceil(pixels(shown).max(1)).clamp(1, 4096) as u32;
    s
}

fn overhear(
    scene: &Scene,
    settings: &Settings,
    accel: &dyn Intersector,
    most: u64,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<Option<Vec<RaySet>>> {
    let recorder =
        Recorder { accel, kept: [Kind::Camera, Kind::Bounce, Kind::Shadow].map(|_| Mutex::default()), most };
    let hooks = render::Hooks { progress: &|_| (), stop };
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let one = one.map_err(|e| crate::error::Error::new(format!("cannot start a thread: {e}")))?;
    let rendering = one.install(|| render::render(scene, settings, &recorder, None, &hooks))?;
    Ok(rendering.complete.then(|| recorder.sets()))
}

/// An intersector that keeps a copy of what it is asked.
struct Recorder<'a> {
    accel: &'a dyn Intersector,
    kept: [Mutex<Kept>; 3],
    most: u64,
}

/// Chunks, evenly from the whole stream: whenever there are too many, every other one goes and from then on only every
/// other one comes.
#[derive(Default)]
struct Kept {
    chunks: Vec<Chunk>,
    rays: u64,
    offered: u64,
    halvings: u32,
}

impl Kept {
    fn offer(&mut self, rays: Checked<'_>, most: u64) {
        let wanted = self.offered.trailing_zeros() >= self.halvings || self.offered == 0;
        self.offered += 1;
        if !wanted || rays.active() == 0 {
            return;
        }
        self.chunks.push(Chunk { rays: rays.rays().clone(), mask: rays.active() });
        self.rays += u64::from(rays.active().count_ones());
        // Twice as many, so that what is left in the end is not much less than asked for.
        if self.rays > most.saturating_mul(2).max(64) {
            let mut turn = 0;
            self.chunks.retain(|_| {
                turn += 1;
                turn % 2 == 1
            });
            self.rays = count(&self.chunks);
            self.halvings += 1;
        }
    }

    /// `most` rays or fewer, evenly from all chunks.
    fn thin(&mut self, most: u64) -> Vec<Chunk> {
        let (mut offered, mut taken) = (0, 0);
        let mut chunks = std::mem::take(&mut self.chunks);
        let rays = self.rays.max(1);
        chunks.retain_mut(|chunk| {
            let has_turn = taken < most && taken as u128 * rays as u128 <= offered as u128 * most as u128;
            offered += u64::from(chunk.mask.count_ones());
            if has_turn {
                while u64::from(chunk.mask.count_ones()) > most - taken {
                    chunk.mask &= chunk.mask - 1;
                }
                taken += u64::from(chunk.mask.count_ones());
            }
            has_turn
        });
        chunks
    }
}

impl Recorder<'_> {
    fn keep(&self, kind: usize) -> MutexGuard<'_, Kept> {
        self.kept[kind].lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn sets(&self) -> Vec<RaySet> {
        let kinds = [Kind::Camera, Kind::Bounce, Kind::Shadow].into_iter().enumerate();
        kinds.map(|(i, kind)| RaySet { kind, chunks: self.keep(i).thin(self.most) }).collect()
    }
}

impl Intersector for Recorder<'_> {
    fn closest(&self, rays: Checked<'_>, coherence: Coherence, hits: &mut Hits) {
        // Only camera rays are called coherent.
        self.keep((coherence == Coherence::Incoherent) as usize).offer(rays, self.most);
        self.accel.closest(rays, coherence, hits);
    }

    fn occluded(&self, rays: Checked<'_>, coherence: Coherence) -> Mask {
        self.keep(2).offer(rays, self.most);
        self.accel.occluded(rays, coherence)
    }

    // Else chunks of bounces would be called coherent, and be taken for the camera's.
    fn gains_from_octants(&self) -> bool {
        false
    }

    fn bytes(&self) -> usize {
        self.accel.bytes()
    }

    fn isa(&self) -> &str {
        self.accel.isa()
    }
}
