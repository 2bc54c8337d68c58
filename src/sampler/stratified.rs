//! Jittered strata: the notes' 13.6 with as many regions as the pixel has samples and one point in each.
//!
//! A pair of dimensions is a grid of cells, a single one a row; which sample gets which cell is a random
//! permutation of its own in every dimension and pixel, so that dimensions stay independent of each other.

use super::{Key, dimension_seed, hash};

/// Jittered strata.
#[derive(Clone, Debug)]
pub(super) struct Stratified {
    /// Cells of a single dimension.
    count: u32,
    /// Cells of a pair, along each axis; at least `count` in all. Where there are more (a count without two
    /// near factors) a random choice of them stays empty, which leaves the mean exact.
    grid: [u32; 2],
}

impl Stratified {
    pub(super) fn new(spp: u32) -> Stratified {
        let count = spp.max(1);
        let root = f64::from(count).sqrt() as u32;
        // The largest factor not far below the root, if there is one; else round up.
        let factor = (root / 2 + 1..=root).rev().find(|f| count.is_multiple_of(*f));
        let rows = factor.unwrap_or_else(|| root.max(1));
        Stratified { count, grid: [count.div_ceil(rows), rows] }
    }

    #[inline]
    pub(super) fn bits(&self, key: Key, dimension: u32) -> u32 {
        let seed = dimension_seed(key.pixel, dimension);
        let cell = permute(key.index % self.count, self.count, seed);
        place(cell, self.count, jitter(seed, key.index))
    }

    #[inline]
    pub(super) fn bits2(&self, key: Key, dimension: u32) -> [u32; 2] {
        let seed = dimension_seed(key.pixel, dimension);
        let [columns, rows] = self.grid;
        let cell = permute(key.index % self.count, columns * rows, seed);
        let second = dimension_seed(key.pixel, dimension + 1);
        [
            place(cell % columns, columns, jitter(seed, key.index)),
            place(cell / columns, rows, jitter(second, key.index)),
        ]
    }
}

/// Independent bits per sample.
#[inline]
fn jitter(seed: u32, index: u32) -> u32 {
    hash(seed ^ hash(index ^ 0x68bc_21eb))
}

/// The point at share `jitter` of `cell` out of `cells`, as a fraction of 2³².
#[inline]
fn place(cell: u32, cells: u32, jitter: u32) -> u32 {
    (((u64::from(cell) << 32) + u64::from(jitter)) / u64::from(cells)) as u32
}

/// A random permutation of 0 … n−1: a keyed bijection of the next power of two, repeated until the value
/// falls below n (cycle walking, Black and Rogaway 2002).
#[inline]
fn permute(mut x: u32, n: u32, seed: u32) -> u32 {
    if n <= 1 {
        return 0;
    }
    let bits = 32 - (n - 1).leading_zeros();
    let mask = u32::MAX >> (32 - bits);
    let half = bits.div_ceil(2);
    loop {
        for round in 0..4u32 {
            let key = hash(seed.wrapping_add(round));
            x = (x ^ key) & mask;
            x = x.wrapping_mul(key >> 8 | 1) & mask;
            x ^= x >> half;
        }
        if x < n {
            return x;
        }
    }
}
