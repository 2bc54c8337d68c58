//! Triangles that would only do harm: those without area, and copies of others.
//!
//! Thousands of coincident triangles ruin any acceleration structure, and exporters write them. Two are
//! copies when their corners are at the same places in the same winding (whichever comes first) and have
//! the same material; the first in the file stays.
//!
//! Hashes of all triangles go through a Bloom filter (Bloom 1970; blocked as in Putze, Sanders, Singler
//! 2007), which leaves the few per cent that may have a copy; only those are sorted and compared.

use super::memory::{OutOfMemory, grow, push};
use super::recenter::Bounds;
use crate::math::DVec3;
use crate::memory::reserve;
use crate::shape::FaceMaterials;
use rayon::prelude::*;

/// Triangles in a unit of parallel work.
const CHUNK: usize = 1 << 16;

/// What one look at every triangle shows.
pub(super) struct Survey {
    /// Of the corners of all triangles.
    pub bounds: Bounds,
    /// Triangles without area, ascending.
    pub without_area: Vec<u32>,
    /// A hash of the corners' places, whatever their order.
    pub hashes: Vec<u32>,
}

/// Looks at every triangle once.
pub(super) fn survey(triangles: &[[u32; 3]], positions: &[[f32; 3]]) -> Result<Survey, OutOfMemory> {
    let mut hashes = Vec::new();
    grow(&mut hashes, triangles.len())?;
    hashes.resize(triangles.len(), 0);
    let parts: Result<Vec<_>, OutOfMemory> = (triangles.par_chunks(CHUNK).zip(hashes.par_chunks_mut(CHUNK)))
        .enumerate()
        .map(|(chunk, (triangles, hashes))| survey_chunk(chunk * CHUNK, triangles, hashes, positions))
        .collect();
    let mut survey = Survey { bounds: Bounds::EMPTY, without_area: Vec::new(), hashes };
    for (bounds, without_area) in parts? {
        survey.bounds = survey.bounds.union(bounds);
        super::memory::extend(&mut survey.without_area, &without_area)?;
    }
    Ok(survey)
}

fn survey_chunk(
    first: usize,
    triangles: &[[u32; 3]],
    hashes: &mut [u32],
    positions: &[[f32; 3]],
) -> Result<(Bounds, Vec<u32>), OutOfMemory> {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    let mut without_area = Vec::new();
    for (i, (&triangle, hash)) in triangles.iter().zip(hashes).enumerate() {
        let [a, b, c] = corners(triangle, positions);
        for p in [a, b, c] {
            for axis in 0..3 {
                low[axis] = low[axis].min(p[axis]);
                high[axis] = high[axis].max(p[axis]);
            }
        }
        // Rotated and mirrored triangles share the sum; comparing tells them apart.
        let sum = hash_point(a).wrapping_add(hash_point(b)).wrapping_add(hash_point(c));
        *hash = (spread(sum) >> 32) as u32;
        let [a, b, c] = [a, b, c].map(|p| DVec3::from_array(p.map(f64::from)));
        if (b - a).cross(c - a) == DVec3::ZERO {
            push(&mut without_area, (first + i) as u32)?;
        }
    }
    let bounds = if triangles.is_empty() {
        Bounds::EMPTY
    } else {
        let f64s = |x: [f32; 3]| DVec3::from_array(x.map(f64::from));
        Bounds { low: f64s(low), high: f64s(high) }
    };
    Ok((bounds, without_area))
}

fn corners(triangle: [u32; 3], positions: &[[f32; 3]]) -> [[f32; 3]; 3] {
    triangle.map(|i| positions.get(i as usize).copied().unwrap_or_default())
}

#[inline]
fn hash_point(p: [f32; 3]) -> u64 {
    // Adding zero makes −0 the 0 it equals. Odd multipliers: fractions of √2, √3, √5.
    let [x, y, z] = p.map(|c| u64::from((c + 0.0).to_bits()));
    let h = x.wrapping_mul(0x6a09_e667_f3bc_c909)
        ^ y.wrapping_mul(0xbb67_ae85_84ca_a73b).rotate_left(21)
        ^ z.wrapping_mul(0x3c6e_f372_fe94_f82b).rotate_left(42);
    spread(h)
}

#[inline]
fn spread(h: u64) -> u64 {
    let h = (h ^ (h >> 32)).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    h ^ (h >> 29)
}

/// Triangles that repeat an earlier one, ascending.
pub(super) fn duplicates(
    hashes: &[u32],
    triangles: &[[u32; 3]],
    positions: &[[f32; 3]],
    materials: &FaceMaterials,
) -> Result<Vec<u32>, OutOfMemory> {
    let mut seen = BloomFilter::new(hashes.len())?;
    let mut repeated = Vec::new();
    for &hash in hashes {
        if seen.insert(hash) {
            push(&mut repeated, hash)?;
        }
    }
    let mut wanted = BloomFilter::new(repeated.len())?;
    for &hash in &repeated {
        wanted.insert(hash);
    }
    drop((seen, repeated));
    let mut candidates: Vec<u64> = Vec::new();
    for (triangle, &hash) in hashes.iter().enumerate() {
        if wanted.contains(hash) {
            push(&mut candidates, u64::from(hash) << 32 | triangle as u64)?;
        }
    }
    candidates.sort_unstable();

    let same = |a: u32, b: u32| {
        let of = |t: u32| triangles.get(t as usize).map(|t| corners(*t, positions)).unwrap_or_default();
        let ([a0, a1, a2], b_corners) = (of(a), of(b));
        materials.get(a as usize) == materials.get(b as usize)
            && [[a0, a1, a2], [a1, a2, a0], [a2, a0, a1]].contains(&b_corners)
    };
    let mut copies = Vec::new();
    for group in candidates.chunk_by(|a, b| a >> 32 == b >> 32) {
        // Different triangles of one hash: both windings, a few materials. More than that would be hostile.
        const DIFFERENT: usize = 16;
        let mut originals = [0; DIFFERENT];
        let mut count = 0;
        for &candidate in group {
            let triangle = candidate as u32;
            if originals.iter().take(count).any(|&original| same(original, triangle)) {
                push(&mut copies, triangle)?;
            } else if let Some(free) = originals.get_mut(count) {
                *free = triangle;
                count += 1;
            }
        }
    }
    copies.sort_unstable();
    Ok(copies)
}

/// A set of hashes that may claim to hold one that it does not (about 2 %), never the reverse.
struct BloomFilter {
    /// Three bits a hash, all in one word: one cache miss.
    words: Vec<u64>,
}

impl BloomFilter {
    fn new(elements: usize) -> Result<Self, OutOfMemory> {
        let count = (elements / 8).max(1).next_power_of_two();
        let mut words = Vec::new();
        reserve(&mut words, count)?;
        words.resize(count, 0);
        Ok(BloomFilter { words })
    }

    #[inline]
    fn place(&self, hash: u32) -> (usize, u64) {
        let h = u64::from(hash).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        let bits = 1 << (h >> 58) | 1 << (h >> 52 & 63) | 1 << (h >> 46 & 63);
        ((h >> 8) as usize & (self.words.len() - 1), bits)
    }

    /// Adds it; whether it seemed to be there before.
    #[inline]
    fn insert(&mut self, hash: u32) -> bool {
        let (word, bits) = self.place(hash);
        let Some(word) = self.words.get_mut(word) else { return true };
        let found = *word & bits == bits;
        *word |= bits;
        found
    }

    #[inline]
    fn contains(&self, hash: u32) -> bool {
        let (word, bits) = self.place(hash);
        self.words.get(word).is_none_or(|word| word & bits == bits)
    }
}

/// Removes the elements of those ascending indices.
pub(super) fn remove<T: Copy>(list: &mut Vec<T>, removed: &[u32]) {
    let Some(&first) = removed.first() else { return };
    let mut skip = removed.iter().map(|&r| r as usize).peekable();
    let mut write = first as usize;
    for read in first as usize..list.len() {
        if skip.next_if_eq(&read).is_none() {
            if let Some(&kept) = list.get(read)
                && let Some(place) = list.get_mut(write)
            {
                *place = kept;
            }
            write += 1;
        }
    }
    list.truncate(write);
}
