//! The GGX microfacet distribution with height-correlated Smith shadowing (Walter et al. 2007, Heitz 2014),
//! sampled by visible normals (Heitz 2018, in the form of Dupuy and Benyoub 2023), and the energy that one
//! scattering loses, tabulated for the compensation of Kulla and Conty 2017.

use crate::math::Vec3;
use crate::math::approx::sin_cos_turn;
use std::f32::consts::FRAC_1_PI;
use std::sync::OnceLock;

/// D(m), per projected area of the macrosurface.
#[inline(always)]
pub fn d(m: Vec3, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    // x² + y² instead of 1 − z²: exact where the normal is near the pole and alpha is small.
    let s = (m.x * m.x + m.y * m.y) / a2 + m.z * m.z;
    FRAC_1_PI / (a2 * s * s)
}

/// Smith's Λ(w).
#[inline(always)]
pub fn lambda(w: Vec3, alpha: f32) -> f32 {
    let tan2 = (w.x * w.x + w.y * w.y) / (w.z * w.z);
    0.5 * ((1.0 + alpha * alpha * tan2).sqrt() - 1.0)
}

/// A microfacet normal, distributed as seen from `wo` (`wo.z > 0`).
#[inline(always)]
pub fn sample_visible_normal(wo: Vec3, alpha: f32, u: [f32; 2]) -> Vec3 {
    let stretched = Vec3::new(alpha * wo.x, alpha * wo.y, wo.z).normalize();
    let (sin, cos) = sin_cos_turn(u[0]);
    let z = (1.0 - u[1]) * (1.0 + stretched.z) - stretched.z;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let h = Vec3::new(r * cos, r * sin, z) + stretched;
    Vec3::new(alpha * h.x, alpha * h.y, h.z.max(1e-12)).normalize()
}

/// Cells of the energy table per axis.
const CELLS: usize = 48;

/// The directional albedo E(μ, α) of one scattering off a perfectly reflecting surface, and its average.
pub struct Energy {
    directional: Vec<f32>,
    average: Vec<f32>,
}

/// The table, computed at first use (a few milliseconds).
pub fn energy() -> &'static Energy {
    static TABLE: OnceLock<Energy> = OnceLock::new();
    TABLE.get_or_init(Energy::compute)
}

impl Energy {
    /// μ and α of a node; μ is spaced quadratically, dense at grazing angles where E is steep.
    fn node(i: usize) -> f32 {
        i as f32 / (CELLS - 1) as f32
    }

    fn compute() -> Energy {
        let mut directional = vec![0.0; CELLS * CELLS];
        let mut average = vec![0.0; CELLS];
        for a in 0..CELLS {
            let alpha = Self::node(a).max(1e-3);
            for m in 0..CELLS {
                let mu = Self::node(m).powi(2).max(1e-4);
                directional[a * CELLS + m] = single_scattering_albedo(mu, alpha);
            }
            // 2∫E(μ)μdμ by the midpoint rule on the interpolated table.
            let n = 512;
            let row = &directional[a * CELLS..][..CELLS];
            let cell = |i: usize| {
                let mu = (i as f32 + 0.5) / n as f32;
                f64::from(lerp(row, mu.sqrt()) * mu)
            };
            average[a] = (2.0 * (0..n).map(cell).sum::<f64>() / n as f64) as f32;
        }
        Energy { directional, average }
    }

    /// E(μ, α).
    #[inline]
    pub fn directional(&self, mu: f32, alpha: f32) -> f32 {
        let x = alpha.clamp(0.0, 1.0) * (CELLS - 1) as f32;
        let i = (x as usize).min(CELLS - 2);
        let t = x - i as f32;
        let at = |row: usize| lerp(&self.directional[row * CELLS..][..CELLS], mu.clamp(0.0, 1.0).sqrt());
        at(i) * (1.0 - t) + at(i + 1) * t
    }

    /// The cosine-weighted average of E over μ.
    #[inline]
    pub fn average(&self, alpha: f32) -> f32 {
        lerp(&self.average, alpha)
    }
}

/// Linear interpolation in a row over [0, 1].
#[inline]
fn lerp(row: &[f32], x: f32) -> f32 {
    let x = x.clamp(0.0, 1.0) * (row.len() - 1) as f32;
    let i = (x as usize).min(row.len() - 2);
    let t = x - i as f32;
    row[i] * (1.0 - t) + row[i + 1] * t
}

/// E(μ, α) = E[G2/G1] over visible normals, by a 32×32 midpoint grid of the sampling square.
fn single_scattering_albedo(mu: f32, alpha: f32) -> f32 {
    let wo = Vec3::new((1.0 - mu * mu).max(0.0).sqrt(), 0.0, mu);
    let lambda_o = lambda(wo, alpha);
    let n = 32;
    let mut sum = 0.0;
    for i in 0..n {
        for j in 0..n {
            let u = [(i as f32 + 0.5) / n as f32, (j as f32 + 0.5) / n as f32];
            let m = sample_visible_normal(wo, alpha, u);
            let wi = m * (2.0 * wo.dot(m)) - wo;
            if wi.z > 0.0 {
                sum += f64::from((1.0 + lambda_o) / (1.0 + lambda_o + lambda(wi, alpha)));
            }
        }
    }
    (sum / f64::from(n * n)) as f32
}
