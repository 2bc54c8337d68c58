//! Vectors, rays, sampling warps and the numerics that must be the same on every machine.
//!
//! Everything here is pure: no scene, no I/O. Colours are linear Rec.709 ([`Rgb`]); directions are unit
//! vectors unless said otherwise; f32 in the render path, f64 where scenes are placed and sums are kept.

pub mod aabb;
pub mod approx;
#[cfg(test)]
pub(crate) mod chi_square;
pub mod digest;
pub mod distribution;
pub mod frame;
pub mod isa;
pub mod mis;
pub mod ray;
pub mod soa;
pub mod solid_angle;
pub mod srgb;
pub mod warp;

pub use aabb::Aabb;
pub use frame::Frame;
pub use glam::{DMat4, DVec3, UVec2, Vec2, Vec3};
pub use soa::Vec3s;

/// Linear RGB with Rec.709 primaries; radiance in W/(m²·sr) unless said otherwise.
pub type Rgb = Vec3;

/// Rec.709 luminance of a linear colour.
#[inline]
pub fn luminance(c: Rgb) -> f32 {
    0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z
}
