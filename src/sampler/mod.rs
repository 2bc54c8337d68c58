//! Where random-looking numbers come from: one file a kind.
//!
//! A number is a function of (seed, pixel, sample index, dimension) and nothing else, so the picture never
//! depends on threads, tiles or order. Integrators give each decision dimensions of its own and keep to
//! them whether or not an earlier one was used: skipping would correlate decisions silently.

mod halton;
mod random;
mod sobol;
mod sobol_table;
mod splits;
mod stratified;

pub use splits::{PREVIEW, Part, Splits};

use crate::error::{Result, lookup, name_in};

/// Where the numbers come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SamplerKind {
    /// Owen-scrambled Sobol points.
    Sobol,
    /// Owen-scrambled Halton points.
    Halton,
    /// Jittered strata, as many as there are samples in a pixel.
    Stratified,
    /// Independent random numbers.
    Random,
}

impl SamplerKind {
    /// Name, meaning, value.
    pub const TABLE: &'static [(&'static str, &'static str, SamplerKind)] = &[
        ("sobol", "Owen-scrambled Sobol points: the least noise", SamplerKind::Sobol),
        ("halton", "Owen-scrambled Halton points: for any number of samples, slower", SamplerKind::Halton),
        ("stratified", "jittered strata, one a sample of the pixel", SamplerKind::Stratified),
        ("random", "independent random numbers", SamplerKind::Random),
    ];

    /// The sampler of that name.
    pub fn from_name(word: &str) -> Result<Self> {
        lookup("sampler", word, Self::TABLE)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        name_in(&self, Self::TABLE)
    }
}

/// A sample of a pixel: what a path carries to draw its numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key {
    /// The pixel's number, scrambled with the seed.
    pub pixel: u32,
    /// The sample's index in the pixel, from 0.
    pub index: u32,
}

/// The keys of `N` samples.
#[derive(Clone, Copy, Debug)]
pub struct Keys<const N: usize> {
    /// See [`Key::pixel`].
    pub pixel: [u32; N],
    /// See [`Key::index`].
    pub index: [u32; N],
}

impl<const N: usize> Keys<N> {
    /// To be filled lane by lane.
    pub const ZERO: Keys<N> = Keys { pixel: [0; N], index: [0; N] };

    /// One lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> Key {
        Key { pixel: self.pixel[lane], index: self.index[lane] }
    }

    /// Sets one lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, key: Key) {
        (self.pixel[lane], self.index[lane]) = (key.pixel, key.index);
    }
}

/// Draws numbers.
#[derive(Clone, Debug)]
pub struct Sampler {
    /// Both halves of the seed, hashed.
    seed: u32,
    kind: Kind,
}

#[derive(Clone, Debug)]
enum Kind {
    Sobol(&'static sobol::Sobol),
    Halton(halton::Halton),
    Stratified(stratified::Stratified),
    Random(random::Random),
}

impl Sampler {
    /// A sampler for pictures with `spp` samples a pixel.
    pub fn new(kind: SamplerKind, seed: u64, spp: u32) -> Sampler {
        let kind = match kind {
            SamplerKind::Sobol => Kind::Sobol(sobol::Sobol::get()),
            SamplerKind::Halton => Kind::Halton(halton::Halton::new()),
            SamplerKind::Stratified => Kind::Stratified(stratified::Stratified::new(spp)),
            SamplerKind::Random => Kind::Random(random::Random::new(seed)),
        };
        let seed = hash(seed as u32) ^ hash((seed >> 32) as u32 ^ 0x5bd1_e995);
        Sampler { seed, kind }
    }

    /// The key of sample `index` in the pixel numbered `pixel` (row by row in the full picture). Pixels of
    /// one picture never share a key: the scrambling is a bijection.
    #[inline(always)]
    pub fn key(&self, pixel: u32, index: u32) -> Key {
        Key { pixel: hash(pixel ^ self.seed), index }
    }

    /// The key of node `branch` among the `nodes` into which every sample of a pixel has split. Nodes of one sample
    /// follow each other, so that they share well-distributed points among them.
    #[inline(always)]
    pub fn branch(&self, key: Key, nodes: u64, branch: u32) -> Key {
        self.node(key, (u64::from(key.index) * nodes).wrapping_add(u64::from(branch)))
    }

    /// The key of node `index` among all into which the samples of `key`'s pixel have split.
    #[inline(always)]
    pub fn node(&self, key: Key, index: u64) -> Key {
        // Beyond 2³² points a pixel goes on with those of another.
        Key { pixel: key.pixel ^ hash((index >> 32) as u32), index: index as u32 }
    }

    /// 32 uniform bits.
    #[inline(always)]
    pub fn bits(&self, key: Key, dimension: u32) -> u32 {
        match &self.kind {
            Kind::Sobol(s) => s.bits(key, dimension),
            Kind::Halton(s) => s.bits(key, dimension),
            Kind::Stratified(s) => s.bits(key, dimension),
            Kind::Random(r) => r.bits(key, dimension),
        }
    }

    /// A number in [0, 1).
    #[inline(always)]
    pub fn d1(&self, key: Key, dimension: u32) -> f32 {
        unit(self.bits(key, dimension))
    }

    /// A point in [0, 1)²; takes `dimension` and the one after.
    #[inline(always)]
    pub fn d2(&self, key: Key, dimension: u32) -> [f32; 2] {
        let [a, b] = match &self.kind {
            Kind::Sobol(s) => s.bits2(key, dimension),
            Kind::Halton(s) => s.bits2(key, dimension),
            Kind::Stratified(s) => s.bits2(key, dimension),
            Kind::Random(r) => r.bits2(key, dimension),
        };
        [unit(a), unit(b)]
    }
}

impl Sampler {
    /// [`Sampler::bits`] of several samples.
    #[inline(always)]
    pub fn bits_of<const N: usize>(&self, keys: &Keys<N>, dimension: u32) -> [u32; N] {
        match &self.kind {
            Kind::Sobol(s) => s.bits_of(keys, dimension),
            _ => std::array::from_fn(|lane| self.bits(keys.get(lane), dimension)),
        }
    }

    /// [`Sampler::d1`] of several samples.
    #[inline(always)]
    pub fn d1_of<const N: usize>(&self, keys: &Keys<N>, dimension: u32) -> [f32; N] {
        units(self.bits_of(keys, dimension))
    }

    /// [`Sampler::d2`] of several samples: the first numbers, and the second.
    #[inline(always)]
    pub fn d2_of<const N: usize>(&self, keys: &Keys<N>, dimension: u32) -> [[f32; N]; 2] {
        match &self.kind {
            Kind::Sobol(s) => {
                let [first, second] = s.bits2_of(keys, dimension);
                [units(first), units(second)]
            }
            _ => {
                let pairs: [[f32; 2]; N] = std::array::from_fn(|lane| self.d2(keys.get(lane), dimension));
                [pairs.map(|pair| pair[0]), pairs.map(|pair| pair[1])]
            }
        }
    }
}

#[inline(always)]
fn units<const N: usize>(bits: [u32; N]) -> [f32; N] {
    let mut all = [0.0; N];
    for lane in 0..N {
        all[lane] = unit(bits[lane]);
    }
    all
}

/// The upper 24 bits as a number in [0, 1).
#[inline(always)]
fn unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// Scatters numbers of branches, so that none follows from another by a simple pattern.
#[inline(always)]
pub fn scatter(branch: u32) -> u32 {
    hash(branch ^ 0x68e3_1da4)
}

/// A bijective hash of 32 bits: two rounds of multiply and xor-shift with low bias (constants as found by
/// Wellons' search, 2018).
#[inline(always)]
fn hash(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

/// The seed of one dimension of one pixel. The dimension is hashed first: seeds of near-by dimensions that
/// differ by a simple pattern leave pairs of scrambled numbers visibly dependent.
#[inline(always)]
fn dimension_seed(pixel: u32, dimension: u32) -> u32 {
    hash(pixel ^ hash(dimension))
}

#[cfg(test)]
mod tests;
