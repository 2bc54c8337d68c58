//! The notes' rules for the integral over the hemisphere (13.5–13.8): N directions, each with the size of the
//! region that it stands for.
//!
//! Eq. (15) is ∫∫ ρ·L·(n·d) sin θ dθ dφ. Every rule here estimates it as Σ_k ρ·L·(n·d_k)·Δω_k: a rule is a list
//! of directions d_k with solid angles Δω_k, for a grid the sin θ Δθ Δφ of eq. (18), for random points the
//! inverse of N times their density, eq. (20). Directions are local, z along the normal, and follow eq. (2):
//! (sin θ sin φ, sin θ cos φ, cos θ).

use crate::error::{Error, Result, lookup};
use crate::math::approx::sin_cos_turn;
use crate::math::{DVec3, Vec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

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
    fn direction(self, u: [f32; 2]) -> (Vec3, f32) {
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

/// The directions of one rule over some cells.
#[derive(Clone, Debug)]
pub struct Fan {
    count: u32,
    kind: Kind,
}

#[derive(Clone, Debug)]
enum Kind {
    /// Directions that are always the same, with their Δω.
    Table(Vec<(Vec3, f32)>),
    /// Points of the whole square.
    Free(Measure),
    /// Points within one cell after the other.
    Jittered(Measure, Cells),
}

impl Fan {
    /// Directions of one vertex at most.
    pub const MOST: u32 = 1 << 16;

    /// Prepares `rule`. The directions of [`HemisphereRule::Importance`] are the material's own; here they count only.
    ///
    /// # Errors
    /// No direction at all, or more than [`Fan::MOST`].
    pub fn new(rule: HemisphereRule, cells: Cells) -> Result<Fan> {
        let count = rule.count(cells);
        if count == 0 || count > Self::MOST {
            return Err(Error::new(format!(
                "{count} directions at a vertex; 1 to {} are possible",
                Self::MOST
            )));
        }
        let kind = match rule {
            HemisphereRule::Uniform => Kind::Table(grid(cells, 0.5)),
            HemisphereRule::UniformCorner => Kind::Table(grid(cells, 0.0)),
            HemisphereRule::Nonuniform { per_cell: 0 } => Kind::Table(equal_cells(cells)),
            HemisphereRule::Nonuniform { .. } => Kind::Jittered(Measure::Projected, cells),
            HemisphereRule::Stratified { measure, .. } => Kind::Jittered(measure, cells),
            HemisphereRule::Random { measure } | HemisphereRule::Sobol { measure } => Kind::Free(measure),
            HemisphereRule::Importance => Kind::Free(Measure::Projected),
        };
        Ok(Fan { count, kind })
    }

    /// N.
    #[inline(always)]
    pub fn count(&self) -> u32 {
        self.count
    }

    /// Direction k < N and its Δω; `u` in [0, 1)² places it where the rule leaves a choice.
    #[inline(always)]
    pub fn direction(&self, k: u32, u: [f32; 2]) -> (Vec3, f32) {
        let n = self.count as f32;
        match &self.kind {
            Kind::Table(table) => table[k as usize],
            Kind::Free(measure) => {
                let (wi, solid_angle) = measure.direction(u);
                (wi, solid_angle / n)
            }
            Kind::Jittered(measure, cells) => {
                let cell = k % cells.count();
                let (m, l) = (cell / cells.phi, cell % cells.phi);
                let within = |i: u32, u: f32, n: u32| ((i as f32 + u) / n as f32).min(BELOW_ONE);
                let (wi, solid_angle) =
                    measure.direction([within(m, u[0], cells.theta), within(l, u[1], cells.phi)]);
                (wi, solid_angle / n)
            }
        }
    }
}

/// The largest number below 1: the last cell's far edge belongs to nobody.
const BELOW_ONE: f32 = 1.0 - 0.5 * f32::EPSILON;

/// Eq. (16)–(18): θ_m = (m + shift)Δθ, φ_n = (n + shift)Δφ counted from 0, Δω = sin θ Δθ Δφ.
fn grid(cells: Cells, shift: f64) -> Vec<(Vec3, f32)> {
    let (d_theta, d_phi) = (FRAC_PI_2 / f64::from(cells.theta), TAU / f64::from(cells.phi));
    each(cells, |m, n| {
        let theta = (m + shift) * d_theta;
        (direction(theta, (n + shift) * d_phi), libm::sin(theta) * d_theta * d_phi)
    })
}

/// Eq. (19) with d_i = π/(M·N): rings between sin²θ = m/M and (m+1)/M hold the same projected solid angle, and the
/// point lies where half of its cell's is on each side. The cosine is part of the region's size here, so Δω is d_i/cos θ.
fn equal_cells(cells: Cells) -> Vec<(Vec3, f32)> {
    let d_phi = TAU / f64::from(cells.phi);
    let size = PI / (f64::from(cells.theta) * f64::from(cells.phi));
    each(cells, |m, n| {
        let theta = libm::asin(((m + 0.5) / f64::from(cells.theta)).sqrt());
        (direction(theta, (n + 0.5) * d_phi), size / libm::cos(theta))
    })
}

fn each(cells: Cells, point: impl Fn(f64, f64) -> (DVec3, f64)) -> Vec<(Vec3, f32)> {
    let pairs = (0..cells.theta).flat_map(|m| (0..cells.phi).map(move |n| (m, n)));
    let points = pairs.map(|(m, n)| point(f64::from(m), f64::from(n)));
    points.map(|(wi, solid_angle)| (wi.as_vec3(), solid_angle as f32)).collect()
}

/// Eq. (2).
fn direction(theta: f64, phi: f64) -> DVec3 {
    let (sin_theta, cos_theta) = (libm::sin(theta), libm::cos(theta));
    DVec3::new(sin_theta * libm::sin(phi), sin_theta * libm::cos(phi), cos_theta)
}

#[cfg(test)]
#[path = "hemisphere_tests.rs"]
mod tests;
