//! OpenEXR: one part, scan lines in increasing order, ZIP over 16 lines, every channel under its own name.

use std::io::Cursor;

use ::exr::block::lines::LineRefMut;
use ::exr::image::write::WritableImage;
use ::exr::image::write::samples::{SamplesWriter, WritableSamples};
use ::exr::image::{AnyChannel, AnyChannels, Encoding, Image as ExrImage, Layer};
use ::exr::math::{RoundingMode, Vec2};
use ::exr::meta::attribute::{AttributeValue, IntegerBounds, LevelMode, LineOrder, SampleType, Text};
use ::exr::meta::header::{Header, ImageAttributes, LayerAttributes};
use ::exr::prelude::{Blocks, Compression};

use super::Options;
use crate::error::{Error, Result};
use crate::film::{Data, Image};

/// Longest channel name that the format's long-name flag allows, in bytes.
const LONGEST_NAME: usize = 255;

/// The data window is the crop, the display window the whole picture, the string attribute `drt` the settings.
pub(super) fn encode(image: &Image, _options: &Options) -> Result<Vec<u8>> {
    let position = Vec2(signed(image.offset[0])?, signed(image.offset[1])?);
    let display = IntegerBounds::new(
        (0, 0),
        (signed(image.full_size[0])? as usize, signed(image.full_size[1])? as usize),
    );
    let size = Vec2(signed(image.width)? as usize, signed(image.height)? as usize);

    let mut attributes = LayerAttributes { layer_position: position, ..LayerAttributes::default() };
    attributes.other.insert(text("drt"), AttributeValue::Text(text(&image.settings)));
    let encoding = Encoding {
        compression: Compression::ZIP16,
        blocks: Blocks::ScanLines,
        line_order: LineOrder::Increasing,
    };
    let layer = Layer::new(size, attributes, encoding, channels(image)?);
    let picture = ExrImage::empty(ImageAttributes::new(display)).with_layer(layer);

    let mut bytes = Cursor::new(Vec::new());
    picture
        .write()
        .non_parallel()
        .to_buffered(&mut bytes)
        .map_err(|e| Error::new(format!("cannot encode the picture as OpenEXR: {e}")))?;
    Ok(bytes.into_inner())
}

/// The format's coordinates are signed 32-bit.
fn signed(coordinate: u32) -> Result<i32> {
    i32::try_from(coordinate)
        .map_err(|_| Error::new(format!("{coordinate} is past OpenEXR's largest coordinate, {}", i32::MAX)))
}

/// The format's strings are bytes; ours are UTF-8, as OpenEXR's documentation recommends.
fn text(string: &str) -> Text {
    Text::from_slice_unchecked(string.as_bytes())
}

/// The format wants the channels in alphabetical order, with unique names of 1 to 255 bytes.
fn channels(image: &Image) -> Result<AnyChannels<Samples<'_>>> {
    let mut names: Vec<&str> = image.channels.iter().map(|c| c.name.as_str()).collect();
    names.sort_unstable();
    if names.is_empty() {
        return Err(Error::new("a picture without channels cannot be written as OpenEXR"));
    }
    if names.iter().any(|n| n.is_empty() || n.len() > LONGEST_NAME || n.contains('\0')) {
        return Err(Error::new(format!(
            "an OpenEXR channel's name must have 1 to {LONGEST_NAME} bytes, none zero"
        )));
    }
    if let Some(twice) = names.windows(2).find(|w| w[0] == w[1]) {
        return Err(Error::new(format!("two channels have the name \"{}\"", twice[0])));
    }
    Ok(AnyChannels::sort(
        image.channels.iter().map(|c| AnyChannel::new(text(&c.name), Samples(&c.data))).collect(),
    ))
}

/// A channel's samples, borrowed: a large picture with many layers is not copied to be written.
struct Samples<'a>(&'a Data);

/// Hands out lines of a channel.
struct Lines<'a> {
    data: &'a Data,
    width: usize,
}

impl<'a> WritableSamples<'a> for Samples<'_> {
    type Writer = Lines<'a>;

    fn sample_type(&self) -> SampleType {
        match self.0 {
            Data::F32(_) => SampleType::F32,
            Data::U32(_) => SampleType::U32,
        }
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_samples_writer(&'a self, header: &Header) -> Lines<'a> {
        Lines { data: self.0, width: header.layer_size.width() }
    }
}

impl SamplesWriter for Lines<'_> {
    fn extract_line(&self, line: LineRefMut<'_>) {
        let start = line.location.position.y() * self.width + line.location.position.x();
        // Writing into the block's memory cannot fail: its length was computed from the same header.
        let _ = match self.data {
            Data::F32(values) => line.write_samples(|x| values.get(start + x).copied().unwrap_or(0.0)),
            Data::U32(values) => line.write_samples(|x| values.get(start + x).copied().unwrap_or(0)),
        };
    }
}
