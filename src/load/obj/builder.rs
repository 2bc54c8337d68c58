//! Meshes of other formats, by the rules of this one: polygons are split, what is wrong is skipped and counted, and
//! what lies far away is moved near, just as if the same faces stood in an OBJ file.

use super::assemble::Assembly;
use super::block::{Block, FaceRun, MAX_ELEMENTS, residual};
use super::memory::{OutOfMemory, push};
use super::notes::Kind;
use super::refuse::{cancelled, no_memory};
use super::{ObjFile, ReadOptions};
use crate::error::{Error, Finding, Findings, Result};
use crate::load::input::Share;
use crate::shape::NO_INDEX;
use std::collections::HashMap;
use std::path::Path;

/// So many elements are gathered before they join the mesh.
const BLOCK: usize = 1 << 17;

/// A corner of a face: indices from 0 into what was or will be added, [`NO_INDEX`] where there is none.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::load) struct Corner {
    pub position: u32,
    pub uv: u32,
    pub normal: u32,
}

impl Corner {
    /// A position alone.
    pub fn at(position: u32) -> Corner {
        Corner { position, uv: NO_INDEX, normal: NO_INDEX }
    }
}

/// Gathers vertices and faces in any order.
pub(in crate::load) struct Builder<'a> {
    file: &'a Path,
    options: ReadOptions<'a>,
    share: Share,
    assembly: Assembly<'a>,
    block: Block,
    /// The line that is being read, from 1; where a file has no lines, the face, from 1.
    line: u64,
    has_lines: bool,
    faces: u64,
    /// The block's ids of materials, by name.
    ids: HashMap<Vec<u8>, u32>,
    counts: [u64; 3],
}

impl<'a> Builder<'a> {
    /// An empty mesh. `has_lines`: the file is text, whose lines are told; else faces are counted.
    pub fn new(file: &'a Path, options: &ReadOptions<'a>, has_lines: bool, share: Share) -> Self {
        let most = options.max_elements.min(MAX_ELEMENTS);
        Builder {
            file,
            options: *options,
            share,
            assembly: Assembly::new(file, most, options.face_lines && has_lines),
            block: Block::default(),
            line: 1,
            has_lines,
            faces: 0,
            ids: HashMap::new(),
            counts: [0; 3],
        }
    }

    /// The line that is being read, from 1; never less than before.
    pub fn at_line(&mut self, line: u64) {
        if self.has_lines {
            self.line = self.line.max(line);
        }
    }

    /// Positions, texture coordinates and normals so far.
    pub fn counts(&self) -> [u64; 3] {
        self.counts
    }

    fn relative_line(&self) -> u64 {
        self.line.saturating_sub(1 + self.assembly.lines())
    }

    /// Adds a position: each number as f64 and rounded to f32. What is not finite or beyond 1e18 is noted, and faces
    /// that use it are skipped.
    ///
    /// # Errors
    /// Not enough memory, too many elements, cancelled.
    pub fn position(&mut self, p: [(f64, f32); 3]) -> Result<()> {
        let usable = p.iter().all(|n| n.0.abs() <= f64::from(crate::accel::LARGEST));
        let (position, residuals) = match usable {
            true => (p.map(|n| n.1), p.map(|n| residual(n.0, n.1))),
            false => ([f32::NAN; 3], [0; 3]),
        };
        self.counts[0] += 1;
        if !usable {
            self.note(Kind::VertexTooLarge);
            self.block.unusable[0] = true;
        }
        let block = &mut self.block;
        let pushed =
            push(&mut block.positions, position).and_then(|()| push(&mut block.residuals, residuals));
        self.done(pushed)
    }

    /// Adds a texture coordinate, (0, 0) at the bottom left.
    ///
    /// # Errors
    /// As [`Builder::position`].
    pub fn uv(&mut self, mut uv: [f32; 2]) -> Result<()> {
        self.counts[1] += 1;
        if !uv.iter().all(|x| x.abs() <= crate::accel::LARGEST) {
            self.note(Kind::UvUnreadable);
            self.block.unusable[2] = true;
            uv = [f32::NAN; 2];
        }
        let pushed = push(&mut self.block.uvs, uv);
        self.done(pushed)
    }

    /// Adds a normal of any length.
    ///
    /// # Errors
    /// As [`Builder::position`].
    pub fn normal(&mut self, mut normal: [f32; 3]) -> Result<()> {
        self.counts[2] += 1;
        let length2 = normal.iter().map(|&x| f64::from(x) * f64::from(x)).sum::<f64>();
        if !(length2 > 0.0 && length2.is_finite()) {
            self.note(Kind::NormalZero);
            self.block.unusable[1] = true;
            normal = [0.0; 3];
        }
        let pushed = push(&mut self.block.normals, normal);
        self.done(pushed)
    }

    #[cold]
    fn note(&mut self, kind: Kind) {
        let of_block = match kind {
            Kind::UvUnreadable => self.block.uvs.len(),
            Kind::NormalZero => self.block.normals.len(),
            _ => self.block.positions.len(),
        };
        self.block.notes.add(kind, self.relative_line(), of_block as i64 + 1);
    }

    /// The faces that follow have the material of that name.
    ///
    /// # Errors
    /// As [`Builder::position`].
    pub fn material(&mut self, name: &[u8]) -> Result<()> {
        let next = self.block.names.len() as u32 + 1;
        self.block.materials.current = match self.ids.get(name) {
            Some(&local) => local,
            None => {
                push(&mut self.block.names, name.to_vec()).map_err(|_| no_memory(self.file))?;
                self.ids.insert(name.to_vec(), next);
                next
            }
        };
        Ok(())
    }

    /// Adds a face; one of fewer than three corners is skipped.
    ///
    /// # Errors
    /// As [`Builder::position`].
    pub fn face(&mut self, corners: &[Corner]) -> Result<()> {
        self.faces += 1;
        self.block.faces += 1;
        if !self.has_lines {
            self.line = self.faces;
        }
        let line = self.relative_line();
        let [first, others @ ..] = corners else { return self.skip(Kind::FaceFewCorners, 0) };
        if others.len() < 2 {
            return self.skip(Kind::FaceFewCorners, corners.len() as i64);
        }
        // Beyond the limit an index would be taken for one that counts back.
        if let Some(beyond) = corners.iter().find(|c| u64::from(c.position) >= MAX_ELEMENTS) {
            return self.skip(Kind::FaceIndex, i64::from(beyond.position) + 1);
        }
        let block = &mut self.block;
        let mut pushed = FaceRun::add(&mut block.runs, block.triangles.len(), corners.len(), line);
        for pair in others.windows(2) {
            let [second, third] = pair else { continue };
            let corners = [first, second, third];
            pushed = pushed
                .and_then(|()| block.materials.push(block.triangles.len()))
                .and_then(|()| push(&mut block.triangles, corners.map(|c| c.position)))
                .and_then(|()| block.uv_corners.push(corners.map(|c| c.uv), &block.triangles, false))
                .and_then(|()| block.normal_corners.push(corners.map(|c| c.normal), &block.triangles, false));
        }
        self.done(pushed)
    }

    /// Adds a face with an index that no vertex has, from 0: it is skipped.
    ///
    /// # Errors
    /// As [`Builder::position`].
    pub fn face_without(&mut self, vertex: i64) -> Result<()> {
        self.faces += 1;
        self.block.faces += 1;
        if !self.has_lines {
            self.line = self.faces;
        }
        self.skip(Kind::FaceIndex, vertex.saturating_add(1))
    }

    /// Counts a face as skipped.
    #[cold]
    fn skip(&mut self, kind: Kind, detail: i64) -> Result<()> {
        self.block.notes.add(kind, self.relative_line(), detail);
        self.block.skipped += 1;
        Ok(())
    }

    #[inline]
    fn done(&mut self, pushed: Result<(), OutOfMemory>) -> Result<()> {
        pushed.map_err(|_| no_memory(self.file))?;
        let block = &self.block;
        let largest = block.positions.len().max(block.triangles.len()).max(block.uvs.len());
        if largest.max(block.normals.len()) >= BLOCK { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> Result<()> {
        if !(self.options.progress)(self.share.now()) {
            return Err(cancelled());
        }
        // The line goes on in the next block, so it is not counted yet.
        self.block.lines = self.relative_line();
        self.ids.clear();
        let current = self.block.materials.current;
        let name = current.checked_sub(1).and_then(|i| self.block.names.get(i as usize).cloned());
        self.assembly.add(std::slice::from_mut(&mut self.block))?;
        // A block takes over the material of the last triangle before it, and there may have been none yet.
        name.map_or(Ok(()), |name| self.material(&name))
    }

    /// The mesh of everything that was added, with `more` that its reader noticed. `lines`: how many the file has.
    ///
    /// # Errors
    /// As [`Builder::position`]; without [`ReadOptions::keep_empty`], no face that can be rendered.
    pub fn finish(mut self, lines: u64, more: Findings) -> Result<ObjFile> {
        self.flush()?;
        let (file, keep_empty, has_lines) = (self.file, self.options.keep_empty, self.has_lines);
        let mut read = self.assembly.finish(true)?;
        read.counts.lines = if has_lines { lines } else { 0 };
        let mut findings = if has_lines { read.findings } else { by_face(read.findings) };
        findings.append(more);
        read.findings = findings;
        match read.mesh.indices.is_empty() && !keep_empty {
            true => Err(nothing_to_render(file, &read)),
            false => Ok(read),
        }
    }
}

/// Findings of a file without lines: faces by their number, vertices tell theirs themselves.
fn by_face(findings: Findings) -> Findings {
    let mut out = Findings::default();
    for finding in findings.kept() {
        let is_face = finding.line > 0 && finding.message.starts_with("face ");
        let message = match is_face {
            true => format!("face {} (from 0): {}", finding.line - 1, finding.message),
            false => finding.message.clone(),
        };
        out.push(Finding { line: 0, message, ..finding.clone() });
    }
    for (kind, count, severity) in findings.counts() {
        out.count_more(kind, severity, count - out.count(kind));
    }
    out
}

/// Why there is nothing to render.
fn nothing_to_render(file: &Path, read: &ObjFile) -> Error {
    let counts = &read.counts;
    let (faces, skipped, vertices) = (counts.faces, counts.skipped_faces, counts.vertices);
    let why = match (faces, skipped) {
        (0, _) if vertices == 0 => "it has neither vertices nor faces".to_string(),
        (0, _) => format!("it is a cloud of {vertices} points; make a surface of them first"),
        (_, 0) => format!("none of its {faces} faces has an area"),
        _ if faces == skipped => {
            let first = read.findings.kept().find(|f| f.kind.starts_with("face-"));
            let example = first.map(|f| match f.line {
                0 => format!("; {}", f.message),
                line => format!("; line {line}: {}", f.message),
            });
            format!("all {faces} faces were skipped{}", example.unwrap_or_default())
        }
        _ => format!("{skipped} of {faces} faces were skipped, and the others have no area"),
    };
    Error::new("no renderable faces").at(file).advise(why)
}
