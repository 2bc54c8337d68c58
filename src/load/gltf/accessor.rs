//! Accessors: typed views of buffers, with what a sparse one replaces. Whether a view fits into its buffer is
//! checked once; reading then cannot leave it.

use super::Document;
use super::item::Item;
use crate::error::Result;
use std::collections::HashMap;
use std::sync::Arc;

/// Elements of an accessor without bytes are zeros: no more than this, or than the longest buffer has bytes if that is
/// more (a sparse one's elements have others with bytes beside them), so that a short file takes little time.
const MOST_ZEROS: usize = 1 << 12;

/// The type of a component.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(code: u64) -> Option<(Component, usize)> {
        Some(match code {
            5120 => (Component::I8, 1),
            5121 => (Component::U8, 1),
            5122 => (Component::I16, 2),
            5123 => (Component::U16, 2),
            5125 => (Component::U32, 4),
            5126 => (Component::F32, 4),
            _ => return None,
        })
    }

    /// The number at the beginning of `bytes`. Integers may stand for shares of 1: the largest is 1, and the smallest
    /// signed one −1.
    fn read(self, bytes: &[u8], normalized: bool) -> Option<f64> {
        let share = |value: f64, most: f64| if normalized { (value / most).max(-1.0) } else { value };
        Some(match self {
            Component::I8 => share(f64::from(i8::from_le_bytes(*bytes.first_chunk()?)), 127.0),
            Component::U8 => share(f64::from(*bytes.first()?), 255.0),
            Component::I16 => share(f64::from(i16::from_le_bytes(*bytes.first_chunk()?)), 32767.0),
            Component::U16 => share(f64::from(u16::from_le_bytes(*bytes.first_chunk()?)), 65535.0),
            Component::U32 => f64::from(u32::from_le_bytes(*bytes.first_chunk()?)),
            Component::F32 => f64::from(f32::from_le_bytes(*bytes.first_chunk()?)),
        })
    }
}

/// Elements in a buffer.
struct View {
    buffer: Arc<Vec<u8>>,
    first: usize,
    stride: usize,
    component: Component,
    size: usize,
}

impl View {
    /// Checks that `count` elements of `components` numbers fit.
    fn new(
        item: &Item<'_>,
        view: &Bytes,
        offset: usize,
        count: usize,
        components: usize,
        kind: (Component, usize),
    ) -> Result<View> {
        let (component, size) = kind;
        let stride = if view.stride == 0 { components * size } else { view.stride };
        let last = count.checked_sub(1).map_or(Some(0), |last| {
            last.checked_mul(stride)?.checked_add(offset)?.checked_add(components * size)
        });
        if last.is_none_or(|last| last > view.length) {
            return Err(
                item.error(&format!("says {count} elements, and they do not fit into its buffer view"))
            );
        }
        Ok(View { buffer: view.buffer.clone(), first: view.first + offset, stride, component, size })
    }

    fn number(&self, element: usize, component: usize, normalized: bool) -> f64 {
        let at = self.first + element * self.stride + component * self.size;
        self.buffer.get(at..).and_then(|bytes| self.component.read(bytes, normalized)).unwrap_or(0.0)
    }
}

/// A buffer view: bytes of a buffer.
pub(super) struct Bytes {
    buffer: Arc<Vec<u8>>,
    first: usize,
    length: usize,
    /// From element to element; 0: one after the other.
    stride: usize,
}

impl Bytes {
    /// View `index` of a document.
    ///
    /// # Errors
    /// It does not exist or does not fit into its buffer.
    pub fn of(document: &Document<'_>, index: usize) -> Result<Bytes> {
        let item = document.root.at("bufferViews", index)?;
        if item.extension("EXT_meshopt_compression").is_some() {
            return Err(item.error("is compressed with meshopt").advise(super::DECODE_FIRST));
        }
        let buffer = item.size("buffer", None)?;
        let buffer =
            document.buffers.get(buffer).ok_or_else(|| item.error("names a buffer that does not exist"))?;
        let (first, length) = (item.size("byteOffset", Some(0))?, item.size("byteLength", None)?);
        if first.checked_add(length).is_none_or(|end| end > buffer.len()) {
            return Err(item.error("does not fit into its buffer"));
        }
        let stride = item.size("byteStride", Some(0))?;
        Ok(Bytes { buffer: buffer.clone(), first, length, stride })
    }

    /// The bytes themselves.
    pub fn bytes(&self) -> &[u8] {
        self.buffer.get(self.first..self.first + self.length).unwrap_or_default()
    }
}

/// Elements of one or several numbers.
pub(super) struct Accessor {
    pub count: usize,
    pub components: usize,
    normalized: bool,
    /// `None`: zeros.
    view: Option<View>,
    /// What replaces elements: which one of the values.
    sparse: Option<(HashMap<usize, usize>, View)>,
}

impl Accessor {
    /// Accessor `index` of a document.
    ///
    /// # Errors
    /// It does not exist, or does not fit into what it names.
    pub fn of(document: &Document<'_>, index: usize) -> Result<Accessor> {
        let item = document.root.at("accessors", index)?;
        let count = item.size("count", None)?;
        let components = match item.text("type") {
            Some("SCALAR") => 1,
            Some("VEC2") => 2,
            Some("VEC3") => 3,
            Some("VEC4" | "MAT2") => 4,
            Some("MAT3") => 9,
            Some("MAT4") => 16,
            _ => return Err(item.error("has an unknown \"type\"")),
        };
        let kind = component(&item)?;
        let normalized = item.get("normalized").is_some_and(|n| n.value.as_bool() == Some(true));
        let view = match item.index("bufferView")? {
            None if count > MOST_ZEROS.max(document.longest) => {
                return Err(item.error(&format!("says {count} elements of no bytes")));
            }
            None => None,
            Some(view) => {
                let bytes = Bytes::of(document, view)?;
                let offset = item.size("byteOffset", Some(0))?;
                Some(View::new(&item, &bytes, offset, count, components, kind)?)
            }
        };
        let sparse = item.get("sparse").map(|s| sparse(&s, document, components, kind)).transpose()?;
        Ok(Accessor { count, components, normalized, view, sparse })
    }

    /// A number; 0 beyond the end.
    pub fn number(&self, element: usize, component: usize) -> f64 {
        if element >= self.count {
            return 0.0;
        }
        if let Some((places, view)) = &self.sparse
            && let Some(place) = places.get(&element)
        {
            return view.number(*place, component, self.normalized);
        }
        self.view.as_ref().map_or(0.0, |view| view.number(element, component, self.normalized))
    }

    /// An element; 0 for components that it has not.
    pub fn element<const N: usize>(&self, element: usize) -> [f64; N] {
        std::array::from_fn(|i| if i < self.components { self.number(element, i) } else { 0.0 })
    }
}

fn component(item: &Item<'_>) -> Result<(Component, usize)> {
    let code = item.need("componentType")?.value.as_u64();
    code.and_then(Component::of).ok_or_else(|| item.error("has an unknown \"componentType\""))
}

fn sparse(
    item: &Item<'_>,
    document: &Document<'_>,
    components: usize,
    kind: (Component, usize),
) -> Result<(HashMap<usize, usize>, View)> {
    let count = item.size("count", None)?;
    let view = |item: &Item<'_>, components, kind| {
        let bytes = Bytes::of(document, item.size("bufferView", None)?)?;
        View::new(item, &bytes, item.size("byteOffset", Some(0))?, count, components, kind)
    };
    let indices = item.need("indices")?;
    let places = view(&indices, 1, component(&indices)?)?;
    let values = view(&item.need("values")?, components, kind)?;
    let places = (0..count).map(|i| (places.number(i, 0, false) as usize, i)).collect();
    Ok((places, values))
}
