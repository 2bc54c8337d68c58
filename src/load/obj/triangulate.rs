//! Polygons into triangles.
//!
//! Quads and strictly convex polygons become fans around their first corner where that is right. Others
//! are clipped ear by ear (Meisters, "Polygons have ears", 1975) in the plane of their Newell normal
//! (Sutherland, Sproull, Schumacker 1974). Only reflex corners can lie in an ear; they are kept in a grid,
//! so that a polygon of a million corners takes about a second. The signed area in that plane is the
//! polygon's, whatever the polygon; for simple ones no two triangles overlap.

use super::memory::{OutOfMemory, push};
use crate::math::DVec3;
use glam::DVec2;

/// Splits polygons; keeps its buffers between them.
#[derive(Default)]
pub(super) struct Triangulator {
    /// The corners of the polygon to split.
    pub points: Vec<DVec3>,
    flat: Vec<DVec2>,
    previous: Vec<u32>,
    next: Vec<u32>,
    reflex: Vec<bool>,
    grid: Grid,
    triangles: Vec<[u32; 3]>,
}

/// How much an ear is forgiven when a whole lap found none better.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd)]
enum Ear {
    /// It has area and holds no other corner: simple polygons need no other.
    Proper,
    /// It has no area: duplicate and collinear corners.
    Flat,
    /// It has area: self-crossing polygons.
    Convex,
}

impl Triangulator {
    /// Splits `points` (at least 3) into `points.len() − 2` triangles of indices into it.
    pub fn split(&mut self) -> Result<&[[u32; 3]], OutOfMemory> {
        self.triangles.clear();
        let corners = self.points.len();
        if let [a, b, c, d] = *self.points.as_slice() {
            for triangle in split_quad([a, b, c, d]) {
                push(&mut self.triangles, triangle)?;
            }
        } else if corners == 3 || !self.flatten()? || self.strictly_convex() {
            return self.fan(corners);
        } else {
            self.clip_ears()?;
        }
        Ok(&self.triangles)
    }

    /// Splits a polygon of that many corners as a fan around its first, wherever they are.
    pub fn fan(&mut self, corners: usize) -> Result<&[[u32; 3]], OutOfMemory> {
        self.triangles.clear();
        for i in 2..corners as u32 {
            push(&mut self.triangles, [0, i - 1, i])?;
        }
        Ok(&self.triangles)
    }

    /// Projects along the largest component of the normal, counter-clockwise; `false` without a normal.
    fn flatten(&mut self) -> Result<bool, OutOfMemory> {
        let Some(&origin) = self.points.first() else { return Ok(false) };
        let normal = newell_normal(&self.points);
        let size = normal.abs();
        if !(size.max_element() > 0.0 && normal.is_finite()) {
            return Ok(false);
        }
        self.flat.clear();
        for &point in &self.points {
            let p = point - origin;
            let (x, y, up) = if size.x >= size.y && size.x >= size.z {
                (p.y, p.z, normal.x)
            } else if size.y >= size.z {
                (p.z, p.x, normal.y)
            } else {
                (p.x, p.y, normal.z)
            };
            push(&mut self.flat, if up > 0.0 { DVec2::new(x, y) } else { DVec2::new(y, x) })?;
        }
        Ok(true)
    }

    /// Every corner turns left, and all of them once around.
    fn strictly_convex(&self) -> bool {
        let corner = |i: usize| self.flat[i % self.flat.len()];
        let rises = |i: usize| {
            let edge = corner(i + 1) - corner(i);
            edge.y > 0.0 || (edge.y == 0.0 && edge.x > 0.0)
        };
        let mut laps = 0;
        for i in 0..self.flat.len() {
            if twice_area(corner(i), corner(i + 1), corner(i + 2)) <= 0.0 {
                return false;
            }
            laps += usize::from(!rises(i) && rises(i + 1));
        }
        laps == 1
    }

    fn clip_ears(&mut self) -> Result<(), OutOfMemory> {
        let n = self.flat.len() as u32;
        self.previous.clear();
        self.next.clear();
        self.reflex.clear();
        for i in 0..n {
            push(&mut self.previous, if i == 0 { n - 1 } else { i - 1 })?;
            push(&mut self.next, if i + 1 == n { 0 } else { i + 1 })?;
        }
        for i in 0..n {
            let is_reflex = self.turn(i) <= 0.0;
            push(&mut self.reflex, is_reflex)?;
        }
        self.grid.build(&self.flat, &self.reflex)?;

        // Hostile polygons would take quadratic time; what is left of them then becomes a fan.
        let mut budget = 1_000_000 + 500 * u64::from(n);
        let (mut corner, mut left, mut without_ear, mut wanted) = (0, n, 0, Ear::Proper);
        while left > 3 && budget > 0 {
            if self.is_ear(corner, wanted, &mut budget) {
                let after = self.clip(corner)?;
                left -= 1;
                // Going on behind the neighbour keeps the triangles from becoming one thin fan.
                corner = self.next[after as usize];
                (without_ear, wanted) = (0, Ear::Proper);
                continue;
            }
            corner = self.next[corner as usize];
            without_ear += 1;
            if without_ear >= left {
                without_ear = 0;
                wanted = match wanted {
                    Ear::Proper => Ear::Flat,
                    Ear::Flat => Ear::Convex,
                    Ear::Convex => break,
                };
            }
        }
        let apex = corner;
        let mut second = self.next[apex as usize];
        for _ in 2..left {
            let third = self.next[second as usize];
            push(&mut self.triangles, [apex, second, third])?;
            second = third;
        }
        Ok(())
    }

    fn at(&self, corner: u32) -> DVec2 {
        self.flat[corner as usize]
    }

    /// Twice the signed area of the corner with its neighbours: positive where it is convex.
    fn turn(&self, corner: u32) -> f64 {
        let (before, after) = (self.previous[corner as usize], self.next[corner as usize]);
        twice_area(self.at(before), self.at(corner), self.at(after))
    }

    fn is_ear(&mut self, corner: u32, wanted: Ear, budget: &mut u64) -> bool {
        *budget = budget.saturating_sub(1);
        let turn = self.turn(corner);
        match wanted {
            Ear::Flat => turn == 0.0,
            Ear::Convex => turn > 0.0,
            Ear::Proper => {
                let ear =
                    [self.previous[corner as usize], corner, self.next[corner as usize]].map(|i| self.at(i));
                turn > 0.0 && !self.grid.any_inside(ear, &self.flat, &self.reflex, budget)
            }
        }
    }

    /// Cuts the corner off; returns the one behind it.
    fn clip(&mut self, corner: u32) -> Result<u32, OutOfMemory> {
        let (before, after) = (self.previous[corner as usize], self.next[corner as usize]);
        push(&mut self.triangles, [before, corner, after])?;
        self.next[before as usize] = after;
        self.previous[after as usize] = before;
        self.reflex[corner as usize] = false;
        for neighbour in [before, after] {
            self.reflex[neighbour as usize] &= self.turn(neighbour) <= 0.0;
        }
        Ok(after)
    }
}

/// Along the diagonal from the first corner where that is right, along the other where only that is.
fn split_quad([a, b, c, d]: [DVec3; 4]) -> [[u32; 3]; 2] {
    let normal = (c - a).cross(d - b);
    let faces_up = |a: DVec3, b: DVec3, c: DVec3| (b - a).cross(c - a).dot(normal) > 0.0;
    let first = faces_up(a, b, c) && faces_up(a, c, d);
    if !first && faces_up(b, c, d) && faces_up(b, d, a) {
        [[0, 1, 3], [1, 2, 3]]
    } else {
        [[0, 1, 2], [0, 2, 3]]
    }
}

/// The normal whose length is twice the polygon's area, relative to its first corner.
pub(super) fn newell_normal(points: &[DVec3]) -> DVec3 {
    let Some((&origin, others)) = points.split_first() else { return DVec3::ZERO };
    others.windows(2).map(|edge| (edge[0] - origin).cross(edge[1] - origin)).sum()
}

fn twice_area(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Reflex corners by the cell they lie in.
#[derive(Default)]
struct Grid {
    low: DVec2,
    cells_per_unit: DVec2,
    side: usize,
    /// Where each cell's corners start in `corners`, and how many are left there.
    cells: Vec<(u32, u32)>,
    corners: Vec<u32>,
}

impl Grid {
    fn build(&mut self, points: &[DVec2], reflex: &[bool]) -> Result<(), OutOfMemory> {
        let count = reflex.iter().filter(|&&r| r).count();
        // Corners lie along curves, not all over the plane: four cells a corner.
        self.side = ((4 * count) as f64).sqrt().clamp(1.0, 2048.0) as usize;
        if count < 32 {
            self.side = 1;
        }
        let (low, high) =
            points.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), &p| (l.min(p), h.max(p)));
        self.low = low;
        self.cells_per_unit = self.side as f64 / (high - low).max(DVec2::splat(f64::MIN_POSITIVE));
        self.cells.clear();
        super::memory::grow(&mut self.cells, self.side * self.side)?;
        self.cells.resize(self.side * self.side, (0, 0));
        self.corners.clear();
        super::memory::grow(&mut self.corners, count)?;
        self.corners.resize(count, 0);
        let inside = || points.iter().zip(reflex).enumerate().filter(|(_, (_, reflex))| **reflex);
        for (_, (&point, _)) in inside() {
            let cell = self.cell(point);
            self.cells[cell].1 += 1;
        }
        let mut start = 0;
        for cell in &mut self.cells {
            cell.0 = start;
            start += std::mem::take(&mut cell.1);
        }
        for (corner, (&point, _)) in inside() {
            let cell = self.cell(point);
            let (start, length) = &mut self.cells[cell];
            self.corners[(*start + *length) as usize] = corner as u32;
            *length += 1;
        }
        Ok(())
    }

    /// In units of cells.
    fn scaled(&self, point: DVec2) -> DVec2 {
        (point - self.low) * self.cells_per_unit
    }

    /// The column or row of a scaled coordinate.
    fn clamp(&self, x: f64) -> usize {
        (x as usize).min(self.side - 1)
    }

    fn cell(&self, point: DVec2) -> usize {
        let scaled = self.scaled(point);
        self.clamp(scaled.y) * self.side + self.clamp(scaled.x)
    }

    /// The columns that a scaled triangle covers in a row: long thin ears cover few cells of their box.
    fn columns(&self, triangle: [DVec2; 3], row: usize) -> std::ops::RangeInclusive<usize> {
        let [a, b, c] = triangle;
        let last = row + 1 == self.side;
        let (bottom, top) = (row as f64, if last { f64::INFINITY } else { row as f64 + 1.0 });
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        for (p, q) in [(a, b), (b, c), (c, a)] {
            let (low, high) = if p.y <= q.y { (p, q) } else { (q, p) };
            if high.y < bottom || low.y > top {
                continue;
            }
            for y in [low.y.max(bottom), high.y.min(top)] {
                let x = if high.y > low.y {
                    low.x + (high.x - low.x) * ((y - low.y) / (high.y - low.y))
                } else {
                    low.x
                };
                left = left.min(x);
                right = right.max(x);
            }
            if high.y == low.y {
                left = left.min(high.x);
                right = right.max(high.x);
            }
        }
        // Far more than the rounding of coordinates below 2048.
        const MARGIN: f64 = 1e-9;
        self.clamp(left - MARGIN)..=self.clamp(right + MARGIN)
    }

    /// Whether a corner that is still reflex lies in the counter-clockwise triangle or on its edge,
    /// corners at the very place of one of the triangle's apart (polygons with a bridge to a hole have those).
    fn any_inside(
        &mut self,
        triangle: [DVec2; 3],
        points: &[DVec2],
        reflex: &[bool],
        budget: &mut u64,
    ) -> bool {
        let [a, b, c] = triangle;
        let scaled = triangle.map(|p| self.scaled(p));
        let heights = scaled.map(|p| self.clamp(p.y));
        let (first_row, last_row) =
            (heights.into_iter().min().unwrap_or(0), heights.into_iter().max().unwrap_or(0));
        for row in first_row..=last_row {
            for column in self.columns(scaled, row) {
                let (start, length) = &mut self.cells[row * self.side + column];
                *budget = budget.saturating_sub(1 + u64::from(*length));
                let mut i = *start;
                while i < *start + *length {
                    let corner = self.corners[i as usize] as usize;
                    if !reflex[corner] {
                        // Clipped, or convex by now, and that it stays.
                        *length -= 1;
                        self.corners.swap(i as usize, (*start + *length) as usize);
                        continue;
                    }
                    let p = points[corner];
                    let inside = twice_area(a, b, p) >= 0.0
                        && twice_area(b, c, p) >= 0.0
                        && twice_area(c, a, p) >= 0.0;
                    if inside && p != a && p != b && p != c {
                        return true;
                    }
                    i += 1;
                }
            }
        }
        false
    }
}

#[cfg(test)]
#[path = "triangulate_tests.rs"]
mod tests;
