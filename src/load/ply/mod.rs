//! PLY: the format of the Stanford scans, of scanners and of MeshLab; as text and as bytes in both orders.
//!
//! Elements and properties may come in any order and of any type; those that are not known are skipped. Used are of
//! `vertex` x y z, nx ny nz and one pair of texture coordinates; of `face` (or `tristrips`) the vertices' indices, and
//! MeshLab's `texcoord` and `texnumber`. Colours are left out.

mod header;
mod rows;
#[cfg(test)]
mod tests;
mod values;

use super::format::{Format, Reading};
use super::input::Input;
use super::obj::builder::{Builder, Corner};
use super::obj::forecast::plain;
use super::object::Object;
use super::texture::{Sources, of_picture};
use crate::accel::need::Extent;
use crate::error::{Findings, Result, Severity};
use crate::scene::need::Meshes;
use crate::shape::NO_INDEX;
use header::{Header, Property};
use rows::Reader;
use std::collections::HashMap;
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use values::Values;

/// The format.
pub(super) const FORMAT: Format = Format {
    name: "ply",
    meaning: "Stanford PLY, as text and binary",
    extensions: &["ply"],
    begins: |head| head.starts_with(b"ply\n") || head.starts_with(b"ply\r"),
    forecast,
    read,
};

/// The header promises how many there are; what lies there cannot be more than there are bytes.
fn forecast(file: &File, bytes: u64) -> Option<(Extent, Meshes)> {
    let header = Header::read(&mut BufReader::new(file), Path::new("")).ok()?;
    let count = |name: &str| {
        let element = header.elements.iter().find(|element| element.name == name);
        element.map_or(0, |element| element.count.min(bytes))
    };
    let (vertices, layout) = (count("vertex"), Layout::of(&header));
    let (extent, mut meshes) = plain(vertices, count("face"));
    let attributes = 12 * u64::from(layout.has_normals) + 8 * u64::from(layout.has_uvs);
    let attributes = vertices.saturating_mul(attributes);
    meshes.kept = meshes.kept.saturating_add(attributes);
    meshes.peak = meshes.peak.saturating_add(attributes);
    Some((extent, meshes))
}

/// Reads a file.
///
/// # Errors
/// What is no PLY file; a file that ends among its vertices; no face that can be rendered.
fn read(input: Input<'_>, reading: &Reading<'_>) -> Result<Object> {
    let file = input.name;
    let (reader, share) = input.into_parts();
    let mut from = BufReader::with_capacity(1 << 18, reader);
    let header = Header::read(&mut from, file)?;
    let is_text = header.encoding == header::Encoding::Ascii;
    let mut reader = Reader {
        file,
        values: Values::new(from, file, header.encoding, header.lines),
        builder: Builder::new(file, &reading.options, is_text, share),
        findings: Findings::default(),
        layout: Layout::of(&header),
        corners: Vec::new(),
    };
    if let Some(line) = header.unknown {
        let message = "a line that no PLY header has was ignored".to_string();
        reader.note("unknown-statement", Severity::Note, line, message);
    }
    reader.name_textures(&header)?;
    for element in &header.elements {
        if !reader.element(element)? {
            break;
        }
    }
    let lines = reader.values.line();
    let read = reader.builder.finish(lines, reader.findings)?;
    if header.textures.is_empty() {
        return Ok(Object::of_clay(read));
    }
    let mut findings = Findings::default();
    let mut sources = Sources::new(reading.reach);
    let names = read.material_names.clone();
    let stated = header.textures.iter().enumerate();
    let textures: HashMap<String, &(u64, String)> =
        stated.map(|(i, texture)| (texture_name(i), texture)).collect();
    let of_name = |name: &Vec<u8>| {
        let name = String::from_utf8_lossy(name).into_owned();
        let picture = textures.get(&name).map(|(line, picture)| (*line, picture.as_str()));
        of_picture(&name, picture, file, &mut sources, &mut findings)
    };
    let materials = names.iter().map(of_name).collect();
    let mut object = Object::of_mesh(read, materials);
    object.findings.append(findings);
    Ok(object)
}

/// The name of the material with a file's picture of that number.
fn texture_name(number: usize) -> String {
    format!("texture {number}")
}

/// What the elements bring, known before the first is read: faces may come before vertices.
struct Layout {
    has_normals: bool,
    has_uvs: bool,
    textures: usize,
}

impl Layout {
    fn of(header: &Header) -> Layout {
        let vertex = header.elements.iter().find(|element| element.name == "vertex");
        let has = |names: &[&str]| {
            let properties = vertex.map_or(&[] as &[Property], |vertex| &vertex.properties);
            names.iter().all(|name| properties.iter().any(|p| p.list.is_none() && p.name == *name))
        };
        Layout {
            has_normals: has(&NORMAL),
            has_uvs: UVS.iter().any(|pair| has(pair)),
            textures: header.textures.len(),
        }
    }
}

impl Layout {
    fn corner(&self, index: u32) -> Corner {
        let if_has = |has: bool| if has { index } else { NO_INDEX };
        Corner { position: index, uv: if_has(self.has_uvs), normal: if_has(self.has_normals) }
    }
}

const NORMAL: [&str; 3] = ["nx", "ny", "nz"];
/// Exporters do not agree on names.
const UVS: [[&str; 2]; 5] = [
    ["u", "v"],
    ["s", "t"],
    ["texture_u", "texture_v"],
    ["texture_s", "texture_t"],
    ["texcoord_u", "texcoord_v"],
];
