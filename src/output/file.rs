//! Bytes to disk so that a reader sees the old file or the new one, whole, and never a part.

use std::fs::{self, File, OpenOptions};
use std::io::{self, Write};
use std::os::unix::fs::{OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

use super::Format;
use super::temporary::{Temporary, folder_of, sweep};

/// As many links as Linux follows.
const MOST_LINKS: usize = 40;

/// Where the bytes of a path really go.
enum Destination {
    /// `-` and `/dev/stdout`.
    Stdout,
    /// A device, a pipe or an open descriptor: nothing that could be replaced, so it is written straight through.
    Stream,
    /// A regular file or none yet, at the end of all symbolic links.
    Regular(PathBuf),
}

/// Is `path` standard output, a device or a pipe, rather than a file that can be replaced?
pub(super) fn is_stream(path: &Path) -> bool {
    matches!(destination(path), Ok(Destination::Stdout | Destination::Stream))
}

/// Checks, before any work is done for it, that a picture can be written to `path`: the extension names a format,
/// the path is no folder, its folder exists and lets files be made in it (one is made and removed), and an existing
/// file may be written. Temporary files that a run which was killed left there for `path` are removed.
///
/// # Errors
/// The first of these that fails, with the file and the system's reason.
pub fn check_path(path: &Path) -> Result<()> {
    Format::of_path(path)?;
    check_writable(path)
}

/// [`check_path`] for files that are no pictures.
///
/// # Errors
/// As [`check_path`], but for the extension.
pub fn check_writable(path: &Path) -> Result<()> {
    match destination(path)? {
        Destination::Stdout => Ok(()),
        // Opening a pipe would wait for its reader.
        Destination::Stream => rustix::fs::access(path, rustix::fs::Access::WRITE_OK)
            .map_err(|e| Error::io("write to it", path, &e.into())),
        Destination::Regular(target) => check_regular(path, &target),
    }
}

fn check_regular(path: &Path, target: &Path) -> Result<()> {
    let folder = folder_of(target);
    match fs::metadata(folder) {
        Ok(meta) if !meta.is_dir() => {
            return Err(Error::new(format!("cannot write: {} is not a folder", folder.display())).at(path));
        }
        Ok(_) => {}
        Err(e) if e.kind() == io::ErrorKind::NotFound => {
            return Err(Error::new(format!("cannot write: the folder {} does not exist", folder.display()))
                .at(path)
                .advise("create it first"));
        }
        Err(e) => return Err(Error::io("write", path, &e)),
    }
    sweep(target);
    Temporary::new(target, NEW).map_err(|e| Error::io("create a file in its folder", path, &e))?;
    // Its folder would let a write-protected file be replaced; whoever protected it would not.
    if target.exists() {
        OpenOptions::new().write(true).open(target).map_err(|e| Error::io("write", path, &e))?;
    }
    Ok(())
}

/// Writes `bytes` to `path`. A file is replaced atomically: a new file in the same folder is written, synced and
/// renamed over it, with the old file's mode; a symbolic link stays and its target is replaced; on any error the
/// old file is as it was and nothing is left behind. `-`, devices and pipes are written straight through.
///
/// # Errors
/// The system's reason, with `path`.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<()> {
    let written = match destination(path)? {
        Destination::Stdout => write_stdout(bytes),
        // Neither created nor cut: what is behind an open descriptor belongs to whoever opened it.
        Destination::Stream => OpenOptions::new()
            .write(true)
            .custom_flags(rustix::fs::OFlags::NOCTTY.bits() as i32)
            .open(path)
            .and_then(|mut stream| stream.write_all(bytes)),
        Destination::Regular(target) => replace(&target, bytes),
    };
    written.map_err(|e| Error::io("write", path, &e))
}

fn write_stdout(bytes: &[u8]) -> io::Result<()> {
    let mut stdout = io::stdout().lock();
    stdout.write_all(bytes)?;
    stdout.flush()
}

/// The mode of a new file, before the umask.
const NEW: u32 = 0o666;

pub(super) fn replace(target: &Path, bytes: &[u8]) -> io::Result<()> {
    let mode = fs::metadata(target).ok().map(|old| old.permissions().mode() & 0o777);
    put(target, NEW, |file| {
        // Not asked of file systems that have one mode for all files and would refuse.
        if let Some(mode) = mode
            && file.metadata()?.permissions().mode() & 0o777 != mode
        {
            file.set_permissions(fs::Permissions::from_mode(mode))?;
        }
        file.write_all(bytes)
    })
}

/// Replaces the file `path` as [`write_bytes`] does, but by one that its user alone may read, and follows no link: one in
/// its place is replaced itself.
///
/// # Errors
/// The system's reason, with `path`.
pub fn write_private(path: &Path, write: impl FnOnce(&mut File) -> io::Result<()>) -> Result<()> {
    put(path, 0o600, write).map_err(|e| Error::io("write", path, &e))
}

/// Makes a new file of what `write` writes, syncs it and renames it over `target`.
fn put(target: &Path, mode: u32, write: impl FnOnce(&mut File) -> io::Result<()>) -> io::Result<()> {
    let mut temporary = Temporary::new(target, mode)?;
    write(temporary.file())?;
    temporary.file().sync_all()?;
    temporary.rename_over(target)?;
    // Past the rename the new file is whole and in place; a folder that cannot be synced only leaves open which of
    // two whole files a power cut would leave, so that is no failure.
    let _ = File::open(folder_of(target)).and_then(|f| f.sync_all());
    Ok(())
}

fn destination(path: &Path) -> Result<Destination> {
    if path.as_os_str() == "-" || path == Path::new("/dev/stdout") {
        return Ok(Destination::Stdout);
    }
    // Behind these may be a regular file that others hold open: replacing its name would not reach them.
    if ["/dev/stderr", "/dev/fd", "/proc/self/fd"].iter().any(|open| path.starts_with(open)) {
        return Ok(Destination::Stream);
    }
    if path.as_os_str().as_encoded_bytes().ends_with(b"/") {
        return Err(is_a_folder(path));
    }
    match fs::metadata(path) {
        Ok(meta) if meta.is_dir() => Err(is_a_folder(path)),
        Ok(meta) if !meta.is_file() => Ok(Destination::Stream),
        Ok(_) => Ok(Destination::Regular(end_of_links(path)?)),
        Err(e) if e.kind() == io::ErrorKind::NotFound && !path.as_os_str().is_empty() => {
            Ok(Destination::Regular(end_of_links(path)?))
        }
        Err(e) => Err(Error::io("write", path, &e)),
    }
}

fn is_a_folder(path: &Path) -> Error {
    Error::new("cannot write a picture: this is a folder")
        .at(path)
        .advise("give a file name, such as picture.png")
}

/// Follows symbolic links one by one, so that a link to a file that does not exist yet is kept too.
fn end_of_links(path: &Path) -> Result<PathBuf> {
    let mut end = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        match fs::read_link(&end) {
            Ok(link) => end = folder_of(&end).join(link),
            Err(_) => return Ok(end),
        }
    }
    Err(Error::new("cannot write: too many symbolic links").at(path))
}
