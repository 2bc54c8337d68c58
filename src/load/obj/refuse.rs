//! What is refused as a whole, and how that is said.

use super::Counts;
use super::block::{Fatal, MAX_ELEMENTS};
use crate::error::{Error, Findings, Result};
use std::path::Path;

/// The error of a reading that its progress callback cancelled.
pub fn cancelled() -> Error {
    Error::new("reading the mesh was cancelled")
}

/// The longest line that is read, in bytes; beyond it a file is no text.
pub(super) const MAX_LINE_BYTES: usize = 16 << 20;

/// The error of such a line.
pub(super) fn line_too_long() -> Error {
    Error::new(format!("a line beyond the limit on line length, {} MiB", MAX_LINE_BYTES >> 20))
        .advise("is it really an OBJ file?")
}

/// The error of an allocation that failed.
pub(super) fn no_memory(file: &Path) -> Error {
    Error::new("not enough memory for the mesh")
        .at(file)
        .advise("use a machine with more memory, or split the mesh")
}

/// Refuses more elements than `limit`, [`MAX_ELEMENTS`] or less.
pub(super) fn check_limit(what: &str, count: u64, limit: u64) -> Result<()> {
    if count <= limit {
        return Ok(());
    }
    let why = if limit == MAX_ELEMENTS { " (2^32/3, 16 GiB)" } else { "" };
    Err(Error::new(format!("more than {limit} {what}{why} in one mesh"))
        .advise("split the file into several meshes of one scene"))
}

/// The error of a block that could not be read to its end; `line` is the file's.
pub(super) fn fatal_error(fatal: Fatal, file: &Path, line: u64) -> Error {
    match fatal {
        Fatal::Nul => Error::new("a NUL byte: this is no text file").advise("is it really an OBJ file?"),
        Fatal::Utf16 => {
            Error::new("looks like UTF-16").advise("convert it to UTF-8: iconv -f UTF-16 -t UTF-8 IN > OUT")
        }
        Fatal::LineTooLong => line_too_long(),
        Fatal::OutOfMemory => return no_memory(file),
    }
    .at(file)
    .line(line)
}

/// Why there is nothing to render: an empty picture would be a lie.
pub(super) fn no_faces(file: &Path, counts: &Counts, findings: &Findings) -> Error {
    let (faces, skipped) = (counts.faces, counts.skipped_faces);
    let why = if counts.lines == 0 {
        "the file is empty".to_string()
    } else if faces == 0 {
        format!("it has {} vertices and not one `f` statement", counts.vertices)
    } else if skipped == faces {
        let first = findings.kept().filter(|f| f.line > 0).min_by_key(|f| f.line);
        let example = first.map(|f| format!("; line {}: {}", f.line, f.message)).unwrap_or_default();
        format!("all {faces} faces were skipped{example}")
    } else if skipped == 0 {
        format!("none of its {faces} faces has an area")
    } else {
        format!("{skipped} of {faces} faces were skipped, and the others have no area")
    };
    Error::new("no renderable faces").at(file).advise(why)
}
