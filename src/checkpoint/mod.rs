//! Checkpoints: the film of a render under way on disk, so that an interrupted render can go on and give the bytes
//! that it would have given, and a finished one can get more samples.
//!
//! A checkpoint knows the render that it belongs to by an *identity*: the settings by name, a digest of all of them, and
//! digests of the scene's parts. One that belongs to another render, was cut short, or has a single bit flipped is
//! refused with the reason; samples of different renders are never mixed. The file is replaced atomically and belongs to
//! its user alone; `docs/interruptions.md` describes it.

mod format;
mod identity;

pub use format::{Header, read};
pub use identity::compare;

use crate::error::{Error, Result};
use crate::film::Film;
use crate::output;
use rustix::fs::OFlags;
use serde_json::Value;
use std::fs::{File, OpenOptions};
use std::io::{BufReader, BufWriter, Write};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};

/// A checkpoint that was found whole.
#[derive(Debug)]
pub struct Checkpoint {
    path: PathBuf,
    header: Header,
}

impl Checkpoint {
    /// Opens and verifies the checkpoint `path`; `None` where there is none yet.
    ///
    /// # Errors
    /// A link, or anything that is no regular file; no checkpoint of this version; a damaged one; the system's reason.
    pub fn open(path: &Path) -> Result<Option<Checkpoint>> {
        let Some(file) = open_file(path)? else { return Ok(None) };
        let header = format::scan(BufReader::with_capacity(1 << 16, file), &mut |_, _| Ok(()));
        Ok(Some(Checkpoint { path: path.to_path_buf(), header: header.map_err(|e| e.at(path))? }))
    }

    /// What it says of itself.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Refuses another render's checkpoint: all that `identity` says must be what it was.
    ///
    /// # Errors
    /// What differs.
    pub fn belongs_to(&self, identity: &Value) -> Result<()> {
        compare(&self.header.identity, identity).map_err(|e| e.at(&self.path))
    }

    /// Puts its tiles into `film`, as far as a picture of `spp` samples a pixel can use them; `tiles`: their indices.
    ///
    /// # Errors
    /// More samples than `spp`; what [`Checkpoint::open`] refuses.
    pub fn restore(&self, film: &Film, tiles: &[usize], spp: u32) -> Result<()> {
        let at = |e: Error| e.at(&self.path);
        let gone = || at(Error::new("the checkpoint is not the one any more that was opened"));
        let file = open_file(&self.path)?.ok_or_else(gone)?;
        let mut too_many = 0;
        let header = format::scan(BufReader::with_capacity(1 << 16, file), &mut |i, saved| {
            let tile = *tiles.get(i).ok_or_else(gone)?;
            let samples = saved.whole();
            if !film.restore(tile, saved, spp) {
                too_many = samples.max(too_many);
            }
            Ok(())
        });
        if header.map_err(at)? != self.header || tiles.len() != self.header.tiles {
            return Err(gone());
        }
        if too_many > 0 {
            let message = format!("the checkpoint has {too_many} samples a pixel already, more than {spp}");
            return Err(at(Error::new(message).advise(format!("ask for --spp {too_many} or more"))));
        }
        Ok(())
    }
}

/// Refuses, before any work is done, a place where no checkpoint can be written.
///
/// # Errors
/// A link, a device or a folder; a folder that lets no file be made.
pub fn check_path(path: &Path) -> Result<()> {
    open_file(path)?;
    output::check_writable(path)
}

/// Replaces the checkpoint `path` by one of `film`; readable by its user alone. The old one is as it was on any error.
///
/// # Errors
/// The system's reason.
pub fn write(path: &Path, header: &Header, film: &Film, tiles: &[usize]) -> Result<()> {
    output::file::write_private(path, |file| {
        let mut out = BufWriter::with_capacity(1 << 18, file);
        format::write(&mut out, header, film, tiles)?;
        out.flush()
    })
}

/// Opens a regular file and follows no link; `None` where there is nothing.
fn open_file(path: &Path) -> Result<Option<File>> {
    let flags = OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::NOCTTY;
    let refuse = |what: &str| {
        let error = Error::new(format!("the checkpoint is {what}")).at(path);
        Err(error.advise("give --checkpoint the name of a file"))
    };
    match OpenOptions::new().read(true).custom_flags(flags.bits() as i32).open(path) {
        Ok(file) => match file.metadata() {
            Ok(about) if about.is_file() => Ok(Some(file)),
            Ok(about) if about.is_dir() => refuse("a folder"),
            Ok(_) => refuse("a pipe or a device"),
            Err(e) => Err(Error::io("read the checkpoint", path, &e)),
        },
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(e) if e.raw_os_error() == Some(rustix::io::Errno::LOOP.raw_os_error()) => {
            refuse("a symbolic link, and checkpoints follow none")
        }
        Err(e) => Err(Error::io("read the checkpoint", path, &e)),
    }
}

#[cfg(test)]
mod tests;
