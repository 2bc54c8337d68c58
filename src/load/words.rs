//! A text as words with the lines they stand in, and the numbers among them.

use super::input::failed;
use super::obj::number::number;
use crate::error::{Error, Result};
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

/// A word of more bytes than this is none.
const LONGEST_WORD: usize = 1024;

/// A number, and the f32 nearest to what the file says.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Value {
    pub exact: f64,
    pub rounded: f32,
}

impl Value {
    /// What a word says that is no number.
    pub const NONE: Value = Value { exact: f64::NAN, rounded: f32::NAN };

    /// A number that f64 holds.
    pub fn of(value: impl Into<f64>) -> Value {
        let exact = value.into();
        Value { exact, rounded: exact as f32 }
    }

    /// As a number of things; `None` where it is none.
    pub fn count(self) -> Option<u64> {
        (self.exact >= 0.0 && self.exact <= f64::from(u32::MAX) && self.exact.fract() == 0.0)
            .then_some(self.exact as u64)
    }

    /// As an index from 0.
    pub fn index(self) -> Option<u32> {
        self.count().and_then(|count| u32::try_from(count).ok())
    }
}

/// The words of a text, one after the other.
pub(super) struct Words<'a, R> {
    pub from: BufReader<R>,
    file: &'a Path,
    /// The line that the last word is in, from 1.
    pub line: u64,
    /// The last word.
    pub word: Vec<u8>,
}

impl<'a, R: Read> Words<'a, R> {
    /// What `from` still holds, from line `line` on.
    pub fn new(from: BufReader<R>, file: &'a Path, line: u64) -> Self {
        Words { from, file, line, word: Vec::new() }
    }

    /// The next word as a number, [`Value::NONE`] where it is none; `None` at the end of the file.
    ///
    /// # Errors
    /// As [`Words::next`].
    pub fn number(&mut self) -> Result<Option<Value>> {
        if !self.next()? {
            return Ok(None);
        }
        if let Some(number) = number(&self.word, 0).filter(|number| number.end == self.word.len()) {
            return Ok(Some(Value { exact: number.value, rounded: number.to_f32(&self.word) }));
        }
        // `inf` is a number, though none that a vertex may have.
        let parsed = std::str::from_utf8(&self.word).ok().and_then(|word| word.parse::<f64>().ok());
        Ok(Some(parsed.map_or(Value::NONE, Value::of)))
    }

    /// Goes on to the next line.
    ///
    /// # Errors
    /// As [`Words::next`].
    pub fn skip_line(&mut self) -> Result<()> {
        loop {
            let buffer = self.from.fill_buf().map_err(|e| failed(self.file, &e))?;
            let end = buffer.iter().position(|b| *b == b'\n');
            let length = end.unwrap_or(buffer.len());
            self.from.consume(length);
            if end.is_some() || length == 0 {
                return Ok(());
            }
        }
    }

    /// Takes the next word; `false` where there is none.
    ///
    /// # Errors
    /// The system's reason; a word without end.
    pub fn next(&mut self) -> Result<bool> {
        self.word.clear();
        loop {
            let buffer = self.from.fill_buf().map_err(|e| failed(self.file, &e))?;
            if buffer.is_empty() {
                return Ok(!self.word.is_empty());
            }
            let mut at = 0;
            if self.word.is_empty() {
                at = buffer.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(buffer.len());
                let blanks = buffer.get(..at).unwrap_or_default();
                self.line += blanks.iter().filter(|b| **b == b'\n').count() as u64;
            }
            let rest = buffer.get(at..).unwrap_or_default();
            let length = rest.iter().position(u8::is_ascii_whitespace);
            let word = rest.get(..length.unwrap_or(rest.len())).unwrap_or_default();
            if self.word.len() + word.len() > LONGEST_WORD {
                return Err(Error::new("a word that is too long for a number").at(self.file).line(self.line));
            }
            self.word.extend_from_slice(word);
            let used = at + word.len();
            self.from.consume(used);
            if length.is_some() {
                return Ok(true);
            }
        }
    }
}
