//! STL: facets and nothing else, as text or as bytes; what printers and CAD speak.
//!
//! Corners at exactly the same place become one vertex, so that surfaces hang together again. Facet normals are those
//! of the corners, whatever the file says; colours in attribute bytes are left out.

use super::format::{Format, Reading};
use super::input::{Input, failed, no_memory};
use super::obj::builder::{Builder, Corner};
use super::obj::forecast::plain;
use super::object::Object;
use super::words::{Value, Words};
use crate::accel::need::Extent;
use crate::error::{Error, Finding, Findings, Result, Severity};
use crate::scene::need::Meshes;
use std::collections::HashMap;
use std::fs::File;
use std::io::{BufReader, ErrorKind, Read};
use std::os::unix::fs::FileExt;
use std::path::Path;

/// The format.
pub(super) const FORMAT: Format =
    Format { name: "stl", meaning: "STL, as text and binary", extensions: &["stl"], begins, forecast, read };

/// Bytes before the facets: anything, and their number.
const HEADER: usize = 84;

/// Bytes of a facet: a normal, three corners, two bytes of attributes.
const FACET: usize = 50;

/// Bytes of a facet in words: some 130 of words, 12 numbers.
const FACET_OF_WORDS: u64 = 250;

/// Bytes of the table of vertices, a vertex.
const TABLE: u64 = 40;

/// Binary STL has no signature: facets of usable numbers must follow a number of facets.
fn begins(head: &[u8]) -> bool {
    let facets = head.get(HEADER..).unwrap_or_default().chunks_exact(FACET);
    let is_usable = |facet: &[u8]| corners(facet).iter().flatten().all(|x| x.abs() <= crate::accel::LARGEST);
    let count = stated_count(head).unwrap_or(0) as usize;
    is_text(head) || head.contains(&0) && (1..=count).contains(&facets.len()) && facets.clone().all(is_usable)
}

/// Closed surfaces have half as many vertices as triangles.
fn forecast(file: &File, bytes: u64) -> Option<(Extent, Meshes)> {
    let mut head = [0; HEADER];
    file.read_exact_at(&mut head, 0).ok()?;
    let facet = if is_text(&head) { FACET_OF_WORDS } else { FACET as u64 };
    let (triangles, vertices) = (bytes / facet, bytes / facet / 2);
    let (extent, mut meshes) = plain(vertices, triangles);
    meshes.peak = meshes.peak.saturating_add(TABLE * vertices);
    Some((extent, meshes))
}

/// Binary files may begin with "solid" too; but the bytes of numbers are no letters.
fn is_text(head: &[u8]) -> bool {
    let word = head.trim_ascii_start().get(..5).unwrap_or_default();
    let is_letter = |b: &u8| !b.is_ascii_control() || b.is_ascii_whitespace();
    word.eq_ignore_ascii_case(b"solid") && head.iter().all(is_letter)
}

fn stated_count(header: &[u8]) -> Option<u32> {
    header.get(80..)?.first_chunk().copied().map(u32::from_le_bytes)
}

/// The corners of a binary facet.
fn corners(facet: &[u8]) -> [[f32; 3]; 3] {
    let number = |i: usize| facet.get(12 + 4 * i..).and_then(|rest| rest.first_chunk().copied());
    let number = |i: usize| number(i).map_or(f32::NAN, f32::from_le_bytes);
    std::array::from_fn(|corner| std::array::from_fn(|axis| number(3 * corner + axis)))
}

/// Reads a file.
///
/// # Errors
/// What is no STL file; no facet that can be rendered; not enough memory.
fn read(input: Input<'_>, reading: &Reading<'_>) -> Result<Object> {
    let (file, is_text) = (input.name, is_text(&input.head));
    let (reader, share) = input.into_parts();
    let builder = Builder::new(file, &reading.options, is_text, share);
    let mut facets = Facets { file, builder, seen: HashMap::new(), findings: Findings::default() };
    let from = BufReader::with_capacity(1 << 18, reader);
    let lines = if is_text { facets.text(from)? } else { facets.binary(from)? };
    facets.builder.finish(lines, facets.findings).map(Object::of_clay)
}

/// The mesh as it grows.
struct Facets<'a> {
    file: &'a Path,
    builder: Builder<'a>,
    /// Vertices by the bits of their coordinates.
    seen: HashMap<[u32; 3], u32>,
    findings: Findings,
}

impl Facets<'_> {
    fn binary(&mut self, mut from: impl Read) -> Result<u64> {
        let mut header = [0; HEADER];
        from.read_exact(&mut header).map_err(|e| match e.kind() {
            ErrorKind::UnexpectedEof => {
                Error::new("shorter than the header of a binary STL file").at(self.file)
            }
            _ => failed(self.file, &e),
        })?;
        let count = stated_count(&header).unwrap_or(0);
        for i in 0..count {
            let mut facet = [0; FACET];
            match from.read_exact(&mut facet) {
                Ok(()) => {}
                Err(e) if e.kind() == ErrorKind::UnexpectedEof => {
                    self.truncated(0, format!("the file ends after {i} of {count} facets"));
                    break;
                }
                Err(e) => return Err(failed(self.file, &e)),
            }
            let [a, b, c] = corners(&facet).map(|corner| corner.map(Value::of));
            let triangle = [self.vertex(a)?, self.vertex(b)?, self.vertex(c)?];
            self.builder.face(&triangle.map(Corner::at))?;
        }
        Ok(0)
    }

    /// Several solids may follow each other; the words between the corners' numbers are not needed.
    fn text(&mut self, from: BufReader<impl Read>) -> Result<u64> {
        let mut words = Words::new(from, self.file, 1);
        let mut corners: Vec<Corner> = Vec::new();
        while words.next()? {
            self.builder.at_line(words.line);
            let word = words.word.to_ascii_lowercase();
            match word.as_slice() {
                b"solid" | b"endsolid" => words.skip_line()?,
                b"outer" => corners.clear(),
                b"vertex" => {
                    let mut vertex = [Value::NONE; 3];
                    for number in &mut vertex {
                        *number = words.number()?.unwrap_or(Value::NONE);
                    }
                    corners.try_reserve(1).map_err(|_| no_memory(self.file))?;
                    corners.push(Corner::at(self.vertex(vertex)?));
                }
                b"endloop" => {
                    self.builder.face(&corners)?;
                    corners.clear();
                }
                _ => {}
            }
        }
        if !corners.is_empty() {
            self.truncated(words.line, "the file ends within a facet".to_string());
        }
        Ok(words.line)
    }

    /// The index of a vertex at that place. What is no place is a vertex of its own, whose facet is skipped.
    fn vertex(&mut self, p: [Value; 3]) -> Result<u32> {
        // Adding zero makes −0 the 0 it equals.
        let bits = p.map(|x| (x.rounded + 0.0).to_bits());
        if let Some(index) = self.seen.get(&bits) {
            return Ok(*index);
        }
        let index = self.builder.counts()[0] as u32;
        self.builder.position(p.map(|x| (x.exact, x.rounded)))?;
        if p.iter().all(|x| x.rounded.is_finite()) {
            self.seen.try_reserve(1).map_err(|_| no_memory(self.file))?;
            self.seen.insert(bits, index);
        }
        Ok(index)
    }

    fn truncated(&mut self, line: u64, message: String) {
        let (file, kind, severity) = (self.file.to_path_buf(), "file-truncated", Severity::Error);
        self.findings.push(Finding { file, line, kind, message, severity });
    }
}

#[cfg(test)]
mod tests;
