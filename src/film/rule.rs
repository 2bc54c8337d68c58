//! Pixel rules: where in the filter's support the points of a pixel lie, and what each counts (notes 13.4, 13.6–13.8).
//!
//! A pixel is the integral of radiance times the filter h over its support, over ∫h: eq. (6) and (11) for the
//! box. N points are averaged with weights whose mean tends to 1: for points placed without regard to h the
//! weight is h(x)·A/∫h, A the support's area; for points drawn from h it is 1.

use super::filter::FilterSampler;
use crate::error::{Error, Result, lookup};

/// How the points of a pixel are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PixelRule {
    /// Points of the picture's sampler, drawn from the filter: the least noise.
    Sampler,
    /// Independent random points of the support, eq. (10) and (11).
    Random,
    /// Independent random points drawn from the filter, eq. (20) and the aside of 13.1.
    Importance,
    /// A grid of midpoints, eq. (14).
    Uniform(Grid),
    /// The grid of left and upper edges, eq. (12)–(14).
    UniformCorner(Grid),
    /// Random points within equal cells, 13.6.
    Stratified(Grid),
    /// Cells of equal weight under the filter, eq. (19): their middles, or random points in them.
    Nonuniform(Grid),
}

/// M×N cells of the support with some points in each.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    /// M cells to the right, N cells down.
    pub cells: [u32; 2],
    /// J: random points in each cell; for points that are fixed, how often each is used (0 counts as 1, and
    /// leaves the points of [`PixelRule::Nonuniform`] fixed).
    pub per_cell: u32,
}

impl Grid {
    /// M·N·J points.
    pub fn points(&self) -> u64 {
        u64::from(self.cells[0]) * u64::from(self.cells[1]) * u64::from(self.per_cell.max(1))
    }
}

/// Where a rule's points get their numbers from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Numbers {
    /// From the picture's sampler.
    Sampler,
    /// Independent random numbers.
    Random,
    /// It needs none.
    None,
}

impl PixelRule {
    const CELL: Grid = Grid { cells: [1, 1], per_cell: 0 };

    /// Name, meaning, value with a grid of one cell.
    pub const TABLE: &'static [(&'static str, &'static str, PixelRule)] = &[
        ("sampler", "the sampler's points, drawn from the filter", PixelRule::Sampler),
        ("random", "independent random points (11)", PixelRule::Random),
        ("importance", "random points drawn from the filter (20)", PixelRule::Importance),
        ("uniform", "a grid of midpoints (14)", PixelRule::Uniform(Self::CELL)),
        ("uniform-corner", "the grid of left edges of (12)-(14)", PixelRule::UniformCorner(Self::CELL)),
        ("stratified", "random points within equal cells (13.6)", PixelRule::Stratified(Self::CELL)),
        ("nonuniform", "cells of equal weight under the filter (19)", PixelRule::Nonuniform(Self::CELL)),
    ];

    /// The rule of that name.
    ///
    /// # Errors
    /// A word that is none.
    pub fn from_name(word: &str) -> Result<PixelRule> {
        lookup("pixel rule", word, Self::TABLE)
    }

    /// Its name.
    pub fn name(&self) -> &'static str {
        match self {
            PixelRule::Sampler => "sampler",
            PixelRule::Random => "random",
            PixelRule::Importance => "importance",
            PixelRule::Uniform(_) => "uniform",
            PixelRule::UniformCorner(_) => "uniform-corner",
            PixelRule::Stratified(_) => "stratified",
            PixelRule::Nonuniform(_) => "nonuniform",
        }
    }

    /// The grid, for the rules that have one. It settles the number of points.
    pub fn grid(&self) -> Option<Grid> {
        match *self {
            PixelRule::Sampler | PixelRule::Random | PixelRule::Importance => None,
            PixelRule::Uniform(g)
            | PixelRule::UniformCorner(g)
            | PixelRule::Stratified(g)
            | PixelRule::Nonuniform(g) => Some(g),
        }
    }

    /// The same rule over another grid; a rule without a grid stays as it is.
    pub fn over(self, grid: Grid) -> PixelRule {
        match self {
            PixelRule::Uniform(_) => PixelRule::Uniform(grid),
            PixelRule::UniformCorner(_) => PixelRule::UniformCorner(grid),
            PixelRule::Stratified(_) => PixelRule::Stratified(grid),
            PixelRule::Nonuniform(_) => PixelRule::Nonuniform(grid),
            other => other,
        }
    }

    /// Where its points get their numbers from.
    #[inline(always)]
    pub fn numbers(&self) -> Numbers {
        match self {
            PixelRule::Sampler => Numbers::Sampler,
            PixelRule::Random | PixelRule::Importance | PixelRule::Stratified(_) => Numbers::Random,
            PixelRule::Nonuniform(g) if g.per_cell > 0 => Numbers::Random,
            PixelRule::Uniform(_) | PixelRule::UniformCorner(_) | PixelRule::Nonuniform(_) => Numbers::None,
        }
    }
}

/// A point of the support and what a sample there counts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PixelPoint {
    /// From the pixel's centre, to the right and down, in pixels.
    pub offset: [f32; 2],
    /// Weight; the mean over many points is 1.
    pub weight: f32,
}

/// The points of a rule under a filter.
#[derive(Clone, Debug)]
pub struct PixelPoints {
    rule: PixelRule,
    filter: FilterSampler,
    /// Makes the mean weight of a fixed grid 1 under a filter with negative lobes, which divides by their sum.
    scale: f32,
}

impl PixelPoints {
    /// Points of `rule` over the support of `filter`.
    ///
    /// # Errors
    /// A fixed grid whose points lie where a filter with negative lobes is negative or zero: their weights make no
    /// mean.
    pub fn new(rule: PixelRule, filter: FilterSampler) -> Result<PixelPoints> {
        let mut points = PixelPoints { rule, filter, scale: 1.0 };
        if let (true, Numbers::None, Some(grid)) = (points.is_signed(), rule.numbers(), rule.grid()) {
            let once = u64::from(grid.cells[0]) * u64::from(grid.cells[1]);
            let weight = |i: u64| f64::from(points.point(i as u32, [0.5; 2]).weight);
            let mean = (0..once).map(weight).sum::<f64>() / once as f64;
            if mean < 0.01 {
                return Err(Error::new(format!(
                    "the {}x{} points of the rule lie where the filter is negative or zero: their weights sum to {:.3}",
                    grid.cells[0],
                    grid.cells[1],
                    mean * once as f64
                ))
                .advise("take more cells, or a filter without negative lobes"));
            }
            points.scale = (1.0 / mean) as f32;
        }
        Ok(points)
    }

    /// Where the numbers for [`PixelPoints::point`] come from.
    #[inline(always)]
    pub fn numbers(&self) -> Numbers {
        self.rule.numbers()
    }

    /// True when weights have signs, so that pixels divide by their sum.
    pub fn is_signed(&self) -> bool {
        self.filter.is_signed()
    }

    /// The point of sample `index`; `u` in [0, 1)² places it where the rule leaves a choice.
    #[inline(always)]
    pub fn point(&self, index: u32, u: [f32; 2]) -> PixelPoint {
        match self.rule {
            PixelRule::Sampler | PixelRule::Importance => self.drawn(u),
            PixelRule::Random => self.weighed(u),
            PixelRule::Uniform(grid) => self.weighed(within(grid, index, [0.5, 0.5])),
            PixelRule::UniformCorner(grid) => self.weighed(within(grid, index, [0.0, 0.0])),
            PixelRule::Stratified(grid) => self.weighed(within(grid, index, u)),
            PixelRule::Nonuniform(grid) => {
                // Regions of equal weight d_i under the filter, eq. (19): equal steps of what it is drawn from.
                let u = if grid.per_cell == 0 { [0.5, 0.5] } else { u };
                self.drawn(within(grid, index, u))
            }
        }
    }

    /// [`PixelPoints::point`] of several samples: offsets, and weights.
    #[inline(always)]
    pub fn points<const N: usize>(&self, indices: &[u32; N], u: &[[f32; N]; 2]) -> ([[f32; N]; 2], [f32; N]) {
        let (mut offsets, mut weights) = ([[0.0; N]; 2], [self.scale; N]);
        // By itself, so that the usual case is a loop without branches.
        if matches!(self.rule, PixelRule::Sampler | PixelRule::Importance) && self.filter.is_box() {
            for (offsets, u) in offsets.iter_mut().zip(u) {
                for (offset, u) in offsets.iter_mut().zip(u) {
                    *offset = self.filter.linear(*u);
                }
            }
            return (offsets, weights);
        }
        for lane in 0..N {
            let point = self.point(indices[lane], [u[0][lane], u[1][lane]]);
            [offsets[0][lane], offsets[1][lane]] = point.offset;
            weights[lane] = point.weight;
        }
        (offsets, weights)
    }

    /// The point at `u` drawn from the filter, which counts 1, or −1 where the filter is negative.
    #[inline(always)]
    fn drawn(&self, u: [f32; 2]) -> PixelPoint {
        let offset = u.map(|u| self.filter.offset(u));
        let sign = |x| if self.filter.is_signed() { self.filter.weight(x) } else { 1.0 };
        PixelPoint { offset, weight: sign(offset[0]) * sign(offset[1]) * self.scale }
    }

    /// The point at `u` of the support, weighted with h·A/∫h.
    #[inline]
    fn weighed(&self, u: [f32; 2]) -> PixelPoint {
        let offset = u.map(|u| (2.0 * u - 1.0) * self.filter.radius());
        let weight = self.filter.density(offset[0]) * self.filter.density(offset[1]) * self.scale;
        PixelPoint { offset, weight }
    }
}

/// The cell of sample `index`: row by row, and again from the first for every further point of the cells.
#[inline(always)]
fn cell(grid: Grid, index: u32) -> [u32; 2] {
    let [m, n] = grid.cells;
    [index % m, index / m % n]
}

/// Eq. (12) and (13): the point at `u` of a cell, in [0, 1)² of the support.
#[inline(always)]
fn within(grid: Grid, index: u32, u: [f32; 2]) -> [f32; 2] {
    let cell = cell(grid, index);
    [(cell[0] as f32 + u[0]) / grid.cells[0] as f32, (cell[1] as f32 + u[1]) / grid.cells[1] as f32]
}

#[cfg(test)]
#[path = "rule_tests.rs"]
mod tests;
