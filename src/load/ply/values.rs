//! The numbers behind the header, one after the other: words of a text, or bytes in either order.

use super::header::{Encoding, Type};
use crate::error::{Error, Result};
use crate::load::input::failed;
use crate::load::words::{Value, Words};
use std::io::{BufRead, BufReader, Read};
use std::path::Path;

/// Numbers in the order of the file.
pub(super) struct Values<'a, R> {
    words: Words<'a, R>,
    file: &'a Path,
    encoding: Encoding,
}

impl<'a, R: Read> Values<'a, R> {
    /// What follows a header of `lines` lines.
    pub fn new(from: BufReader<R>, file: &'a Path, encoding: Encoding, lines: u64) -> Self {
        Values { words: Words::new(from, file, lines + 1), file, encoding }
    }

    /// The line of the last number; 0 in a binary file.
    pub fn line(&self) -> u64 {
        if self.encoding == Encoding::Ascii { self.words.line } else { 0 }
    }

    /// The next number of that type; `None` at the end of the file.
    ///
    /// # Errors
    /// The system's reason; a word that is no number.
    #[inline]
    pub fn next(&mut self, kind: Type) -> Result<Option<Value>> {
        let big = self.encoding == Encoding::BigEndian;
        macro_rules! read {
            ($type:ty) => {
                self.bytes()?.map(|b| if big { <$type>::from_be_bytes(b) } else { <$type>::from_le_bytes(b) })
            };
        }
        if self.encoding == Encoding::Ascii {
            return self.text();
        }
        Ok(match kind {
            Type::I8 => read!(i8).map(Value::of),
            Type::U8 => read!(u8).map(Value::of),
            Type::I16 => read!(i16).map(Value::of),
            Type::U16 => read!(u16).map(Value::of),
            Type::I32 => read!(i32).map(Value::of),
            Type::U32 => read!(u32).map(Value::of),
            Type::F32 => read!(f32).map(|x| Value { exact: f64::from(x), rounded: x }),
            Type::F64 => read!(f64).map(|x| Value { exact: x, rounded: x as f32 }),
        })
    }

    /// A word that is no number is an error: what follows would be taken for something else.
    fn text(&mut self) -> Result<Option<Value>> {
        let value = self.words.number()?;
        let is_none = value.is_some_and(|value| value.exact.is_nan());
        if is_none && !self.words.word.eq_ignore_ascii_case(b"nan") && !self.words.word.ends_with(b"nan") {
            return Err(Error::new("not a number").at(self.file).line(self.words.line));
        }
        Ok(value)
    }

    #[inline]
    fn bytes<const N: usize>(&mut self) -> Result<Option<[u8; N]>> {
        if let Some(bytes) = self.words.from.buffer().first_chunk().copied() {
            self.words.from.consume(N);
            return Ok(Some(bytes));
        }
        self.bytes_between()
    }

    /// Bytes that are in two buffers.
    #[cold]
    fn bytes_between<const N: usize>(&mut self) -> Result<Option<[u8; N]>> {
        let mut bytes = [0; N];
        match self.words.from.read_exact(&mut bytes) {
            Ok(()) => Ok(Some(bytes)),
            Err(e) if e.kind() == std::io::ErrorKind::UnexpectedEof => Ok(None),
            Err(e) => Err(failed(self.file, &e)),
        }
    }
}
