//! JPEG: 8-bit sRGB, lossy.

use ::image::ExtendedColorType;
use ::image::codecs::jpeg::JpegEncoder;

use super::{Options, display};
use crate::error::{Error, Result};
use crate::film::Image;

/// High enough that blocks do not show in smooth skies; higher mostly stores the picture's noise.
const QUALITY: u8 = 95;

/// The largest side the format can name.
const LARGEST_SIDE: u32 = 65535;

pub(super) fn encode(image: &Image, options: &Options) -> Result<Vec<u8>> {
    if image.width.max(image.height) > LARGEST_SIDE {
        return Err(Error::new(format!("JPEG holds at most {LARGEST_SIDE} pixels a side"))
            .advise("write .png or .exr instead"));
    }
    let mut bytes = Vec::new();
    JpegEncoder::new_with_quality(&mut bytes, QUALITY)
        .encode(&display::to_srgb8(image, options), image.width, image.height, ExtendedColorType::Rgb8)
        .map_err(|e| Error::new(format!("cannot encode the picture as JPEG: {e}")))?;
    Ok(bytes)
}
