//! A developed [`Image`] becomes a file: one encoder a format, one way to write bytes safely.
//!
//! Encoders return bytes, so that the same picture gives the same bytes wherever it is written, and only
//! [`mod@file`] knows about disks, links and devices.

pub mod display;
mod exr;
pub mod file;
mod hdr;
mod jpeg;
mod pfm;
mod png;
mod temporary;
#[cfg(test)]
mod tests;

use std::path::Path;

use crate::error::{Error, Result, unknown_word_advice};
use crate::film::{Data, Image};

pub use display::ToneMap;
pub use file::{check_path, check_writable, write_bytes};

/// A picture file's format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// OpenEXR: linear f32, every channel, the settings; lossless.
    Exr,
    /// 8-bit sRGB, lossless.
    Png,
    /// 8-bit sRGB, lossy.
    Jpeg,
    /// Radiance RGBE: linear, 8-bit mantissas with one exponent a pixel.
    Hdr,
    /// Portable float map: linear f32, colour only.
    Pfm,
}

/// What the program knows about a format; a new one is a file beside this one and a line in [`FORMATS`].
pub struct FormatEntry {
    /// The format.
    pub format: Format,
    /// File name extensions in lower case, without the dot; the first is the format's name.
    pub extensions: &'static [&'static str],
    /// The encoder.
    encode: fn(&Image, &Options) -> Result<Vec<u8>>,
}

/// Every format that can be written.
pub const FORMATS: [FormatEntry; 5] = [
    FormatEntry { format: Format::Exr, extensions: &["exr"], encode: exr::encode },
    FormatEntry { format: Format::Png, extensions: &["png"], encode: png::encode },
    FormatEntry { format: Format::Jpeg, extensions: &["jpg", "jpeg"], encode: jpeg::encode },
    FormatEntry { format: Format::Hdr, extensions: &["hdr"], encode: hdr::encode },
    FormatEntry { format: Format::Pfm, extensions: &["pfm"], encode: pfm::encode },
];

impl Format {
    /// The format that `path`'s extension names, in any case. Standard output (`-`) and devices or pipes
    /// whose name has no known extension carry PNG.
    ///
    /// # Errors
    /// An unknown or missing extension; the advice lists the known ones.
    pub fn of_path(path: &Path) -> Result<Format> {
        let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase());
        let named = extension.as_deref().and_then(|e| FORMATS.iter().find(|f| f.extensions.contains(&e)));
        if let Some(entry) = named {
            return Ok(entry.format);
        }
        if file::is_stream(path) {
            return Ok(Format::Png);
        }
        let known: Vec<&str> = FORMATS.iter().flat_map(|f| f.extensions).copied().collect();
        Err(match extension {
            Some(e) => {
                Error::new(format!("unknown picture format \".{e}\"")).advise(unknown_word_advice(&e, &known))
            }
            None => Error::new("the output's name has no extension to tell its format")
                .advise(format!("known: {}", known.join(", "))),
        }
        .at(path))
    }
}

/// How a picture is prepared for 8-bit formats; the float formats ignore all of it.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct Options {
    /// Exposure compensation in EV (stops): values are multiplied by 2^EV before the tone map.
    pub exposure: f32,
    /// The curve that brings bright values below one.
    pub tone_map: ToneMap,
}

/// The file's bytes; the same for the same picture on any number of threads.
///
/// # Errors
/// A picture without pixels, a channel of the wrong length, or a size that the format cannot hold.
pub fn encode(image: &Image, format: Format, options: &Options) -> Result<Vec<u8>> {
    check_image(image)?;
    match FORMATS.iter().find(|f| f.format == format) {
        Some(entry) => (entry.encode)(image, options),
        None => Err(Error::new(format!("no encoder for {format:?}"))),
    }
}

/// Encodes the picture by `path`'s extension and writes it there as [`write_bytes`] does.
///
/// # Errors
/// As [`Format::of_path`], [`encode`] and [`write_bytes`], naming `path`.
pub fn write(path: &Path, image: &Image, options: &Options) -> Result<()> {
    let bytes = encode(image, Format::of_path(path)?, options).map_err(|e| e.at(path))?;
    write_bytes(path, &bytes)
}

/// Every encoder may rely on this: at least one pixel, and `width·height` samples in each channel.
fn check_image(image: &Image) -> Result<()> {
    let pixels = image.width as usize * image.height as usize;
    if pixels == 0 {
        return Err(Error::new(format!("a picture of {}x{} has no pixels", image.width, image.height)));
    }
    for channel in &image.channels {
        let samples = match &channel.data {
            Data::F32(values) => values.len(),
            Data::U32(values) => values.len(),
        };
        if samples != pixels {
            return Err(Error::new(format!(
                "channel \"{}\" has {samples} samples for {}x{} pixels",
                channel.name, image.width, image.height
            )));
        }
    }
    Ok(())
}
