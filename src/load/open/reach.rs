//! How far an input may reach: anywhere, or only into its own folder (`--secure`).
//!
//! A path is judged by what it leads to, not by how it is spelt: every link is followed first, and what it led to is
//! then opened folder by folder below the one that is allowed, following none. A link that is put in between the
//! two makes the opening fail; it leads nowhere else.

use super::{open_regular, regular};
use crate::error::{Error, Result};
use rustix::fs::{Mode, OFlags, openat};
use std::fs::File;
use std::os::fd::OwnedFd;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The files that an input may name.
#[derive(Clone, Debug, Default)]
pub enum Reach {
    /// Every file that the user may read.
    #[default]
    Anywhere,
    /// Files below one folder.
    Inside(Arc<Folder>),
}

/// An open folder.
#[derive(Debug)]
pub struct Folder {
    /// Its path without links.
    path: PathBuf,
    /// The file in it that the user named: read wherever it is linked from.
    input: PathBuf,
    handle: OwnedFd,
}

impl Reach {
    /// Only the folder of the file `input`, and what is below it. `input` itself may be a link to elsewhere.
    ///
    /// # Errors
    /// The folder cannot be opened.
    pub fn folder_of(input: &Path) -> Result<Reach> {
        let folder = match input.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        };
        let failed = |e: &std::io::Error| Error::io("open the folder", folder, e);
        let path = folder.canonicalize().map_err(|e| failed(&e))?;
        let flags = OFlags::DIRECTORY | OFlags::RDONLY | OFlags::CLOEXEC;
        let handle = rustix::fs::open(&path, flags, Mode::empty()).map_err(|e| failed(&e.into()))?;
        Ok(Reach::Inside(Arc::new(Folder { path, input: input.to_path_buf(), handle })))
    }

    /// True where `path` leads to something that may be read, or nowhere.
    pub fn holds(&self, path: &Path) -> bool {
        match self {
            Reach::Anywhere => true,
            Reach::Inside(folder) => {
                let path = if path.as_os_str().is_empty() { Path::new(".") } else { path };
                path.canonicalize().map_or(true, |path| path.starts_with(&folder.path))
            }
        }
    }

    /// Opens the regular file `path`, as [`open_regular`], if it may be read.
    ///
    /// # Errors
    /// As [`open_regular`]; that the file is out of reach.
    pub fn open(&self, path: &Path) -> Result<(File, u64)> {
        let Reach::Inside(folder) = self else { return open_regular(path) };
        if path == folder.input {
            return open_regular(path);
        }
        let real = path.canonicalize().map_err(|e| Error::io("open", path, &e))?;
        let Ok(below) = real.strip_prefix(&folder.path) else { return Err(refused().at(path)) };
        folder.open(below).map_err(|e| Error::io("open", path, &e)).and_then(|file| regular(file, path))
    }
}

impl Folder {
    /// Opens `below`, a path without links, for reading.
    fn open(&self, below: &Path) -> std::io::Result<File> {
        let flags = OFlags::RDONLY | OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::NOCTTY | OFlags::CLOEXEC;
        let mut parts = below.iter().peekable();
        let mut at: Option<OwnedFd> = None;
        while let Some(part) = parts.next() {
            let is_folder = parts.peek().is_some();
            let flags = if is_folder { flags | OFlags::DIRECTORY } else { flags };
            at = Some(openat(at.as_ref().unwrap_or(&self.handle), part, flags, Mode::empty())?);
        }
        // Nothing below is the folder itself.
        at.map_or_else(|| self.handle.try_clone(), Ok).map(File::from)
    }
}

/// What a file out of reach is answered with.
fn refused() -> Error {
    Error::new("is outside the input's folder, and --secure reads nothing there")
        .advise("put it into that folder, or leave --secure out")
}
