//! Pictures of every format: as many pixels as they say, or an error.

use drt::load::picture::{MOST_PIXELS, decode_in};
use drt::memory::{Left, Limit};

/// The bytes are the file.
pub fn run(bytes: &[u8]) {
    // Room for some hundred thousand pixels, so that executions take milliseconds at most.
    let memory = || Some(Left { bytes: 1 << 22, limit: Limit::Machine });
    let Ok(picture) = decode_in(memory, bytes) else { return };
    let image = picture.image;
    let pixels = u64::from(image.width) * u64::from(image.height);
    assert!((1..=MOST_PIXELS).contains(&pixels));
    assert_eq!(image.rgb_pixels().len() as u64, pixels);
    assert!(image.offset[0] + image.width <= image.full_size[0].max(image.width));
    assert!(image.offset[1] + image.height <= image.full_size[1].max(image.height));
}
