//! What shines: environments and points as plain data ([`Light`]), emissive triangles found in the meshes,
//! and [`Lights`], which chooses among all of them by power.
//!
//! Radiance in W/(m²·sr), a point's intensity in W/sr. Directions `wi` point from the surface to the light.

mod environment;
mod lights;
mod point;

pub use environment::Environment;
pub use lights::{Emission, LightSample, Lights};
pub use point::Point;

/// A light that is no geometry.
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// Light from infinitely far away, all around.
    Environment(Environment),
    /// A point that sends the same intensity in all directions.
    Point(Point),
}

impl Light {
    /// Every kind's name in scene files, with what it is.
    pub const NAMES: &'static [(&'static str, &'static str)] = &[
        ("environment", "light from all around: constant radiance, or a built-in sky"),
        ("point", "the same intensity (W/sr) in all directions"),
    ];
}
