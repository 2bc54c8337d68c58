//! The OBJ reader.
//!
//! Wavefront OBJ as it is found in the wild: written by scanners, photogrammetry, CAD and thirty years of
//! exporters, up to hundreds of millions of lines. Polygons only; free-form curves are left out.
//!
//! The file is read in blocks that end at line ends. While one batch of blocks is read, the one before is
//! parsed and the one before that joined to the mesh, all in parallel; so memory is bounded by the mesh
//! and two batches. The result, findings and line numbers included, does not depend on the number of
//! threads or the size of the blocks.
//!
//! - **One mesh** with a material id a face, however often `usemtl` changes; `o`, `g` and `s` are ignored.
//! - **Numbers** are exact: positions are the f32s nearest to the decimals in the file. Where they lie so
//!   far from the origin that f32 would lose the shape, the mesh is moved near it ([`ObjFile::origin`]).
//! - **Indices** may be negative (relative) and may point forward.
//! - **Polygons** of any shape are triangulated.
//! - **What is wrong** is skipped, counted and reported by line ([`ObjFile::findings`]); nothing that is
//!   not finite or out of range gets into the mesh. Only text that is none (NUL bytes, UTF-16, endless
//!   lines), too much of it, or a file without any face is an error.
//! - Names are bytes, since old exporters write Latin-1 and Shift-JIS.
//!
//! ```no_run
//! use drt::load::obj::{ReadOptions, read};
//! let bunny = read("bunny.obj".as_ref(), &ReadOptions::default())?;
//! println!("{} triangles", bunny.mesh.indices.len());
//! # Ok::<(), drt::error::Error>(())
//! ```

mod assemble;
mod block;
pub(super) mod builder;
mod cleanup;
mod corners;
mod faces;
pub(super) mod forecast;
mod memory;
mod notes;
pub(super) mod number;
mod parse;
mod recenter;
mod refuse;
mod source;
mod triangulate;

use crate::error::{Findings, Result};
use crate::math::DVec3;
use crate::shape::Mesh;
use assemble::Assembly;
use block::{Block, MAX_ELEMENTS};
pub(super) use notes::kind_of_finding;
use rayon::prelude::*;
pub use refuse::cancelled;
use refuse::{MAX_LINE_BYTES, line_too_long};
use source::{Source, Stop};
use std::io::Read;
use std::path::Path;

/// How a file is read.
#[derive(Clone, Copy)]
pub struct ReadOptions<'a> {
    /// Called now and then on the reading thread with the share done (0 to 1); `false` cancels the reading,
    /// which then fails with [`cancelled`].
    pub progress: &'a (dyn Fn(f64) -> bool + Sync),
    /// Bytes in a block; twice as many blocks as there are threads are in memory at a time.
    pub block_bytes: usize,
    /// The longest line in bytes, continuation included, before the file is taken for something else.
    pub max_line_bytes: usize,
    /// The most vertices, normals, texture coordinates or triangles of a mesh: at most (and by default) 2³²/3, what
    /// indices and Embree's buffers can address.
    pub max_elements: u64,
    /// Whether a file without any renderable face gives an empty mesh (so that its findings can be shown)
    /// instead of an error.
    pub keep_empty: bool,
    /// Whether each triangle's line is kept ([`ObjFile::face_lines`]); four bytes a triangle.
    pub face_lines: bool,
}

impl Default for ReadOptions<'_> {
    fn default() -> Self {
        ReadOptions {
            progress: &|_| true,
            block_bytes: 1 << 20,
            max_line_bytes: MAX_LINE_BYTES,
            max_elements: MAX_ELEMENTS,
            keep_empty: false,
            face_lines: false,
        }
    }
}

/// An OBJ file as one mesh.
#[derive(Clone, Debug)]
pub struct ObjFile {
    /// The mesh, relative to `origin`; its material ids are indices into `material_names`.
    pub mesh: Mesh,
    /// Mesh coordinates + origin = file coordinates. Zero unless the mesh is more than half its own
    /// size away from the file's origin; then a multiple of a power of two near the mesh's centre.
    pub origin: DVec3,
    /// Names after `usemtl` in the order they first appear; the empty name is the default material of
    /// faces without any. Bytes: the file says not in which encoding.
    pub material_names: Vec<Vec<u8>>,
    /// The `mtllib` statements.
    pub libraries: Vec<Library>,
    /// What was skipped or replaced.
    pub findings: Findings,
    /// What the file held.
    pub counts: Counts,
    /// The 1-based line of each triangle's `f` statement, if [`ReadOptions::face_lines`] asked for it; 0 beyond
    /// 2³² lines.
    pub face_lines: Option<Vec<u32>>,
}

/// A `mtllib` statement.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Library {
    /// Its line in the file, from 1.
    pub line: u64,
    /// Everything after the keyword: one name with spaces, or several names.
    pub names: Vec<u8>,
}

/// What a file held.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Counts {
    /// Physical lines.
    pub lines: u64,
    /// `v` statements.
    pub vertices: u64,
    /// `vt` statements.
    pub uvs: u64,
    /// `vn` statements.
    pub normals: u64,
    /// `f` statements.
    pub faces: u64,
    /// Faces left out because something is wrong with them.
    pub skipped_faces: u64,
    /// Triangles of the other faces, before those without area and copies were dropped.
    pub triangles: u64,
    /// Triangles dropped because they have no area.
    pub zero_area: u64,
    /// Triangles dropped because an earlier one has the same corners, winding and material.
    pub duplicates: u64,
}

/// Reads the regular file `path`.
///
/// # Errors
/// The file cannot be opened or read, is no text, has a line beyond the limit, more elements than 32-bit
/// indices address, no renderable face; there is not enough memory; the callback cancelled.
pub fn read(path: &Path, options: &ReadOptions<'_>) -> Result<ObjFile> {
    let (file, bytes) = super::open::open_regular(path)?;
    read_from(file, path, Some(bytes), options)
}

/// Reads from `from`. `name` is what messages call it, `bytes` its length where known (for progress).
///
/// # Errors
/// As [`read`].
pub fn read_from<R: Read + Send>(
    from: R,
    name: &Path,
    bytes: Option<u64>,
    options: &ReadOptions<'_>,
) -> Result<ObjFile> {
    let mut source = Source::new(from, name, options.block_bytes, options.max_line_bytes);
    let mut assembly = Assembly::new(name, options.max_elements.min(MAX_ELEMENTS), options.face_lines);
    let blocks_at_once = rayon::current_num_threads().max(1);
    let mut spare: Vec<Block> = Vec::new();
    let (mut texts, mut stop) = source.next_blocks(blocks_at_once);
    remove_mark(texts.first_mut());
    let mut parsed: Vec<Block> = Vec::new();
    // A pipeline of three stages: batch n+1 is read, batch n parsed, batch n−1 joined to the mesh.
    while !(texts.is_empty() && parsed.is_empty()) {
        let share = bytes.map_or(0.0, |total| source.bytes_read() as f64 / total.max(1) as f64);
        if !(options.progress)(share.min(1.0)) {
            return Err(cancelled());
        }
        let mut parsing: Vec<Block> = texts.iter().map(|_| spare.pop().unwrap_or_default()).collect();
        let (added, next) = rayon::join(
            || assembly.add(&mut parsed),
            || {
                let next =
                    || if stop.is_none() { source.next_blocks(blocks_at_once) } else { Default::default() };
                rayon::join(next, || parse_all(&texts, &mut parsing, options.max_line_bytes)).0
            },
        );
        added?;
        spare.append(&mut parsed);
        parsed = parsing;
        source.recycle(std::mem::replace(&mut texts, next.0));
        stop = stop.or(next.1);
    }
    match stop {
        Some(Stop::Failed(error)) => Err(error),
        Some(Stop::LineTooLong) => Err(line_too_long().at(name).line(assembly.lines() + 1)),
        None => assembly.finish(options.keep_empty),
    }
}

fn parse_all(texts: &[Vec<u8>], blocks: &mut [Block], max_line_bytes: usize) {
    texts
        .par_iter()
        .zip(blocks)
        .with_max_len(1)
        .for_each(|(text, block)| parse::parse_block(text, max_line_bytes, block));
}

/// Removes the byte-order mark that some editors put before UTF-8.
fn remove_mark(start: Option<&mut Vec<u8>>) {
    const MARK: &[u8] = b"\xef\xbb\xbf";
    if let Some(text) = start.filter(|text| text.starts_with(MARK)) {
        text.drain(..MARK.len());
    }
}

#[cfg(test)]
mod tests;
