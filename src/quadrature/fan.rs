//! The directions of a hemisphere rule, ready to be followed.

use super::hemisphere::{Cells, HemisphereRule, Measure};
use crate::error::{Error, Result};
use crate::math::{DVec3, Vec3};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

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
