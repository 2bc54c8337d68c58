//! The same for rough boundaries of dielectrics, which reflect and transmit.
//!
//! What reflection keeps and loses is tabulated as a quotient by what a perfectly reflecting surface does, whose steep
//! part is in [`energy`]'s table, and by Fresnel's formula.

use super::{
    ALPHAS, AVERAGE_CAUTION, AVERAGES, CAUTION, FINE, MARGIN, alpha_cell, alpha_node, between, by_alpha,
    cell, energy, hemispherical, in_plane, over_visible_normals, shadowed,
};
use crate::bsdf::{fresnel, ggx};
use crate::math::{Vec2, Vec3};
use std::sync::OnceLock;

/// Nodes in √μ: Fresnel's formula is steep towards grazing angles.
const ROOTS: usize = 32;
/// What is reflected is taken this much higher than interpolation says.
const REFLECTED_CAUTION: f32 = 1.006;
/// Added to both losses of a quotient, so that it means something where neither is more than rounding.
const LEAST: f32 = 1e-4;

/// Single scattering at a rough boundary, seen from one side.
struct Boundary {
    /// By √α and √μ: the share that is reflected, over what a smooth surface of [`blurred`] cosine would reflect and a
    /// perfectly reflecting rough one keep.
    reflected: Vec<f32>,
    /// What reflection loses, over the loss of a perfectly reflecting surface.
    lost_in_front: Vec<f32>,
    /// What transmission loses.
    lost_behind: Vec<f32>,
    /// Averages of [`Boundary::reflected`] and [`Boundary::lost`], by √α.
    reflected_average: Vec<f32>,
    lost_average: Vec<f32>,
    eta: f32,
    /// Taken off the loss.
    margin: f32,
}

/// What a facet with normal `m` reflects, what it loses in front and behind, and what it would lose if it reflected
/// everything.
#[inline(always)]
fn facet(wo: Vec3, m: Vec3, widths: Vec2, eta: f32) -> [f32; 4] {
    let cos = wo.dot(m).max(0.0);
    let (f, cos_t) = fresnel::dielectric(cos, eta);
    let wi = m * (cos / eta - cos_t) - wo / eta;
    // Where all is reflected, nothing is lost behind, whatever wi is; elsewhere it is unit.
    let behind = if wi.z < 0.0 { ggx::lambda(wi, widths) } else { f32::INFINITY };
    let (front, behind) = (shadowed(wo, m, widths), 1.0 - 1.0 / (1.0 + behind));
    [f * (1.0 - front), f * front, (1.0 - f) * behind, front]
}

/// A cosine at which the facets of width `alpha`, seen at `mu`, reflect about as much as they do on average.
#[inline(always)]
fn blurred(mu: f32, alpha: f32) -> f32 {
    (mu * mu + 0.25 * alpha * alpha).sqrt().min(1.0)
}

/// Nodes in √x, x = (η − 1)/(η + 1), whose square is the reflectance at normal incidence; η from 1/9 to 9, dense around 1,
/// where critical angles move fast, with one node at 1.5.
const ETA: usize = 65;
const X_MAX: f32 = 0.8;
/// The node of η = 1.
const NO_BOUNDARY: usize = ETA / 2;

impl Boundary {
    fn at_node(node: usize) -> &'static Boundary {
        static NODES: [OnceLock<Boundary>; ETA] = [const { OnceLock::new() }; ETA];
        NODES[node].get_or_init(|| {
            let s = 2.0 * node as f32 / (ETA - 1) as f32 - 1.0;
            let x = X_MAX * s * s.abs();
            Boundary::new((1.0 + x) / (1.0 - x))
        })
    }

    fn new(eta: f32) -> Boundary {
        let (mut reflected, mut lost_in_front, mut lost_behind) = (Vec::new(), Vec::new(), Vec::new());
        for i in 0..ALPHAS {
            let alpha = alpha_node(i, ALPHAS);
            for j in 0..ROOTS {
                let mu = (j as f32 / (ROOTS - 1) as f32).powi(2).max(1e-5);
                let (wo, widths) = (in_plane(mu), Vec2::splat(alpha));
                let [back, front, behind, white] = over_visible_normals(
                    wo,
                    widths,
                    FINE,
                    #[inline(always)]
                    |m| facet(wo, m, widths, eta),
                );
                let smooth = fresnel::dielectric(blurred(mu, alpha), eta).0.max(LEAST);
                reflected.push(back / ((1.0 - white) * smooth));
                lost_in_front.push((front + LEAST) / (white + LEAST));
                lost_behind.push(behind);
            }
        }
        let (reflected_average, lost_average) = (Vec::new(), Vec::new());
        // Indices near 1 lose light in a grazing rim that is too narrow for the nodes.
        let x = (eta - 1.0) / (eta + 1.0);
        let margin = MARGIN + (4e-7 / (x * x)).min(0.04);
        let mut boundary =
            Boundary { reflected, lost_in_front, lost_behind, reflected_average, lost_average, eta, margin };
        let average = |f: fn(&Boundary, f32, f32) -> f32| {
            let at = |i: usize| hemispherical(|mu| f(&boundary, mu, alpha_node(i, AVERAGES)));
            (0..AVERAGES).map(at).collect()
        };
        let (back, loss) = (average(Boundary::reflected), average(Boundary::lost));
        (boundary.reflected_average, boundary.lost_average) = (back, loss);
        boundary
    }

    #[inline(always)]
    fn at(table: &[f32], mu: f32, alpha: f32) -> f32 {
        between(table, ROOTS, alpha_cell(alpha, ALPHAS), cell(mu.max(0.0).sqrt(), ROOTS))
    }

    fn reflected(&self, mu: f32, alpha: f32) -> f32 {
        let smooth = fresnel::dielectric(blurred(mu, alpha), self.eta).0.max(LEAST);
        let kept = (1.0 - energy().lost(mu, alpha)) * smooth * REFLECTED_CAUTION;
        (Boundary::at(&self.reflected, mu, alpha) * kept).min(1.0)
    }

    fn lost(&self, mu: f32, alpha: f32) -> f32 {
        let white = energy().lost(mu, alpha) + LEAST;
        let front = Boundary::at(&self.lost_in_front, mu, alpha) * white - LEAST;
        (front + Boundary::at(&self.lost_behind, mu, alpha) - self.margin).max(0.0)
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
        let s = (x.abs() / X_MAX).sqrt().copysign(x);
        let (i, t) = cell(0.5 * (s + 1.0), ETA);
        // A table that would not count need not be computed.
        // An index of 1 does not bend what it shadows, as no other: its table has no part in others.
        let (low, high) = if t < 1e-4 || i + 1 == NO_BOUNDARY {
            (i, i)
        } else if t > 0.9999 || i == NO_BOUNDARY {
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

    /// The share that is reflected, never below the true one.
    #[inline]
    pub fn reflected(&self, mu: f32, alpha: f32) -> f32 {
        self.mix(|b| b.reflected(mu, alpha))
    }

    /// Its cosine-weighted average, or a little less.
    #[inline]
    pub fn reflected_average(&self, alpha: f32) -> f32 {
        let passes = 1.0 - self.mix(|b| by_alpha(&b.reflected_average, alpha));
        1.0 - passes * 1.0005
    }

    /// The share that is reflected or transmitted, never below the true one.
    #[inline]
    pub fn total(&self, mu: f32, alpha: f32) -> f32 {
        1.0 - CAUTION * self.mix(|b| b.lost(mu, alpha))
    }

    /// Its cosine-weighted average, or a little less.
    #[inline]
    pub fn total_average(&self, alpha: f32) -> f32 {
        1.0 - CAUTION * AVERAGE_CAUTION * self.mix(|b| by_alpha(&b.lost_average, alpha))
    }
}
