//! Moving one side's references to the front, in place.
//!
//! The bins tell how many belong there, so only what lies on the wrong side of that place has to move: the k-th
//! misplaced reference of the front changes places with the k-th of the back. That order does not depend on who
//! does it, so the front and the back can be cut where equally many are misplaced and the cuts be done by all
//! threads. No second array is needed, and each reference is read once and written at most once.

use super::bins::Plane;
use super::bounds::Bounds;
use super::split::PARALLEL;
use rayon::prelude::*;

/// References of one piece of parallel work.
const CHUNK: usize = 1 << 14;

/// References that are counted together to find where to cut.
const COUNTED: usize = 1 << 10;

/// Offsets that are collected before any reference moves, so that the tests take no branch (Edelkamp and Weiß
/// 2016, "BlockQuicksort").
const OFFSETS: usize = 64;

/// Moves what is left of `plane`, `mid` references, to the front. Returns the boxes around both sides' middles.
pub fn partition(plane: Plane, refs: &mut [Bounds], mid: usize) -> (Bounds, Bounds) {
    let all = refs.len();
    let (front, back) = refs.split_at_mut(mid);
    if all < PARALLEL {
        return exchange(plane, front, back);
    }
    let cuts = cuts(plane, front, back);
    let (mut front, mut back) = (front, back);
    let (mut pieces, mut done) = (Vec::with_capacity(cuts.len()), (0, 0));
    for cut in cuts {
        let (f, front_rest) = front.split_at_mut(cut.0 - done.0);
        let (b, back_rest) = back.split_at_mut(cut.1 - done.1);
        (front, back, done) = (front_rest, back_rest, cut);
        pieces.push((f, b));
    }
    let union = |a: (Bounds, Bounds), b: (Bounds, Bounds)| (a.0.union(&b.0), a.1.union(&b.1));
    pieces
        .into_par_iter()
        .map(|(front, back)| exchange(plane, front, back))
        .reduce(|| (Bounds::EMPTY, Bounds::EMPTY), union)
}

/// Where to cut front and back so that every piece has as many misplaced references in the one as in the other.
fn cuts(plane: Plane, front: &[Bounds], back: &[Bounds]) -> Vec<(usize, usize)> {
    let running = |part: &[Bounds], left: bool| {
        let count = |c: &[Bounds]| c.iter().filter(|r| plane.is_left(r) == left).count();
        let mut counts: Vec<usize> = part.par_chunks(COUNTED).map(count).collect();
        let mut sum = 0;
        counts.iter_mut().for_each(|c| {
            sum += *c;
            *c = sum;
        });
        counts
    };
    let (in_front, in_back) = (running(front, false), running(back, true));
    // Behind the k-th misplaced reference of a part.
    let behind = |part: &[Bounds], left: bool, running: &[usize], k: usize| {
        let chunk = running.partition_point(|&c| c < k);
        let mut before = if chunk == 0 { 0 } else { running[chunk - 1] };
        let start = chunk * COUNTED;
        let found = part[start..].iter().position(|r| {
            before += (plane.is_left(r) == left) as usize;
            before == k
        });
        start + found.map_or(0, |at| at + 1)
    };
    let pieces = (front.len() + back.len()).div_ceil(CHUNK);
    let misplaced = in_front.last().copied().unwrap_or(0);
    let mut cuts: Vec<(usize, usize)> = (1..pieces)
        .into_par_iter()
        .map(|i| match misplaced * i / pieces {
            0 => (0, 0),
            k => (behind(front, false, &in_front, k), behind(back, true, &in_back, k)),
        })
        .collect();
    cuts.push((front.len(), back.len()));
    cuts
}

/// Exchanges the misplaced references of two slices that have equally many.
fn exchange(plane: Plane, front: &mut [Bounds], back: &mut [Bounds]) -> (Bounds, Bounds) {
    let mut middles = [Bounds::EMPTY; 2];
    let (mut wrong, mut other) = (Misplaced::new(false), Misplaced::new(true));
    loop {
        wrong.refill(&plane, front, &mut middles);
        other.refill(&plane, back, &mut middles);
        let (from, to) = (wrong.pending(), other.pending());
        let n = from.len().min(to.len());
        for (&f, &b) in from.iter().zip(to) {
            std::mem::swap(&mut front[f as usize], &mut back[b as usize]);
        }
        wrong.taken += n;
        other.taken += n;
        // Equally many on both sides: when one walk found none until its end, so did the other.
        if n == 0 {
            return (middles[0], middles[1]);
        }
    }
}

/// A walk over a slice that collects the offsets of what belongs elsewhere.
struct Misplaced {
    offsets: [u32; OFFSETS],
    len: usize,
    taken: usize,
    next: usize,
    /// Which side is wrong here.
    left: bool,
}

impl Misplaced {
    #[inline(always)]
    fn new(left: bool) -> Misplaced {
        Misplaced { offsets: [0; OFFSETS], len: 0, taken: 0, next: 0, left }
    }

    #[inline(always)]
    fn pending(&self) -> &[u32] {
        &self.offsets[self.taken..self.len]
    }

    /// When all are taken, walks on until some are found or the slice ends.
    #[inline(always)]
    fn refill(&mut self, plane: &Plane, part: &[Bounds], middles: &mut [Bounds; 2]) {
        let [mut left, mut right] = *middles;
        while self.taken == self.len && self.next < part.len() {
            (self.taken, self.len) = (0, 0);
            let end = part.len().min(self.next + OFFSETS);
            for (at, r) in part[self.next..end].iter().enumerate() {
                let is_left = plane.is_left(r);
                self.offsets[self.len % OFFSETS] = (self.next + at) as u32;
                self.len += (is_left == self.left) as usize;
                let middle = Bounds::point(r.middle2());
                left.add(&middle.or_empty(is_left));
                right.add(&middle.or_empty(!is_left));
            }
            self.next = end;
        }
        *middles = [left, right];
    }
}
