//! OpenEXR: the colour channels of the first layer that has them, of any sample type.

use super::{Encoding, Memory, Picture, check_room, check_size};
use crate::error::{Error, Result};
use crate::film::Image;
use crate::texture::{Data, Texels};
use ::exr::image::read::read;
use ::exr::math::Vec2;
use ::exr::meta::MetaData;
use ::exr::meta::attribute::{AttributeValue, Text};
use ::exr::meta::header::Header;
use ::exr::prelude::{ReadChannels, ReadLayers, ReadSpecificChannel};
use std::collections::BTreeSet;
use std::io::{Cursor, Read, Seek, SeekFrom};

/// RGB and alpha being filled, and the number of pixels in a row.
struct Grid {
    width: usize,
    pixels: Vec<[f32; 4]>,
}

impl Grid {
    fn new(size: Vec2<usize>) -> Grid {
        Grid { width: size.width(), pixels: vec![[0.0; 4]; size.area()] }
    }

    fn set(&mut self, at: Vec2<usize>, colour: [f32; 4]) {
        if let Some(pixel) = self.pixels.get_mut(at.y() * self.width + at.x()) {
            *pixel = colour;
        }
    }
}

pub(super) fn decode(bytes: &[u8], memory: Memory) -> Result<Picture> {
    let [width, height] = size_of(&mut Cursor::new(bytes))?;
    let (width, height) = check_size(width, height)?;
    check_room(width, height, memory)?;
    let (header, grid) = pixels(Cursor::new(bytes))?;
    Ok(Picture { image: with_windows(&header, &grid), encoding: Encoding::Linear })
}

/// The texels of a texture: RGB and alpha.
pub(super) fn texels(input: impl Read + Seek) -> Result<Texels> {
    let (header, grid) = pixels(input)?;
    let [width, height] = [header.layer_size.width(), header.layer_size.height()].map(|n| n as u32);
    Texels::new(width, height, 4, Data::F32(grid.pixels.into_flattened()))
}

/// Width and height of the layer that would be read.
pub(super) fn size_of(input: &mut (impl Read + Seek)) -> Result<[u64; 2]> {
    let (header, _, _) = layer(input)?;
    Ok([header.layer_size.width() as u64, header.layer_size.height() as u64])
}

/// The decoder's own words may hold the file's.
fn damaged(_: ::exr::error::Error) -> Error {
    super::damaged("OpenEXR file")
}

/// The layer that is read, the names of its colours, and whether it has alpha.
fn layer(input: &mut (impl Read + Seek)) -> Result<(Header, ColourNames, Text)> {
    let meta = MetaData::read_from_buffered(input, false).map_err(damaged)?;
    // Every header is checked: the reader below chooses the layer by itself.
    for header in &meta.headers {
        check_size(header.layer_size.width() as u64, header.layer_size.height() as u64)?;
    }
    let found = meta.headers.into_iter().filter(|h| !h.deep).find_map(|h| colour_names(&h).map(|n| (h, n)));
    let (header, names) = found.ok_or_else(|| {
        Error::new("the OpenEXR file has no colour channels")
            .advise("R, G, B or Y are looked for, in any layer")
    })?;
    let alpha = names.alpha();
    Ok((header, names, alpha))
}

/// All pixels of that layer.
fn pixels(mut input: impl Read + Seek) -> Result<(Header, Grid)> {
    let (header, names, alpha) = layer(&mut input)?;
    input.seek(SeekFrom::Start(0)).map_err(|e| damaged(e.into()))?;
    let flat = read().no_deep_data().largest_resolution_level();
    let grid = match names {
        ColourNames::Rgb([r, g, b]) => {
            flat.specific_channels()
                .required(r)
                .required(g)
                .required(b)
                .optional(alpha, 1.0f32)
                .collect_pixels(
                    |size, _| Grid::new(size),
                    |grid: &mut Grid, at, (r, g, b, a): (f32, f32, f32, f32)| grid.set(at, [r, g, b, a]),
                )
                .first_valid_layer()
                .all_attributes()
                .non_parallel()
                .from_buffered(input)
                .map_err(damaged)?
                .layer_data
                .channel_data
                .pixels
        }
        ColourNames::Grey(y) => {
            flat.specific_channels()
                .required(y)
                .optional(alpha, 1.0f32)
                .collect_pixels(
                    |size, _| Grid::new(size),
                    |grid: &mut Grid, at, (y, a): (f32, f32)| grid.set(at, [y, y, y, a]),
                )
                .first_valid_layer()
                .all_attributes()
                .non_parallel()
                .from_buffered(input)
                .map_err(damaged)?
                .layer_data
                .channel_data
                .pixels
        }
    };
    Ok((header, grid))
}

enum ColourNames {
    Rgb([Text; 3]),
    Grey(Text),
}

impl ColourNames {
    /// The alpha beside these colours.
    fn alpha(&self) -> Text {
        let beside = match self {
            ColourNames::Rgb([red, _, _]) => red.to_string(),
            ColourNames::Grey(_) => "R".to_string(),
        };
        Text::from(format!("{}A", beside.strip_suffix('R').unwrap_or_default()).as_str())
    }
}

/// `R`, `G`, `B`, else the first layer's `NAME.R` … in alphabetical order, else the luminance `Y`.
fn colour_names(header: &Header) -> Option<ColourNames> {
    let names: BTreeSet<String> = header.channels.list.iter().map(|c| c.name.to_string()).collect();
    let all_three = |prefix: &str| {
        let three = ["R", "G", "B"].map(|c| format!("{prefix}{c}"));
        three
            .iter()
            .all(|name| names.contains(name))
            .then(|| ColourNames::Rgb(three.map(|n| Text::from(n.as_str()))))
    };
    all_three("")
        .or_else(|| {
            names.iter().filter_map(|n| n.strip_suffix('R')).filter(|p| p.ends_with('.')).find_map(all_three)
        })
        .or_else(|| names.contains("Y").then(|| ColourNames::Grey(Text::from("Y"))))
}

fn with_windows(header: &Header, grid: &Grid) -> Image {
    let settings = match header.own_attributes.other.get(b"drt".as_slice()) {
        Some(AttributeValue::Text(text)) => String::from_utf8_lossy(text.bytes()).into_owned(),
        _ => String::new(),
    };
    let (width, height) = (header.layer_size.width() as u32, header.layer_size.height() as u32);
    let colours: Vec<[f32; 3]> = grid.pixels.iter().map(|[r, g, b, _]| [*r, *g, *b]).collect();
    let mut image = Image::from_rgb(width, height, &colours, settings);
    let display = header.shared_attributes.display_window;
    let from = header.own_attributes.layer_position - display.position;
    let place = |from: i32, size: u32, full: usize| {
        let (from, full) = (u32::try_from(from).ok()?, u32::try_from(full).ok()?);
        (from.checked_add(size)? <= full).then_some((from, full))
    };
    let x = place(from.x(), width, display.size.width());
    let y = place(from.y(), height, display.size.height());
    if let (Some((x, full_width)), Some((y, full_height))) = (x, y) {
        image.offset = [x, y];
        image.full_size = [full_width, full_height];
    }
    image
}
