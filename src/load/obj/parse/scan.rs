//! Bytes, blanks and lines: what every statement has in common.

use super::Parser;
use crate::load::obj::block::Fatal;
use crate::load::obj::memory::push;

impl Parser<'_, '_> {
    #[inline(always)]
    pub(super) fn peek(&self, ahead: usize) -> Option<u8> {
        self.text.get(self.at + ahead).copied()
    }

    /// Length of the line end `ahead` of here; 0 when there is none. The text's end counts as none.
    #[inline(always)]
    pub(super) fn line_end(&self, ahead: usize) -> usize {
        match self.peek(ahead) {
            Some(b'\n') => 1,
            Some(b'\r') => 1 + usize::from(self.peek(ahead + 1) == Some(b'\n')),
            _ => 0,
        }
    }

    /// Skips spaces, tabs and continued line ends.
    #[inline(always)]
    pub(super) fn skip_blanks(&mut self) {
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
    pub(super) fn word_ends(&self, ahead: usize) -> bool {
        match self.peek(ahead) {
            None | Some(b' ' | b'\t' | b'\n' | b'\r') => true,
            Some(b'\\') => self.line_end(ahead + 1) > 0 || self.at + ahead + 1 == self.text.len(),
            _ => false,
        }
    }

    /// Skips what is left of the logical line and its end.
    #[inline(always)]
    pub(super) fn skip_line(&mut self) -> Result<(), Fatal> {
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

    /// At a NUL: in UTF-16 every other byte of plain text is one. Only this line is asked; the next may be in
    /// another block.
    #[cold]
    pub(super) fn nul(&self) -> Fatal {
        match (self.peek(1), self.peek(2)) {
            (Some(b'\n' | b'\r'), _) => Fatal::Nul,
            (Some(1..), Some(0)) => Fatal::Utf16,
            _ => Fatal::Nul,
        }
    }

    /// A comment ends with its line: a `\` there is part of it (of a Windows path, most often).
    pub(super) fn skip_comment(&mut self) -> Result<(), Fatal> {
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

    /// The rest of the logical line as bytes, blanks at both ends removed, each continuation as a space.
    pub(super) fn rest_of_line(&mut self) -> Result<Vec<u8>, Fatal> {
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
}
