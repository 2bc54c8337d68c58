//! Owen-scrambled Sobol points (Sobol 1967, Owen 1995).
//!
//! Each pixel scrambles the same points in its own way. A nested uniform scramble flips a digit depending on
//! all higher ones; on bit-reversed numbers that is what carries of additions and multiplications do, so a
//! few of them make the whole tree of flips (Laine and Karras 2011). Points are therefore stored
//! bit-reversed: a dimension costs two loads, the scramble and one bit reversal.
//!
//! Dimensions beyond the table are padded: pairs of the first two dimensions, each with the sample indices
//! shuffled by a scramble of its own (Burley 2020).

use super::sobol_table::JOE_KUO;
use super::{Key, Keys, dimension_seed, hash};
use std::sync::OnceLock;

/// Dimensions with direction numbers of their own.
const DIMENSIONS: usize = 64;

/// The generator matrices, and tables of the points' low and middle index digits.
#[derive(Debug)]
pub(super) struct Sobol {
    /// Bit-reversed direction numbers: `columns[dimension][k]` belongs to bit k of the index.
    columns: Vec<[u32; 32]>,
    /// The points of indices 0 … 15 and 0, 16, … 240, whose sum (xor) is any point below 256.
    low: Vec<[[u32; 16]; 2]>,
}

impl Sobol {
    /// The tables, made at first use.
    pub(super) fn get() -> &'static Sobol {
        static TABLES: OnceLock<Sobol> = OnceLock::new();
        TABLES.get_or_init(|| {
            let columns: Vec<[u32; 32]> = (0..DIMENSIONS).map(direction_numbers).collect();
            let sum =
                |c: &[u32; 32], i: u32| (0..32).filter(|k| i >> k & 1 == 1).fold(0, |x, k| x ^ c[k as usize]);
            let table = |c: &[u32; 32]| {
                [std::array::from_fn(|i| sum(c, i as u32)), std::array::from_fn(|i| sum(c, 16 * i as u32))]
            };
            let low = columns.iter().map(table).collect();
            Sobol { columns, low }
        })
    }

    /// The point's coordinate, bit-reversed.
    #[inline(always)]
    fn point(&self, index: u32, dimension: usize) -> u32 {
        let [low, middle] = &self.low[dimension];
        low[(index & 15) as usize] ^ middle[(index >> 4 & 15) as usize] ^ self.high(index >> 8, dimension)
    }

    /// What the index digits beyond the tables, `rest`, add.
    #[inline(always)]
    fn high(&self, mut rest: u32, dimension: usize) -> u32 {
        let mut x = 0;
        while rest != 0 {
            x ^= self.columns[dimension][(rest.trailing_zeros() + 8) as usize];
            rest &= rest - 1;
        }
        x
    }

    #[inline(always)]
    pub(super) fn bits(&self, key: Key, dimension: u32) -> u32 {
        let seed = dimension_seed(key.pixel, dimension);
        if (dimension as usize) < DIMENSIONS {
            scramble(self.point(key.index, dimension as usize), seed).reverse_bits()
        } else {
            // Bit-reversed, van der Corput's point is the index itself.
            scramble(shuffle(key.index, seed), hash(seed)).reverse_bits()
        }
    }

    #[inline(always)]
    pub(super) fn bits2(&self, key: Key, dimension: u32) -> [u32; 2] {
        if (dimension as usize) + 1 < DIMENSIONS {
            [self.bits(key, dimension), self.bits(key, dimension + 1)]
        } else {
            self.padded2(key, dimension)
        }
    }

    /// [`Sobol::bits`] of several samples. Those of a wave are of one block, whose indices differ in their low digits.
    #[inline(always)]
    pub(super) fn bits_of<const N: usize>(&self, keys: &Keys<N>, dimension: u32) -> [u32; N] {
        let mut bits = [0; N];
        if dimension as usize >= DIMENSIONS {
            for (lane, bits) in bits.iter_mut().enumerate() {
                let seed = dimension_seed(keys.pixel[lane], dimension);
                *bits = scramble(shuffle(keys.index[lane], seed), hash(seed)).reverse_bits();
            }
            return bits;
        }
        let block = keys.index[0] >> 8;
        if keys.index.iter().any(|index| index >> 8 != block) {
            return std::array::from_fn(|lane| self.bits(keys.get(lane), dimension));
        }
        let high = self.high(block, dimension as usize);
        let [low, middle] = &self.low[dimension as usize];
        for (lane, bits) in bits.iter_mut().enumerate() {
            let index = keys.index[lane];
            let point = low[(index & 15) as usize] ^ middle[(index >> 4 & 15) as usize] ^ high;
            *bits = scramble(point, dimension_seed(keys.pixel[lane], dimension)).reverse_bits();
        }
        bits
    }

    /// [`Sobol::bits2`] of several samples.
    #[inline(always)]
    pub(super) fn bits2_of<const N: usize>(&self, keys: &Keys<N>, dimension: u32) -> [[u32; N]; 2] {
        if (dimension as usize) + 1 < DIMENSIONS {
            return [self.bits_of(keys, dimension), self.bits_of(keys, dimension + 1)];
        }
        let pairs: [[u32; 2]; N] = std::array::from_fn(|lane| self.padded2(keys.get(lane), dimension));
        [pairs.map(|pair| pair[0]), pairs.map(|pair| pair[1])]
    }

    #[inline(never)]
    fn padded2(&self, key: Key, dimension: u32) -> [u32; 2] {
        let seed = dimension_seed(key.pixel, dimension);
        let index = shuffle(key.index, seed);
        let (a, b) = (hash(seed), hash(seed ^ 0x517c_c1b7));
        [scramble(index, a).reverse_bits(), scramble(self.point(index, 1), b).reverse_bits()]
    }
}

/// A nested uniform scramble of a bit-reversed number: every step changes a bit only by lower ones (which
/// stand for the higher digits). Constants after Vegdahl 2021, who searched for low bias.
#[inline(always)]
fn scramble(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul(seed >> 16 | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// Shuffles indices within every aligned block of a power of two: again a scramble, of the index read as a
/// fraction, so that each block stays a good set.
#[inline(always)]
fn shuffle(index: u32, seed: u32) -> u32 {
    scramble(index.reverse_bits(), seed).reverse_bits()
}

/// The 32 direction numbers of a dimension by the recurrence of its primitive polynomial, bit-reversed.
fn direction_numbers(dimension: usize) -> [u32; 32] {
    if dimension == 0 {
        return std::array::from_fn(|k| 1 << k);
    }
    let (polynomial, initial) = JOE_KUO[dimension - 1];
    let degree = initial.len();
    let mut m = [0u32; 32];
    m[..degree].copy_from_slice(initial);
    for k in degree..32 {
        // m_k = 2a_1·m_{k−1} ⊕ 2²a_2·m_{k−2} ⊕ … ⊕ 2^s·m_{k−s} ⊕ m_{k−s}
        m[k] = m[k - degree] ^ (m[k - degree] << degree);
        for j in 1..degree {
            if polynomial >> (degree - j) & 1 == 1 {
                m[k] ^= m[k - j] << j;
            }
        }
    }
    // v_k = m_k/2^(k+1) as a fraction of 2³² is m_k << (31 − k).
    std::array::from_fn(|k| (m[k] << (31 - k)).reverse_bits())
}
