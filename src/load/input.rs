//! A mesh file, opened: a regular file or standard input, unpacked where it is packed.

use super::open::Reach;
use super::unpack::{Counted, Limit, Packing};
use crate::error::{Error, Result};
use std::fs::File;
use std::io::{self, Cursor, Read, Seek};
use std::os::fd::AsFd;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;

/// The name that stands for standard input.
pub const STDIN: &str = "-";

/// How many bytes tell a format.
const HEAD: usize = 1024;

/// Told now and then the share done (0 to 1); `false` cancels.
pub(crate) type ReadingProgress<'a> = &'a (dyn Fn(f64) -> bool + Sync);

/// What comes out of an opened file.
pub(crate) struct Input<'a> {
    /// What messages call it.
    pub name: &'a Path,
    /// Its bytes from the first on.
    pub reader: Box<dyn Read + Send + 'a>,
    /// Its first bytes, for a look ahead.
    pub head: Vec<u8>,
    /// Tells the share of the file that has been read.
    share: Share,
}

/// The share of a file that has been read; 0 where its length is not known.
pub(crate) enum Share {
    /// So many bytes make the whole of an open file.
    Of(File, u64),
    /// Always the same.
    Always(f64),
}

impl Share {
    /// The file that is read, where it is one.
    pub fn file(&self) -> Option<&File> {
        match self {
            Share::Of(file, _) => Some(file),
            Share::Always(_) => None,
        }
    }

    /// From 0 to 1.
    pub fn now(&self) -> f64 {
        match self {
            Share::Of(file, length) => {
                let read = rustix::fs::tell(file).unwrap_or(0);
                (read as f64 / (*length).max(1) as f64).min(1.0)
            }
            Share::Always(share) => *share,
        }
    }
}

impl<'a> Input<'a> {
    /// Opens the file `name` within `reach`, or standard input where it is [`STDIN`]. `most_unpacked`: the most bytes that come out of
    /// a packed file; `None`: [`super::unpack::ALWAYS_ALLOWED`], or more for large files.
    ///
    /// # Errors
    /// As [`Reach::open`]; the first bytes cannot be read or unpacked; cancelled.
    pub fn open(
        name: &'a Path,
        reach: &Reach,
        most_unpacked: Option<u64>,
        progress: ReadingProgress<'a>,
    ) -> Result<Input<'a>> {
        if name == Path::new(STDIN) {
            let packed = Arc::new(AtomicU64::new(0));
            let limit = Limit { stated: most_unpacked, packed: packed.clone(), length: None };
            let mut stdin = Counted { from: Stdin { progress }, count: packed };
            let name = Path::new("stdin");
            let head = beginning(&mut stdin).map_err(|e| failed(name, &e))?;
            let stdin = Box::new(Cursor::new(head.clone()).chain(stdin));
            return Input::new(name, stdin, head, limit, Share::Always(0.0));
        }
        let (mut file, length) = reach.open(name)?;
        let head = beginning(&mut file).and_then(|head| file.rewind().map(|()| head));
        let head = head.map_err(|e| failed(name, &e))?;
        let limit = Limit { stated: most_unpacked, packed: Arc::default(), length: Some(length) };
        // A second handle of one open file knows how far the first has come.
        let share = file.try_clone().map_or(Share::Always(0.0), |file| Share::Of(file, length));
        Input::new(name, Box::new(file), head, limit, share)
    }

    fn new(
        name: &'a Path,
        from: Box<dyn Read + Send + 'a>,
        head: Vec<u8>,
        limit: Limit,
        share: Share,
    ) -> Result<Input<'a>> {
        let Some(packing) = Packing::of(&head) else { return Ok(Input { name, reader: from, head, share }) };
        let mut reader = packing.unpack(from, limit);
        let head = beginning(&mut reader).map_err(|e| failed(name, &e))?;
        let reader = Box::new(Cursor::new(head.clone()).chain(reader));
        Ok(Input { name, reader, head, share })
    }

    /// The bytes in order, and what tells how many of them have been read.
    pub fn into_parts(self) -> (Box<dyn Read + Send + 'a>, Share) {
        (self.reader, self.share)
    }

    /// All bytes, at most `most` of them.
    ///
    /// # Errors
    /// The system's reason; more bytes; not enough memory; cancelled.
    pub fn read_all(mut self, most: u64, progress: ReadingProgress<'_>) -> Result<Vec<u8>> {
        // As much again as there is, so that small files take little.
        const STEPS: [u64; 2] = [64 << 10, 16 << 20];
        let mut bytes = Vec::new();
        loop {
            if !progress(self.share.now()) {
                return Err(super::cancelled());
            }
            let read = bytes.len() as u64;
            let step = read.clamp(STEPS[0], STEPS[1]).min(most.saturating_add(1).saturating_sub(read));
            bytes.try_reserve(step as usize).map_err(|_| no_memory(self.name))?;
            match self.reader.by_ref().take(step).read_to_end(&mut bytes) {
                Ok(0) => return Ok(bytes),
                Ok(_) if bytes.len() as u64 > most => {
                    return Err(Error::new(format!("more than {} MiB", most >> 20)).at(self.name));
                }
                Ok(_) => {}
                Err(e) => return Err(failed(self.name, &e)),
            }
        }
    }
}

/// The error of a reading that failed or was cancelled.
pub(crate) fn failed(file: &Path, error: &io::Error) -> Error {
    match error.get_ref().is_some_and(|inner| inner.is::<Cancelled>()) {
        true => super::cancelled(),
        false => Error::io("read", file, error),
    }
}

/// The error of an allocation that failed.
pub(crate) fn no_memory(file: &Path) -> Error {
    Error::new("not enough memory for the file").at(file).advise("use a machine with more memory")
}

pub(super) fn beginning(from: &mut impl Read) -> io::Result<Vec<u8>> {
    let mut head = Vec::new();
    from.take(HEAD as u64).read_to_end(&mut head).map(|_| head)
}

/// Standard input. It is asked for bytes ten times a second, so that waiting for them can be cancelled.
struct Stdin<'a> {
    progress: ReadingProgress<'a>,
}

/// The error of a cancelled reading, as input and output know errors.
#[derive(Debug)]
struct Cancelled;

impl std::fmt::Display for Cancelled {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("cancelled")
    }
}

impl std::error::Error for Cancelled {}

impl Read for Stdin<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        use rustix::event::{PollFd, PollFlags, Timespec, poll};
        let stdin = io::stdin();
        let tenth = Timespec { tv_sec: 0, tv_nsec: 100_000_000 };
        loop {
            let mut fds = [PollFd::from_borrowed_fd(stdin.as_fd(), PollFlags::IN)];
            match poll(&mut fds, Some(&tenth)) {
                Ok(0) | Err(rustix::io::Errno::INTR) => {}
                Ok(_) => return Ok(rustix::io::read(&stdin, buffer)?),
                Err(e) => return Err(e.into()),
            }
            if !(self.progress)(0.0) {
                return Err(io::Error::other(Cancelled));
            }
        }
    }
}
