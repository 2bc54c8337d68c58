//! The GGX microfacet distribution with height-correlated Smith shadowing (Walter et al. 2007, Heitz 2014),
//! sampled by visible normals (Heitz 2018, in the form of Dupuy and Benyoub 2023). What one scattering loses is
//! in [`super::energy`].

use crate::math::approx::sin_cos_turn;
use crate::math::{Vec2, Vec3};
use std::f32::consts::FRAC_1_PI;

/// Below this α a surface is smooth: its lobe is narrower than f32 can resolve.
pub const SMOOTH: f32 = 1e-4;

/// What an anisotropy of 1 takes off the squared aspect of [`widths`]: Burley's 0.9.
pub const STRONGEST: f32 = 0.9;

/// α along x and along y for a surface of width `alpha` and `anisotropy` in [−1, 1]: positive makes the highlight
/// longer along x (the grain runs along y). The aspect is Burley's (2012), and no α exceeds 1.
#[inline(always)]
pub fn widths(alpha: f32, anisotropy: f32) -> Vec2 {
    let aspect = (1.0 - STRONGEST * anisotropy.abs()).sqrt();
    let (narrow, wide) = ((alpha * aspect).max(SMOOTH), (alpha / aspect).min(1.0));
    if anisotropy >= 0.0 { Vec2::new(wide, narrow) } else { Vec2::new(narrow, wide) }
}

/// D(m), per projected area of the macrosurface.
#[inline(always)]
pub fn d(m: Vec3, alpha: Vec2) -> f32 {
    // x² + y² instead of 1 − z²: exact where the normal is near the pole and alpha is small.
    let (x, y) = (m.x / alpha.x, m.y / alpha.y);
    let s = x * x + y * y + m.z * m.z;
    FRAC_1_PI / (alpha.x * alpha.y * s * s)
}

/// Smith's Λ(w), the same on both sides of the surface.
#[inline(always)]
pub fn lambda(w: Vec3, alpha: Vec2) -> f32 {
    let (x, y) = (alpha.x * w.x, alpha.y * w.y);
    0.5 * ((1.0 + (x * x + y * y) / (w.z * w.z)).sqrt() - 1.0)
}

/// A microfacet normal, distributed as seen from `wo` (`wo.z > 0`): with density D(m)·G1(wo)·(wo·m)/wo.z.
#[inline(always)]
pub fn sample_visible_normal(wo: Vec3, alpha: Vec2, u: [f32; 2]) -> Vec3 {
    let stretched = Vec3::new(alpha.x * wo.x, alpha.y * wo.y, wo.z).normalize();
    let (sin, cos) = sin_cos_turn(u[0]);
    let z = (1.0 - u[1]) * (1.0 + stretched.z) - stretched.z;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let h = Vec3::new(r * cos, r * sin, z) + stretched;
    Vec3::new(alpha.x * h.x, alpha.y * h.y, h.z.max(1e-12)).normalize()
}
