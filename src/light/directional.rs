//! Light that arrives from one direction, like the sun's without its width.

use crate::math::{Rgb, Vec3};

/// Parallel light; it cannot be hit, only sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Directional {
    /// Unit direction in which the light travels.
    pub direction: Vec3,
    /// W/m² on a plane that faces it.
    pub irradiance: Rgb,
}
