//! Portable float map: `PF` (colour) or `Pf` (grey), width, height, scale; rows from the bottom. The scale's sign is
//! the byte order, negative for little endian; its size has no agreed meaning and is ignored, as most readers do.

use super::{Encoding, Picture, check_size};
use crate::error::{Error, Result};
use crate::film::Image;

pub(super) fn decode(bytes: &[u8]) -> Result<Picture> {
    let damaged =
        || Error::new("the PFM header is damaged").advise("it must be: PF or Pf, width, height, scale");
    let mut rest = bytes;
    let mut word = || next_word(&mut rest).ok_or_else(damaged);
    let channels = match word()? {
        "PF" => 3,
        "Pf" => 1,
        _ => return Err(damaged()),
    };
    let width = word()?.parse().map_err(|_| damaged())?;
    let height = word()?.parse().map_err(|_| damaged())?;
    let scale: f64 = word()?.parse().map_err(|_| damaged())?;
    let (width, height) = check_size(width, height)?;

    let samples = width as usize * height as usize * channels;
    if rest.len() < 4 * samples {
        return Err(Error::new(format!(
            "the file ends early: {} of {} bytes of pixels",
            rest.len(),
            4 * samples
        )));
    }
    let (words, _) = rest.as_chunks::<4>();
    let value = |b: &[u8; 4]| if scale < 0.0 { f32::from_le_bytes(*b) } else { f32::from_be_bytes(*b) };
    let values: Vec<f32> = words.iter().take(samples).map(value).collect();
    let rows = values.chunks_exact(width as usize * channels).rev();
    let pixels: Vec<[f32; 3]> = rows.flat_map(|row| row.chunks_exact(channels)).map(colour).collect();
    Ok(Picture { image: Image::from_rgb(width, height, &pixels, String::new()), encoding: Encoding::Linear })
}

fn colour(samples: &[f32]) -> [f32; 3] {
    match *samples {
        [r, g, b] => [r, g, b],
        [grey, ..] => [grey; 3],
        [] => [0.0; 3],
    }
}

/// The next word, and the rest after the single white space that ends it.
fn next_word<'a>(rest: &mut &'a [u8]) -> Option<&'a str> {
    let trimmed = rest.trim_ascii_start();
    let end = trimmed.iter().position(u8::is_ascii_whitespace)?;
    let (word, after) = trimmed.split_at_checked(end)?;
    *rest = after.get(1..)?;
    std::str::from_utf8(word).ok()
}
