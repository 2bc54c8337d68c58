//! What light does along rays, in waves of paths.
//!
//! An [`Integrator`] is the mathematics of vertices and of a ray that meets no mesh. It *pushes* what it finds into
//! a [`Sink`]: emitted light, shadow rays, rays to follow (0 … N). Vertices come in a [`Batch`], so that the hot
//! paths can work on all of its lanes at once. [`wave`] owns lanes, chunks and compaction and knows no physics.
//!
//! Vocabulary: `wo` to the viewer and `wi` to the light, both unit and away from the surface; `beta` the
//! throughput of a path up to its last vertex; `pdf` the density per solid angle with which the direction
//! that led here was chosen, infinite after a mirror or from the camera, where no other technique competes.

mod ao;
mod batch;
mod context;
mod cutout;
mod distribution;
mod explore;
mod lanes;
mod normals;
mod path;
mod place;
mod stats;
pub mod wave;

pub use ao::Ao;
pub use batch::Batch;
pub use context::{Context, Dimensions};
pub use distribution::Distribution;
pub use normals::Normals;
pub use path::Path;
pub use stats::RenderStats;

use crate::bsdf::{Scatter, View};
use crate::light::{End, LightSample, Receiver};
use crate::math::ray::Ray;
use crate::math::{Frame, Rgb, Vec3, mis};
use crate::sampler::Key;
use crate::scene::LightSampling;
use crate::shape::Surface;
use wave::BatchSink;

/// A point where a path meets a surface.
#[derive(Clone, Copy, Debug)]
pub struct Vertex {
    /// The point.
    pub surface: Surface,
    /// Around the shading normal, on the side of `wo`.
    pub frame: Frame,
    /// Unit direction back along the ray.
    pub wo: Vec3,
    /// The same in `frame`, and the side.
    pub view: View,
    /// Origin of the ray that led here.
    pub origin: Vec3,
    /// Its length.
    pub t: f32,
    /// Mesh and triangle.
    pub ids: [u32; 2],
    /// Material id.
    pub material: u32,
    /// The material that scatters: the same, or a part of it where it is a mixture.
    pub part: u32,
    /// What led here.
    pub arrival: Arrival,
}

impl Vertex {
    /// How it faces the viewer.
    #[inline(always)]
    pub fn facing(&self) -> Facing {
        let (ng, beta) = (self.surface.ng, self.arrival.beta);
        Facing { frame: self.frame, view: self.view, ng, wo: self.wo, beta }
    }
}

/// What the scattering at a vertex depends on, besides the material.
#[derive(Clone, Copy, Debug)]
pub struct Facing {
    /// See [`Vertex::frame`].
    pub frame: Frame,
    /// See [`Vertex::view`].
    pub view: View,
    /// The geometric normal.
    pub ng: Vec3,
    /// See [`Vertex::wo`].
    pub wo: Vec3,
    /// See [`Arrival::beta`].
    pub beta: Rgb,
}

impl Facing {
    /// True when `wi` is in front of the true surface where `local`, the same direction in the shading frame,
    /// is in front of the shading normal, and behind it where that is behind. Where the two disagree, light
    /// would leak through the surface or out of it, so none passes.
    #[inline(always)]
    pub fn on_the_same_side_as(&self, local: Vec3, wi: Vec3) -> bool {
        let front = self.ng.dot(wi) * self.ng.dot(self.wo);
        front * local.z > 0.0
    }
}

/// How a ray came about.
#[derive(Clone, Copy, Debug)]
pub struct Arrival {
    /// Throughput.
    pub beta: Rgb,
    /// Density of the ray's direction per solid angle.
    pub pdf: f32,
    /// Normal of where the ray started, packed; see [`Receiver`].
    pub normal: u32,
    /// Scattering events so far.
    pub depth: u32,
    /// Which of the branches into which the sample has split by now; 0 where nothing splits.
    pub branch: u32,
    /// When the sample is taken: 0 as the shutter opens, before 1 when it closes.
    pub time: f32,
    /// Which sample of which pixel.
    pub key: Key,
}

/// Receives what a vertex finds.
pub trait Sink {
    /// Radiance that reaches the pixel.
    fn emit(&mut self, radiance: Rgb);

    /// Radiance that reaches the pixel if `shadow` is free.
    fn connect(&mut self, shadow: Ray, radiance: Rgb);

    /// A ray to follow.
    fn extend(&mut self, next: Extension);
}

/// A ray to follow.
#[derive(Clone, Copy, Debug)]
pub struct Extension {
    /// Origin.
    pub o: Vec3,
    /// Unit direction.
    pub d: Vec3,
    /// Throughput.
    pub beta: Rgb,
    /// Density of the direction per solid angle, infinite where no other technique competes.
    pub pdf: f32,
    /// See [`Arrival::normal`].
    pub normal: u32,
    /// See [`Arrival::branch`].
    pub branch: u32,
}

/// The mathematics of an integrator. Both functions are compiled into the wave per instruction set and per
/// BSDF, so mark them `#[inline(always)]`.
pub trait Integrator: Sync {
    /// Whether it is compiled once a BSDF, in vector instructions: for what many rays are traced with. Otherwise once, for
    /// [`Bsdf`](crate::bsdf::Bsdf), which takes a ninth of the time to compile.
    const BY_MODEL: bool = false;

    /// Rays that a vertex after `depth` scattering events pushes at most, of each kind. Waves are cut into pieces
    /// by it, so that branching does not fill the memory.
    fn fan_out(&self, _cx: &Context<'_>, _depth: u32) -> u32 {
        1
    }

    /// What happens at vertices.
    fn vertices<B: Scatter>(&self, cx: &Context<'_>, batch: &Batch<B>, out: &mut BatchSink<'_>);

    /// What happens to a ray from `o` with unit direction `d` that meets no mesh.
    fn end(&self, cx: &Context<'_>, end: End, o: Vec3, d: Vec3, arrival: &Arrival, out: &mut impl Sink);
}

/// Light that the surface itself emits, weighted against the chance that light sampling had found it.
#[inline(always)]
fn emitted(cx: &Context<'_>, v: &Vertex, out: &mut impl Sink) {
    let le = cx.lights.emitted(v.material, &v.surface, v.wo);
    if le == Rgb::ZERO {
        return;
    }
    if !cx.lights.samples(v.ids[0]) {
        out.emit(v.arrival.beta * le);
        return;
    }
    let competes = v.arrival.pdf > 0.0 && v.arrival.pdf < f32::INFINITY;
    let from = Receiver::new(v.origin, v.arrival.normal);
    let pdf = match competes {
        true => cx.lights.pdf_of_hit(&from, v.ids, &v.surface, v.wo, v.t, v.arrival.time),
        false => 1.0,
    };
    out.emit(v.arrival.beta * le * mis::power(v.arrival.pdf, pdf));
}

/// The same for light that comes from no mesh.
#[inline(always)]
fn emitted_at_end(cx: &Context<'_>, end: End, o: Vec3, d: Vec3, arrival: &Arrival, out: &mut impl Sink) {
    cx.lights.at_end(end, o, d, arrival.normal, |le, pdf| {
        out.emit(arrival.beta * le * mis::power(arrival.pdf, pdf));
    });
}

/// One light sample, and the shadow ray that says whether it arrives.
#[inline(always)]
fn connect<B: Scatter>(
    lights: LightSampling,
    v: &Vertex,
    bsdf: &B,
    light: &LightSample,
    share: f32,
    out: &mut impl Sink,
) {
    if let (radiance, true) = brought::<B, false>(lights, &v.facing(), bsdf, light, share) {
        out.connect(light.shadow, radiance);
    }
}

/// What the light sample brings if nothing is in its way, weighted against the chance that BSDF sampling finds the same; of
/// use if the second is true. `SMALL`: [`Scatter::is_small`] holds.
#[inline(always)]
fn brought<B: Scatter, const SMALL: bool>(
    lights: LightSampling,
    v: &Facing,
    bsdf: &B,
    light: &LightSample,
    share: f32,
) -> (Rgb, bool) {
    let wi = v.frame.to_local(light.wi);
    let (f_cos, bsdf_pdf) = if SMALL { bsdf.eval_small(&v.view, wi) } else { bsdf.eval(&v.view, wi) };
    // A delta light has an infinite density: nothing else finds it. No `match`: a loop with one stays scalar.
    let alone = matches!(lights, LightSampling::Light) | (light.pdf == f32::INFINITY);
    let combined = mis::power(light.pdf, bsdf_pdf);
    let only = if alone { 1.0 } else { 0.0 };
    let weight = if matches!(lights, LightSampling::Mis) { combined } else { only };
    let arrives = (f_cos != Rgb::ZERO) & v.on_the_same_side_as(wi, light.wi) & (weight != 0.0);
    (v.beta * f_cos * light.radiance_over_pdf * (weight * share), arrives)
}

/// The density that the ray along a BSDF sample of density `pdf` carries, so that what it meets weighs its light
/// against light sampling; `light_sampled`: whether this vertex took light samples. They never find what a delta
/// chose.
#[inline(always)]
fn competing_pdf(lights: LightSampling, light_sampled: bool, pdf: f32) -> f32 {
    match lights {
        LightSampling::Mis => pdf,
        LightSampling::Bsdf => f32::INFINITY,
        LightSampling::Light if light_sampled && pdf < f32::INFINITY => 0.0,
        LightSampling::Light => f32::INFINITY,
    }
}
