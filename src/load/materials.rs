//! From what files say about materials to [`Material`]s: a model with its numbers, which an MTL sets and
//! `[materials.NAME]` changes key by key before it is built.

use super::texture::MapSpec;
use crate::bsdf::{Bsdf, Diffuse, Material, Mix};
use crate::math::Rgb;

/// A material before it is built.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MaterialSpec {
    /// The name in the file.
    pub name: String,
    /// The model with its numbers.
    pub model: Bsdf,
    /// Emitted radiance.
    pub emission: Rgb,
    /// Whether the back scatters and emits as well.
    pub two_sided: bool,
    /// The share of hits that count, 0 to 1; the rest of the light goes straight on.
    pub opacity: f32,
    /// By how many degrees an anisotropic model's x axis is turned from growing u towards growing v.
    pub rotation: f32,
    /// Pictures in place of constants.
    pub maps: Vec<MapSpec>,
    /// A mixture of others.
    pub mix: Option<MixSpec>,
}

/// A mixture before its parts are found.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MixSpec {
    /// The parts' names.
    pub names: [String; 2],
    /// The share of the second.
    pub amount: f32,
    /// Their ids, once they have some.
    pub ids: [u32; 2],
}

impl MaterialSpec {
    /// A two-sided diffuse material that emits nothing.
    pub fn diffuse(name: impl Into<String>, reflectance: Rgb) -> Self {
        MaterialSpec {
            name: name.into(),
            model: Bsdf::Diffuse(Diffuse { reflectance }),
            emission: Rgb::ZERO,
            two_sided: true,
            opacity: 1.0,
            rotation: 0.0,
            maps: Vec::new(),
            mix: None,
        }
    }

    /// The material that is rendered, before its pictures and holes are put on.
    pub fn build(self) -> Material {
        Material {
            name: self.name,
            bsdf: self.model,
            emission: self.emission,
            two_sided: self.two_sided,
            maps: None,
            mix: self.mix.map(|mix| Mix { parts: mix.ids, amount: mix.amount }),
        }
    }
}
