//! The file in blocks that end where a logical line ends.

use crate::error::{Error, Result};
use std::io::{ErrorKind, Read};
use std::path::Path;

/// Cuts what `from` delivers into blocks of about `block_bytes`, each a whole number of logical lines (a
/// line that a `\` continues is one with its successor). Holds one block and the tail of the one before.
pub(super) struct Source<'a, R> {
    from: R,
    file: &'a Path,
    block_bytes: usize,
    max_line_bytes: usize,
    /// The start of a line whose end has not been read yet.
    tail: Vec<u8>,
    /// Emptied buffers, to be filled again.
    spare: Vec<Vec<u8>>,
    bytes_read: u64,
    ended: bool,
}

/// Why there are no further blocks.
pub(super) enum Stop {
    /// The operating system's reason, or no memory.
    Failed(Error),
    /// The next line is longer than allowed.
    LineTooLong,
}

impl<'a, R: Read> Source<'a, R> {
    pub fn new(from: R, file: &'a Path, block_bytes: usize, max_line_bytes: usize) -> Self {
        let block_bytes = block_bytes.max(1);
        Source {
            from,
            file,
            block_bytes,
            max_line_bytes,
            tail: Vec::new(),
            spare: Vec::new(),
            bytes_read: 0,
            ended: false,
        }
    }

    /// Bytes read so far.
    pub fn bytes_read(&self) -> u64 {
        self.bytes_read
    }

    /// Takes buffers back.
    pub fn recycle(&mut self, texts: Vec<Vec<u8>>) {
        self.spare.extend(texts);
    }

    /// Up to `count` blocks (none at the end of the file), and why there will be no more of them.
    pub fn next_blocks(&mut self, count: usize) -> (Vec<Vec<u8>>, Option<Stop>) {
        let mut blocks = Vec::new();
        while blocks.len() < count {
            match self.next_block() {
                Ok(Some(block)) => blocks.push(block),
                Ok(None) => break,
                Err(stop) => return (blocks, Some(stop)),
            }
        }
        (blocks, None)
    }

    fn next_block(&mut self) -> Result<Option<Vec<u8>>, Stop> {
        let mut text = self.spare.pop().unwrap_or_default();
        text.clear();
        self.append(&mut text, None)?;
        let mut searched = 0;
        while !self.ended {
            self.append(&mut text, Some(self.block_bytes))?;
            if self.ended {
                break;
            }
            if let Some(end) = last_line_end(&text, searched) {
                let rest = text.get(end..).unwrap_or_default();
                self.tail.try_reserve(rest.len()).map_err(|_| self.no_memory())?;
                self.tail.extend_from_slice(rest);
                text.truncate(end);
                return Ok(Some(text));
            }
            if text.len() > self.max_line_bytes {
                return Err(Stop::LineTooLong);
            }
            // Two bytes back: a cut after `\`, CR, LF can only be judged with all three in sight.
            searched = text.len().saturating_sub(2);
        }
        Ok((!text.is_empty()).then_some(text))
    }

    /// Appends the kept tail (`None`) or up to that many bytes of the file.
    fn append(&mut self, text: &mut Vec<u8>, bytes: Option<usize>) -> Result<(), Stop> {
        let Some(bytes) = bytes else {
            text.try_reserve(self.tail.len() + self.block_bytes).map_err(|_| self.no_memory())?;
            text.append(&mut self.tail);
            return Ok(());
        };
        text.try_reserve(bytes).map_err(|_| self.no_memory())?;
        let before = text.len();
        loop {
            // `read_to_end` on a `Take` fills reserved memory without clearing it first, and retries EINTR.
            let missing = (bytes - (text.len() - before)) as u64;
            match self.from.by_ref().take(missing).read_to_end(text) {
                Ok(_) => break,
                Err(e) if e.kind() == ErrorKind::Interrupted => {}
                Err(e) => return Err(Stop::Failed(Error::io("read", self.file, &e))),
            }
        }
        let got = text.len() - before;
        self.ended = got < bytes;
        self.bytes_read += got as u64;
        Ok(())
    }

    fn no_memory(&self) -> Stop {
        Stop::Failed(Error::new("not enough memory to read the file").at(self.file))
    }
}

/// The end of the last logical line that ends in `text`, not before `from`. The last byte never counts
/// as an end by itself when it is a CR, since an LF may follow.
fn last_line_end(text: &[u8], from: usize) -> Option<usize> {
    let byte = |i: usize| text.get(i).copied();
    let mut end = text.len();
    while end > from {
        let ends_here = match byte(end - 1) {
            Some(b'\n') => true,
            Some(b'\r') => byte(end).is_some(),
            _ => false,
        };
        if ends_here {
            let mut content = end - 1;
            if byte(content) == Some(b'\n') && content > 0 && byte(content - 1) == Some(b'\r') {
                content -= 1;
            }
            if content == 0 || byte(content - 1) != Some(b'\\') {
                return Some(end);
            }
        }
        end -= 1;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(text: &[u8], block_bytes: usize) -> Vec<Vec<u8>> {
        let mut source = Source::new(text, Path::new("x"), block_bytes, 1 << 20);
        let (blocks, stop) = source.next_blocks(usize::MAX >> 8);
        assert!(stop.is_none());
        blocks
    }

    #[test]
    fn blocks_end_at_logical_line_ends() {
        for size in 1..40 {
            let text = b"v 1 2 3\r\nf 1 \\\r\n2 3\rv\\\n 4\n\n\\\rend";
            let blocks = cut(text, size);
            assert_eq!(blocks.concat(), text);
            for block in &blocks[..blocks.len() - 1] {
                assert_eq!(last_line_end(&[block.as_slice(), b"x"].concat(), 0), Some(block.len()), "{size}");
            }
        }
        assert_eq!(cut(b"a\nb\nc", 2), [b"a\n".to_vec(), b"b\n".to_vec(), b"c".to_vec()]);
    }
}
