//! The grammar: statements of a block of whole logical lines.

use super::block::{Block, FaceRun, Fatal, MAX_ELEMENTS, residual};
use super::memory::{OutOfMemory, push};
use super::notes::Kind;
use super::number::{Number, number};
use crate::shape::NO_INDEX;
use std::collections::HashMap;

/// Magnitude beyond which coordinates are refused (rays could not reach them: [`crate::accel::LARGEST`]).
const LARGEST: f64 = 1e18;

/// Parses `text` into `block`, which is empty. Never fails: what stops it is in [`Block::fatal`].
pub(super) fn parse_block(text: &[u8], max_line_bytes: usize, block: &mut Block) {
    let mut parser = Parser { text, at: 0, line: 0, names: HashMap::new(), corners: Vec::new(), block };
    let fatal = parser.statements(max_line_bytes).err();
    parser.block.lines = parser.line;
    parser.block.fatal = fatal.map(|f| (parser.line, f));
}

struct Parser<'t, 'b> {
    text: &'t [u8],
    at: usize,
    /// Lines ended so far.
    line: u64,
    names: HashMap<Vec<u8>, u32>,
    corners: Vec<Corner>,
    block: &'b mut Block,
}

/// A face's corner: position, texture coordinate, normal; bit k of `relative` as in [`Block::relative`],
/// one bit for each of the three.
#[derive(Clone, Copy)]
struct Corner {
    index: [u32; 3],
    relative: u8,
}

impl From<OutOfMemory> for Fatal {
    fn from(_: OutOfMemory) -> Fatal {
        Fatal::OutOfMemory
    }
}

impl Parser<'_, '_> {
    fn statements(&mut self, max_line_bytes: usize) -> Result<(), Fatal> {
        while self.at < self.text.len() {
            let start = self.at;
            let line = self.line;
            self.statement(line)?;
            if self.at - start > max_line_bytes {
                self.line = line;
                return Err(Fatal::LineTooLong);
            }
        }
        Ok(())
    }

    #[inline(always)]
    fn peek(&self, ahead: usize) -> Option<u8> {
        self.text.get(self.at + ahead).copied()
    }

    /// Length of the line end `ahead` of here; 0 when there is none. The text's end counts as none.
    #[inline(always)]
    fn line_end(&self, ahead: usize) -> usize {
        match self.peek(ahead) {
            Some(b'\n') => 1,
            Some(b'\r') => 1 + usize::from(self.peek(ahead + 1) == Some(b'\n')),
            _ => 0,
        }
    }

    /// Skips spaces, tabs and continued line ends.
    #[inline(always)]
    fn skip_blanks(&mut self) {
        loop {
            match self.peek(0) {
                Some(b' ' | b'\t') => self.at += 1,
                Some(b'\\') if self.continues() => {}
                _ => return,
            }
        }
    }

    /// At a `\`: skips it and the line end behind it. A `\` that is the file's last byte counts.
    #[cold]
    fn continues(&mut self) -> bool {
        let end = self.line_end(1);
        let last = self.at + 1 == self.text.len();
        if end > 0 {
            self.line += 1;
        }
        self.at += if end > 0 || last { 1 + end } else { 0 };
        end > 0 || last
    }

    /// Whether a word may end `ahead` of here.
    #[inline(always)]
    fn word_ends(&self, ahead: usize) -> bool {
        match self.peek(ahead) {
            None | Some(b' ' | b'\t' | b'\n' | b'\r') => true,
            Some(b'\\') => self.line_end(ahead + 1) > 0 || self.at + ahead + 1 == self.text.len(),
            _ => false,
        }
    }

    #[inline(always)]
    fn statement(&mut self, line: u64) -> Result<(), Fatal> {
        self.skip_blanks();
        match (self.peek(0), self.peek(1)) {
            (Some(b'v'), Some(b' ')) => {
                self.at += 1;
                self.vertex(line)?;
            }
            (Some(b'f'), Some(b' ')) => {
                self.at += 1;
                self.face(line)?;
            }
            (Some(b'v'), Some(b'n')) if self.word_ends(2) => {
                self.at += 2;
                self.normal(line)?;
            }
            (Some(b'v'), Some(b't')) if self.word_ends(2) => {
                self.at += 2;
                self.uv(line)?;
            }
            (Some(b'\n' | b'\r') | None, _) => {}
            (Some(b'#'), _) => return self.skip_comment(),
            _ => self.word(line)?,
        }
        self.skip_line()
    }

    /// Skips what is left of the logical line and its end.
    #[inline(always)]
    fn skip_line(&mut self) -> Result<(), Fatal> {
        loop {
            match self.peek(0) {
                Some(b'\n') => {
                    self.at += 1;
                    self.line += 1;
                    return Ok(());
                }
                Some(b'\r') => {
                    self.at += self.line_end(0);
                    self.line += 1;
                    return Ok(());
                }
                None => return self.end_of_text(),
                Some(b'\\') if self.continues() => {}
                Some(b'#') => return self.skip_comment(),
                Some(0) => return Err(self.nul()),
                _ => self.at += 1,
            }
        }
    }

    /// At a NUL: in UTF-16 every other byte of plain text is one.
    #[cold]
    fn nul(&self) -> Fatal {
        match (self.peek(1), self.peek(2)) {
            (Some(1..), Some(0)) => Fatal::Utf16,
            _ => Fatal::Nul,
        }
    }

    /// A comment ends with its line: a `\` there is part of it (of a Windows path, most often).
    fn skip_comment(&mut self) -> Result<(), Fatal> {
        let rest = self.text.get(self.at..).unwrap_or_default();
        let length = rest.iter().position(|b| matches!(b, b'\n' | b'\r' | 0)).unwrap_or(rest.len());
        self.at += length;
        match self.peek(0) {
            Some(0) => Err(self.nul()),
            Some(_) => {
                self.at += self.line_end(0);
                self.line += 1;
                Ok(())
            }
            None => self.end_of_text(),
        }
    }

    /// A last line without an end is a line too.
    #[cold]
    fn end_of_text(&mut self) -> Result<(), Fatal> {
        self.line += 1;
        Ok(())
    }

    /// The next word as a number; `None` (and no step ahead) when it is none.
    #[inline(always)]
    fn next_number(&mut self) -> Option<Number> {
        self.skip_blanks();
        let number = number(self.text, self.at)?;
        if !self.word_ends(number.end - self.at) && !self.comment_follows(number.end) {
            return None;
        }
        self.at = number.end;
        Some(number)
    }

    /// Whether a comment touches the number before it; `1.#INF`, an old C library's infinity, is none.
    #[cold]
    fn comment_follows(&self, end: usize) -> bool {
        self.text.get(end) == Some(&b'#') && self.text.get(end.wrapping_sub(1)) != Some(&b'.')
    }

    /// Three numbers, each as f64 and f32.
    #[inline(always)]
    fn three_numbers(&mut self) -> Option<[(f64, f32); 3]> {
        let mut three = [(0.0, 0.0); 3];
        for one in &mut three {
            let number = self.next_number()?;
            *one = (number.value, number.to_f32(self.text));
        }
        Some(three)
    }

    #[inline(always)]
    fn vertex(&mut self, line: u64) -> Result<(), Fatal> {
        let mut position = [f32::NAN; 3];
        let mut residuals = [0; 3];
        match self.three_numbers() {
            Some(three) if three.iter().all(|n| n.0.abs() <= LARGEST) => {
                position = three.map(|n| n.1);
                residuals = three.map(|n| residual(n.0, n.1));
            }
            three => self.unusable_vertex(line, three.is_some()),
        }
        push(&mut self.block.positions, position)?;
        push(&mut self.block.residuals, residuals)?;
        Ok(())
    }

    /// Says why a vertex cannot be used: not finite or too large (`nan` and `inf` included), or no numbers.
    #[cold]
    fn unusable_vertex(&mut self, line: u64, numbers: bool) {
        let kind = if numbers || self.not_finite() { Kind::VertexTooLarge } else { Kind::VertexUnreadable };
        self.block.notes.add(kind, line, self.block.positions.len() as i64 + 1);
        self.block.unusable[0] = true;
    }

    /// Whether the next word is one of `str::parse`'s words for what is not finite.
    fn not_finite(&self) -> bool {
        let rest = self.text.get(self.at..).unwrap_or_default();
        let length = (0..).position(|k| self.word_ends(k)).unwrap_or(0);
        let word = rest.get(..length).and_then(|w| std::str::from_utf8(w).ok());
        word.and_then(|w| w.parse::<f64>().ok()).is_some_and(|v| !v.is_finite())
    }

    #[inline(always)]
    fn normal(&mut self, line: u64) -> Result<(), Fatal> {
        let values = self.three_numbers();
        let mut normal = values.map_or([0.0; 3], |three| three.map(|n| n.1));
        // Normals are directions: any magnitude will do, as long as its square is finite and not zero.
        let length2 = normal.iter().map(|&x| f64::from(x) * f64::from(x)).sum::<f64>();
        if !(length2 > 0.0 && length2.is_finite()) {
            let kind =
                if values.is_some() || self.not_finite() { Kind::NormalZero } else { Kind::NormalUnreadable };
            self.block.notes.add(kind, line, self.block.normals.len() as i64 + 1);
            self.block.unusable[1] = true;
            normal = [0.0; 3];
        }
        push(&mut self.block.normals, normal)?;
        Ok(())
    }

    /// One to three numbers; the third (a depth) is not used.
    #[inline(always)]
    fn uv(&mut self, line: u64) -> Result<(), Fatal> {
        let mut uv = [f32::NAN; 2];
        if let Some(u) = self.next_number() {
            uv = [u.to_f32(self.text), 0.0];
            self.skip_blanks();
            if !(self.word_ends(0) || self.peek(0) == Some(b'#')) {
                uv[1] = self.next_number().map_or(f32::NAN, |v| v.to_f32(self.text));
            }
        }
        if !uv.iter().all(|x| f64::from(x.abs()) <= LARGEST) {
            self.block.notes.add(Kind::UvUnreadable, line, self.block.uvs.len() as i64 + 1);
            self.block.unusable[2] = true;
            uv = [f32::NAN; 2];
        }
        push(&mut self.block.uvs, uv)?;
        Ok(())
    }

    #[inline(always)]
    fn face(&mut self, line: u64) -> Result<(), Fatal> {
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

    /// Every statement that is not one of the frequent four.
    #[cold]
    fn word(&mut self, line: u64) -> Result<(), Fatal> {
        let start = self.at;
        while !self.word_ends(0) {
            if self.peek(0) == Some(0) {
                return Err(self.nul());
            }
            self.at += 1;
        }
        let word = self.text.get(start..self.at).unwrap_or_default();
        let kind = match word {
            b"v" => return self.vertex(line),
            b"f" | b"fo" => return self.face(line),
            b"usemtl" => return self.use_material(line),
            b"mtllib" => return self.library(line),
            b"o" | b"g" | b"s" | b"mg" | b"vp" | b"bevel" | b"c_interp" | b"d_interp" | b"lod"
            | b"maplib" | b"usemap" | b"shadow_obj" | b"trace_obj" => return Ok(()),
            b"p" | b"l" => Kind::PointsAndLines,
            b"curv" | b"curv2" | b"surf" | b"parm" | b"trim" | b"hole" | b"scrv" | b"sp" | b"end"
            | b"con" | b"deg" | b"bmat" | b"step" | b"cstype" | b"ctech" | b"stech" | b"bsp" | b"bzp"
            | b"cdc" | b"cdp" | b"res" => Kind::FreeForm,
            b"call" | b"csh" => Kind::Command,
            _ => Kind::UnknownStatement,
        };
        self.block.notes.add(kind, line, 0);
        Ok(())
    }

    /// The rest of the logical line as bytes, blanks at both ends removed, each continuation as a space.
    fn rest_of_line(&mut self) -> Result<Vec<u8>, Fatal> {
        let mut rest = Vec::new();
        self.skip_blanks();
        while self.line_end(0) == 0 {
            match self.peek(0) {
                None => break,
                Some(0) => return Err(self.nul()),
                Some(b'\\') if self.continues() => push(&mut rest, b' ')?,
                Some(byte) => {
                    push(&mut rest, byte)?;
                    self.at += 1;
                }
            }
        }
        while let Some(b' ' | b'\t') = rest.last() {
            rest.pop();
        }
        Ok(rest)
    }

    fn use_material(&mut self, line: u64) -> Result<(), Fatal> {
        let name = self.rest_of_line()?;
        if name.is_empty() {
            self.block.notes.add(Kind::NoMaterialName, line, 0);
        }
        let next = self.names.len() as u32 + 1;
        let id = match self.names.get(&name) {
            Some(&id) => id,
            None => {
                push(&mut self.block.names, name.clone())?;
                self.names.insert(name, next);
                next
            }
        };
        self.block.materials.current = id;
        Ok(())
    }

    fn library(&mut self, line: u64) -> Result<(), Fatal> {
        let name = self.rest_of_line()?;
        if name.is_empty() {
            self.block.notes.add(Kind::NoLibraryName, line, 0);
        } else {
            push(&mut self.block.libraries, (line, name))?;
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
        super::memory::grow(&mut block.relative, missing)?;
        block.relative.resize(before, 0);
    }
    push(&mut block.relative, mask)
}
