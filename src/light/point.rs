//! The point light.

use crate::math::{Rgb, Vec3};

/// A point that sends the same intensity in all directions; it cannot be hit, only sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Where it is, in scene coordinates.
    pub position: Vec3,
    /// W/sr.
    pub intensity: Rgb,
}
