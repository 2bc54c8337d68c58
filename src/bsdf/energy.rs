//! How much light one scattering at a GGX surface keeps, tabulated: what it loses is what compensation gives back
//! (Kulla and Conty 2017), and what a coat does not reflect is what reaches the base below.
//!
//! Tables are computed when a material first asks for them, some milliseconds each, and kept.

use super::{fresnel, ggx};
use crate::math::{Vec2, Vec3};
use std::sync::OnceLock;

/// Nodes in √μ and in √α, dense at grazing angles and for narrow lobes, where everything is steep.
const MU: usize = 48;
const ALPHA: usize = 32;

/// A function of (μ, α) on [0, 1]² with its cosine-weighted average over μ.
struct Table {
    at: Vec<f32>,
    average: Vec<f32>,
}

impl Table {
    fn new(f: impl Fn(f32, f32) -> f32) -> Table {
        let node = |i: usize, n: usize| i as f32 / (n - 1) as f32;
        let row = |a: usize| {
            (0..MU).map(move |m| (node(m, MU).powi(2).max(1e-4), node(a, ALPHA).powi(2).max(1e-4)))
        };
        let at: Vec<f32> = (0..ALPHA).flat_map(row).map(|(mu, alpha)| f(mu, alpha)).collect();
        let average = at.chunks(MU).map(average).collect();
        Table { at, average }
    }

    #[inline]
    fn at(&self, mu: f32, alpha: f32) -> f32 {
        let (i, t) = alpha_cell(alpha, ALPHA);
        let (j, s) = cell(mu.max(0.0).sqrt(), MU);
        let row = |i: usize| self.at[i * MU + j] * (1.0 - s) + self.at[i * MU + j + 1] * s;
        row(i) * (1.0 - t) + row(i + 1) * t
    }

    #[inline]
    fn average(&self, alpha: f32) -> f32 {
        let (i, t) = alpha_cell(alpha, ALPHA);
        self.average[i] * (1.0 - t) + self.average[i + 1] * t
    }
}

/// The cell of [0, 1] with `n` nodes that `x` is in, and where in it.
#[inline]
fn cell(x: f32, n: usize) -> (usize, f32) {
    let x = x.clamp(0.0, 1.0) * (n - 1) as f32;
    let i = (x as usize).min(n - 2);
    (i, x - i as f32)
}

/// The same for nodes in √α. In between, light is lost in proportion to α² at first, so that is how it is
/// interpolated: linear in √α would find more lost than is, and give back too much.
#[inline]
fn alpha_cell(alpha: f32, n: usize) -> (usize, f32) {
    let (i, _) = cell(alpha.max(0.0).sqrt(), n);
    let fourth = |x: f32| x * x * x * x;
    let (low, high) = (fourth(i as f32), fourth((i + 1) as f32));
    let at = (alpha * alpha).min(1.0) * fourth((n - 1) as f32);
    (i, ((at - low) / (high - low)).clamp(0.0, 1.0))
}

/// 2∫f(μ)μdμ of a row, the integral that interpolation in the table has: linear in √μ.
fn average(row: &[f32]) -> f32 {
    let n = 1024;
    let term = |i: usize| {
        let mu = (i as f32 + 0.5) / n as f32;
        let (j, s) = cell(mu.sqrt(), row.len());
        f64::from((row[j] * (1.0 - s) + row[j + 1] * s) * mu)
    };
    (2.0 * (0..n).map(term).sum::<f64>() / n as f64) as f32
}

/// The mean over the visible normals of a surface seen at (μ, α), by a midpoint grid of the sampling square's half
/// (the other mirrors it).
fn over_visible_normals(mu: f32, alpha: f32, f: impl Fn(Vec3, Vec3, Vec2) -> f32) -> f32 {
    let wo = Vec3::new((1.0 - mu * mu).max(0.0).sqrt(), 0.0, mu);
    let alpha = Vec2::splat(alpha);
    let (columns, rows) = (24, 48);
    let mut sum = 0.0;
    for i in 0..columns {
        for j in 0..rows {
            let u = [(i as f32 + 0.5) / (2 * columns) as f32, (j as f32 + 0.5) / rows as f32];
            sum += f64::from(f(wo, ggx::sample_visible_normal(wo, alpha, u), alpha));
        }
    }
    (sum / f64::from(columns * rows)) as f32
}

/// G2/G1 of a reflection about m: what height-correlated shadowing leaves of a visible normal's light.
#[inline]
fn reflected(wo: Vec3, m: Vec3, alpha: Vec2) -> f32 {
    let wi = m * (2.0 * wo.dot(m)) - wo;
    let lo = ggx::lambda(wo, alpha);
    if wi.z > 0.0 { (1.0 + lo) / (1.0 + lo + ggx::lambda(wi, alpha)) } else { 0.0 }
}

/// The directional albedo of single scattering off a perfectly reflecting surface.
pub struct Energy(Table);

/// The table of [`Energy`].
pub fn energy() -> &'static Energy {
    static TABLE: OnceLock<Energy> = OnceLock::new();
    TABLE.get_or_init(|| Energy(Table::new(|mu, alpha| over_visible_normals(mu, alpha, reflected))))
}

/// Nodes of a brushed metal's table: √μ, cos²φ from the grain, √α, |anisotropy|.
const GRAIN: [usize; 4] = [28, 7, 20, 8];

/// The directional albedo of single scattering off a perfectly reflecting brushed surface, and its average.
pub struct GrainEnergy {
    at: Vec<f32>,
    average: Vec<f32>,
}

/// The table of [`GrainEnergy`].
pub fn grain_energy() -> &'static GrainEnergy {
    static TABLE: OnceLock<GrainEnergy> = OnceLock::new();
    TABLE.get_or_init(GrainEnergy::compute)
}

impl GrainEnergy {
    fn compute() -> GrainEnergy {
        let node = |i: usize, axis: usize| i as f32 / (GRAIN[axis] - 1) as f32;
        let (mut at, mut average) = (Vec::new(), Vec::new());
        for anisotropy in 0..GRAIN[3] {
            for alpha in 0..GRAIN[2] {
                let widths = ggx::widths(node(alpha, 2).powi(2).max(1e-4), node(anisotropy, 3));
                let first = at.len();
                for across in 0..GRAIN[1] {
                    for mu in 0..GRAIN[0] {
                        at.push(brushed_albedo(node(mu, 0).powi(2).max(1e-4), node(across, 1), widths));
                    }
                }
                average.push(average_over_turn(&at[first..]));
            }
        }
        GrainEnergy { at, average }
    }

    /// The four cells (α, anisotropy) with their weights.
    #[inline]
    fn corners(alpha: f32, anisotropy: f32) -> [(usize, f32); 4] {
        let (i, t) = alpha_cell(alpha, GRAIN[2]);
        let (j, s) = cell(anisotropy.abs(), GRAIN[3]);
        let id = |i: usize, j: usize| j * GRAIN[2] + i;
        [
            (id(i, j), (1.0 - t) * (1.0 - s)),
            (id(i + 1, j), t * (1.0 - s)),
            (id(i, j + 1), (1.0 - t) * s),
            (id(i + 1, j + 1), t * s),
        ]
    }

    /// E(w) of a surface with [`ggx::widths`] of `alpha` and `anisotropy`.
    #[inline]
    pub fn directional(&self, w: Vec3, alpha: f32, anisotropy: f32) -> f32 {
        // The table has the wide axis along x.
        let (along, across) = if anisotropy < 0.0 { (w.y, w.x) } else { (w.x, w.y) };
        let cos2 = along * along / (along * along + across * across).max(1e-12);
        let plane = GRAIN[0] * GRAIN[1];
        let corners = GrainEnergy::corners(alpha, anisotropy);
        corners.iter().map(|(id, weight)| weight * in_plane(&self.at[id * plane..], w.z, cos2)).sum()
    }

    /// Its cosine-weighted average.
    #[inline]
    pub fn average(&self, alpha: f32, anisotropy: f32) -> f32 {
        GrainEnergy::corners(alpha, anisotropy).iter().map(|(id, weight)| weight * self.average[*id]).sum()
    }
}

/// Interpolates a plane of nodes (√μ, cos²φ).
#[inline]
fn in_plane(plane: &[f32], mu: f32, cos2: f32) -> f32 {
    let (i, t) = cell(mu.max(0.0).sqrt(), GRAIN[0]);
    let (j, s) = cell(cos2, GRAIN[1]);
    let row = |j: usize| plane[j * GRAIN[0] + i] * (1.0 - t) + plane[j * GRAIN[0] + i + 1] * t;
    row(j) * (1.0 - s) + row(j + 1) * s
}

/// (2/π)∫∫f(μ, φ)μdμdφ over a quarter turn.
fn average_over_turn(plane: &[f32]) -> f32 {
    let (rows, columns) = (128, 16);
    let mut sum = 0.0;
    for column in 0..columns {
        let (_, cos) = crate::math::approx::sin_cos_turn(0.25 * (column as f32 + 0.5) / columns as f32);
        for row in 0..rows {
            let mu = (row as f32 + 0.5) / rows as f32;
            sum += f64::from(in_plane(plane, mu, cos * cos) * mu);
        }
    }
    (2.0 * sum / f64::from(rows * columns)) as f32
}

/// E(μ, φ) of a brushed surface, by a midpoint grid of the whole sampling square: nothing is mirrored here.
fn brushed_albedo(mu: f32, cos2: f32, widths: Vec2) -> f32 {
    let r = (1.0 - mu * mu).max(0.0).sqrt();
    let wo = Vec3::new(r * cos2.sqrt(), r * (1.0 - cos2).sqrt(), mu);
    let (columns, rows) = (16, 16);
    let mut sum = 0.0;
    for i in 0..columns {
        for j in 0..rows {
            let u = [(i as f32 + 0.5) / columns as f32, (j as f32 + 0.5) / rows as f32];
            sum += f64::from(reflected(wo, ggx::sample_visible_normal(wo, widths, u), widths));
        }
    }
    (sum / f64::from(columns * rows)) as f32
}

impl Energy {
    /// E(μ, α).
    #[inline]
    pub fn directional(&self, mu: f32, alpha: f32) -> f32 {
        self.0.at(mu, alpha)
    }

    /// The cosine-weighted average of E over μ.
    #[inline]
    pub fn average(&self, alpha: f32) -> f32 {
        self.0.average(alpha)
    }
}

/// The directional albedos of single scattering at a rough boundary, seen from one side.
struct Boundary {
    /// Reflected alone.
    reflected: Table,
    /// Reflected and transmitted, as energy (no factor η²).
    total: Table,
}

/// Nodes in x = (η − 1)/(η + 1), whose square is the reflectance at normal incidence; η from 1/9 to 9, with one node
/// at 1.5.
const ETA: usize = 65;
const X_MAX: f32 = 0.8;

impl Boundary {
    fn at_node(node: usize) -> &'static Boundary {
        static NODES: [OnceLock<Boundary>; ETA] = [const { OnceLock::new() }; ETA];
        NODES[node].get_or_init(|| {
            let x = X_MAX * (2.0 * node as f32 / (ETA - 1) as f32 - 1.0);
            Boundary::new((1.0 + x) / (1.0 - x))
        })
    }

    fn new(eta: f32) -> Boundary {
        let reflection = |wo: Vec3, m: Vec3, alpha: Vec2| {
            fresnel::dielectric(wo.dot(m).max(0.0), eta).0 * reflected(wo, m, alpha)
        };
        let transmission = |wo: Vec3, m: Vec3, alpha: Vec2| {
            let (f, cos_t) = fresnel::dielectric(wo.dot(m).max(0.0), eta);
            let wi = (m * (wo.dot(m) / eta - cos_t) - wo / eta).normalize_or_zero();
            if f < 1.0 && wi.z < 0.0 { (1.0 - f) / (1.0 + ggx::lambda(wi, alpha)) } else { 0.0 }
        };
        let reflected = Table::new(|mu, alpha| over_visible_normals(mu, alpha, reflection));
        let transmitted = Table::new(|mu, alpha| over_visible_normals(mu, alpha, transmission));
        let sum = |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| a + b).collect();
        let total = Table {
            at: sum(&reflected.at, &transmitted.at),
            average: sum(&reflected.average, &transmitted.average),
        };
        Boundary { reflected, total }
    }
}

/// The energy of a boundary with a given η, the other side's index relative to this side's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interface {
    /// The tables between which η lies; they are computed when a number is asked for.
    nodes: [u8; 2],
    t: f32,
}

impl Interface {
    /// For `eta` in [1/9, 9]; beyond, the ends stand for it.
    pub fn new(eta: f32) -> Interface {
        let x = (eta - 1.0) / (eta + 1.0);
        let (i, t) = cell(0.5 * (x / X_MAX + 1.0), ETA);
        // A table that would not count need not be computed.
        let (low, high) = if t < 1e-4 {
            (i, i)
        } else if t > 0.9999 {
            (i + 1, i + 1)
        } else {
            (i, i + 1)
        };
        Interface { nodes: [low as u8, high as u8], t }
    }

    #[inline]
    fn mix(&self, of: impl Fn(&Boundary) -> f32) -> f32 {
        let [low, high] = self.nodes.map(|node| of(Boundary::at_node(usize::from(node))));
        low * (1.0 - self.t) + high * self.t
    }

    /// The share that is reflected.
    #[inline]
    pub fn reflected(&self, mu: f32, alpha: f32) -> f32 {
        self.mix(|b| b.reflected.at(mu, alpha))
    }

    /// Its cosine-weighted average.
    #[inline]
    pub fn reflected_average(&self, alpha: f32) -> f32 {
        self.mix(|b| b.reflected.average(alpha))
    }

    /// The share that is reflected or transmitted.
    #[inline]
    pub fn total(&self, mu: f32, alpha: f32) -> f32 {
        self.mix(|b| b.total.at(mu, alpha))
    }

    /// Its cosine-weighted average.
    #[inline]
    pub fn total_average(&self, alpha: f32) -> f32 {
        self.mix(|b| b.total.average(alpha))
    }
}
