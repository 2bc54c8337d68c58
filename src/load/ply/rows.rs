//! The rows of a PLY file's elements: which values go where.

use super::header::{Element, Header, Property, Type};
use super::values::Values;
use super::{Layout, NORMAL, UVS, texture_name};
use crate::error::{Error, Finding, Findings, Result, Severity};
use crate::load::input::no_memory;
use crate::load::obj::builder::{Builder, Corner};
use crate::load::words::Value;
use crate::shape::NO_INDEX;
use std::io::Read;
use std::path::Path;

const POSITION: [&str; 3] = ["x", "y", "z"];

/// Where a vertex's number goes: x y z nx ny nz u v; [`SKIP`]: nowhere.
fn vertex_place(name: &str) -> usize {
    let pairs = UVS.iter().find_map(|pair| pair.iter().position(|known| *known == name));
    let place = POSITION.iter().chain(&NORMAL).position(|known| *known == name);
    place.or(pairs.map(|at| 6 + at)).unwrap_or(SKIP)
}

const SKIP: usize = 8;

/// Reads rows and hands them to the builder.
pub(super) struct Reader<'a, R> {
    pub file: &'a Path,
    pub values: Values<'a, R>,
    pub builder: Builder<'a>,
    pub findings: Findings,
    pub layout: Layout,
    pub corners: Vec<Corner>,
}

/// Whether a row was there.
type Row = Result<Option<()>>;

impl<R: Read> Reader<'_, R> {
    /// Faces without a `texnumber` have the first picture.
    pub fn name_textures(&mut self, header: &Header) -> Result<()> {
        match header.textures.is_empty() {
            true => Ok(()),
            false => self.builder.material(texture_name(0).as_bytes()),
        }
    }

    /// Reads an element's rows; `false` where the file ended before the last of them.
    pub fn element(&mut self, element: &Element) -> Result<bool> {
        let is_vertex = element.name == "vertex";
        let places: Vec<usize> = element.properties.iter().map(|p| vertex_place(&p.name)).collect();
        if is_vertex {
            self.check_vertex(element, &places)?;
        }
        if element.properties.is_empty() {
            return Ok(true);
        }
        for row in 0..element.count {
            let read = match element.name.as_str() {
                "vertex" => self.vertex(element, &places)?,
                "face" => self.face(element)?,
                "tristrips" => self.strip(element)?,
                _ => self.skip_row(element)?,
            };
            if read.is_none() {
                let (name, count) = (&element.name, element.count);
                let message = format!("the file ends after {row} of {count} rows of its element {name}");
                if is_vertex || row == 0 {
                    return Err(Error::new(message).at(self.file).advise("it is incomplete; fetch it again"));
                }
                self.note("file-truncated", Severity::Error, self.values.line(), message);
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// Adds a finding.
    pub fn note(&mut self, kind: &'static str, severity: Severity, line: u64, message: String) {
        self.findings.push(Finding { file: self.file.to_path_buf(), line, kind, message, severity });
    }

    fn check_vertex(&mut self, element: &Element, places: &[usize]) -> Result<()> {
        if let Some(missing) = (0..3).find(|place| !places.contains(place)) {
            let name = POSITION.get(missing).unwrap_or(&"x");
            let error = Error::new(format!("the element vertex has no property {name}"));
            return Err(error.at(self.file).line(element.line));
        }
        if element.properties.iter().any(|p| matches!(p.name.as_str(), "red" | "diffuse_red")) {
            let message = "colours of vertices are not used".to_string();
            self.note("vertex-colors-ignored", Severity::Note, element.line, message);
        }
        Ok(())
    }

    fn vertex(&mut self, element: &Element, places: &[usize]) -> Row {
        let mut values = [Value::default(); SKIP + 1];
        for (property, place) in element.properties.iter().zip(places) {
            let read = match property.list {
                Some(_) => self.skip(property)?,
                None => self.values.next(property.kind)?.map(|value| {
                    if let Some(slot) = values.get_mut(*place) {
                        *slot = value;
                    }
                }),
            };
            if read.is_none() {
                return Ok(None);
            }
        }
        self.builder.at_line(self.values.line());
        let [x, y, z, nx, ny, nz, u, v, _] = values;
        if self.layout.has_normals {
            self.builder.normal([nx, ny, nz].map(|n| n.rounded))?;
        }
        if self.layout.has_uvs {
            self.builder.uv([u, v].map(|n| n.rounded))?;
        }
        self.builder.position([x, y, z].map(|n| (n.exact, n.rounded)))?;
        Ok(Some(()))
    }

    /// A property that is not used.
    fn skip(&mut self, property: &Property) -> Row {
        let count = match property.list {
            None => 1,
            Some(kind) => match self.length(kind)? {
                Some(count) => count,
                None => return Ok(None),
            },
        };
        for _ in 0..count {
            if self.values.next(property.kind)?.is_none() {
                return Ok(None);
            }
        }
        Ok(Some(()))
    }

    fn skip_row(&mut self, element: &Element) -> Row {
        for property in &element.properties {
            if self.skip(property)?.is_none() {
                return Ok(None);
            }
        }
        Ok(Some(()))
    }

    /// The length of a list.
    fn length(&mut self, kind: Type) -> Result<Option<u64>> {
        let Some(value) = self.values.next(kind)? else { return Ok(None) };
        let line = self.values.line();
        let error = || {
            let error = Error::new(format!("a list cannot have {} values", value.exact)).at(self.file);
            if line > 0 { error.line(line) } else { error }
        };
        value.count().ok_or_else(error).map(Some)
    }

    fn face(&mut self, element: &Element) -> Row {
        self.corners.clear();
        let (mut unknown, mut own_uvs) = (None, false);
        for property in &element.properties {
            let read = match (property.name.as_str(), property.list) {
                ("vertex_indices" | "vertex_index", Some(kind)) => {
                    let read = self.indices(kind, property.kind, &mut unknown)?;
                    self.builder.at_line(self.values.line());
                    read
                }
                ("texcoord", Some(kind)) => {
                    own_uvs = true;
                    self.corner_uvs(kind, property.kind)?
                }
                ("texnumber", None) => self.texture_number(property.kind)?,
                _ => self.skip(property)?,
            };
            if read.is_none() {
                return Ok(None);
            }
        }
        for corner in &mut self.corners {
            corner.normal = if self.layout.has_normals { corner.position } else { NO_INDEX };
            if self.layout.has_uvs && !own_uvs {
                corner.uv = corner.position;
            }
        }
        match unknown {
            Some(index) => self.builder.face_without(index)?,
            None => self.builder.face(&self.corners)?,
        }
        Ok(Some(()))
    }

    /// A face's corners; `unknown` is an index that cannot be one.
    fn indices(&mut self, length: Type, kind: Type, unknown: &mut Option<i64>) -> Row {
        let Some(count) = self.length(length)? else { return Ok(None) };
        let first = self.corners.len();
        for i in 0..count {
            let Some(value) = self.values.next(kind)? else { return Ok(None) };
            if value.index().is_none() {
                unknown.get_or_insert(value.exact as i64);
            }
            // Texture coordinates may have come before.
            let position = value.index().unwrap_or(NO_INDEX);
            match self.corners.get_mut(i as usize).filter(|_| first > 0) {
                Some(corner) => corner.position = position,
                None => self.add_corner(Corner::at(position))?,
            }
        }
        self.corners.truncate(count as usize);
        Ok(Some(()))
    }

    fn add_corner(&mut self, corner: Corner) -> Result<()> {
        self.corners.try_reserve(1).map_err(|_| no_memory(self.file))?;
        self.corners.push(corner);
        Ok(())
    }

    /// Two numbers a corner.
    fn corner_uvs(&mut self, length: Type, kind: Type) -> Row {
        let Some(count) = self.length(length)? else { return Ok(None) };
        let mut uv = [0.0; 2];
        for i in 0..count {
            let Some(value) = self.values.next(kind)? else { return Ok(None) };
            let Some(slot) = uv.get_mut(i as usize % 2) else { continue };
            *slot = value.rounded;
            if i % 2 == 0 {
                continue;
            }
            let index = self.builder.counts()[1] as u32;
            self.builder.uv(uv)?;
            match self.corners.get_mut(i as usize / 2) {
                Some(corner) => corner.uv = index,
                None => self.add_corner(Corner { uv: index, ..Corner::at(NO_INDEX) })?,
            }
        }
        Ok(Some(()))
    }

    fn texture_number(&mut self, kind: Type) -> Row {
        let Some(value) = self.values.next(kind)? else { return Ok(None) };
        let number = value.index().map_or(0, |n| n as usize);
        if self.layout.textures > 1 && number < self.layout.textures {
            self.builder.material(texture_name(number).as_bytes())?;
        }
        Ok(Some(()))
    }

    /// Triangle strips, each ended by −1: every second triangle is turned over.
    fn strip(&mut self, element: &Element) -> Row {
        for property in &element.properties {
            let list =
                property.list.filter(|_| matches!(property.name.as_str(), "vertex_indices" | "vertex_index"));
            let Some(length) = list else {
                if self.skip(property)?.is_none() {
                    return Ok(None);
                }
                continue;
            };
            let Some(count) = self.length(length)? else { return Ok(None) };
            let mut strip = Strip::default();
            for _ in 0..count {
                let Some(value) = self.values.next(property.kind)? else { return Ok(None) };
                self.builder.at_line(self.values.line());
                match (strip.next(value.index()), value.index()) {
                    (Some(triangle), _) => self.builder.face(&triangle.map(|i| self.layout.corner(i)))?,
                    (None, None) if value.exact != -1.0 => self.builder.face_without(value.exact as i64)?,
                    _ => {}
                }
            }
        }
        Ok(Some(()))
    }
}

/// The last vertices of a strip.
#[derive(Default)]
struct Strip {
    last: [u32; 2],
    length: u64,
}

impl Strip {
    /// The triangle that a further vertex makes, if it makes one; no vertex ends the strip.
    fn next(&mut self, vertex: Option<u32>) -> Option<[u32; 3]> {
        let Some(vertex) = vertex else {
            self.length = 0;
            return None;
        };
        let [a, b] = self.last;
        self.last = [b, vertex];
        self.length += 1;
        // Strips are joined by triangles that have a vertex twice.
        let is_triangle = self.length >= 3 && a != b && b != vertex && a != vertex;
        let turned = self.length.is_multiple_of(2);
        is_triangle.then_some(if turned { [b, a, vertex] } else { [a, b, vertex] })
    }
}
