//! Pictures for surfaces: the size from the header alone, and texels as compact as the file has them.

use super::{Kind, MOST_PIXELS, exr, kind_of, pfm};
use crate::error::Result;
use crate::load::open::Reach;
use crate::load::texture::Place;
use crate::texture::{Data, Texels, Transfer};
use ::image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Read, Seek, SeekFrom};
use std::sync::Arc;

/// A file may be this much longer than its texels: profiles, previews, further pictures.
const SURPLUS: u64 = 64 << 20;

/// What is wrong with a picture. It says nothing that the file says: others may have named it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Trouble {
    /// The operating system's reason, or that it is no regular file.
    Unreadable(String),
    /// It is not within reach.
    Refused(String),
    /// No bytes.
    Empty,
    /// Not a format that is known.
    Unknown,
    /// Too many pixels, or more bytes than its pixels can need.
    TooLarge,
    /// The header promises what the data do not keep.
    Damaged,
}

impl Trouble {
    /// The kind of finding that it is.
    pub fn kind(&self) -> &'static str {
        if matches!(self, Trouble::Refused(_)) { "path-refused" } else { "texture-unreadable" }
    }

    /// For a message, after "the file".
    pub fn message(&self) -> String {
        match self {
            Trouble::Unreadable(why) | Trouble::Refused(why) => format!("cannot be read: {why}"),
            Trouble::Empty => "is empty".to_string(),
            Trouble::Unknown => format!("is no picture that can be read (known: {})", super::KNOWN),
            Trouble::TooLarge => {
                format!("is too large for a texture (at most {MOST_PIXELS} pixels)")
            }
            Trouble::Damaged => "is damaged or incomplete".to_string(),
        }
    }
}

/// What a header says.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Probe {
    /// Width and height.
    pub size: [u32; 2],
    /// Bytes of memory that the texels will take.
    pub bytes: u64,
    kind: Kind,
}

/// Reads the header of the picture at `place`, and nothing else; in a file of its own it must be within `reach`.
///
/// # Errors
/// Everything that a header can tell.
pub(crate) fn probe(place: &Place, reach: &Reach) -> Result<Probe, Trouble> {
    let (mut file, length, kind) = open(place, reach)?;
    let (size, bytes_a_pixel) = match kind {
        Kind::Exr => exr::size_of(&mut BufReader::new(&mut file)).map(|size| (size, 16)),
        Kind::Pfm => {
            pfm::header(&beginning(&mut file)?).map(|header| (header.size, 4 * header.channels as u64))
        }
        Kind::Coded(format) => {
            let decoder = reader(BufReader::new(&mut file), format, u64::MAX).into_decoder();
            let decoder = decoder.map_err(|_| Trouble::Damaged)?;
            let (width, height) = decoder.dimensions();
            Ok(([width, height].map(u64::from), u64::from(decoder.color_type().bytes_per_pixel())))
        }
    }
    .map_err(|_| Trouble::Damaged)?;
    let [width, height] = size;
    let (w, h) = super::check_size(width, height).map_err(|_| match width.checked_mul(height) {
        Some(0) => Trouble::Damaged,
        _ => Trouble::TooLarge,
    })?;
    let bytes = width * height * bytes_a_pixel;
    if length > SURPLUS + 2 * bytes {
        return Err(Trouble::TooLarge);
    }
    Ok(Probe { size: [w, h], bytes, kind })
}

/// Decodes the picture at `place`, which `probe` has looked at.
///
/// # Errors
/// Damage, and a file that changed in between.
pub(crate) fn texels(place: &Place, reach: &Reach, probe: &Probe) -> Result<Texels, Trouble> {
    let (file, length, kind) = open(place, reach)?;
    if kind != probe.kind || length > SURPLUS + 2 * probe.bytes {
        return Err(Trouble::Damaged);
    }
    let decoded = match kind {
        Kind::Exr => exr::texels(BufReader::new(file)).map_err(drop),
        Kind::Pfm => {
            let mut bytes = Vec::new();
            let read = file.take(SURPLUS + 2 * probe.bytes).read_to_end(&mut bytes);
            read.map_err(|_| Trouble::Damaged)?;
            pfm::texels(&bytes).map_err(drop)
        }
        Kind::Coded(format) => {
            coded(BufReader::new(file), format, probe.bytes).map(|coded| coded.0).map_err(drop)
        }
    };
    let texels = decoded.map_err(|()| Trouble::Damaged)?;
    if texels.size() == probe.size { Ok(texels) } else { Err(Trouble::Damaged) }
}

/// An opened picture.
enum Opened {
    File(File),
    Bytes(Cursor<Shared>),
}

/// Bytes that belong to several.
struct Shared(Arc<Vec<u8>>);

impl AsRef<[u8]> for Shared {
    fn as_ref(&self) -> &[u8] {
        &self.0
    }
}

impl Read for Opened {
    fn read(&mut self, buffer: &mut [u8]) -> std::io::Result<usize> {
        match self {
            Opened::File(file) => file.read(buffer),
            Opened::Bytes(bytes) => bytes.read(buffer),
        }
    }
}

impl Seek for Opened {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        match self {
            Opened::File(file) => file.seek(to),
            Opened::Bytes(bytes) => bytes.seek(to),
        }
    }
}

/// The picture, its length and what it holds, told from its first bytes.
fn open(place: &Place, reach: &Reach) -> Result<(Opened, u64, Kind), Trouble> {
    let (mut file, length) = match place {
        Place::File(path) => {
            let (file, length) = reach.open(path).map_err(|e| match reach.holds(path) {
                true => Trouble::Unreadable(e.message),
                false => Trouble::Refused(e.message),
            })?;
            (Opened::File(file), length)
        }
        Place::Inside(inside) => {
            (Opened::Bytes(Cursor::new(Shared(inside.bytes.clone()))), inside.bytes.len() as u64)
        }
    };
    let first = beginning(&mut file)?;
    if first.is_empty() {
        return Err(Trouble::Empty);
    }
    let kind = kind_of(&first).ok_or(Trouble::Unknown)?;
    Ok((file, length, kind))
}

/// The first bytes; the file stands at its start again.
fn beginning(file: &mut Opened) -> Result<Vec<u8>, Trouble> {
    let mut first = Vec::new();
    let read = file.by_ref().take(256).read_to_end(&mut first).and_then(|_| file.seek(SeekFrom::Start(0)));
    read.map(|_| first).map_err(|e| Trouble::Unreadable(e.to_string()))
}

fn reader<R: BufRead + Seek>(input: R, format: ImageFormat, bytes: u64) -> ImageReader<R> {
    let mut reader = ImageReader::with_format(input, format);
    let mut limits = Limits::default();
    // Decoders need some room beside the texels themselves.
    limits.max_alloc = Some(bytes.saturating_mul(2).saturating_add(SURPLUS));
    reader.limits(limits);
    reader
}

/// The texels of what the `image` crate reads, and what its codes mean in a picture for people; `bytes`: what they
/// take.
pub(super) fn coded<R: BufRead + Seek>(
    input: R,
    format: ImageFormat,
    bytes: u64,
) -> ::image::ImageResult<(Texels, Transfer)> {
    let decoder = reader(input, format, bytes).into_decoder()?;
    let decoded = DynamicImage::from_decoder(decoder)?;
    let (width, height) = (decoded.width(), decoded.height());
    let (channels, data) = match decoded {
        DynamicImage::ImageLuma8(image) => (1, Data::U8(image.into_raw())),
        DynamicImage::ImageLumaA8(image) => (2, Data::U8(image.into_raw())),
        DynamicImage::ImageRgb8(image) => (3, Data::U8(image.into_raw())),
        DynamicImage::ImageRgba8(image) => (4, Data::U8(image.into_raw())),
        DynamicImage::ImageLuma16(image) => (1, Data::U16(image.into_raw())),
        DynamicImage::ImageLumaA16(image) => (2, Data::U16(image.into_raw())),
        DynamicImage::ImageRgb16(image) => (3, Data::U16(image.into_raw())),
        DynamicImage::ImageRgba16(image) => (4, Data::U16(image.into_raw())),
        DynamicImage::ImageRgb32F(image) => (3, Data::F32(image.into_raw())),
        other => (4, Data::F32(other.into_rgba32f().into_raw())),
    };
    let transfer = if matches!(data, Data::F32(_)) { Transfer::Linear } else { Transfer::Srgb };
    let texels = Texels::new(width, height, channels, data);
    let texels = texels.map_err(|e| ::image::ImageError::IoError(std::io::Error::other(e.message)))?;
    Ok((texels, transfer))
}

/// [`coded`] of bytes in memory, refused by their header if there are too many pixels.
pub(super) fn coded_bytes(
    bytes: &[u8],
    format: ImageFormat,
    memory: super::Memory,
) -> Result<(Texels, Transfer)> {
    // The decoders' own words may hold the file's.
    let damaged = |_: ::image::ImageError| super::damaged("picture");
    let decoder = reader(Cursor::new(bytes), format, u64::MAX).into_decoder().map_err(damaged)?;
    let (width, height) = decoder.dimensions();
    super::check_size(width.into(), height.into())?;
    super::check_room(width, height, memory)?;
    let most = decoder.total_bytes();
    coded(Cursor::new(bytes), format, most).map_err(damaged)
}
