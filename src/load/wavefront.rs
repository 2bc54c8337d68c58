//! OBJ files with their material libraries, one of the formats of [`super::format`].

use super::format::{Format, Reading};
use super::input::Input;
use super::materials::MaterialSpec;
use super::object::Object;
use super::texture::{self, Search};
use super::{auto, classic, mtl, obj};
use crate::error::Result;

/// Wavefront OBJ.
pub(super) const FORMAT: Format = Format {
    name: "obj",
    meaning: "Wavefront OBJ with its material libraries (.mtl)",
    extensions: &["obj"],
    begins: is_text,
    forecast: obj::forecast::forecast,
    read,
};

/// OBJ has no signature: a statement or a comment must stand at the beginning.
fn is_text(head: &[u8]) -> bool {
    let head = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(head);
    let head = head.trim_ascii_start();
    let word = head.split(u8::is_ascii_whitespace).next().unwrap_or_default();
    let known: [&[u8]; 10] = [b"v", b"vt", b"vn", b"f", b"o", b"g", b"s", b"mtllib", b"usemtl", b"vp"];
    !head.contains(&0) && (head.starts_with(b"#") || known.contains(&word))
}

/// Reads a file and the material libraries that it names; a missing library or material is a finding, and its faces
/// are clay.
///
/// # Errors
/// As [`obj::read`].
fn read(input: Input<'_>, reading: &Reading<'_>) -> Result<Object> {
    let name = input.name;
    let (reader, share) = input.into_parts();
    let progress = |_| (reading.options.progress)(share.now());
    let options = obj::ReadOptions { progress: &progress, ..reading.options };
    let parse = || obj::read_from(reader, name, None, &options);
    let is_usual = !options.keep_empty && !options.face_lines;
    let read = match reading.cache.filter(|_| is_usual).zip(share.file()) {
        Some((cache, file)) => {
            let unpacked = reading.opening.max_unpacked.unwrap_or(u64::MAX);
            let limits = [options.max_line_bytes as u64, options.max_elements, unpacked];
            cache.through((name, file), &limits, options.progress, parse)?
        }
        None => parse()?,
    };
    let resolved = mtl::resolve(name, &read.libraries, &read.material_names, reading.defined, reading.reach);
    let mut findings = read.findings;
    findings.append(resolved.findings);
    let mut search = Search::new(reading.reach);
    let definitions = resolved.materials.iter().map(Option::as_ref).chain(std::iter::repeat(None));
    let materials = read.material_names.iter().zip(definitions).map(|(name, definition)| {
        let name = String::from_utf8_lossy(name).into_owned();
        match definition {
            None => MaterialSpec::diffuse(name, auto::CLAY),
            Some(m) => texture::of_mtl(&name, m, classic::from_mtl, &mut search, &mut findings),
        }
    });
    let materials = materials.collect();
    Ok(Object {
        mesh: read.mesh,
        origin: read.origin,
        materials,
        findings,
        skipped_faces: read.counts.skipped_faces,
        libraries: resolved.libraries,
        defined: resolved.defined,
        definitions: resolved.materials,
        counts: read.counts,
        face_lines: read.face_lines,
        parts: Vec::new(),
        camera: None,
        lights: Vec::new(),
    })
}
