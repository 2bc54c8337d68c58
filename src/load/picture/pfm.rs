//! Portable float map: `PF` (colour) or `Pf` (grey), width, height, scale; rows from the bottom. The scale's sign is
//! the byte order, negative for little endian; its size has no agreed meaning and is ignored, as most readers do.

use super::{Encoding, Memory, Picture, check_room, check_size};
use crate::error::{Error, Result};
use crate::film::Image;
use crate::texture::{Data, Texels};

/// What stands before the samples.
pub(super) struct Header<'b> {
    /// Width and height, as they are stated.
    pub size: [u64; 2],
    /// 3 or 1.
    pub channels: usize,
    little: bool,
    samples: &'b [u8],
}

pub(super) fn header(bytes: &[u8]) -> Result<Header<'_>> {
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
    Ok(Header { size: [width, height], channels, little: scale < 0.0, samples: rest })
}

/// Size, channels and samples, row by row from the top.
fn samples(bytes: &[u8]) -> Result<([u32; 2], usize, Vec<f32>)> {
    let Header { size: [width, height], channels, little, samples } = header(bytes)?;
    let (width, height) = check_size(width, height)?;
    let count = width as usize * height as usize * channels;
    if samples.len() < 4 * count {
        return Err(Error::new(format!(
            "the file ends early: {} of {} bytes of pixels",
            samples.len(),
            4 * count
        )));
    }
    let (words, _) = samples.as_chunks::<4>();
    let value = |b: &[u8; 4]| if little { f32::from_le_bytes(*b) } else { f32::from_be_bytes(*b) };
    let row_bytes = width as usize * channels;
    let rows = words.get(..count).unwrap_or_default().chunks_exact(row_bytes).rev();
    Ok(([width, height], channels, rows.flatten().map(value).collect()))
}

pub(super) fn decode(bytes: &[u8], memory: Memory) -> Result<Picture> {
    let [width, height] = header(bytes)?.size;
    let (width, height) = check_size(width, height)?;
    check_room(width, height, memory)?;
    let ([width, height], channels, values) = samples(bytes)?;
    let pixels: Vec<[f32; 3]> = values.chunks_exact(channels).map(colour).collect();
    Ok(Picture { image: Image::from_rgb(width, height, &pixels, String::new()), encoding: Encoding::Linear })
}

/// The texels of a texture.
pub(super) fn texels(bytes: &[u8]) -> Result<Texels> {
    let ([width, height], channels, values) = samples(bytes)?;
    Texels::new(width, height, channels, Data::F32(values))
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
