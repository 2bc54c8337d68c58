//! Independent random numbers: ChaCha8 keyed by seed, pixel and sample, read at the dimension.

use super::Key;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::{Rng, SeedableRng};

/// Independent random numbers.
#[derive(Clone, Debug)]
pub(super) struct Random {
    seed: u64,
}

impl Random {
    pub(super) fn new(seed: u64) -> Random {
        Random { seed }
    }

    #[inline]
    pub(super) fn bits(&self, key: Key, dimension: u32) -> u32 {
        let mut bytes = [0; 32];
        bytes[..8].copy_from_slice(&self.seed.to_le_bytes());
        bytes[8..12].copy_from_slice(&key.pixel.to_le_bytes());
        bytes[12..16].copy_from_slice(&key.index.to_le_bytes());
        let mut rng = ChaCha8Rng::from_seed(bytes);
        rng.set_word_pos(u128::from(dimension));
        rng.next_u32()
    }
}
