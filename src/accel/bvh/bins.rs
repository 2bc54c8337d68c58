//! Counting triangles in bins, and the cheapest plane between two bins.
//!
//! Wald 2007 ("On fast construction of SAH-based bounding volume hierarchies"): middles of boxes are sorted into
//! equal bins along each axis, and the best of the planes between bins is taken. The cost of a side is
//! area × blocks rather than area × triangles, since four triangles cost as much to test as one.
//!
//! All that is accumulated are minima and integers, so however rayon divides the work, and whatever the
//! instruction set, the sums are the same bits.

use super::bounds::Bounds;
use super::triangle::BLOCK;
use glam::Vec4;

/// The most bins an axis can have.
pub const MAX_BINS: usize = 32;

/// How many blocks hold this many triangles.
#[inline(always)]
pub fn blocks(triangles: usize) -> f64 {
    triangles.div_ceil(BLOCK) as f64
}

/// 2²³: a sum with it is a whole number, which stands in the lowest bits. The rounding is to the nearest, on every
/// machine and without the care that conversions to integers take of numbers out of range. A middle lies half a bin lower than in a
/// grid with truncation, so that what rounds to n is in bin n.
const WHOLE: f32 = (1 << 23) as f32;

/// How middles map to bins.
#[derive(Clone, Copy)]
pub struct Grid {
    origin: Vec4,
    scale: Vec4,
    bins: usize,
}

impl Grid {
    /// `bins` bins along each axis of this box around (doubled) middles. An axis without extent, or with one too
    /// small to be inverted, has one bin; `None` when that is so for all.
    #[inline(always)]
    pub fn new(middles: &Bounds, bins: usize) -> Option<Grid> {
        let extent = middles.extent();
        let mut scale = [0.0; 4];
        for k in 0..3 {
            let s = bins as f32 / extent[k];
            scale[k] = if extent[k] > 0.0 && s.is_finite() { s } else { 0.0 };
        }
        let [x, y, z] = middles.lo();
        let (origin, scale) = (Vec4::new(x, y, z, 0.0), Vec4::from(scale));
        (scale != Vec4::ZERO).then_some(Grid { origin, scale, bins })
    }

    #[inline(always)]
    fn bin(&self, middle: [f32; 4]) -> [u32; 4] {
        let place = (Vec4::from(middle) - self.origin) * self.scale - Vec4::splat(0.5);
        let inside = place.max(Vec4::ZERO).min(Vec4::splat((self.bins - 1) as f32));
        (inside + Vec4::splat(WHOLE)).to_array().map(|x| x.to_bits() - WHOLE.to_bits())
    }

    /// The plane below a bin (not the first), as a test of one box.
    #[inline(always)]
    pub fn plane(&self, axis: usize, bin: usize) -> Plane {
        Plane { axis: axis % 3, origin: self.origin[axis], scale: self.scale[axis], bin: WHOLE + bin as f32 }
    }
}

/// Tells which side of a plane between bins a box belongs to.
#[derive(Clone, Copy)]
pub struct Plane {
    axis: usize,
    origin: f32,
    scale: f32,
    bin: f32,
}

impl Plane {
    /// True when the box's middle is in a bin below the plane, by the same roundings as [`Grid::bin`]'s.
    #[inline(always)]
    pub fn is_left(&self, r: &Bounds) -> bool {
        let middle = r.0[self.axis] - r.0[self.axis + 4];
        ((middle - self.origin) * self.scale - 0.5) + WHOLE < self.bin
    }
}

/// Boxes and numbers of the triangles in each of at most `N` bins; to clear what is not needed would cost as much as to
/// fill what is.
pub struct Bins<const N: usize> {
    bounds: [[Bounds; N]; 3],
    counts: [[u32; N]; 3],
}

/// The cheapest plane of a [`Bins`].
#[derive(Clone, Copy)]
pub struct Best {
    /// Axis of the plane.
    pub axis: usize,
    /// The first bin above it.
    pub bin: usize,
    /// Σ area × blocks over both sides.
    pub cost: f64,
}

impl<const N: usize> Bins<N> {
    /// Sorts triangles into bins.
    #[inline(always)]
    pub fn fill(grid: &Grid, refs: &[Bounds]) -> Self {
        let mut bins = Bins { bounds: [[Bounds::EMPTY; N]; 3], counts: [[0; N]; 3] };
        for r in refs {
            let bin = grid.bin(r.middle2());
            for (axis, b) in bin.into_iter().take(3).enumerate() {
                let b = b as usize % N;
                bins.bounds[axis][b].add(r);
                bins.counts[axis][b] += 1;
            }
        }
        bins
    }

    /// The bins of both.
    pub fn merge(mut self, other: Self) -> Self {
        for axis in 0..3 {
            for b in 0..N {
                self.bounds[axis][b].add(&other.bounds[axis][b]);
                self.counts[axis][b] += other.counts[axis][b];
            }
        }
        self
    }

    /// The cheapest plane with triangles on both sides; of equal ones the first.
    #[inline(always)]
    pub fn best(&self, grid: &Grid) -> Option<Best> {
        let mut best: Option<Best> = None;
        for axis in (0..3).filter(|&axis| grid.scale[axis] > 0.0) {
            let (bounds, counts) = (&self.bounds[axis], &self.counts[axis]);
            let count = grid.bins.min(N);
            let mut right_cost = [0.0; N];
            let (mut right, mut m) = (Bounds::EMPTY, 0);
            for b in (1..count).rev() {
                right.add(&bounds[b]);
                m += counts[b] as usize;
                right_cost[b] = right.half_area() * blocks(m);
            }
            let total = m + counts[0] as usize;
            let (mut left, mut n) = (Bounds::EMPTY, 0);
            for b in 1..count {
                left.add(&bounds[b - 1]);
                n += counts[b - 1] as usize;
                let cost = left.half_area() * blocks(n) + right_cost[b];
                if n != 0 && n != total && best.is_none_or(|s| cost < s.cost) {
                    best = Some(Best { axis, bin: b, cost });
                }
            }
        }
        best
    }

    /// Boxes on both sides of a plane, and how many triangles are on the left.
    #[inline(always)]
    pub fn sides(&self, best: &Best) -> (Bounds, Bounds, usize) {
        let (bounds, counts) = (&self.bounds[best.axis], &self.counts[best.axis]);
        let (mut left, mut right, mut n) = (Bounds::EMPTY, Bounds::EMPTY, 0);
        for b in 0..N {
            if b < best.bin {
                left.add(&bounds[b]);
                n += counts[b] as usize;
            } else {
                right.add(&bounds[b]);
            }
        }
        (left, right, n)
    }
}
