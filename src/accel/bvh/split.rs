//! One binary split of a group of references: find it, and carry it out.
//!
//! Which way is taken depends on the number of triangles alone, never on the threads.

use super::bins::{Bins, Grid, MAX_BINS, Plane};
use super::bounds::Bounds;
use super::partition::partition;
use rayon::prelude::*;

/// From here on a range is binned and partitioned by all threads.
pub const PARALLEL: usize = 1 << 17;

const CHUNK: usize = 1 << 14;

/// The bins of up to 64 triangles.
const FEW_BINS: usize = 16;

/// Triangles of a node-to-be: a range of the builder's references, the box around them, and the box around
/// their (doubled) middles.
#[derive(Clone, Copy, Debug)]
pub struct Group {
    /// Index of the first reference.
    pub first: usize,
    /// How many.
    pub len: usize,
    /// For how many there is room, itself included; splits in space fill it.
    pub room: usize,
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
            middles.add(&Bounds::point(r.middle2()));
            (bounds, middles)
        };
        let (bounds, middles) = if refs.len() < PARALLEL {
            refs.iter().fold(empty, add)
        } else {
            refs.par_chunks(CHUNK)
                .map(|part| part.iter().fold(empty, add))
                .reduce(|| empty, |a, b| (a.0.union(&b.0), a.1.union(&b.1)))
        };
        Group { first, len: refs.len(), room: refs.len(), bounds, middles }
    }
}

/// A plane between bins, and what is on its sides.
pub struct Split {
    plane: Plane,
    /// Σ area × blocks over both sides.
    pub cost: f64,
    left: Bounds,
    right: Bounds,
    /// How many are on the left.
    mid: usize,
}

impl Split {
    /// The cheapest split; `None` when all middles coincide (to the resolution of f32).
    pub fn find(refs: &[Bounds], group: &Group) -> Option<Split> {
        match refs.len() {
            0..64 => Split::find_in::<FEW_BINS>(refs, group),
            _ => Split::find_in::<MAX_BINS>(refs, group),
        }
    }

    fn find_in<const N: usize>(refs: &[Bounds], group: &Group) -> Option<Split> {
        // Few triangles need few bins, and clearing and sweeping bins is most of their cost.
        let count = (8 + refs.len() / 8).min(N);
        let grid = Grid::new(&group.middles, count)?;
        let bins = if refs.len() < PARALLEL {
            Bins::<N>::fill(&grid, refs)
        } else {
            refs.par_chunks(CHUNK).map(|part| Bins::fill(&grid, part)).reduce_with(Bins::merge)?
        };
        let best = bins.best(&grid)?;
        let (left, right, mid) = bins.sides(&best);
        Some(Split { plane: grid.plane(best.axis, best.bin), cost: best.cost, left, right, mid })
    }

    /// Moves the left side's references to the front.
    pub fn apply(&self, refs: &mut [Bounds], first: usize) -> (Group, Group) {
        let mid = self.mid;
        let (left, right) = partition(self.plane, refs, mid);
        let group = |first, len, bounds, middles| Group { first, len, room: len, bounds, middles };
        (group(first, mid, self.left, left), group(first + mid, refs.len() - mid, self.right, right))
    }

    /// Half the area that both sides have in common.
    pub fn overlap(&self) -> f64 {
        let both = self.left.within(&self.right);
        if both.is_empty() { 0.0 } else { both.half_area() }
    }
}

/// Parts a block's triangles or fewer along the axis on which their middles are farthest apart, where the two boxes are
/// the smallest.
pub fn part_few(refs: &mut [Bounds], first: usize) -> (Group, Group) {
    let middles = refs.iter().fold(Bounds::EMPTY, |b, r| b.union(&Bounds::point(r.middle2())));
    let [x, y, z] = middles.extent();
    let axis = if x >= y && x >= z { 0 } else { 1 + usize::from(z > y) };
    for i in 1..refs.len() {
        let mut at = i;
        while at > 0 && refs[at - 1].middle2()[axis] > refs[at].middle2()[axis] {
            refs.swap(at - 1, at);
            at -= 1;
        }
    }
    let around = |refs: &[Bounds]| refs.iter().fold(Bounds::EMPTY, |b, r| b.union(r));
    let (mut cut, mut least) = (1, f64::INFINITY);
    for at in 1..refs.len() {
        let cost = around(&refs[..at]).half_area() + around(&refs[at..]).half_area();
        if cost < least {
            (cut, least) = (at, cost);
        }
    }
    let (left, right) = refs.split_at(cut);
    (Group::around(left, first), Group::around(right, first + cut))
}

/// Gives each of two adjoining groups, which begin `refs`, its share of the room behind them.
pub fn share_room(refs: &mut [Bounds], left: &mut Group, right: &mut Group) {
    let spare = refs.len() - left.len - right.len;
    let mine = (spare as u64 * left.len as u64 / (left.len + right.len) as u64) as usize;
    let moved = mine.min(right.len);
    refs.copy_within(left.len..left.len + moved, left.len + mine + right.len - moved);
    left.room = left.len + mine;
    right.first += mine;
    right.room = right.len + spare - mine;
}

/// Halves a group in the order it happens to have: for coinciding middles, which no plane separates.
pub fn halve(refs: &[Bounds], first: usize) -> (Group, Group) {
    let (left, right) = refs.split_at(refs.len() / 2);
    (Group::around(left, first), Group::around(right, first + left.len()))
}
