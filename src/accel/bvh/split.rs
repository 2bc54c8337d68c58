//! One binary split: binned surface area heuristic, and the partition that follows from it.
//!
//! Wald 2007 ("On fast construction of SAH-based bounding volume hierarchies"): middles of boxes are sorted into
//! equal bins along each axis, and the best of the planes between bins is taken. The cost of a side is
//! area × blocks rather than area × triangles, since four triangles cost as much to test as one.
//!
//! All that is accumulated are minima and integers, so however rayon divides the work, the sums are the same
//! bits; and which of the two partitions runs depends on the number of triangles alone.

use super::bounds::Bounds;
use super::triangle::BLOCK;
use rayon::prelude::*;

/// The most bins an axis can have.
pub const MAX_BINS: usize = 32;

/// From here on a range is binned and partitioned by all threads.
pub const PARALLEL: usize = 1 << 17;

const CHUNK: usize = 1 << 14;

/// Triangles of a node-to-be: a range of the builder's references, the box around them, and the box around
/// their (doubled) middles.
#[derive(Clone, Copy, Debug)]
pub struct Group {
    /// Index of the first reference.
    pub first: usize,
    /// How many.
    pub len: usize,
    /// The box.
    pub bounds: Bounds,
    /// The box around the middles.
    pub middles: Bounds,
}

impl Group {
    /// The group of these references.
    pub fn around(refs: &[Bounds], first: usize) -> Group {
        let empty = (Bounds::EMPTY, Bounds::EMPTY);
        let add = |(mut bounds, mut middles): (Bounds, Bounds), r: &Bounds| {
            bounds.add(r);
            middles.add_point(r.middle2());
            (bounds, middles)
        };
        let (bounds, middles) = if refs.len() < PARALLEL {
            refs.iter().fold(empty, add)
        } else {
            refs.par_chunks(CHUNK)
                .map(|part| part.iter().fold(empty, add))
                .reduce(|| empty, |a, b| (a.0.union(&b.0), a.1.union(&b.1)))
        };
        Group { first, len: refs.len(), bounds, middles }
    }

    /// Cost of testing this many triangles against a ray that enters the box, in block tests.
    pub fn leaf_cost(&self) -> f64 {
        self.bounds.half_area() * blocks(self.len)
    }
}

fn blocks(triangles: usize) -> f64 {
    triangles.div_ceil(BLOCK) as f64
}

/// How middles map to bins.
#[derive(Clone, Copy)]
struct Grid {
    origin: [f32; 4],
    scale: [f32; 4],
    bins: usize,
}

impl Grid {
    /// `None` along axes without extent, or with one too small to be inverted.
    fn new(middles: &Bounds, bins: usize) -> Option<Grid> {
        let extent = middles.extent();
        let mut scale = [0.0; 4];
        for k in 0..3 {
            let s = bins as f32 / extent[k];
            scale[k] = if extent[k] > 0.0 && s.is_finite() { s } else { 0.0 };
        }
        let [x, y, z] = middles.lo();
        (scale != [0.0; 4]).then_some(Grid { origin: [x, y, z, 0.0], scale, bins })
    }

    #[inline(always)]
    fn bin(&self, middle: [f32; 4]) -> [u32; 4] {
        let mut bin = [0; 4];
        for k in 0..4 {
            // In range but for the upper end, which rounds to `bins` itself; 32-bit signed, as SSE2 converts.
            let b = ((middle[k] - self.origin[k]) * self.scale[k]) as i32;
            bin[k] = b.clamp(0, self.bins as i32 - 1) as u32;
        }
        bin
    }
}

struct Bins {
    bounds: [[Bounds; MAX_BINS]; 3],
    counts: [[u32; MAX_BINS]; 3],
}

impl Bins {
    fn fill(grid: &Grid, refs: &[Bounds]) -> Bins {
        let mut bins = Bins { bounds: [[Bounds::EMPTY; MAX_BINS]; 3], counts: [[0; MAX_BINS]; 3] };
        for r in refs {
            let bin = grid.bin(r.middle2());
            for (axis, b) in bin.into_iter().take(3).enumerate() {
                let b = b as usize % MAX_BINS;
                bins.bounds[axis][b].add(r);
                bins.counts[axis][b] += 1;
            }
        }
        bins
    }

    fn merge(mut self, other: Bins) -> Bins {
        for axis in 0..3 {
            for b in 0..MAX_BINS {
                self.bounds[axis][b].add(&other.bounds[axis][b]);
                self.counts[axis][b] += other.counts[axis][b];
            }
        }
        self
    }
}

/// A plane between bins.
pub struct Split {
    grid: Grid,
    axis: usize,
    /// The first bin on the right.
    bin: u32,
    /// Σ area × blocks over both sides.
    pub cost: f64,
    left: Bounds,
    right: Bounds,
}

impl Split {
    /// The cheapest split; `None` when all middles coincide (to the resolution of f32).
    pub fn find(refs: &[Bounds], group: &Group, most_bins: usize) -> Option<Split> {
        // Few triangles need few bins, and clearing and sweeping bins is most of their cost.
        let count = (8 + refs.len() / 8).min(most_bins).min(MAX_BINS);
        let grid = Grid::new(&group.middles, count)?;
        let bins = if refs.len() < PARALLEL {
            Bins::fill(&grid, refs)
        } else {
            refs.par_chunks(CHUNK).map(|part| Bins::fill(&grid, part)).reduce_with(Bins::merge)?
        };
        let mut best: Option<Split> = None;
        for axis in (0..3).filter(|&axis| grid.scale[axis] > 0.0) {
            let (bounds, counts) = (&bins.bounds[axis], &bins.counts[axis]);
            let mut right_side = [(Bounds::EMPTY, 0usize); MAX_BINS];
            let (mut right, mut n) = (Bounds::EMPTY, 0);
            for b in (1..count).rev() {
                right.add(&bounds[b]);
                n += counts[b] as usize;
                right_side[b] = (right, n);
            }
            let (mut left, mut n) = (Bounds::EMPTY, 0);
            for b in 1..count {
                left.add(&bounds[b - 1]);
                n += counts[b - 1] as usize;
                let (right, m) = right_side[b];
                if n == 0 || m == 0 {
                    continue;
                }
                let cost = left.half_area() * blocks(n) + right.half_area() * blocks(m);
                if best.as_ref().is_none_or(|s| cost < s.cost) {
                    best = Some(Split { grid, axis, bin: b as u32, cost, left, right });
                }
            }
        }
        best
    }

    #[inline(always)]
    fn is_left(&self, middle: [f32; 4]) -> bool {
        self.grid.bin(middle)[self.axis] < self.bin
    }

    /// Moves the left side's references to the front. `scratch` is as long as `refs` where `refs` is long
    /// enough for all threads.
    pub fn apply(&self, refs: &mut [Bounds], scratch: &mut [Bounds], first: usize) -> (Group, Group) {
        let (mid, left, right) = if refs.len() < PARALLEL || scratch.len() != refs.len() {
            self.partition(refs)
        } else {
            self.partition_parallel(refs, scratch)
        };
        (
            Group { first, len: mid, bounds: self.left, middles: left },
            Group { first: first + mid, len: refs.len() - mid, bounds: self.right, middles: right },
        )
    }

    /// Hoare's, in place. Returns the length of the left side and both sides' middles.
    fn partition(&self, refs: &mut [Bounds]) -> (usize, Bounds, Bounds) {
        let (mut left, mut right) = (Bounds::EMPTY, Bounds::EMPTY);
        let (mut i, mut j) = (0, refs.len());
        while i < j {
            let middle = refs[i].middle2();
            if self.is_left(middle) {
                left.add_point(middle);
                i += 1;
            } else {
                right.add_point(middle);
                j -= 1;
                refs.swap(i, j);
            }
        }
        (i, left, right)
    }

    /// Stable, through `scratch`, in chunks that write to places counted beforehand.
    fn partition_parallel(&self, refs: &mut [Bounds], scratch: &mut [Bounds]) -> (usize, Bounds, Bounds) {
        let parts: Vec<(usize, Bounds, Bounds)> = refs
            .par_chunks(CHUNK)
            .map(|part| {
                let (mut n, mut left, mut right) = (0, Bounds::EMPTY, Bounds::EMPTY);
                for middle in part.iter().map(Bounds::middle2) {
                    if self.is_left(middle) {
                        n += 1;
                        left.add_point(middle);
                    } else {
                        right.add_point(middle);
                    }
                }
                (n, left, right)
            })
            .collect();
        let mid = parts.iter().map(|p| p.0).sum();
        let (mut lefts, mut rights) = scratch.split_at_mut(mid);
        let mut places = Vec::with_capacity(parts.len());
        for (part, (n, _, _)) in refs.chunks(CHUNK).zip(&parts) {
            let (left, rest) = std::mem::take(&mut lefts).split_at_mut(*n);
            lefts = rest;
            let (right, rest) = std::mem::take(&mut rights).split_at_mut(part.len() - n);
            rights = rest;
            places.push((part, left, right));
        }
        places.into_par_iter().for_each(|(part, left, right)| {
            let (mut i, mut j) = (0, 0);
            for r in part {
                if self.is_left(r.middle2()) {
                    left[i] = *r;
                    i += 1;
                } else {
                    right[j] = *r;
                    j += 1;
                }
            }
        });
        refs.par_chunks_mut(CHUNK)
            .zip(scratch.par_chunks(CHUNK))
            .for_each(|(to, from)| to.copy_from_slice(from));
        let sides =
            parts.iter().fold((Bounds::EMPTY, Bounds::EMPTY), |(l, r), p| (l.union(&p.1), r.union(&p.2)));
        (mid, sides.0, sides.1)
    }
}

/// Halves a group in the order it happens to have: for coinciding middles, which no plane separates.
pub fn halve(refs: &[Bounds], first: usize) -> (Group, Group) {
    let (left, right) = refs.split_at(refs.len() / 2);
    (Group::around(left, first), Group::around(right, first + left.len()))
}
