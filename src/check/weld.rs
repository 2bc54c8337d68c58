//! Vertices at the same place. Exporters repeat a vertex along seams and between parts, so that faces meet in
//! space but not by index.

use super::out_of_memory;
use crate::error::Result;
use rayon::prelude::*;

/// Which vertices are used, and which of them are at the same place.
pub(super) struct Weld {
    /// By vertex: the first one that triangles use and that has exactly its position; itself where it is alone.
    /// Empty when all are alone.
    first: Vec<u32>,
    /// Vertices that no triangle uses.
    pub unreferenced: u64,
    /// Used vertices that repeat the position of an earlier one.
    pub coincident: u64,
}

impl Weld {
    /// Compares positions exactly; zeros of either sign are equal.
    ///
    /// # Errors
    /// Not enough memory.
    pub fn new(positions: &[[f32; 3]], triangles: &[[u32; 3]]) -> Result<Weld> {
        let mut used: Vec<u64> = Vec::new();
        used.try_reserve_exact(positions.len() / 64 + 1).map_err(|_| out_of_memory())?;
        used.resize(positions.len() / 64 + 1, 0);
        for &vertex in triangles.iter().flatten() {
            if let Some(word) = used.get_mut(vertex as usize / 64) {
                *word |= 1 << (vertex % 64);
            }
        }
        let count: usize = used.iter().map(|word| word.count_ones() as usize).sum();
        let is_used =
            |vertex: usize| used.get(vertex / 64).is_some_and(|word| word >> (vertex % 64) & 1 == 1);

        let mut places: Vec<([u32; 3], u32)> = Vec::new();
        places.try_reserve_exact(count).map_err(|_| out_of_memory())?;
        // Adding zero makes −0 the 0 it equals.
        let bits = |p: &[f32; 3]| p.map(|x| (x + 0.0).to_bits());
        places.extend(
            positions.iter().enumerate().filter(|(i, _)| is_used(*i)).map(|(i, p)| (bits(p), i as u32)),
        );
        places.par_sort_unstable();

        let alone = |group: &[([u32; 3], u32)]| group.len() as u64 - 1;
        let groups = || places.chunk_by(|a, b| a.0 == b.0);
        let coincident = groups().map(alone).sum();
        let mut first = Vec::new();
        if coincident > 0 {
            first.try_reserve_exact(positions.len()).map_err(|_| out_of_memory())?;
            first.extend(0..positions.len() as u32);
            for group in groups() {
                let Some((_, smallest)) = group.first() else { continue };
                for (_, vertex) in group {
                    if let Some(slot) = first.get_mut(*vertex as usize) {
                        *slot = *smallest;
                    }
                }
            }
        }
        Ok(Weld { first, unreferenced: (positions.len() - count) as u64, coincident })
    }

    /// The vertex that stands for `vertex`.
    #[inline]
    pub fn first(&self, vertex: u32) -> u32 {
        self.first.get(vertex as usize).copied().unwrap_or(vertex)
    }
}
