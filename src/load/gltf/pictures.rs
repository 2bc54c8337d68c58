//! Textures: which picture, how it is laid over the coordinates, and which coordinates those are.

use super::container::{data_uri, unescape};
use super::item::Item;
use super::{Document, accessor::Bytes, finding};
use crate::error::{Findings, Result, Severity};
use crate::load::open::{Finder, Reach};
use crate::load::texture::{Inside, Place, Source};
use crate::texture::{Filter, Mapping, Transfer, Wrap};
use glam::{DAffine2, DMat2, DVec2};
use std::collections::HashMap;
use std::sync::Arc;

/// A texture as a material uses it.
pub(super) struct Laid {
    pub source: Source,
    /// Without its place: see `transform`.
    pub mapping: Mapping,
    /// Which set of coordinates.
    pub uv_set: usize,
    /// What is done to them, as the document has them: v goes down.
    pub transform: DAffine2,
}

/// The texture that `info` names; `None`, with a warning, where it has no picture that can be used.
///
/// # Errors
/// References that lead nowhere.
pub(super) fn laid(
    info: &Item<'_>,
    document: &Document<'_>,
    transfer: Transfer,
    images: &mut Images,
    findings: &mut Findings,
) -> Result<Option<Laid>> {
    let root = &document.root;
    let texture = root.at("textures", info.size("index", None)?)?;
    let mut left_out = |kind, what: &str| {
        findings.push(finding(document.file, kind, Severity::Warning, format!("{} {what}", info.way)));
    };
    let Some(number) = texture.index("source")? else {
        left_out("texture-unreadable", "has no picture of a kind that can be read (png, jpg and others)");
        return Ok(None);
    };
    let Some(place) = images.place(number, document)? else {
        left_out("texture-missing", "is in a file that was not found beside this one");
        return Ok(None);
    };
    let sampler = texture.index("sampler")?.map(|s| root.at("samplers", s)).transpose()?;
    let setting = |key: &str| sampler.as_ref().map_or(Ok(0), |sampler| sampler.size(key, Some(0)));
    let wrap = match setting("wrapS")? {
        33071 => Wrap::Clamp,
        33648 => Wrap::Mirror,
        _ => Wrap::Repeat,
    };
    let filter = if setting("magFilter")? == 9728 { Filter::Nearest } else { Filter::Bilinear };
    let transform = info.extension("KHR_texture_transform");
    let own_set = info.size("texCoord", Some(0))?;
    Ok(Some(Laid {
        source: Source::One(place),
        mapping: Mapping { wrap, filter, ..Mapping::plain(transfer) },
        uv_set: transform.as_ref().map_or(Ok(own_set), |t| t.size("texCoord", Some(own_set)))?,
        transform: transform.map_or(Ok(DAffine2::IDENTITY), |t| affine(&t))?,
    }))
}

/// Scale, then rotation (counter-clockwise where v goes down), then offset.
fn affine(item: &Item<'_>) -> Result<DAffine2> {
    let offset = DVec2::from(item.numbers("offset", [0.0; 2])?);
    let scale = DVec2::from(item.numbers("scale", [1.0; 2])?);
    let angle = item.number("rotation", 0.0)?;
    let (sin, cos) = (libm::sin(angle), libm::cos(angle));
    let turn = DMat2::from_cols(DVec2::new(cos, -sin), DVec2::new(sin, cos));
    Ok(DAffine2 { matrix2: turn * DMat2::from_diagonal(scale), translation: offset })
}

/// A transform without rotation as scale and offset of coordinates whose v goes up; `None` with rotation.
pub(super) fn scale_and_offset(transform: &DAffine2) -> Option<([f32; 2], [f32; 2])> {
    let [a, b, c, d] = transform.matrix2.to_cols_array();
    let DVec2 { x, y } = transform.translation;
    // v' = d v + y with v = 1 − w, so w' = 1 − v' = d w + (1 − d − y).
    (b == 0.0 && c == 0.0).then_some(([a as f32, d as f32], [x as f32, (1.0 - d - y) as f32]))
}

/// Where the document's images are; each is looked for, or copied out of the document, once.
pub(super) struct Images {
    finder: Finder,
    places: HashMap<usize, Option<Place>>,
}

impl Images {
    /// Images within `reach`.
    pub fn new(reach: &Reach) -> Images {
        Images { finder: Finder::new(reach), places: HashMap::new() }
    }

    /// Where the image `number` is; `None` where its file is not there.
    fn place(&mut self, number: usize, document: &Document<'_>) -> Result<Option<Place>> {
        if let Some(known) = self.places.get(&number) {
            return Ok(known.clone());
        }
        let image = document.root.at("images", number)?;
        let place = place(&image, number, document, &mut self.finder)?;
        self.places.insert(number, place.clone());
        Ok(place)
    }
}

fn place(
    image: &Item<'_>,
    number: usize,
    document: &Document<'_>,
    finder: &mut Finder,
) -> Result<Option<Place>> {
    let inside =
        |bytes| Place::Inside(Inside { file: document.file.to_path_buf(), number, bytes: Arc::new(bytes) });
    if let Some(view) = image.index("bufferView")? {
        let bytes = Bytes::of(document, view)?;
        return Ok(Some(inside(bytes.bytes().to_vec())));
    }
    let uri = image.text("uri").ok_or_else(|| image.error("has neither \"uri\" nor \"bufferView\""))?;
    if let Some(data) = uri.strip_prefix("data:") {
        let bytes = data_uri(data).ok_or_else(|| image.error("has a data: URI that is not base64"))?;
        return Ok(Some(inside(bytes)));
    }
    let folder = document.file.parent().unwrap_or(std::path::Path::new(""));
    let found = finder.find(folder, &unescape(uri));
    Ok(found.map(|found| Place::File(found.path)))
}
