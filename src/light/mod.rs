//! What shines: environments and points as plain data ([`Light`]), emissive triangles found in the meshes,
//! and [`Lights`], which chooses among all of them by power.
//!
//! Radiance in W/(m²·sr), a point's intensity in W/sr. Directions `wi` point from the surface to the light.

mod directional;
mod environment;
mod lights;
mod point;
pub mod sphere;

pub use directional::Directional;
pub use environment::Environment;
pub use lights::{Emission, End, LightSample, Lights, Sampled};
pub use point::Point;
pub use sphere::Sphere;

/// A light that is no mesh. (A rectangle is one: two triangles with an emissive material.)
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// Light from infinitely far away, all around.
    Environment(Environment),
    /// A point that sends the same intensity in all directions.
    Point(Point),
    /// Parallel light.
    Directional(Directional),
    /// A spherical lamp.
    Sphere(Sphere),
}

impl Light {
    /// Every kind's name in scene files, with what it is.
    pub const NAMES: &'static [(&'static str, &'static str)] = &[
        ("environment", "light from all around: constant radiance, or a built-in sky"),
        ("point", "the same intensity (W/sr) in all directions"),
        ("directional", "parallel light of an irradiance (W/m²)"),
        ("sphere", "a spherical lamp of a radiance; seen and blocking"),
        ("rectangle", "a flat lamp of a radiance; seen and blocking"),
    ];
}
