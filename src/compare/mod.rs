//! How far two pictures are apart: squared errors for statisticians, FLIP for eyes.

mod filters;
pub mod flip;
#[cfg(test)]
mod tests;

use crate::error::{Error, Result};
use crate::film::{Channel, Data, Image};
use flip::Kind;

/// The differences of a picture `a` from a reference `b`, over linear R, G and B.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Width in pixels.
    pub width: u32,
    /// Height in pixels.
    pub height: u32,
    /// Mean of (a − b)².
    pub mse: f64,
    /// Mean of (a − b)²/(b² + 0.01) (Rousselle et al. 2011): errors count relative to the brightness they are in.
    pub rel_mse: f64,
    /// 10 log₁₀(1/MSE) in dB: the peak is 1, whatever the picture holds. `None` where the pictures are the same.
    pub psnr: Option<f64>,
    /// Largest |a − b|.
    pub max: f64,
    /// Mean of |a − b|.
    pub mean: f64,
    /// Mean of the FLIP map: 0 for no visible difference, 1 for the greatest.
    pub flip: f64,
    /// Which FLIP was used.
    pub flip_kind: Kind,
    /// FLIP of every pixel, row by row from the top.
    pub flip_map: Vec<f32>,
}

/// Compares `a` with the reference `b`.
///
/// # Errors
/// Different sizes, missing colour channels, or a value that is not finite (the first is named).
pub fn compare(a: &Image, b: &Image, kind: Kind) -> Result<Comparison> {
    if (a.width, a.height) != (b.width, b.height) {
        return Err(Error::new(format!(
            "the pictures have different sizes: {}x{} and {}x{}",
            a.width, a.height, b.width, b.height
        )));
    }
    let (pixels_a, pixels_b) = (colours(a, "first")?, colours(b, "second")?);
    if pixels_a.is_empty() {
        return Err(Error::new("the pictures have no pixels"));
    }

    let (mut squares, mut relative, mut absolute, mut max) = (0.0, 0.0, 0.0, 0.0_f64);
    let samples = pixels_a.iter().flatten().zip(pixels_b.iter().flatten());
    for (&value, &reference) in samples {
        let (value, reference) = (f64::from(value), f64::from(reference));
        let difference = (value - reference).abs();
        squares += difference * difference;
        relative += relative_square(value, reference);
        absolute += difference;
        max = max.max(difference);
    }
    let count = 3.0 * pixels_a.len() as f64;
    let mse = squares / count;
    let flip_map = flip::map(&pixels_a, &pixels_b, a.width as usize, kind);
    Ok(Comparison {
        width: a.width,
        height: a.height,
        mse,
        rel_mse: relative / count,
        psnr: (mse > 0.0).then(|| 10.0 * libm::log10(1.0 / mse)),
        max,
        mean: absolute / count,
        flip: flip_map.iter().map(|&v| f64::from(v)).sum::<f64>() / flip_map.len() as f64,
        flip_kind: kind,
        flip_map,
    })
}

/// One value's part of relMSE: (a − b)²/(b² + 0.01) with the reference b.
pub fn relative_square(a: f64, b: f64) -> f64 {
    (a - b) * (a - b) / (b * b + 0.01)
}

/// |a − b| as `R`, `G`, `B`, with the FLIP map as the layer `flip.Y`; for two pictures that [`compare`] accepts.
pub fn difference(a: &Image, b: &Image, comparison: &Comparison) -> Image {
    let absolute = |(a, b): (&[f32; 3], &[f32; 3])| [0, 1, 2].map(|c| (a[c] - b[c]).abs());
    let pixels: Vec<[f32; 3]> = a.rgb_pixels().iter().zip(&b.rgb_pixels()).map(absolute).collect();
    let mut image = Image::from_rgb(a.width, a.height, &pixels, String::new());
    image.channels.push(Channel { name: "flip.Y".to_string(), data: Data::F32(comparison.flip_map.clone()) });
    image
}

/// The picture's colours, all there and finite.
fn colours(image: &Image, which: &str) -> Result<Vec<[f32; 3]>> {
    let count = image.width as usize * image.height as usize;
    for name in ["R", "G", "B"] {
        if image.f32_channel(name).is_none_or(|values| values.len() != count) {
            return Err(Error::new(format!("the {which} picture has no whole colour channel {name}")));
        }
    }
    let pixels = image.rgb_pixels();
    let wrong = |p: &[f32; 3]| p.iter().any(|v| !v.is_finite());
    if let Some(first) = pixels.iter().position(wrong) {
        let number = pixels.iter().filter(|p| wrong(p)).count();
        let (x, y) = (first % image.width as usize, first / image.width as usize);
        return Err(Error::new(format!(
            "the {which} picture has values that are not finite in {number} pixels, the first at ({x}, {y})"
        )));
    }
    Ok(pixels)
}
