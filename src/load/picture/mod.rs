//! Picture files become linear colours: .exr, .hdr and .pfm as they are, .png and .jpg from sRGB.
//!
//! The format is told from the first bytes, not from the name. Sizes are checked before anything is decoded.

mod exr;
mod pfm;
#[cfg(test)]
mod tests;

use super::open::open_regular;
use crate::error::{Error, Result};
use crate::film::Image;
use crate::math::srgb::srgb_to_linear;
use ::image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::io::{Cursor, Read};
use std::path::Path;

/// More pixels than this are refused: 3 GiB as linear colours, about a 22k × 11k panorama.
pub const MOST_PIXELS: u64 = 1 << 28;

/// A file of more bytes than the most pixels can need, four bytes for each of four channels, is refused.
const MOST_BYTES: u64 = 16 * MOST_PIXELS;

/// What a file's values mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Linear floats without an upper end.
    Linear,
    /// sRGB codes of 8 or 16 bits, made for a display.
    Display,
}

/// A picture that was read.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// Linear colours in `R`, `G`, `B` only; alpha and other layers are left out. An EXR's windows give the offset
    /// and full size (a data window outside the display window: no offset).
    pub image: Image,
    /// What the file's values meant.
    pub encoding: Encoding,
}

/// Reads the picture `path`.
///
/// # Errors
/// The system's reason; an unknown format; a damaged file; more than [`MOST_PIXELS`] pixels.
pub fn read(path: &Path) -> Result<Picture> {
    let (file, length) = open_regular(path)?;
    if length > MOST_BYTES {
        return Err(Error::new(format!("{length} bytes are too many for a picture")).at(path));
    }
    let mut bytes = Vec::new();
    file.take(MOST_BYTES).read_to_end(&mut bytes).map_err(|e| Error::io("read", path, &e))?;
    decode(&bytes).map_err(|e| e.at(path))
}

/// Decodes a picture file's bytes.
///
/// # Errors
/// As [`read`], without the file's name.
pub fn decode(bytes: &[u8]) -> Result<Picture> {
    const SIGNATURES: [(&[u8], Decoder); 6] = [
        (b"\x76\x2f\x31\x01", exr::decode),
        (b"\x89PNG\r\n\x1a\n", |bytes| coded(bytes, ImageFormat::Png)),
        (b"\xff\xd8\xff", |bytes| coded(bytes, ImageFormat::Jpeg)),
        (b"#?", |bytes| coded(bytes, ImageFormat::Hdr)),
        (b"PF", pfm::decode),
        (b"Pf", pfm::decode),
    ];
    match SIGNATURES.iter().find(|(signature, _)| bytes.starts_with(signature)) {
        Some((_, decoder)) => decoder(bytes),
        None if bytes.is_empty() => Err(Error::new("the file is empty")),
        None => {
            Err(Error::new("not a picture that can be read").advise("known: .exr, .png, .jpg, .hdr, .pfm"))
        }
    }
}

type Decoder = fn(&[u8]) -> Result<Picture>;

/// Refuses a picture without pixels or with too many.
fn check_size(width: u64, height: u64) -> Result<(u32, u32)> {
    match (u32::try_from(width), u32::try_from(height)) {
        (Ok(w), Ok(h)) if w > 0 && h > 0 && width * height <= MOST_PIXELS => Ok((w, h)),
        _ => Err(Error::new(format!("a picture of {width}x{height} pixels cannot be read"))
            .advise(format!("it must have 1 to {MOST_PIXELS} pixels"))),
    }
}

/// PNG, JPEG and Radiance files.
fn coded(bytes: &[u8], format: ImageFormat) -> Result<Picture> {
    let damaged = |e: ::image::ImageError| Error::new(format!("cannot decode the picture: {e}"));
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    let mut limits = Limits::default();
    limits.max_alloc = Some(MOST_BYTES);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    let (width, height) = check_size(width.into(), height.into())?;
    let decoded = DynamicImage::from_decoder(decoder).map_err(damaged)?;

    let (encoding, pixels): (_, Vec<[f32; 3]>) = match (&decoded, format) {
        (_, ImageFormat::Hdr) => (Encoding::Linear, decoded.into_rgb32f().pixels().map(|p| p.0).collect()),
        (DynamicImage::ImageLuma8(_) | DynamicImage::ImageLumaA8(_), _)
        | (DynamicImage::ImageRgb8(_) | DynamicImage::ImageRgba8(_), _) => {
            let linear: Vec<f32> = (0..=255).map(|c| srgb_to_linear(f64::from(c) / 255.0) as f32).collect();
            let value = |c: u8| linear.get(usize::from(c)).copied().unwrap_or(1.0);
            (Encoding::Display, decoded.into_rgb8().pixels().map(|p| p.0.map(value)).collect())
        }
        _ => {
            let value = |c: u16| srgb_to_linear(f64::from(c) / 65535.0) as f32;
            (Encoding::Display, decoded.into_rgb16().pixels().map(|p| p.0.map(value)).collect())
        }
    };
    Ok(Picture { image: Image::from_rgb(width, height, &pixels, String::new()), encoding })
}
