//! Boxes in f64, for what is placed and moved before it is rounded.

use crate::math::{Aabb, DVec3};
use glam::DAffine3;

/// A box in f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds64 {
    /// Smallest corner.
    pub min: DVec3,
    /// Largest corner.
    pub max: DVec3,
}

impl Bounds64 {
    /// The box that holds nothing.
    pub const EMPTY: Bounds64 = Bounds64 { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The same box.
    pub fn of(bounds: &Aabb) -> Bounds64 {
        Bounds64 { min: bounds.min.as_dvec3(), max: bounds.max.as_dvec3() }
    }

    /// True when no point lies inside.
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// The eight corners.
    pub fn corners(&self) -> [DVec3; 8] {
        let ends = [self.min, self.max];
        let pick = |i: usize, bit: usize| ends[i >> bit & 1];
        std::array::from_fn(|i| DVec3::new(pick(i, 0).x, pick(i, 1).y, pick(i, 2).z))
    }

    /// The smallest box around both.
    #[must_use]
    pub fn union(&self, other: &Bounds64) -> Bounds64 {
        Bounds64 { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The smallest box around the transformed corners.
    #[must_use]
    pub fn moved(&self, transform: &DAffine3) -> Bounds64 {
        if self.is_empty() {
            return *self;
        }
        let corners = self.corners().map(|p| transform.transform_point3(p));
        corners.iter().fold(Bounds64::EMPTY, |b, p| Bounds64 { min: b.min.min(*p), max: b.max.max(*p) })
    }

    /// The box with so much added on all sides.
    #[must_use]
    pub fn grown(&self, by: f64) -> Bounds64 {
        Bounds64 { min: self.min - by, max: self.max + by }
    }
}
