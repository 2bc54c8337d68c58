//! Convolution along rows and columns; beyond the border the border's pixel goes on.

use rayon::prelude::*;

/// exp(−sharpness·k²) for k = −radius … radius.
pub(super) fn gaussian_kernel(radius: usize, sharpness: f64) -> Vec<f64> {
    (0..=2 * radius)
        .map(|k| {
            let offset = k as f64 - radius as f64;
            libm::exp(-sharpness * offset * offset)
        })
        .collect()
}

/// Along which way a kernel lies.
pub(super) trait Direction {
    /// The index of the pixel `shift` from `(x, y)`, kept inside the picture.
    fn neighbour(x: usize, y: usize, shift: isize, width: usize, height: usize) -> usize;
}

/// Along a row.
pub(super) struct Horizontal;
/// Along a column.
pub(super) struct Vertical;

impl Direction for Horizontal {
    fn neighbour(x: usize, y: usize, shift: isize, width: usize, _height: usize) -> usize {
        y * width + x.saturating_add_signed(shift).min(width - 1)
    }
}

impl Direction for Vertical {
    fn neighbour(x: usize, y: usize, shift: isize, width: usize, height: usize) -> usize {
        y.saturating_add_signed(shift).min(height - 1) * width + x
    }
}

/// Applies a kernel of 2·radius + 1 weights; `multiply_add(sum, value, weights)` is one term.
/// Rows are independent, so the result does not depend on the threads.
pub(super) fn convolve<D: Direction, In: Sync, Weights: Sync, Out: Default + Send + Copy>(
    pixels: &[In],
    width: usize,
    kernel: &[Weights],
    multiply_add: impl Fn(Out, &In, &Weights) -> Out + Sync,
) -> Vec<Out> {
    let height = pixels.len() / width;
    let radius = (kernel.len() / 2) as isize;
    let mut out = vec![Out::default(); pixels.len()];
    out.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
        for (x, value) in row.iter_mut().enumerate() {
            let mut sum = Out::default();
            for (weights, shift) in kernel.iter().zip(-radius..) {
                sum = multiply_add(sum, &pixels[D::neighbour(x, y, shift, width, height)], weights);
            }
            *value = sum;
        }
    });
    out
}
