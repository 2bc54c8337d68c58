//! How surfaces scatter light: one file a model, the terms they share in [`fresnel`], [`ggx`] and
//! [`energy`].
//!
//! Directions are local: z along the shading normal, which is on the side of `wo`; `wo` points to the
//! viewer and `wi` to the light, both unit and both away from the surface. `f_cos` is the BRDF times
//! |cos θi| (the notes' ρ·(n·d_i) of eq. 1); `pdf` is per solid angle, and infinite for a direction that
//! only a delta can choose.
//!
//! A new model is one file, one variant of [`Bsdf`] and one line in [`Bsdf::NAMES`]. The small ones are inlined into the
//! integrators' loops; the larger ones, whose own work outweighs a call, are not, or they would be compiled for each
//! integrator and instruction set.

mod any;
mod coat;
pub mod conductor;
pub mod dielectric;
pub mod diffuse;
pub mod energy;
pub mod fresnel;
pub mod ggx;
mod maps;
pub mod metals;
pub mod mirror;
pub mod oren_nayar;
pub mod parameter;
pub mod phong;
pub mod plastic;
pub mod principled;
pub mod sheen;
pub mod translucent;

pub use conductor::Conductor;
pub use dielectric::Dielectric;
pub use diffuse::Diffuse;
pub use maps::{Grain, Map, Maps};
pub use mirror::Mirror;
pub use oren_nayar::OrenNayar;
pub use parameter::Parameter;
pub use phong::Phong;
pub use plastic::Plastic;
pub use principled::Principled;
pub use translucent::Translucent;

use crate::math::{Rgb, Vec3};
use std::sync::Arc;

/// A direction chosen by [`Scatter::sample`].
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// The direction to follow.
    pub wi: Vec3,
    /// f_cos/pdf.
    pub weight: Rgb,
    /// Density of `wi` per solid angle; infinite for a delta.
    pub pdf: f32,
}

/// Where a surface is seen from.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Unit direction to the viewer, `wo.z > 0`.
    pub wo: Vec3,
    /// True on the side that `ng` points to: outside a closed body.
    pub outside: bool,
}

/// What one vertex of a path asks of its material. Directions `wi` with `wi.z < 0` lie behind the surface:
/// light that passes through.
pub trait Scatter {
    /// True where there are no branches worth skipping and no tables: where that is true of all lanes of a batch, they
    /// are evaluated at once, whether in use or not, by the functions below.
    #[inline(always)]
    fn is_small(&self) -> bool {
        false
    }

    /// [`Scatter::eval`] of a small one, without a branch.
    #[inline(always)]
    fn eval_small(&self, view: &View, wi: Vec3) -> (Rgb, f32) {
        self.eval(view, wi)
    }

    /// [`Scatter::sample`] of a small one, without a branch: if the second is false, it is `None`.
    #[inline(always)]
    fn sample_small(&self, view: &View, u: [f32; 2]) -> (Sample, bool) {
        let none = Sample { wi: Vec3::ZERO, weight: Rgb::ZERO, pdf: 0.0 };
        self.sample(view, u, 0.0).map_or((none, false), |sample| (sample, true))
    }

    /// (f_cos, pdf) of the non-delta part. Zero where no light passes.
    fn eval(&self, view: &View, wi: Vec3) -> (Rgb, f32);

    /// A direction by importance: `u` places it, `lobe` chooses between lobes. `None` absorbs.
    fn sample(&self, view: &View, u: [f32; 2], lobe: f32) -> Option<Sample>;

    /// The sample that chose `wi` by the density of [`Scatter::eval`]; `None` where that is zero.
    #[inline(always)]
    fn towards(&self, view: &View, wi: Vec3) -> Option<Sample> {
        let (f_cos, pdf) = self.eval(view, wi);
        (pdf > 0.0 && pdf.is_finite()).then(|| Sample { wi, weight: f_cos / pdf, pdf })
    }

    /// True when [`Scatter::eval`] is zero everywhere, so that light samples would be wasted: all there is, are
    /// [`Scatter::deltas`].
    fn is_delta(&self) -> bool;

    /// The directions that only a delta chooses, for integrators that follow each of them instead of choosing by
    /// chance: the sum of their weights is the mean weight of the samples with infinite density.
    fn deltas(&self, _view: &View) -> [Option<Delta>; 2] {
        [None; 2]
    }

    /// True when light passes through by directions that are not deltas: `eval` is not zero for all `wi.z < 0`.
    fn transmits(&self) -> bool {
        false
    }

    /// Gives `parameter` the value, clamped to its range; a number is the first channel. False where the model has
    /// no such parameter. Cheap enough to be done at every hit.
    fn set(&mut self, parameter: Parameter, value: Rgb) -> bool;
}

/// One of the directions of [`Scatter::deltas`].
#[derive(Clone, Copy, Debug)]
pub struct Delta {
    /// The direction.
    pub wi: Vec3,
    /// What of the light from there goes on to `wo`.
    pub weight: Rgb,
}

/// The models.
#[expect(
    clippy::large_enum_variant,
    reason = "materials are few, and a box would be allocated at every textured hit"
)]
#[derive(Clone, Debug, PartialEq)]
pub enum Bsdf {
    /// Lambert's law.
    Diffuse(Diffuse),
    /// A perfect mirror.
    Mirror(Mirror),
    /// A metal, smooth or rough.
    Conductor(Conductor),
    /// Phong's cosine lobe over a diffuse base.
    Phong(Phong),
    /// Clear glass or water.
    Dielectric(Dielectric),
    /// A thin sheet that scatters to both sides.
    Translucent(Translucent),
    /// Lambert's law for rough surfaces.
    OrenNayar(OrenNayar),
    /// A clear coat over a diffuse base.
    Plastic(Plastic),
    /// Metal, clear body or coated base, with coat and sheen.
    Principled(Principled),
}

impl Bsdf {
    /// Every model's name in scene files, with what it is.
    pub const NAMES: &'static [(&'static str, &'static str)] = &[
        ("diffuse", "Lambert's law: the same radiance in all directions"),
        ("mirror", "a perfect mirror"),
        ("conductor", "a metal, smooth or rough (GGX)"),
        ("phong", "a diffuse base with Phong's highlight"),
        ("dielectric", "clear glass or water, smooth or rough (GGX), a body or a thin sheet"),
        ("translucent", "a thin sheet that scatters light to both sides"),
        ("oren-nayar", "a rough matte surface (energy-preserving)"),
        ("plastic", "a clear coat, smooth or rough, over a diffuse base"),
        ("principled", "one model for most things: base, metal, glass, coat, sheen"),
    ];

    /// The model's place in [`Bsdf::NAMES`]; waves shade lanes of one kind together.
    #[inline(always)]
    pub fn kind(&self) -> usize {
        match self {
            Bsdf::Diffuse(_) => 0,
            Bsdf::Mirror(_) => 1,
            Bsdf::Conductor(_) => 2,
            Bsdf::Phong(_) => 3,
            Bsdf::Dielectric(_) => 4,
            Bsdf::Translucent(_) => 5,
            Bsdf::OrenNayar(_) => 6,
            Bsdf::Plastic(_) => 7,
            Bsdf::Principled(_) => 8,
        }
    }

    /// The model's name in scene files.
    pub fn name(&self) -> &'static str {
        Bsdf::NAMES.get(self.kind()).map_or("", |row| row.0)
    }

    /// True for what is seen through though all of it is there.
    pub fn is_clear(&self) -> bool {
        match self {
            Bsdf::Dielectric(_) => true,
            Bsdf::Principled(m) => m.look().transmission > 0.0,
            _ => false,
        }
    }

    /// The share of light sent back on average, for the albedo layer.
    pub fn albedo(&self) -> Rgb {
        match self {
            Bsdf::Diffuse(m) => m.reflectance,
            Bsdf::Mirror(m) => m.reflectance,
            Bsdf::Conductor(m) => m.albedo(),
            Bsdf::Phong(m) => m.albedo(),
            Bsdf::Dielectric(m) => m.albedo(),
            Bsdf::Translucent(m) => m.albedo(),
            Bsdf::OrenNayar(m) => m.albedo(),
            Bsdf::Plastic(m) => m.albedo(),
            Bsdf::Principled(m) => m.albedo(),
        }
    }

    /// True when the model looks different from different sides of a point, so that the frame's axes matter.
    pub fn has_grain(&self) -> bool {
        match self {
            Bsdf::Conductor(m) => m.is_brushed(),
            Bsdf::Principled(m) => m.look().anisotropy != 0.0,
            _ => false,
        }
    }

    /// True when sampling needs the `lobe` number.
    pub fn has_lobes(&self) -> bool {
        match self {
            Bsdf::Diffuse(_) | Bsdf::Mirror(_) => false,
            Bsdf::Conductor(m) => m.compensates(),
            Bsdf::Phong(_)
            | Bsdf::Dielectric(_)
            | Bsdf::Translucent(_)
            | Bsdf::OrenNayar(_)
            | Bsdf::Plastic(_)
            | Bsdf::Principled(_) => true,
        }
    }
}

/// Two materials of which each hit takes one by chance, so that the picture is their mixture. Emission, opacity and
/// sides are the mixture's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mix {
    /// Ids of materials that come before the mixture's own.
    pub parts: [u32; 2],
    /// The share of the second, 0 to 1.
    pub amount: f32,
}

impl Mix {
    /// The name in scene files, with what it is, beside [`Bsdf::NAMES`].
    pub const NAME: (&'static str, &'static str) = ("mix", "two materials by their names, in a proportion");
}

/// A surface's material: how it scatters and what it emits.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The name in the MTL or scene file.
    pub name: String,
    /// How it scatters.
    pub bsdf: Bsdf,
    /// Emitted radiance, the same in all directions.
    pub emission: Rgb,
    /// False: only the side that `ng` points to scatters and emits; the other is black.
    pub two_sided: bool,
    /// What changes over the surface; `None` where nothing does.
    pub maps: Option<Arc<Maps>>,
    /// Other materials in place of `bsdf` and the relief.
    pub mix: Option<Mix>,
}

impl Material {
    /// A two-sided diffuse material that emits nothing.
    pub fn diffuse(name: impl Into<String>, reflectance: Rgb) -> Material {
        Material {
            name: name.into(),
            bsdf: Bsdf::Diffuse(Diffuse { reflectance }),
            emission: Rgb::ZERO,
            two_sided: true,
            maps: None,
            mix: None,
        }
    }
}

/// The mirror direction of `wo` about z.
#[inline(always)]
pub(crate) fn reflect(wo: Vec3) -> Vec3 {
    Vec3::new(-wo.x, -wo.y, wo.z)
}

#[cfg(test)]
mod tests;
