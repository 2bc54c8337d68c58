//! Which part of a surface is there.

use super::Texture;
use crate::math::Vec2;

/// The share of hits that count; the rest of the light goes straight on, as through holes too small to see.
#[derive(Clone, Debug, PartialEq)]
pub struct Opacity {
    /// The share, 0 to 1, where there is no picture or the surface has no texture coordinates.
    pub constant: f32,
    /// The share as a picture.
    pub texture: Option<Texture>,
}

impl Opacity {
    /// The share at texture coordinates `uv`, 0 to 1.
    pub fn at(&self, uv: Option<Vec2>) -> f32 {
        match (&self.texture, uv) {
            (Some(texture), Some(uv)) => texture.number(uv).clamp(0.0, 1.0),
            _ => self.constant,
        }
    }
}
