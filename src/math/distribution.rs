//! Choosing one of many with given probabilities.

use rayon::prelude::*;

/// An alias table (Walker 1977; built as in Vose 1991).
#[derive(Clone, Debug, Default)]
pub struct AliasTable {
    /// (threshold of keeping the cell's own index as a share of 2³², the other index).
    cells: Vec<(u32, u32)>,
}

impl AliasTable {
    /// A table over `weights`: non-negative and finite, fewer than 2³². All zero (or none) gives an empty
    /// table, which [`AliasTable::sample`] answers with `None`.
    pub fn new(weights: &[f64]) -> AliasTable {
        let total: f64 = weights.iter().sum();
        if total <= 0.0 || !total.is_finite() {
            return AliasTable::default();
        }
        let n = weights.len();
        let mut share: Vec<f64> = weights.iter().map(|w| w / total * n as f64).collect();
        let mut cells: Vec<(u32, u32)> = (0..n as u32).map(|i| (u32::MAX, i)).collect();
        let (mut small, mut large): (Vec<usize>, Vec<usize>) = (0..n).partition(|&i| share[i] < 1.0);
        while let (Some(&s), Some(&l)) = (small.last(), large.last()) {
            small.pop();
            cells[s] = ((share[s] * 4_294_967_296.0) as u32, l as u32);
            share[l] -= 1.0 - share[s];
            if share[l] < 1.0 {
                large.pop();
                small.push(l);
            }
        }
        // A cell left over by rounding keeps itself, unless its weight is zero: that must never be chosen.
        if let Some(heaviest) = (0..n).max_by(|&a, &b| weights[a].total_cmp(&weights[b])) {
            for i in small.into_iter().filter(|&i| weights[i] == 0.0) {
                cells[i] = (0, heaviest as u32);
            }
        }
        AliasTable { cells }
    }

    /// The index that 32 uniform bits choose.
    #[inline(always)]
    pub fn sample(&self, bits: u32) -> Option<usize> {
        let n = self.cells.len() as u64;
        if n <= 1 {
            return (n == 1).then_some(0);
        }
        // With n cells only 2³²/n values of the fraction occur; the hash fills the digits below.
        let fine = u64::from(bits) * n + u64::from(bits.wrapping_mul(0x9e37_79b9)) * n / (1 << 32);
        let (cell, fraction) = ((fine >> 32) as usize, fine as u32);
        let (threshold, other) = *self.cells.get(cell)?;
        Some(if fraction < threshold { cell } else { other as usize })
    }

    /// True when there is nothing to choose.
    pub fn is_empty(&self) -> bool {
        self.cells.is_empty()
    }
}

/// A choice among the cells of a grid by two numbers, which keeps what is even about them: the first chooses a row, the
/// second a cell of it, both by inversion, so that stratified numbers give stratified cells (an alias table would tear
/// neighbours apart).
#[derive(Clone, Debug, PartialEq)]
pub struct GridTable {
    width: usize,
    /// Ends of the rows' shares of [0, 1].
    rows: Vec<f32>,
    /// By row: ends of the cells' shares of [0, 1].
    cells: Vec<f32>,
    /// Sum of all weights.
    pub total: f64,
}

impl GridTable {
    /// A table over `weights`, row by row, non-negative and finite; `None` when all are zero or there are none.
    pub fn new(width: usize, weights: &[f32]) -> Option<GridTable> {
        let mut cells = vec![0.0; weights.len()];
        let sums: Vec<f64> = cells
            .par_chunks_mut(width.max(1))
            .zip(weights.par_chunks(width.max(1)))
            .map(|(cells, weights)| accumulate(weights.iter().map(|w| f64::from(*w)), cells))
            .collect();
        let mut rows = vec![0.0; sums.len()];
        let total = accumulate(sums.iter().copied(), &mut rows);
        (total > 0.0 && total.is_finite()).then_some(GridTable { width, rows, cells, total })
    }

    /// The column and row that `u` in [0, 1)² chooses, and what is left of both numbers, again in [0, 1).
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> ([usize; 2], [f32; 2]) {
        let (y, v) = invert(&self.rows, u[1]);
        let (x, u) = invert(&self.cells[y * self.width..(y + 1) * self.width], u[0]);
        ([x, y], [u, v])
    }
}

/// Writes the running sums of `weights` over their sum, which it returns; nothing but zeros where that is zero.
fn accumulate(weights: impl Iterator<Item = f64> + Clone, ends: &mut [f32]) -> f64 {
    let total: f64 = weights.clone().sum();
    let mut sum = 0.0;
    for (end, weight) in ends.iter_mut().zip(weights) {
        sum += weight;
        *end = if total > 0.0 { (sum / total) as f32 } else { 0.0 };
    }
    total
}

/// The first part that ends above `u`, and how far `u` has come in it. A part of weight zero ends where it begins, so it
/// is never the one.
#[inline]
fn invert(ends: &[f32], u: f32) -> (usize, f32) {
    let i = ends.partition_point(|end| *end <= u).min(ends.len() - 1);
    let start = if i > 0 { ends[i - 1] } else { 0.0 };
    let share = (u - start) / (ends[i] - start);
    (i, if share < 1.0 { share.max(0.0) } else { 1.0 - 0.5 * f32::EPSILON })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frequencies_follow_the_weights() {
        let weights = [1.0, 0.0, 3.0, 0.5, 10.0, 0.0, 0.25];
        let table = AliasTable::new(&weights);
        let total: f64 = weights.iter().sum();
        let mut counts = [0u32; 7];
        let n = 1 << 20;
        for i in 0..n {
            counts[table.sample((i as u32) << 12).unwrap()] += 1;
        }
        for (count, weight) in counts.iter().zip(weights) {
            let expected = weight / total * f64::from(n);
            assert!((f64::from(*count) - expected).abs() <= 2.0 + 1e-4 * expected, "{counts:?}");
        }
    }

    #[test]
    fn nothing_to_choose_is_said() {
        assert_eq!(AliasTable::new(&[]).sample(7), None);
        assert_eq!(AliasTable::new(&[0.0, 0.0]).sample(7), None);
        assert_eq!(AliasTable::new(&[0.0, 2.0]).sample(0), Some(1));
        assert_eq!(AliasTable::new(&[0.0, 2.0]).sample(u32::MAX), Some(1));
        assert_eq!(AliasTable::new(&[5.0]).sample(u32::MAX), Some(0));
    }

    #[test]
    fn many_cells_are_chosen_evenly() {
        let n = 1usize << 20;
        let weights: Vec<f64> = (0..n).map(|i| if i % 2 == 0 { 1.0 } else { 3.0 }).collect();
        let table = AliasTable::new(&weights);
        let odd =
            (0..1u32 << 20).filter(|i| table.sample(i.wrapping_mul(0x9e37_79b1)).unwrap() % 2 == 1).count();
        assert!((odd as f64 / f64::from(1u32 << 20) - 0.75).abs() < 2e-3);
    }

    #[test]
    fn cells_of_a_grid_follow_their_weights() {
        let weights = [0.0, 2.0, 1.0, 0.0, 0.0, 0.0, 4.0, 0.5, 0.5];
        let table = GridTable::new(3, &weights).unwrap();
        assert_eq!(table.total, 8.0);
        let n = 512;
        let mut counts = [0; 9];
        for i in 0..n * n {
            let u = [(i % n) as f32, (i / n) as f32].map(|x| (x + 0.5) / n as f32);
            let ([x, y], rest) = table.sample(u);
            assert!(rest.iter().all(|r| (0.0..1.0).contains(r)));
            counts[y * 3 + x] += 1;
        }
        for (count, weight) in counts.iter().zip(weights) {
            let expected = f64::from(weight) / 8.0 * f64::from(n * n);
            assert!((f64::from(*count) - expected).abs() < 1e-2 * expected + 0.1, "{counts:?}");
        }
        assert_eq!(table.sample([0.0, 0.0]).0, [1, 0]);
        assert_eq!(table.sample([0.999_999_94; 2]).0, [2, 2]);
        assert!(GridTable::new(2, &[0.0; 4]).is_none() && GridTable::new(0, &[]).is_none());
    }
}
