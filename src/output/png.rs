//! PNG: 8-bit sRGB without alpha, marked with the `sRGB` chunk; the settings in an `iTXt` chunk `drt`.

use super::{Options, display};
use crate::error::{Error, Result};
use crate::film::Image;

pub(super) fn encode(image: &Image, options: &Options) -> Result<Vec<u8>> {
    let mut bytes = Vec::new();
    write(image, options, &mut bytes)
        .map_err(|e| Error::new(format!("cannot encode the picture as PNG: {e}")))?;
    Ok(bytes)
}

fn write(image: &Image, options: &Options, bytes: &mut Vec<u8>) -> Result<(), ::png::EncodingError> {
    let mut encoder = ::png::Encoder::new(bytes, image.width, image.height);
    encoder.set_color(::png::ColorType::Rgb);
    encoder.set_depth(::png::BitDepth::Eight);
    encoder.set_source_srgb(::png::SrgbRenderingIntent::RelativeColorimetric);
    // Names what made the picture, and whether it was stopped early, without a second file beside it.
    if !image.settings.is_empty() {
        encoder.add_itxt_chunk("drt".to_string(), image.settings.clone())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&display::to_srgb8(image, options))?;
    writer.finish()
}
