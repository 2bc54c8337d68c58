//! Owen-scrambled Halton points (Halton 1960, Owen 1995, with linear permutations after Matoušek 1998): dimension d is the radical inverse of the sample's index in
//! the d-th prime, Σ digit_k·b^−(k+1).
//!
//! Every digit is permuted in a way that depends on the digits before it, a node of a tree, so that each power
//! of the base keeps one point in each of as many equal intervals. Unlike Sobol's, the points favour no power of two as
//! the number of samples. They cost several times as much, and in larger bases they fill the first dozens of samples
//! worse, so dimensions beyond the table are the Sobol sampler's.

use super::sobol::Sobol;
use super::{Key, dimension_seed, hash};

/// The bases.
const PRIMES: [u32; 32] = [
    2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53, 59, 61, 67, 71, 73, 79, 83, 89, 97, 101, 103,
    107, 109, 113, 127, 131,
];

/// Digits are permuted one by one down to intervals of at most this share of the whole, and as far as the index goes;
/// below that the point is anywhere in its interval.
const FINE: u64 = 1 << 16;

/// Scrambled Halton points.
#[derive(Clone, Copy, Debug)]
pub(super) struct Halton {
    beyond: &'static Sobol,
}

impl Halton {
    pub(super) fn new() -> Halton {
        Halton { beyond: Sobol::get() }
    }

    #[inline]
    pub(super) fn bits(&self, key: Key, dimension: u32) -> u32 {
        match PRIMES.get(dimension as usize) {
            Some(base) => scrambled_inverse(key.index, *base, dimension_seed(key.pixel, dimension)),
            None => self.beyond.bits(key, dimension),
        }
    }

    #[inline]
    pub(super) fn bits2(&self, key: Key, dimension: u32) -> [u32; 2] {
        if (dimension as usize) < PRIMES.len() {
            [self.bits(key, dimension), self.bits(key, dimension + 1)]
        } else {
            self.beyond.bits2(key, dimension)
        }
    }
}

/// A digit under a random permutation of 0 … base − 1. The base is prime, so a·digit + c is one for every a but 0; any two
/// digits go to any two places alike.
#[inline]
fn permuted(digit: u32, base: u32, seed: u32) -> u32 {
    let below = |n: u32, bits: u32| (u64::from(bits) * u64::from(n)) >> 32;
    let (a, c) = (1 + below(base - 1, seed), below(base, hash(seed ^ 0x2545_f491)));
    ((a * u64::from(digit) + c) % u64::from(base)) as u32
}

/// The radical inverse of `index` in `base`, scrambled, as a fraction of 2³².
fn scrambled_inverse(index: u32, base: u32, seed: u32) -> u32 {
    let (mut rest, mut node, mut cell, mut cells) = (index, seed, 0u64, 1u64);
    while cells < FINE || rest > 0 {
        let digit = rest % base;
        rest /= base;
        // One base more than 2³² at the most: no overflow.
        cell = cell * u64::from(base) + u64::from(permuted(digit, base, node));
        cells *= u64::from(base);
        node = hash(node ^ hash(digit + 1));
    }
    let within = u128::from(cell) << 32 | u128::from(hash(node));
    (within / u128::from(cells)) as u32
}
