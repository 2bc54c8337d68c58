//! Portable float map (Debevec): three linear f32 a pixel, little endian, rows from the bottom.

use super::Options;
use crate::error::Result;
use crate::film::Image;

pub(super) fn encode(image: &Image, _options: &Options) -> Result<Vec<u8>> {
    // The scale's sign is the byte order: negative is little endian.
    let mut bytes = format!("PF\n{} {}\n-1.0\n", image.width, image.height).into_bytes();
    for row in image.rgb_pixels().chunks(image.width as usize).rev() {
        bytes.extend(row.iter().flatten().flat_map(|value| value.to_le_bytes()));
    }
    Ok(bytes)
}
