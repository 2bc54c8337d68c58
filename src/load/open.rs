//! Opening a file that somebody else named.
//!
//! A scene may name a FIFO, a device or a folder. Opening those can block for ever or never end, so a
//! file is opened without blocking and refused unless it is a regular one.

use crate::error::{Error, Result};
use std::fs::{File, OpenOptions};
use std::path::Path;

/// Opens the regular file `path` for reading, and tells its length in bytes.
///
/// # Errors
/// The operating system's reason, or that it is not a regular file. Never blocks.
pub fn open_regular(path: &Path) -> Result<(File, u64)> {
    let mut options = OpenOptions::new();
    options.read(true);
    #[cfg(unix)]
    {
        use std::os::unix::fs::OpenOptionsExt;
        let flags = rustix::fs::OFlags::NONBLOCK | rustix::fs::OFlags::NOCTTY;
        options.custom_flags(flags.bits() as i32);
    }
    let file = options.open(path).map_err(|e| Error::io("open", path, &e))?;
    // The open file is asked, not the path, which may have been exchanged in between.
    let about = file.metadata().map_err(|e| Error::io("open", path, &e))?;
    if about.is_dir() {
        return Err(Error::new("is a directory").at(path).advise("name a file"));
    }
    if !about.is_file() {
        return Err(Error::new("is not a regular file")
            .at(path)
            .advise("pipes and devices are not read; write the data to a file first"));
    }
    Ok((file, about.len()))
}
