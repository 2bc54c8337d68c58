//! How much light one scattering at a GGX surface loses, tabulated: compensation gives it back (Kulla and Conty 2017), and
//! what a coat does not reflect is what reaches the base below.
//!
//! Facets of width α seen at grazing incidence look alike where k = α·tan θ does (stretching a surface stretches its facets,
//! Heitz 2014), so the tables' axis is 1/(1 + k): along it the loss is smooth and hardly depends on α, and few nodes do.
//! Every number errs to the side on which a white surface in a white furnace stays at or below 1: `CAUTION`.
//!
//! Tables are computed when a material first asks for them, some milliseconds each, and kept.

mod boundary;
mod grain;

pub use boundary::Interface;
pub use grain::{GrainEnergy, grain_energy};

use super::ggx;
use crate::math::isa::{self, Isa, Kernel};
use crate::math::{Vec2, Vec3};
use std::sync::OnceLock;

/// The share of a tabulated loss that is given back, after [`MARGIN`] is taken off: interpolation errs by less than the rest.
const CAUTION: f32 = 0.996;
/// What a table's loss may be off where little is lost; taken off the loss.
const MARGIN: f32 = 8e-4;

/// Nodes on the axis and in √α.
const PLACES: usize = 48;
const ALPHAS: usize = 24;
/// Nodes in √α of what is averaged over the hemisphere.
const AVERAGES: usize = 96;
/// An average loss is taken this much higher than interpolation says.
const AVERAGE_CAUTION: f32 = 1.0015;

/// Where a direction lies on the tables' axis: `across` is α·sin θ.
#[inline(always)]
fn place(mu: f32, across: f32) -> f32 {
    let mu = mu.max(1e-6);
    mu / (mu + across)
}

/// The cosine at that place for facets of width `alpha`.
fn cosine_at(place: f32, alpha: f32) -> f32 {
    let place = place.max(1e-3);
    let k = (1.0 - place) / place;
    alpha / (alpha * alpha + k * k).sqrt()
}

/// The cell of [0, 1] with `n` nodes that `x` is in, and where in it.
#[inline(always)]
fn cell(x: f32, n: usize) -> (usize, f32) {
    let x = x.clamp(0.0, 1.0) * (n - 1) as f32;
    let i = (x as usize).min(n - 2);
    (i, x - i as f32)
}

/// The α of a node among `n` in √α.
#[inline(always)]
fn alpha_node(i: usize, n: usize) -> f32 {
    let x = i as f32 / (n - 1) as f32;
    (x * x).max(ggx::SMOOTH)
}

/// The cell of nodes in √α that `alpha` is in, and where in it: linear in α.
#[inline(always)]
fn alpha_cell(alpha: f32, n: usize) -> (usize, f32) {
    let (i, _) = cell(alpha.sqrt(), n);
    let (low, high) = (alpha_node(i, n), alpha_node(i + 1, n));
    (i, ((alpha - low) / (high - low)).clamp(0.0, 1.0))
}

/// Two rows of a table with `n` columns, linear between nodes and rows.
#[inline(always)]
fn between(table: &[f32], n: usize, (i, t): (usize, f32), (j, s): (usize, f32)) -> f32 {
    let row = |i: usize| table[i * n + j] * (1.0 - s) + table[i * n + j + 1] * s;
    row(i) * (1.0 - t) + row(i + 1) * t
}

/// A quantity by nodes in √α, linear in α between.
#[inline(always)]
fn by_alpha(table: &[f32], alpha: f32) -> f32 {
    let (i, t) = alpha_cell(alpha, table.len());
    table[i] * (1.0 - t) + table[i + 1] * t
}

/// 2∫f(μ)μdμ, dense towards grazing angles.
fn hemispherical(f: impl Fn(f32) -> f32) -> f32 {
    let n = 512;
    let term = |i: usize| {
        let x = (i as f32 + 0.5) / n as f32;
        // μ = x³: 2μ·dμ = 6x⁵·dx.
        f64::from(f(x * x * x) * x.powi(5))
    };
    (6.0 * (0..n).map(term).sum::<f64>() / n as f64) as f32
}

/// Lanes of a vector loop (see [`crate::math::soa`]).
const LANES: usize = 16;

/// Means over the visible normals of a surface of those widths, seen from `wo`: over the first `LANES`·`rounds` points of
/// the golden ratio's sequence, which meets the narrow edges of what is shadowed evenly, as a grid does not.
struct OverVisibleNormals<F> {
    wo: Vec3,
    widths: Vec2,
    rounds: u32,
    /// What to average, by the facet's normal.
    f: F,
}

impl<const N: usize, F: Fn(Vec3) -> [f32; N]> Kernel for OverVisibleNormals<F> {
    type Output = [f32; N];

    #[inline(always)]
    fn run<S: isa::Set>(self) -> [f32; N] {
        let mut sums = [[0.0; LANES]; N];
        let points = (self.rounds * LANES as u32) as f32;
        for round in 0..self.rounds {
            for lane in 0..LANES {
                let i = round * LANES as u32 + lane as u32;
                // i·φ modulo 1, in 24 bits.
                let turn = (i.wrapping_mul(0x9e37_79b9) >> 8) as f32 * (1.0 / 16_777_216.0);
                let u = [turn, (i as f32 + 0.5) / points];
                let values = (self.f)(ggx::sample_visible_normal(self.wo, self.widths, u));
                for (sums, value) in sums.iter_mut().zip(values) {
                    sums[lane] += value;
                }
            }
        }
        sums.map(|lanes| lanes.iter().sum::<f32>() / points)
    }
}

/// The means that [`OverVisibleNormals`] says.
fn over_visible_normals<const N: usize>(
    wo: Vec3,
    widths: Vec2,
    rounds: u32,
    f: impl Fn(Vec3) -> [f32; N],
) -> [f32; N] {
    isa::run(Isa::best(), OverVisibleNormals { wo, widths, rounds, f })
}

/// Rounds of that for tables in two dimensions.
const FINE: u32 = 128;

/// The direction with that cosine in the plane of x and z.
fn in_plane(mu: f32) -> Vec3 {
    Vec3::new((1.0 - mu * mu).max(0.0).sqrt(), 0.0, mu)
}

/// 1 − G2/G1 of a reflection about m: what height-correlated shadowing takes of a visible normal's light.
#[inline(always)]
fn shadowed(wo: Vec3, m: Vec3, alpha: Vec2) -> f32 {
    let wi = m * (2.0 * wo.dot(m)) - wo;
    let li = ggx::lambda(wi, alpha);
    if wi.z > 0.0 { li / (1.0 + ggx::lambda(wo, alpha) + li) } else { 1.0 }
}

/// The loss of single scattering off a perfectly reflecting surface.
pub struct Energy {
    /// By √α and place.
    lost: Vec<f32>,
    average: Vec<f32>,
}

/// The table of [`Energy`].
pub fn energy() -> &'static Energy {
    static TABLE: OnceLock<Energy> = OnceLock::new();
    TABLE.get_or_init(Energy::compute)
}

impl Energy {
    fn compute() -> Energy {
        let row = |i: usize| (0..PLACES).map(move |j| (alpha_node(i, ALPHAS), j));
        let node = |(alpha, j): (f32, usize)| {
            // In the limit of grazing incidence nothing is lost.
            if j == 0 {
                return 0.0;
            }
            let mu = cosine_at(j as f32 / (PLACES - 1) as f32, alpha);
            let (wo, widths) = (in_plane(mu), Vec2::splat(alpha));
            over_visible_normals(
                wo,
                widths,
                FINE,
                #[inline(always)]
                |m| [shadowed(wo, m, widths)],
            )[0]
        };
        let lost = (0..ALPHAS).flat_map(row).map(node).collect();
        let mut energy = Energy { lost, average: Vec::new() };
        let average = |i: usize| hemispherical(|mu| energy.lost(mu, alpha_node(i, AVERAGES)));
        energy.average = (0..AVERAGES).map(average).collect();
        energy
    }

    /// The share that is lost at (μ, α), less [`MARGIN`].
    #[inline(always)]
    fn lost(&self, mu: f32, alpha: f32) -> f32 {
        let alpha = alpha.clamp(ggx::SMOOTH, 1.0);
        let across = alpha * (1.0 - mu * mu).max(0.0).sqrt();
        let column = cell(place(mu, across), PLACES);
        (between(&self.lost, PLACES, alpha_cell(alpha, ALPHAS), column) - MARGIN).max(0.0)
    }

    /// The directional albedo E(μ, α), never below the true one.
    #[inline]
    pub fn directional(&self, mu: f32, alpha: f32) -> f32 {
        1.0 - CAUTION * self.lost(mu, alpha)
    }

    /// The cosine-weighted average of [`Energy::directional`] over μ, or a little less.
    #[inline]
    pub fn average(&self, alpha: f32) -> f32 {
        1.0 - CAUTION * AVERAGE_CAUTION * by_alpha(&self.average, alpha)
    }
}
