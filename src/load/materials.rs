//! From what files say about materials to [`Material`]s: a model with its numbers, which an MTL sets and
//! `[materials.NAME]` changes key by key before it is built.

use super::texture::MapSpec;
use crate::bsdf::fresnel::Reflectance;
use crate::bsdf::{Bsdf, Conductor, Dielectric, Diffuse, Material, Mirror, Phong, Translucent};
use crate::math::Rgb;

/// A material before it is built.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct MaterialSpec {
    /// The name in the file.
    pub name: String,
    /// The model with its numbers.
    pub model: Model,
    /// Emitted radiance.
    pub emission: Rgb,
    /// Whether the back scatters and emits as well.
    pub two_sided: bool,
    /// The share of hits that count, 0 to 1; the rest of the light goes straight on.
    pub opacity: f32,
    /// Pictures in place of constants.
    pub maps: Vec<MapSpec>,
}

/// A scattering model with its numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Model {
    Diffuse { reflectance: Rgb },
    Mirror { reflectance: Rgb },
    Conductor { reflectance: Reflectance, alpha: f32, compensate: bool },
    Phong { diffuse: Rgb, specular: Rgb, exponent: f32 },
    Dielectric { ior: f32, tint: Rgb },
    Translucent { reflectance: Rgb, transmittance: Rgb },
}

impl Model {
    /// Its name in scene files.
    pub fn name(&self) -> &'static str {
        match self {
            Model::Diffuse { .. } => "diffuse",
            Model::Mirror { .. } => "mirror",
            Model::Conductor { .. } => "conductor",
            Model::Phong { .. } => "phong",
            Model::Dielectric { .. } => "dielectric",
            Model::Translucent { .. } => "translucent",
        }
    }
}

impl MaterialSpec {
    /// A two-sided diffuse material that emits nothing.
    pub fn diffuse(name: impl Into<String>, reflectance: Rgb) -> Self {
        let model = Model::Diffuse { reflectance };
        MaterialSpec { name: name.into(), model, emission: Rgb::ZERO, two_sided: true, opacity: 1.0, maps: Vec::new() }
    }

    /// The material that is rendered, before its pictures and holes are put on.
    pub fn build(self) -> Material {
        let bsdf = match self.model {
            Model::Diffuse { reflectance } => Bsdf::Diffuse(Diffuse { reflectance }),
            Model::Mirror { reflectance } => Bsdf::Mirror(Mirror { reflectance }),
            Model::Conductor { reflectance, alpha, compensate } => {
                Bsdf::Conductor(Conductor::new(reflectance, alpha, compensate))
            }
            Model::Phong { diffuse, specular, exponent } => {
                Bsdf::Phong(Phong::new(diffuse, specular, exponent))
            }
            Model::Dielectric { ior, tint } => Bsdf::Dielectric(Dielectric::new(ior, tint)),
            Model::Translucent { reflectance, transmittance } => {
                Bsdf::Translucent(Translucent::new(reflectance, transmittance))
            }
        };
        Material { name: self.name, bsdf, emission: self.emission, two_sided: self.two_sided, maps: None }
    }
}
