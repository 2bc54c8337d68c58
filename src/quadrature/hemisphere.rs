//! The notes' rules for the integral over the hemisphere (13.5–13.8): N directions, each with the size of the
//! region that it stands for.
//!
//! Eq. (15) is ∫∫ ρ·L·(n·d) sin θ dθ dφ. Every rule here estimates it as Σ_k ρ·L·(n·d_k)·Δω_k: a rule is a list
//! of directions d_k with solid angles Δω_k, for a grid the sin θ Δθ Δφ of eq. (18), for random points the
//! inverse of N times their density, eq. (20). Directions are local, z along the normal, and follow eq. (2):
//! (sin θ sin φ, sin θ cos φ, cos θ).

pub use super::fan::Fan;

use crate::error::{Result, lookup};
use crate::math::Vec3;
use crate::math::approx::sin_cos_turn;
use std::f64::consts::{PI, TAU};

/// How the directions are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HemisphereRule {
    /// A grid of midpoints in θ and φ: eq. (18) with its points in the middle of their cells.
    Uniform,
    /// The grid of eq. (16) and (17): left edges, so that the first ring lies on the pole and counts nothing.
    UniformCorner,
    /// Independent random directions: eq. (10) in two dimensions.
    Random {
        /// In what they are uniform.
        measure: Measure,
    },
    /// Random directions within equal cells: 13.6.
    Stratified {
        /// In what the cells are equal.
        measure: Measure,
        /// J, directions in each cell.
        per_cell: u32,
    },
    /// Cells of equal projected solid angle, eq. (19).
    Nonuniform {
        /// 0: one direction in the middle of each cell; J: that many random ones in it.
        per_cell: u32,
    },
    /// Random directions with the density of the BSDF or of the lights, eq. (20).
    Importance,
    /// Owen-scrambled Sobol points instead of random ones.
    Sobol {
        /// In what they are uniform.
        measure: Measure,
    },
}

/// In what random directions are uniform.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Measure {
    /// The angles θ and φ, as the notes have it: Δω = sin θ·π²/N.
    Angles,
    /// Solid angle: Δω = 2π/N.
    SolidAngle,
    /// Solid angle times cosine: Δω = π/(N cos θ).
    Projected,
}

impl Measure {
    /// Name, meaning, value.
    pub const TABLE: &'static [(&'static str, &'static str, Measure)] = &[
        ("angles", "uniform in theta and phi, as in the notes", Measure::Angles),
        ("solid-angle", "uniform in solid angle", Measure::SolidAngle),
        ("projected", "uniform in solid angle times cosine", Measure::Projected),
    ];

    /// The measure of that name.
    ///
    /// # Errors
    /// A word that is none.
    pub fn from_name(word: &str) -> Result<Measure> {
        lookup("measure", word, Self::TABLE)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        crate::error::name_in(&self, Self::TABLE)
    }

    /// The direction at `u` of the unit square, u₀ along θ and u₁ along φ, and its Δω for N = 1.
    #[inline(always)]
    pub(super) fn direction(self, u: [f32; 2]) -> (Vec3, f32) {
        let (sin_theta, cos_theta, solid_angle) = match self {
            Measure::Angles => {
                let (s, c) = sin_cos_turn(0.25 * u[0]);
                (s, c, s * (PI * PI) as f32)
            }
            Measure::SolidAngle => {
                let c = 1.0 - u[0];
                ((u[0] * (1.0 + c)).sqrt(), c, TAU as f32)
            }
            Measure::Projected => {
                let c = (1.0 - u[0]).sqrt();
                (u[0].sqrt(), c, PI as f32 / c)
            }
        };
        let (sin_phi, cos_phi) = sin_cos_turn(u[1]);
        (Vec3::new(sin_theta * sin_phi, sin_theta * cos_phi, cos_theta), solid_angle)
    }
}

impl HemisphereRule {
    /// Name, meaning, value with its usual parameters.
    pub const TABLE: &'static [(&'static str, &'static str, HemisphereRule)] = {
        const ANGLES: Measure = Measure::Angles;
        &[
            ("uniform", "a grid of midpoints in theta and phi (18)", HemisphereRule::Uniform),
            ("uniform-corner", "the grid of left edges of (16)-(18)", HemisphereRule::UniformCorner),
            ("random", "independent random directions (10)", HemisphereRule::Random { measure: ANGLES }),
            (
                "stratified",
                "random directions within equal cells (13.6)",
                HemisphereRule::Stratified { measure: ANGLES, per_cell: 1 },
            ),
            (
                "nonuniform",
                "cells of equal projected solid angle (19)",
                HemisphereRule::Nonuniform { per_cell: 0 },
            ),
            ("importance", "the density of BSDF and lights (20)", HemisphereRule::Importance),
            ("sobol", "Owen-scrambled Sobol points", HemisphereRule::Sobol { measure: ANGLES }),
        ]
    };

    /// The rule of that name.
    ///
    /// # Errors
    /// A word that is none.
    pub fn from_name(word: &str) -> Result<HemisphereRule> {
        lookup("hemisphere rule", word, Self::TABLE)
    }

    /// Its name.
    pub fn name(&self) -> &'static str {
        match self {
            HemisphereRule::Uniform => "uniform",
            HemisphereRule::UniformCorner => "uniform-corner",
            HemisphereRule::Random { .. } => "random",
            HemisphereRule::Stratified { .. } => "stratified",
            HemisphereRule::Nonuniform { .. } => "nonuniform",
            HemisphereRule::Importance => "importance",
            HemisphereRule::Sobol { .. } => "sobol",
        }
    }

    /// The measure of random points, for the rules that have one.
    pub fn measure(&self) -> Option<Measure> {
        match *self {
            HemisphereRule::Random { measure }
            | HemisphereRule::Stratified { measure, .. }
            | HemisphereRule::Sobol { measure } => Some(measure),
            _ => None,
        }
    }

    /// Directions in each cell, for the rules that have cells with random points.
    pub fn per_cell(&self) -> Option<u32> {
        match *self {
            HemisphereRule::Stratified { per_cell, .. } | HemisphereRule::Nonuniform { per_cell } => {
                Some(per_cell)
            }
            _ => None,
        }
    }

    /// True when the directions are the same for every seed.
    pub fn is_deterministic(&self) -> bool {
        use HemisphereRule::*;
        matches!(self, Uniform | UniformCorner | Nonuniform { per_cell: 0 })
    }

    /// N, the number of directions over `cells`.
    pub fn count(&self, cells: Cells) -> u32 {
        cells.count().saturating_mul(self.per_cell().unwrap_or(1).max(1))
    }
}

/// M×N cells of the hemisphere: M in θ from the pole, N in φ.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cells {
    /// M, along θ.
    pub theta: u32,
    /// N, along φ.
    pub phi: u32,
}

impl Cells {
    /// About as many cells along θ as along φ, `count` in all; a prime count gives a single ring.
    pub fn of(count: u32) -> Cells {
        let theta = (1..=count.isqrt()).rev().find(|m| count.is_multiple_of(*m)).unwrap_or(1);
        Cells { theta, phi: count.max(1) / theta }
    }

    /// M·N.
    pub fn count(self) -> u32 {
        self.theta.saturating_mul(self.phi)
    }
}

#[cfg(test)]
#[path = "hemisphere_tests.rs"]
mod tests;
