//! What pictures change of a material from place to place.

use super::Scatter;
use super::parameter::{Channels, Parameter};
use crate::math::{Rgb, Vec2, Vec3};
use crate::shape::{Mesh, Surface};
use crate::texture::{Opacity, Relief, Tangents, Texture};

/// One number or colour of the BSDF as a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// What it sets.
    pub parameter: Parameter,
    /// The picture.
    pub texture: Texture,
}

impl Map {
    /// The value at texture coordinates `uv`, within the parameter's range.
    fn at(&self, uv: Vec2) -> Rgb {
        self.parameter.clamp(match self.parameter.channels() {
            Channels::Color => self.texture.rgb(uv),
            Channels::Number => Rgb::splat(self.texture.number(uv)),
        })
    }
}

/// Everything that changes over a surface. All its triangles have texture coordinates, unless nothing but a constant
/// opacity is here.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Maps {
    /// Of the BSDF.
    pub parameters: Vec<Map>,
    /// Emitted radiance, in place of the material's.
    pub emission: Option<Texture>,
    /// How much of the surface is there, where that is not all of it.
    pub opacity: Option<Opacity>,
    /// How the shading normal turns.
    pub relief: Option<Relief>,
}

impl Maps {
    /// Hands every parameter's value at texture coordinates `uv` to `set`.
    pub fn each(&self, uv: Vec2, mut set: impl FnMut(Parameter, Rgb)) {
        for map in &self.parameters {
            set(map.parameter, map.at(uv));
        }
    }

    /// `plain` as it is at texture coordinates `uv`.
    pub fn applied<B: Scatter + Clone>(&self, plain: &B, uv: Vec2) -> B {
        let mut bsdf = plain.clone();
        self.each(uv, |parameter, value| {
            bsdf.set(parameter, value);
        });
        bsdf
    }

    /// True when something depends on texture coordinates.
    pub fn have_pictures(&self) -> bool {
        let hides = self.opacity.as_ref().is_some_and(|opacity| opacity.texture.is_some());
        hides || !self.parameters.is_empty() || self.emission.is_some() || self.relief.is_some()
    }

    /// The shading normal at a point of a triangle.
    pub fn normal(&self, surface: &Surface, mesh: &Mesh, triangle: usize) -> Vec3 {
        let turned = self.relief.as_ref().and_then(|relief| {
            let tangents = Tangents::new(mesh, triangle, mesh.triangle_uvs(triangle)?)?;
            Some(relief.normal(surface.ns, surface.ng, &tangents, surface.uv))
        });
        turned.unwrap_or(surface.ns)
    }
}
