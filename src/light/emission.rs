//! What a surface emits, as its material says: a colour or a picture, from one side or both, where it has no holes.

use crate::math::{Rgb, Vec2, luminance, warp};
use crate::shape::Mesh;
use crate::texture::{Opacity, Texture};

/// What a material emits.
#[derive(Clone, Debug)]
pub struct Emission {
    /// Radiance, the same in all directions; of a picture its mean, by which lights are chosen.
    pub radiance: Rgb,
    /// True: from both sides; false: from the side `ng` points to.
    pub two_sided: bool,
    /// Radiance as a picture.
    pub texture: Option<Box<Texture>>,
    /// Where the surface is there. A ray that meets a hole goes on; a light sample must count what is there.
    pub opacity: Option<Box<Opacity>>,
}

impl Emission {
    /// Radiance at texture coordinates `uv` of a surface that is there.
    #[inline(always)]
    pub(super) fn at(&self, uv: Vec2) -> Rgb {
        match &self.texture {
            None => self.radiance,
            Some(texture) => texture.rgb(uv).max(Rgb::ZERO).min(Rgb::splat(Self::LARGEST)),
        }
    }

    /// What a point at texture coordinates `uv` (none: it has none) sends in the mean, with its holes.
    #[inline(always)]
    pub(super) fn there(&self, uv: Option<Vec2>) -> Rgb {
        self.at(uv.unwrap_or_default()) * self.opacity.as_ref().map_or(1.0, |opacity| opacity.at(uv))
    }

    /// Radiance above this is cut, as the scene file does.
    const LARGEST: f32 = 1e12;

    /// True when points of one triangle send different light, or none.
    #[inline(always)]
    pub(super) fn varies(&self) -> bool {
        self.texture.is_some() || self.opacity.is_some()
    }

    /// Luminance by which triangle `t` of a mesh is chosen: of a picture its mean over the triangle, from a few points.
    /// They may miss what shines, so it never falls below a share of the whole picture's.
    pub(super) fn luminance_over(&self, mesh: &Mesh, t: usize) -> f32 {
        const SIDE: u16 = 4;
        const LEAST: f32 = 0.05;
        let whole = luminance(self.radiance);
        let (Some(_), Some([a, b, c])) = (&self.texture, mesh.triangle_uvs(t)) else { return whole };
        let place = |i: u16| (f32::from(i) + 0.5) / f32::from(SIDE);
        let points = (0..SIDE * SIDE).map(|i| warp::triangle([place(i % SIDE), place(i / SIDE)]));
        let sum: f32 = points.map(|[u, v]| luminance(self.at(a * (1.0 - u - v) + b * u + c * v))).sum();
        (sum / f32::from(SIDE * SIDE)).max(LEAST * whole)
    }
}
