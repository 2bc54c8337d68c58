//! What shines: lights as plain data ([`Light`]), emissive triangles found in the meshes, and [`Lights`], which chooses
//! among all of them by what they can mean to a point.
//!
//! Radiance in W/(m²·sr), a point's intensity in W/sr. Directions `wi` point from the surface to the light.

pub mod bounds;
#[cfg(test)]
mod density_tests;
mod directional;
pub mod distant;
mod emission;
mod environment;
pub mod importance;
mod lights;
mod openings;
pub mod panorama;
pub mod patch;
mod point;
pub mod preetham;
mod reach;
mod receiver;
mod samples;
mod single;
pub mod sphere;
mod spot;
mod sun;
pub mod tree;

pub use directional::Directional;
pub use emission::Emission;
pub use environment::Environment;
pub use lights::{End, Lights, Sampled};
pub use openings::{Escape, Openings};
pub use panorama::Panorama;
pub use point::Point;
pub use reach::LightSample;
pub use receiver::Receiver;
pub use samples::LightSamples;
pub use sphere::Sphere;
pub use spot::Spot;
pub use sun::Sun;

/// A light that is no mesh. (A rectangle is one: two triangles with an emissive material.)
#[derive(Clone, Debug, PartialEq)]
pub enum Light {
    /// Light from infinitely far away, all around.
    Environment(Environment),
    /// A point that sends the same intensity in all directions.
    Point(Point),
    /// A point that sends light into a cone.
    Spot(Spot),
    /// Parallel light.
    Directional(Directional),
    /// A disc infinitely far away.
    Sun(Sun),
    /// A spherical lamp.
    Sphere(Sphere),
}

impl Light {
    /// Every kind's name in scene files, with what it is.
    pub const NAMES: &'static [(&'static str, &'static str)] = &[
        ("environment", "light from all around: constant radiance, a picture, or a built-in sky"),
        ("sun-sky", "daylight by place of the sun and turbidity"),
        ("point", "the same intensity (W/sr) in all directions"),
        ("spot", "an intensity (W/sr) on the axis of a cone with a soft edge"),
        ("directional", "parallel light of an irradiance (W/m²)"),
        ("sphere", "a spherical lamp of a radiance; seen and blocking"),
        ("rectangle", "a flat lamp of a radiance; seen and blocking"),
    ];
}
