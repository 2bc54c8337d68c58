//! The grammar: statements of a block of whole logical lines.

mod faces;
mod scan;
mod values;

use super::block::{Block, Fatal};
use super::memory::{OutOfMemory, push};
use super::notes::Kind;
use faces::Corner;
use std::collections::HashMap;

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
