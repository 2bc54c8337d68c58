//! Independent random numbers: a hash of seed, pixel, sample and dimension.

use super::Key;

/// Independent random numbers.
#[derive(Clone, Debug)]
pub(super) struct Random {
    seed: u64,
}

impl Random {
    pub(super) fn new(seed: u64) -> Random {
        Random { seed: mix(seed ^ 0x9e37_79b9_7f4a_7c15) }
    }

    #[inline(always)]
    pub(super) fn bits(&self, key: Key, dimension: u32) -> u32 {
        (self.word(key, dimension) >> 32) as u32
    }

    #[inline(always)]
    pub(super) fn bits2(&self, key: Key, dimension: u32) -> [u32; 2] {
        let word = self.word(key, dimension);
        [(word >> 32) as u32, word as u32]
    }

    /// 64 random bits. Two rounds, each a bijection of what is new in it, so that no two addresses share a number
    /// by their form; the second also takes in the seed, so that seeds are no shifts of each other.
    #[inline(always)]
    fn word(&self, key: Key, dimension: u32) -> u64 {
        let place = u64::from(key.pixel) << 32 | u64::from(key.index);
        mix(mix(place ^ self.seed) ^ self.seed.rotate_left(32) ^ u64::from(dimension).wrapping_mul(GOLDEN))
    }
}

/// 2⁶⁴ over the golden ratio: neighbouring dimensions end up far apart.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// A bijection of 64 bits in which every output bit depends on every input bit (Stafford 2011, variant 13).
#[inline(always)]
fn mix(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}
