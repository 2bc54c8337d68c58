//! Picture files become linear colours: .exr, .hdr and .pfm as they are, the others from sRGB; or the compact texels
//! of a texture, which leave open what codes mean (`texels`).
//!
//! The format is told from the first bytes, not from the name. Sizes are checked before anything is decoded.

mod exr;
mod pfm;
#[cfg(test)]
mod tests;
pub(crate) mod texels;

use super::open::Reach;
use crate::error::{Error, Result};
use crate::film::Image;
use crate::memory::{self, Left};
use crate::texture::Transfer;
use ::image::ImageFormat;
use std::io::Read;
use std::path::Path;

/// More pixels than this are refused: 3 GiB as linear colours, about a 22k × 11k panorama.
pub const MOST_PIXELS: u64 = 1 << 28;

/// A file of more bytes than the most pixels can need, four bytes for each of four channels, is refused.
const MOST_BYTES: u64 = 16 * MOST_PIXELS;

/// Bytes a pixel while a picture is decoded: its codes, and its linear colours as they come and by channel.
const PEAK: u64 = 4 + 12 + 12;

/// A picture that takes less is decoded without a look at the memory that is left, which would take longer.
const SMALL: u64 = 16 << 20;

/// Says how much memory is left.
pub type Memory = fn() -> Option<Left>;

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
/// The system's reason; an unknown format; a damaged file; more than [`MOST_PIXELS`] pixels, or than fit into memory.
pub fn read(path: &Path) -> Result<Picture> {
    read_within(&Reach::Anywhere, path)
}

/// As [`read`], of a file within `reach`.
///
/// # Errors
/// As [`read`]; the file is out of reach.
pub(crate) fn read_within(reach: &Reach, path: &Path) -> Result<Picture> {
    let (file, length) = reach.open(path)?;
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
    decode_in(memory::left, bytes)
}

/// As [`decode`], in what `memory` says is left.
///
/// # Errors
/// As [`decode`].
pub fn decode_in(memory: Memory, bytes: &[u8]) -> Result<Picture> {
    match kind_of(bytes) {
        Some(Kind::Exr) => exr::decode(bytes, memory),
        Some(Kind::Pfm) => pfm::decode(bytes, memory),
        Some(Kind::Coded(format)) => coded(bytes, format, memory),
        None if bytes.is_empty() => Err(Error::new("the file is empty")),
        None => Err(Error::new("not a picture that can be read").advise(format!("known: {KNOWN}"))),
    }
}

/// What can be read, for messages.
const KNOWN: &str = ".exr, .png, .jpg, .hdr, .pfm, .tga, .bmp, .tif, .gif";

/// A format of pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Exr,
    Pfm,
    /// What the `image` crate reads.
    Coded(ImageFormat),
}

/// The format of a file that begins with these bytes.
fn kind_of(bytes: &[u8]) -> Option<Kind> {
    const SIGNATURES: [(&[u8], Kind); 11] = [
        (b"\x76\x2f\x31\x01", Kind::Exr),
        (b"\x89PNG\r\n\x1a\n", Kind::Coded(ImageFormat::Png)),
        (b"\xff\xd8\xff", Kind::Coded(ImageFormat::Jpeg)),
        (b"#?", Kind::Coded(ImageFormat::Hdr)),
        (b"PF", Kind::Pfm),
        (b"Pf", Kind::Pfm),
        (b"BM", Kind::Coded(ImageFormat::Bmp)),
        (b"GIF8", Kind::Coded(ImageFormat::Gif)),
        (b"II*\0", Kind::Coded(ImageFormat::Tiff)),
        (b"MM\0*", Kind::Coded(ImageFormat::Tiff)),
        (b"II+\0", Kind::Coded(ImageFormat::Tiff)),
    ];
    let signed = SIGNATURES.iter().find(|(signature, _)| bytes.starts_with(signature)).map(|row| row.1);
    signed.or_else(|| is_targa(bytes).then_some(Kind::Coded(ImageFormat::Tga)))
}

/// Targa files have no signature: a header that makes sense must do.
fn is_targa(bytes: &[u8]) -> bool {
    let Some(&[_, map, kind, _, _, _, _, map_bits, _, _, _, _, w0, w1, h0, h1, bits, _]) =
        bytes.first_chunk()
    else {
        return false;
    };
    let has_map = matches!(kind, 1 | 9);
    matches!(kind, 1 | 2 | 3 | 9 | 10 | 11)
        && map == u8::from(has_map || map == 1)
        && (!has_map || map == 1 && matches!(map_bits, 15 | 16 | 24 | 32))
        && matches!(bits, 8 | 15 | 16 | 24 | 32)
        && [w0, w1] != [0; 2]
        && [h0, h1] != [0; 2]
}

/// The error of a file that begins well. It says nothing that the file says: another file may have named it.
fn damaged(what: &str) -> Error {
    Error::new(format!("cannot decode the {what}"))
        .advise("it is damaged, incomplete or of a kind that is not supported")
}

/// Refuses a picture without pixels or with too many.
fn check_size(width: u64, height: u64) -> Result<(u32, u32)> {
    match (u32::try_from(width), u32::try_from(height)) {
        (Ok(w), Ok(h)) if w > 0 && h > 0 && width * height <= MOST_PIXELS => Ok((w, h)),
        _ => Err(Error::new(format!("a picture of {width}x{height} pixels cannot be read"))
            .advise(format!("it must have 1 to {MOST_PIXELS} pixels"))),
    }
}

/// Refuses a picture of a size that was checked, if it does not fit into memory: a kilobyte can say that it is millions
/// of pixels, and nothing more could be said once the process is killed.
fn check_room(width: u32, height: u32, memory: Memory) -> Result<()> {
    let needed = u64::from(width) * u64::from(height) * PEAK;
    match (needed > SMALL).then(memory).flatten() {
        Some(left) if left.bytes < needed => {
            let what = format!("a picture of {width}x{height} pixels");
            Err(memory::refused(needed, &what, left, "scale the picture down"))
        }
        _ => Ok(()),
    }
}

/// What the `image` crate reads, as linear colours.
fn coded(bytes: &[u8], format: ImageFormat, memory: Memory) -> Result<Picture> {
    let (texels, transfer) = texels::coded_bytes(bytes, format, memory)?;
    let [width, height] = texels.size();
    let pixels: Vec<[f32; 3]> = texels.pixels(transfer).map(|[r, g, b, _]| [r, g, b]).collect();
    let encoding = if transfer == Transfer::Srgb { Encoding::Display } else { Encoding::Linear };
    let settings = if format == ImageFormat::Png { png_settings(bytes) } else { String::new() };
    Ok(Picture { image: Image::from_rgb(width, height, &pixels, settings), encoding })
}

/// What drt wrote into a PNG beside the picture; empty where it did not.
fn png_settings(bytes: &[u8]) -> String {
    let Ok(reader) = png::Decoder::new(std::io::Cursor::new(bytes)).read_info() else { return String::new() };
    let own = reader.info().utf8_text.iter().find(|text| text.keyword == "drt");
    own.and_then(|text| text.get_text().ok()).unwrap_or_default()
}
