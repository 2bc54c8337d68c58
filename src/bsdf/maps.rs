//! What pictures change of a material from place to place.

use super::Scatter;
use super::parameter::{Channels, Parameter};
use crate::math::{Frame, Rgb, Vec2, Vec3};
use crate::shape::{Mesh, Surface};
use crate::texture::{Opacity, Relief, Tangents, Texture};
use glam::DAffine3;

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
    /// The frame's x axis on the surface: this much along growing u and along growing v (a cosine and a sine). `None`: the
    /// BSDF is the same all around.
    pub grain: Option<[f32; 2]>,
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

    /// The way of the grain on a triangle; `None` where the BSDF has none or the triangle no texture coordinates.
    pub fn grain_at(&self, mesh: &Mesh, triangle: usize) -> Option<Grain> {
        let shares = self.grain?;
        let tangents = Tangents::new(mesh, triangle, mesh.triangle_uvs(triangle)?)?;
        Some(Grain { tangents, shares })
    }
}

/// Which way an anisotropic BSDF's x axis lies at a hit.
#[derive(Clone, Copy, Debug)]
pub struct Grain {
    tangents: Tangents,
    /// As [`Maps::grain`].
    shares: [f32; 2],
}

impl Grain {
    /// The same of a mesh that is placed by `transform`.
    #[must_use]
    pub fn placed(self, transform: &DAffine3) -> Grain {
        let place = |v: Vec3| transform.transform_vector3(v.as_dvec3()).as_vec3();
        let Tangents { dpdu, dpdv } = self.tangents;
        Grain { tangents: Tangents { dpdu: place(dpdu), dpdv: place(dpdv) }, ..self }
    }

    /// The frame around the unit normal `n` with x along the grain; `None` where u grows along the normal.
    #[inline]
    pub fn frame(&self, n: Vec3) -> Option<Frame> {
        let [u, v] = self.tangents.around(n)?;
        Some(Frame::with_x(u * self.shares[0] + v * self.shares[1], n))
    }
}
