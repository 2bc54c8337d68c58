//! Splits in space: a triangle that reaches over the plane goes to both sides, each with the box of its part.
//!
//! Stich, Friedrich and Dietrich 2009 ("Spatial splits in bounding volume hierarchies"). Long thin triangles that lie
//! across the axes have boxes far larger than themselves, and no sorting of whole boxes keeps them apart. Their
//! remedy is tried where the two sides of the best ordinary split overlap, while there is room for more references.
//!
//! **Why no answer changes.** A triangle met twice is the same hit twice. What must hold is that every point where a
//! ray may meet the triangle lies in the box of one of its parts, and rounding displaces such a point by a share of
//! the triangle's *own* largest coordinate ([`super::node`] derives it), which a part's box may know nothing of. So a
//! whole triangle's box is enlarged by twice that margin before any cut ([`with_margin`]), and a part on all sides
//! when it is cut off, but never beyond the box it is cut from.

use super::bins::blocks;
use super::bounds::Bounds;
use super::node::margin;
use super::split::{Group, PARALLEL};
use crate::shape::Mesh;
use rayon::prelude::*;
use std::sync::Arc;

/// Planes are tried between this many bins an axis.
const BINS: usize = 16;

const CHUNK: usize = 1 << 14;

/// References beyond the triangles, as a share of them, at most. Meshes of even triangles take some hundredths; a
/// hall of beams takes all of it. More would let the references outweigh the finished structure.
pub const BUDGET: f64 = 0.7;

/// How large the overlap of an ordinary split's sides must be, against the root, for space to be tried.
pub const OVERLAP: f64 = 1e-5;

/// A plane in space.
pub struct Spatial {
    axis: usize,
    plane: f32,
    /// Σ area × blocks over both sides.
    pub cost: f64,
    left: (Bounds, usize),
    right: (Bounds, usize),
}

/// Bins of one axis: boxes of the parts, and how many references begin and end there.
#[derive(Clone)]
struct Bins {
    bounds: [[Bounds; BINS]; 3],
    begin: [[u32; BINS]; 3],
    end: [[u32; BINS]; 3],
}

impl Spatial {
    /// The cheapest plane in space through the references of a group that cuts no more of them than there is
    /// room for.
    pub fn find(meshes: &[Arc<Mesh>], refs: &[Bounds], group: &Group) -> Option<Spatial> {
        let (lo, extent) = (group.bounds.lo(), group.bounds.extent());
        let planes = [0, 1, 2].map(|k| {
            let mut planes = [lo[k]; BINS];
            planes.iter_mut().enumerate().for_each(|(i, p)| *p += extent[k] * (i as f32 / BINS as f32));
            planes
        });
        let bins = if refs.len() < PARALLEL {
            Bins::fill(meshes, refs, &planes, extent)
        } else {
            let fill = |part| Bins::fill(meshes, part, &planes, extent);
            refs.par_chunks(CHUNK).map(fill).reduce_with(Bins::merge)?
        };
        let mut best: Option<Spatial> = None;
        for (axis, planes) in planes.iter().enumerate() {
            let mut rights = [(Bounds::EMPTY, 0); BINS];
            let (mut right, mut m) = (Bounds::EMPTY, 0);
            for b in (1..BINS).rev() {
                right.add(&bins.bounds[axis][b]);
                m += bins.end[axis][b] as usize;
                rights[b] = (right, m);
            }
            let (mut left, mut n) = (Bounds::EMPTY, 0);
            for b in 1..BINS {
                left.add(&bins.bounds[axis][b - 1]);
                n += bins.begin[axis][b - 1] as usize;
                let (right, m) = rights[b];
                let cost = left.half_area() * blocks(n) + right.half_area() * blocks(m);
                if n != 0 && m != 0 && n + m <= group.room && best.as_ref().is_none_or(|s| cost < s.cost) {
                    let (left, right) = ((left, n), (right, m));
                    best = Some(Spatial { axis, plane: planes[b], cost, left, right });
                }
            }
        }
        best
    }

    /// Distributes the first `len` of `refs`; parts that are new are put behind them. `None`, and no more
    /// than their order has changed, where these would be too many or one side would stay empty.
    pub fn apply(
        &self,
        meshes: &[Arc<Mesh>],
        refs: &mut [Bounds],
        len: usize,
        first: usize,
    ) -> Option<(Group, Group)> {
        if refs[..len].iter().filter(|r| self.is_across(r)).count() > refs.len() - len {
            return None;
        }
        let empty = Group { first, len: 0, room: 0, bounds: Bounds::EMPTY, middles: Bounds::EMPTY };
        let (mut left, mut right) = (empty, empty);
        let (mut i, mut j, mut end) = (0, len, len);
        while i < j {
            let r = refs[i];
            let parts = if self.is_across(&r) { self.parts(meshes, &r) } else { None };
            if let Some((l, r)) = parts {
                left.add(&l);
                right.add(&r);
                (refs[i], refs[end]) = (l, r);
                (i, end) = (i + 1, end + 1);
            } else if self.goes_left(&r) {
                left.add(&r);
                i += 1;
            } else {
                right.add(&r);
                j -= 1;
                refs.swap(i, j);
            }
        }
        right.first = first + i;
        // With a side empty nothing was cut, only the order has changed.
        (left.len > 0 && right.len > 0).then_some((left, right))
    }

    fn is_across(&self, r: &Bounds) -> bool {
        r.lo()[self.axis] < self.plane && r.hi()[self.axis] > self.plane
    }

    /// For what is not cut in two.
    fn goes_left(&self, r: &Bounds) -> bool {
        if self.is_across(r) {
            return self.whole_cost(r, true) <= self.whole_cost(r, false);
        }
        r.hi()[self.axis] <= self.plane
    }

    /// Both parts of a reference that lies across; `None` where it is cheaper on one side as a whole (their
    /// "reference unsplitting", against the bins' boxes so that no order of the references matters).
    fn parts(&self, meshes: &[Arc<Mesh>], r: &Bounds) -> Option<(Bounds, Bounds)> {
        let cut =
            self.left.0.half_area() * self.left.1 as f64 + self.right.0.half_area() * self.right.1 as f64;
        if cut >= self.whole_cost(r, true).min(self.whole_cost(r, false)) {
            return None;
        }
        let (left, right) = Triangle::of(meshes, r).cut(r, self.axis, self.plane);
        (!left.is_empty() && !right.is_empty()).then_some((left, right))
    }

    fn whole_cost(&self, r: &Bounds, to_left: bool) -> f64 {
        let ((left, n), (right, m)) = (self.left, self.right);
        if to_left {
            left.union(r).half_area() * n as f64 + right.half_area() * (m as f64 - 1.0)
        } else {
            left.half_area() * (n as f64 - 1.0) + right.union(r).half_area() * m as f64
        }
    }
}

impl Group {
    fn add(&mut self, r: &Bounds) {
        self.len += 1;
        self.bounds.add(r);
        self.middles.add(&Bounds::point(r.middle2()));
    }
}

impl Bins {
    fn fill(meshes: &[Arc<Mesh>], refs: &[Bounds], planes: &[[f32; BINS]; 3], extent: [f32; 3]) -> Bins {
        let mut bins =
            Bins { bounds: [[Bounds::EMPTY; BINS]; 3], begin: [[0; BINS]; 3], end: [[0; BINS]; 3] };
        let scale = extent.map(|e| if e > 0.0 { BINS as f32 / e } else { 0.0 });
        let bin = |axis: usize, x: f32| {
            let b = ((x - planes[axis][0]) * scale[axis]) as i32;
            b.clamp(0, BINS as i32 - 1) as usize
        };
        for r in refs {
            let (lo, hi) = (r.lo(), r.hi());
            for axis in 0..3 {
                let (first, last) = (bin(axis, lo[axis]), bin(axis, hi[axis]));
                bins.begin[axis][first] += 1;
                bins.end[axis][last] += 1;
                let mut rest = *r;
                if first < last {
                    let triangle = Triangle::of(meshes, r);
                    for b in first..last {
                        let (left, right) = triangle.cut(&rest, axis, planes[axis][b + 1]);
                        bins.bounds[axis][b].add(&left);
                        rest = right;
                    }
                }
                bins.bounds[axis][last].add(&rest);
            }
        }
        bins
    }

    fn merge(mut self, other: Bins) -> Bins {
        for axis in 0..3 {
            for b in 0..BINS {
                self.bounds[axis][b].add(&other.bounds[axis][b]);
                self.begin[axis][b] += other.begin[axis][b];
                self.end[axis][b] += other.end[axis][b];
            }
        }
        self
    }
}

/// A triangle's box with the margin that its parts need, on the sides where none is cut off as well.
pub fn with_margin(bounds: Bounds, corners: &[[f32; 3]; 3]) -> Bounds {
    let mut larger = bounds.enlarged(part_margin(corners));
    (larger.0[3], larger.0[7]) = (bounds.0[3], bounds.0[7]);
    larger
}

fn part_margin(corners: &[[f32; 3]; 3]) -> f32 {
    2.0 * margin(corners.iter().flatten().fold(0.0f32, |l, x| l.max(x.abs())))
}

/// A triangle to be cut.
struct Triangle {
    corners: [[f32; 3]; 3],
    /// How far its parts' boxes reach beyond them.
    margin: f32,
}

impl Triangle {
    fn of(meshes: &[Arc<Mesh>], r: &Bounds) -> Triangle {
        let (mesh, triangle) = r.words();
        let corners = meshes[mesh as usize].triangle(triangle as usize).map(|p| p.to_array());
        Triangle { corners, margin: part_margin(&corners) }
    }

    /// Boxes of what is below and above the plane of the part in `r`; empty where nothing is.
    fn cut(&self, r: &Bounds, axis: usize, plane: f32) -> (Bounds, Bounds) {
        let (mut left, mut right) = (Bounds::EMPTY, Bounds::EMPTY);
        for i in 0..3 {
            let (a, b) = (self.corners[i], self.corners[(i + 1) % 3]);
            let corner = Bounds::point([a[0], a[1], a[2], 0.0]);
            if a[axis] <= plane {
                left.add(&corner);
            }
            if a[axis] >= plane {
                right.add(&corner);
            }
            if (a[axis] < plane) != (b[axis] < plane) {
                // In f64 far more exact than the margin.
                let share = (plane as f64 - a[axis] as f64) / (b[axis] as f64 - a[axis] as f64);
                let [x, y, z] = [0, 1, 2].map(|k| (a[k] as f64 + (b[k] as f64 - a[k] as f64) * share) as f32);
                let crossing = Bounds::point([x, y, z, 0.0]);
                left.add(&crossing);
                right.add(&crossing);
            }
        }
        (left.enlarged(self.margin).within(r), right.enlarged(self.margin).within(r))
    }
}
