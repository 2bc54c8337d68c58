//! The same for brushed surfaces, whose facets are wider along one axis than along the other.

use super::{AVERAGE_CAUTION, alpha_cell, alpha_node, cell, over_visible_normals, shadowed};
use crate::bsdf::ggx::STRONGEST;
use crate::math::{Vec2, Vec3};
use std::sync::OnceLock;

/// Nodes: the tables' axis, cos²φ from the wide axis on the stretched surface, √α of the wide axis, and how narrow the other one is.
const PLACES: usize = 24;
const TURNS: usize = 9;
const WIDTHS: usize = 14;
const RATIOS: usize = 8;
/// Nodes in √α of averages, which grow with a power of α.
const AVERAGES: usize = 64;
/// The narrowest ratio of two widths, that of an anisotropy of 1.
const NARROWEST: f32 = 1.0 - STRONGEST;
/// Rounds of [`over_visible_normals`] for each node; there are many.
const COARSE: u32 = 24;
/// As [`super::CAUTION`] and [`super::MARGIN`], of coarser tables.
const CAUTION: f32 = 0.985;
const MARGIN: f32 = 3.5e-3;

/// The loss of single scattering off a perfectly reflecting brushed surface.
pub struct GrainEnergy {
    lost: Vec<f32>,
    average: Vec<f32>,
}

/// The table of [`GrainEnergy`].
pub fn grain_energy() -> &'static GrainEnergy {
    static TABLE: OnceLock<GrainEnergy> = OnceLock::new();
    TABLE.get_or_init(GrainEnergy::compute)
}

/// Where two widths are among the tables' planes: wider one, narrower over wider one.
#[derive(Clone, Copy)]
struct Corners([(usize, f32); 4]);

impl Corners {
    /// Among planes of `n` nodes in √α each.
    #[inline]
    fn new(widths: Vec2, n: usize) -> Corners {
        let wide = widths.max_element();
        let ratio = (widths.min_element() / wide).max(NARROWEST);
        let (i, t) = alpha_cell(wide, n);
        // √ratio: where the narrow axis matters most, nodes are dense.
        let (j, s) = cell((ratio.sqrt() - NARROWEST.sqrt()) / (1.0 - NARROWEST.sqrt()), RATIOS);
        let id = |i: usize, j: usize| j * n + i;
        Corners([
            (id(i, j), (1.0 - t) * (1.0 - s)),
            (id(i + 1, j), t * (1.0 - s)),
            (id(i, j + 1), (1.0 - t) * s),
            (id(i + 1, j + 1), t * s),
        ])
    }

    #[inline]
    fn mix(&self, of: impl Fn(usize) -> f32) -> f32 {
        self.0.iter().map(|(id, weight)| weight * of(*id)).sum()
    }
}

/// The two widths of a plane among those of `n` nodes in √α, the wide one along x.
fn widths_of(plane: usize, n: usize) -> Vec2 {
    let wide = alpha_node(plane % n, n);
    let low = NARROWEST.sqrt();
    let root = low + (1.0 - low) * (plane / n) as f32 / (RATIOS - 1) as f32;
    Vec2::new(wide, wide * root * root)
}

impl GrainEnergy {
    fn compute() -> GrainEnergy {
        let mut lost = Vec::with_capacity(RATIOS * WIDTHS * TURNS * PLACES);
        for plane in 0..RATIOS * WIDTHS {
            let widths = widths_of(plane, WIDTHS);
            for turn in 0..TURNS {
                let cos2 = turn as f32 / (TURNS - 1) as f32;
                // The direction in the surface that is stretched to one with that cos², and its length there.
                let flat = Vec2::new(cos2.sqrt(), (1.0 - cos2).sqrt()) / widths;
                let (flat, alpha) = (flat.normalize(), 1.0 / flat.length());
                // In the limit of grazing incidence nothing is lost.
                lost.push(0.0);
                for j in 1..PLACES {
                    let mu = super::cosine_at(j as f32 / (PLACES - 1) as f32, alpha);
                    let wo = (flat * (1.0 - mu * mu).max(0.0).sqrt()).extend(mu);
                    let [loss] = over_visible_normals(
                        wo,
                        widths,
                        COARSE,
                        #[inline(always)]
                        |m| [shadowed(wo, m, widths)],
                    );
                    lost.push(loss);
                }
            }
        }
        let mut energy = GrainEnergy { lost, average: Vec::new() };
        let average = |plane: usize| energy.average_of(widths_of(plane, AVERAGES));
        energy.average = (0..RATIOS * AVERAGES).map(average).collect();
        energy
    }

    /// The share of light from w that surfaces with those widths along x and y lose, less [`MARGIN`].
    #[inline]
    fn lost(&self, w: Vec3, widths: Vec2) -> f32 {
        // The table has the wide axis along x.
        let flat = (Vec2::new(w.x, w.y) * widths).abs();
        let along = if widths.x < widths.y { flat.y } else { flat.x };
        let square = flat.length_squared();
        let cos2 = if square > 1e-20 { along * along / square } else { 1.0 };
        let c = cell(super::place(w.z, square.sqrt()), PLACES);
        let turn = cell(cos2, TURNS);
        let plane = |plane: usize| super::between(&self.lost[plane * TURNS * PLACES..], PLACES, turn, c);
        (Corners::new(widths, WIDTHS).mix(plane) - MARGIN).max(0.0)
    }

    /// E(w) of a surface with those widths, never below the true one.
    #[inline]
    pub fn directional(&self, w: Vec3, widths: Vec2) -> f32 {
        1.0 - CAUTION * self.lost(w, widths)
    }

    /// Its cosine-weighted average, or a little less.
    #[inline]
    pub fn average(&self, widths: Vec2) -> f32 {
        1.0 - CAUTION * AVERAGE_CAUTION * Corners::new(widths, AVERAGES).mix(|plane| self.average[plane])
    }

    /// (2/π)∫∫lost(μ, φ)μdμdφ over a quarter turn, dense towards grazing angles.
    fn average_of(&self, widths: Vec2) -> f32 {
        let (rows, columns) = (64, 12);
        let mut sum = 0.0;
        for column in 0..columns {
            let turn = 0.25 * (column as f32 + 0.5) / columns as f32;
            let (sin, cos) = crate::math::approx::sin_cos_turn(turn);
            for row in 0..rows {
                let x = (row as f32 + 0.5) / rows as f32;
                let mu = x * x * x;
                let r = (1.0 - mu * mu).sqrt();
                sum += f64::from(self.lost(Vec3::new(r * cos, r * sin, mu), widths) * x.powi(5));
            }
        }
        (6.0 * sum / f64::from(rows * columns)) as f32
    }
}
