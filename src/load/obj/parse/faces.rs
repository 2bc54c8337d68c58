//! `f`: corners, their indices, and the fan of triangles that they first become.

use super::Parser;
use crate::load::obj::block::{Block, FaceRun, Fatal, MAX_ELEMENTS};
use crate::load::obj::memory::{OutOfMemory, grow, push};
use crate::load::obj::notes::Kind;
use crate::shape::NO_INDEX;

/// A face's corner: position, texture coordinate, normal; bit k of `relative` as in [`Block::relative`],
/// one bit for each of the three.
#[derive(Clone, Copy)]
pub(super) struct Corner {
    index: [u32; 3],
    relative: u8,
}

impl Parser<'_, '_> {
    #[inline(always)]
    pub(super) fn face(&mut self, line: u64) -> Result<(), Fatal> {
        self.corners.clear();
        self.block.faces += 1;
        loop {
            self.skip_blanks();
            match self.peek(0) {
                None | Some(b'\n' | b'\r' | b'#') => break,
                _ => {}
            }
            match self.corner(line) {
                Ok(corner) => push(&mut self.corners, corner)?,
                Err((kind, detail)) => {
                    self.skip_face(kind, line, detail);
                    return Ok(());
                }
            }
        }
        if self.corners.len() < 3 {
            self.skip_face(Kind::FaceFewCorners, line, self.corners.len() as i64);
            return Ok(());
        }
        self.emit_face(line)?;
        Ok(())
    }

    #[cold]
    fn skip_face(&mut self, kind: Kind, line: u64, detail: i64) {
        self.block.notes.add(kind, line, detail);
        self.block.skipped += 1;
    }

    /// `v`, `v/vt`, `v//vn`, `v/vt/vn`; an index may be missing behind its slash (`v/`, `v/vt/`).
    #[inline(always)]
    fn corner(&mut self, line: u64) -> Result<Corner, (Kind, i64)> {
        let malformed = (Kind::FaceMalformed, self.corners.len() as i64 + 1);
        let mut corner = Corner { index: [NO_INDEX; 3], relative: 0 };
        for part in 0..3 {
            match self.index() {
                Some(stated) => self.resolve(stated, part, line, &mut corner)?,
                None if part == 0 => return Err(malformed),
                None => {}
            }
            if self.peek(0) != Some(b'/') {
                break;
            }
            if part < 2 {
                self.at += 1;
            }
        }
        let ends = self.word_ends(0) || self.peek(0) == Some(b'#');
        if ends { Ok(corner) } else { Err(malformed) }
    }

    /// An index as it stands, saturated beyond any that can be right.
    #[inline(always)]
    fn index(&mut self) -> Option<i64> {
        let (sign, signed) = match self.peek(0) {
            Some(b'-') => (-1, 1),
            Some(b'+') => (1, 1),
            _ => (1, 0),
        };
        let start = self.at + signed;
        let mut end = start;
        let mut value = 0u64;
        while let Some(byte) = self.text.get(end) {
            let digit = byte.wrapping_sub(b'0');
            if digit > 9 {
                break;
            }
            // Beyond the limit the value only has to stay there (row A2: 2^32+1 is not 1).
            value = if value > MAX_ELEMENTS { value } else { value * 10 + u64::from(digit) };
            end += 1;
        }
        if end == start {
            return None;
        }
        self.at = end;
        Some(sign * value as i64)
    }

    /// Turns a stated index into one from 0, or one relative to the block's first element.
    #[inline(always)]
    fn resolve(
        &mut self,
        stated: i64,
        part: usize,
        line: u64,
        corner: &mut Corner,
    ) -> Result<(), (Kind, i64)> {
        if stated > 0 && stated as u64 <= MAX_ELEMENTS {
            corner.index[part] = (stated - 1) as u32;
        } else if stated < 0 && stated.unsigned_abs() <= MAX_ELEMENTS {
            let here = match part {
                0 => self.block.positions.len(),
                1 => self.block.uvs.len(),
                _ => self.block.normals.len(),
            };
            // Between −2³²/3 and the block's count: fits an i32.
            corner.index[part] = (here as i64 + stated) as i32 as u32;
            corner.relative |= 1 << part;
        } else {
            match part {
                0 => return Err((Kind::FaceIndex, stated)),
                1 => self.block.notes.add(Kind::UvIndex, line, stated),
                _ => self.block.notes.add(Kind::NormalIndex, line, stated),
            }
        }
        Ok(())
    }

    /// Adds the face as a fan around its first corner; [`super::faces`] corrects that where it is wrong.
    #[inline(always)]
    fn emit_face(&mut self, line: u64) -> Result<(), OutOfMemory> {
        let block = &mut *self.block;
        let [first, others @ ..] = self.corners.as_slice() else { return Ok(()) };
        FaceRun::add(&mut block.runs, block.triangles.len(), self.corners.len(), line)?;
        for pair in others.windows(2) {
            let [second, third] = pair else { continue };
            let corners = [first, second, third];
            let of = |part: usize| corners.map(|c| c.index[part]);
            block.materials.push(block.triangles.len())?;
            push(&mut block.triangles, of(0))?;
            let relative = first.relative | second.relative | third.relative;
            block.uv_corners.push(of(1), &block.triangles, relative != 0)?;
            block.normal_corners.push(of(2), &block.triangles, relative != 0)?;
            if relative != 0 || !block.relative.is_empty() {
                push_relative(block, corners.map(|c| c.relative))?;
            }
        }
        Ok(())
    }
}

/// Marks the last triangle's relative indices; three bits a corner become three a kind of index.
fn push_relative(block: &mut Block, corners: [u8; 3]) -> Result<(), OutOfMemory> {
    let mut mask = 0u16;
    for (corner, bits) in corners.into_iter().enumerate() {
        for part in 0..3 {
            mask |= u16::from(bits >> part & 1) << (3 * part + corner);
        }
    }
    let before = block.triangles.len().saturating_sub(1);
    if block.relative.len() < before {
        let missing = before - block.relative.len();
        grow(&mut block.relative, missing)?;
        block.relative.resize(before, 0);
    }
    push(&mut block.relative, mask)
}
