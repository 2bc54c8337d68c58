//! Blocks of samples. Waves are made of them, so they are part of what a picture's bits depend on, and fixed.

use std::ops::Range;

/// Samples in a block beyond the first two.
const LENGTH: u32 = 16;

/// The samples of block `k`: the first sample alone, so that a whole picture exists soon; the other 15 of
/// the first 16; then 16 at a time.
pub fn block(k: u32) -> Range<u32> {
    match k {
        0 => 0..1,
        1 => 1..LENGTH,
        _ => LENGTH * (k - 1)..LENGTH * k,
    }
}

/// True for numbers of samples that are whole blocks.
pub fn is_whole(samples: u32) -> bool {
    samples == 1 || samples.is_multiple_of(LENGTH)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blocks_follow_each_other_without_gap() {
        let mut next = 0;
        for k in 0..100 {
            assert_eq!(block(k).start, next);
            assert!(block(k).all(|sample| is_whole(sample) == (sample == next)));
            next = block(k).end;
        }
        assert_eq!(next, 16 * 99);
    }
}
