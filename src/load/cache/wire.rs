//! Numbers and lists to a file and back: little-endian, a digest of all of it at the end.
//!
//! A [`Source`] trusts nothing: a list is as long as the rest of the file at most, so what is damaged costs neither
//! memory nor time, and no value counts before [`Source::finish`] has found the digest right.

use super::Key;
use crate::memory;
use std::fs::{File, OpenOptions};
use std::io::{self, BufReader, Read, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

/// Bytes that are handled at a time.
const PIECE: usize = 1 << 18;
/// Bytes of the digest.
const DIGEST: u64 = 32;

/// Why a file is of no use.
pub(super) type Problem = String;

/// Writes.
pub(super) struct Sink<'a> {
    to: &'a mut File,
    hasher: blake3::Hasher,
    buffer: Vec<u8>,
}

impl<'a> Sink<'a> {
    pub fn new(to: &'a mut File, magic: [u8; 8]) -> io::Result<Sink<'a>> {
        let mut sink = Sink { to, hasher: blake3::Hasher::new(), buffer: Vec::with_capacity(2 * PIECE) };
        sink.bytes(&magic)?;
        Ok(sink)
    }

    pub fn bytes(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.buffer.extend_from_slice(bytes);
        if self.buffer.len() >= PIECE { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.hasher.update(&self.buffer);
        self.to.write_all(&self.buffer)?;
        self.buffer.clear();
        Ok(())
    }

    pub fn number(&mut self, number: u64) -> io::Result<()> {
        self.bytes(&number.to_le_bytes())
    }

    /// Bytes with their number.
    pub fn text(&mut self, text: &[u8]) -> io::Result<()> {
        self.number(text.len() as u64)?;
        self.bytes(text)
    }

    /// A list with its length.
    pub fn list<T: Copy, const N: usize>(
        &mut self,
        list: &[[T; N]],
        to: impl Fn(T) -> [u8; 4],
    ) -> io::Result<()> {
        self.number(list.len() as u64)?;
        for piece in list.as_flattened().chunks(PIECE / 4) {
            self.buffer.extend(piece.iter().flat_map(|&value| to(value)));
            self.flush()?;
        }
        Ok(())
    }

    /// Numbers without their number.
    pub fn numbers(&mut self, numbers: &[u32]) -> io::Result<()> {
        self.buffer.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
        if self.buffer.len() >= PIECE { self.flush() } else { Ok(()) }
    }

    pub fn finish(mut self) -> io::Result<()> {
        self.flush()?;
        self.to.write_all(self.hasher.finalize().as_bytes())
    }
}

/// Reads.
pub(super) struct Source {
    from: BufReader<File>,
    hasher: blake3::Hasher,
    /// Bytes before the digest that were not read yet.
    left: u64,
}

impl Source {
    /// `None` where there is no such file.
    pub fn open(path: &Path, magic: [u8; 8]) -> Result<Option<Source>, Problem> {
        let flags = rustix::fs::OFlags::NONBLOCK | rustix::fs::OFlags::NOFOLLOW;
        let file = match OpenOptions::new().read(true).custom_flags(flags.bits() as i32).open(path) {
            Ok(file) => file,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Ok(None),
            Err(_) => return Err("cannot be opened".to_string()),
        };
        let about = file.metadata().map_err(|_| "cannot be read".to_string())?;
        if !about.is_file() {
            return Err("is no regular file".to_string());
        }
        let left = about.len().checked_sub(DIGEST).ok_or("is cut short")?;
        let from = BufReader::with_capacity(PIECE, file);
        let mut source = Source { from, hasher: blake3::Hasher::new(), left };
        let mut found = [0; 8];
        source.fill(&mut found)?;
        if found != magic { Err("is of another kind or version".to_string()) } else { Ok(Some(source)) }
    }

    fn fill(&mut self, bytes: &mut [u8]) -> Result<(), Problem> {
        self.left = self.left.checked_sub(bytes.len() as u64).ok_or("is cut short")?;
        self.from.read_exact(bytes).map_err(|_| "cannot be read".to_string())?;
        self.hasher.update(bytes);
        Ok(())
    }

    pub fn number(&mut self) -> Result<u64, Problem> {
        let mut bytes = [0; 8];
        self.fill(&mut bytes)?;
        Ok(u64::from_le_bytes(bytes))
    }

    pub fn key(&mut self) -> Result<Key, Problem> {
        let mut key = [0; 32];
        self.fill(&mut key)?;
        Ok(key)
    }

    /// How many elements of `bytes` bytes come; no more than the rest of the file holds.
    pub fn count(&mut self, bytes: u64) -> Result<usize, Problem> {
        let count = self.number()?;
        if count.checked_mul(bytes).is_none_or(|all| all > self.left) {
            return Err("is damaged: a list is longer than the file".to_string());
        }
        Ok(count as usize)
    }

    pub fn text(&mut self) -> Result<Vec<u8>, Problem> {
        let mut text = room(self.count(1)?)?;
        text.resize(text.capacity(), 0);
        self.fill(&mut text)?;
        Ok(text)
    }

    /// A list, with room for `spare` elements more.
    pub fn list<T: Copy + Default, const N: usize>(
        &mut self,
        spare: usize,
        of: impl Fn([u8; 4]) -> T,
    ) -> Result<Vec<[T; N]>, Problem> {
        let count = self.count(4 * N as u64)?;
        let mut list = room(count + spare)?;
        self.items(count, |words: [u32; N]| list.push(words.map(|word| of(word.to_le_bytes()))))?;
        Ok(list)
    }

    /// `count` elements of `N` numbers.
    pub fn items<const N: usize>(
        &mut self,
        count: usize,
        mut each: impl FnMut([u32; N]),
    ) -> Result<(), Problem> {
        let mut buffer = vec![0; PIECE / (4 * N) * (4 * N)];
        let mut missing = count;
        while missing > 0 {
            let elements = missing.min(buffer.len() / (4 * N));
            let piece = buffer.get_mut(..elements * 4 * N).unwrap_or_default();
            self.fill(piece)?;
            let (words, _) = piece.as_chunks::<4>();
            let (items, _) = words.as_chunks::<N>();
            items.iter().for_each(|words| each(words.map(u32::from_le_bytes)));
            missing -= elements;
        }
        Ok(())
    }

    /// Whether all was read, and as it was written.
    pub fn finish(mut self) -> Result<(), Problem> {
        let mut digest = [0; DIGEST as usize];
        let whole = self.left == 0 && self.from.read_exact(&mut digest).is_ok();
        if whole && digest == *self.hasher.finalize().as_bytes() {
            return Ok(());
        }
        Err("is damaged: its digest is another".to_string())
    }
}

/// An empty list with room for `count` elements.
pub(super) fn room<T>(count: usize) -> Result<Vec<T>, Problem> {
    let mut list = Vec::new();
    memory::reserve(&mut list, count).map_err(|_| "does not fit into the memory".to_string())?;
    Ok(list)
}
