//! What light does along rays, in waves of paths.
//!
//! An [`Integrator`] is the mathematics of one vertex and of a ray that meets no mesh, as plain scalar
//! functions that *push* what they find into a [`Sink`]: emitted light, shadow rays, rays to follow (0 … N).
//! [`wave`] owns lanes, chunks and compaction and knows no physics; tests use a sink that records.
//!
//! Vocabulary: `wo` to the viewer and `wi` to the light, both unit and away from the surface; `beta` the
//! throughput of a path up to its last vertex; `pdf` the density per solid angle with which the direction
//! that led here was chosen, infinite after a mirror or from the camera, where no other technique competes.

mod ao;
mod context;
mod normals;
mod path;
mod stats;
pub mod wave;

pub use ao::Ao;
pub use context::{Context, Dimensions};
pub use normals::Normals;
pub use path::Path;
pub use stats::RenderStats;

use crate::bsdf::{Scatter, View};
use crate::light::End;
use crate::math::ray::Ray;
use crate::math::{Frame, Rgb, Vec3};
use crate::sampler::Key;
use crate::shape::Surface;

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
    /// Length of the ray that led here.
    pub t: f32,
    /// Material id.
    pub material: u32,
    /// What led here.
    pub arrival: Arrival,
}

impl Vertex {
    /// True when `wi` is in front of the true surface where `local`, the same direction in the shading frame,
    /// is in front of the shading normal, and behind it where that is behind. Where the two disagree, light
    /// would leak through the surface or out of it, so none passes.
    #[inline(always)]
    pub fn on_the_same_side_as(&self, local: Vec3, wi: Vec3) -> bool {
        let front = self.surface.ng.dot(wi) * self.surface.ng.dot(self.wo);
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
    /// Scattering events so far.
    pub depth: u32,
    /// Which sample of which pixel.
    pub key: Key,
}

/// Receives what a vertex finds.
pub trait Sink {
    /// Radiance that reaches the pixel.
    fn emit(&mut self, radiance: Rgb);

    /// Radiance that reaches the pixel if `shadow` is free.
    fn connect(&mut self, shadow: Ray, radiance: Rgb);

    /// A ray to follow: unit direction `d`, throughput `beta`, density `pdf` of the direction.
    fn extend(&mut self, o: Vec3, d: Vec3, beta: Rgb, pdf: f32);
}

/// The mathematics of an integrator. Both functions are compiled into the wave per instruction set and per
/// BSDF, so mark them `#[inline(always)]`.
pub trait Integrator: Sync {
    /// What happens at one vertex.
    fn vertex<B: Scatter>(&self, cx: &Context<'_>, v: &Vertex, bsdf: &B, out: &mut impl Sink);

    /// What happens to a ray from `o` with unit direction `d` that meets no mesh.
    fn end(&self, cx: &Context<'_>, end: End, o: Vec3, d: Vec3, arrival: &Arrival, out: &mut impl Sink);
}
