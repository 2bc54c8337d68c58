//! The soft rim of cloth: the cylindrical microfacets of Estevez and Kulla (2017), D = (2 + 1/r)/(2π)·sin^(1/r) θh,
//! with the smooth visibility of Neubelt and Pettineo (2013), V = 1/(4(μo + μi − μo·μi)), and its tabulated albedo.
//!
//! At grazing angles that visibility lets narrow rims send back more than arrives, up to a third more: [`f_cos`] is divided
//! by the larger of the two directions' albedos where it exceeds 1, which is reciprocal.

use crate::math::Vec3;
use std::f32::consts::{PI, TAU};
use std::sync::OnceLock;

/// Below this roughness the rim would be narrower than the table's cells.
const NARROWEST: f32 = 0.1;

/// f·cos θi of white sheen with roughness `r`.
#[inline]
pub fn f_cos(wo: Vec3, wi: Vec3, r: f32) -> f32 {
    unlimited(wo, wi, r) / tabulated(wo.z, r).max(tabulated(wi.z, r)).max(1.0)
}

fn unlimited(wo: Vec3, wi: Vec3, r: f32) -> f32 {
    let Some(h) = (wo + wi).try_normalize() else { return 0.0 };
    let power = 1.0 / r.max(NARROWEST);
    let sin = (h.x * h.x + h.y * h.y).sqrt().min(1.0);
    let d = (2.0 + power) / TAU * libm::powf(sin, power);
    d * wi.z / (4.0 * (wo.z + wi.z - wo.z * wi.z))
}

/// Nodes in √μ and in the root of what r exceeds [`NARROWEST`] by.
const MU: usize = 32;
const R: usize = 16;

/// The directional albedo of white sheen, or a little more.
pub fn albedo(mu: f32, r: f32) -> f32 {
    tabulated(mu, r).min(1.0)
}

/// What [`integrate`] says of the unlimited sheen, by a table and with what its interpolation errs.
fn tabulated(mu: f32, r: f32) -> f32 {
    static TABLE: OnceLock<Vec<f32>> = OnceLock::new();
    let table = TABLE.get_or_init(|| {
        let node = |i: usize, n: usize| i as f32 / (n - 1) as f32;
        let width = |x: f32| NARROWEST + (1.0 - NARROWEST) * x * x;
        let row =
            |j: usize| (0..MU).map(move |i| integrate(node(i, MU).powi(2).max(1e-4), width(node(j, R))));
        (0..R).flat_map(row).collect()
    });
    let place = |x: f32, n: usize| {
        let x = x.clamp(0.0, 1.0) * (n - 1) as f32;
        let i = (x as usize).min(n - 2);
        (i, x - i as f32)
    };
    let ((i, s), (j, t)) = (
        place(mu.max(0.0).sqrt(), MU),
        place(((r.max(NARROWEST) - NARROWEST) / (1.0 - NARROWEST)).sqrt(), R),
    );
    let row = |j: usize| table[j * MU + i] * (1.0 - s) + table[j * MU + i + 1] * s;
    1.005 * (row(j) * (1.0 - t) + row(j + 1) * t) + 0.001
}

/// ∫f·cos over the hemisphere by midpoints, dense towards the horizon.
fn integrate(mu: f32, r: f32) -> f32 {
    let wo = Vec3::new((1.0 - mu * mu).sqrt(), 0.0, mu);
    let (rows, columns) = (48, 24);
    let mut sum = 0.0;
    for i in 0..rows {
        let x = (i as f32 + 0.5) / rows as f32;
        let (z, dz) = (x * x, 2.0 * x / rows as f32);
        for j in 0..columns {
            let (sin, cos) = crate::math::approx::sin_cos_turn(0.5 * (j as f32 + 0.5) / columns as f32);
            let s = (1.0 - z * z).sqrt();
            sum += f64::from(unlimited(wo, Vec3::new(s * cos, s * sin, z), r) * dz);
        }
    }
    (sum / columns as f64) as f32 * 2.0 * PI
}
