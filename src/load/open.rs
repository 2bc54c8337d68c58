//! Opening a file that somebody else named.
//!
//! A scene may name a FIFO, a device or a folder. Opening those can block for ever or never end, so a
//! file is opened without blocking and refused unless it is a regular one.

mod reach;

pub use reach::Reach;

use crate::error::{Error, Result};
use std::collections::HashMap;
use std::ffi::OsString;
use std::fs::{File, OpenOptions};
use std::path::{Component, Path, PathBuf};

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
    options.open(path).map_err(|e| Error::io("open", path, &e)).and_then(|file| regular(file, path))
}

/// `file`, opened as `path`, with its length, if it is a regular one.
fn regular(file: File, path: &Path) -> Result<(File, u64)> {
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

/// The one path of the file that `path` leads to, however it is spelt; where it leads nowhere, `path`.
pub(crate) fn real(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| path.to_path_buf())
}

/// A path of the bytes that a file states.
pub fn path_from_bytes(bytes: &[u8]) -> PathBuf {
    #[cfg(unix)]
    {
        use std::os::unix::ffi::OsStrExt;
        PathBuf::from(std::ffi::OsStr::from_bytes(bytes))
    }
    #[cfg(not(unix))]
    PathBuf::from(String::from_utf8_lossy(bytes).into_owned())
}

/// How a stated name led to a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Match {
    /// As stated.
    Exact,
    /// Upper and lower case differ.
    OtherCase,
    /// A file of that name, without the stated folders, next to the file that states it.
    OtherFolder,
}

/// A file that a stated name led to.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// Where it is. It exists; that it is a regular file is for [`open_regular`] to say.
    pub path: PathBuf,
    /// How it was found; anything but [`Match::Exact`] deserves a warning.
    pub how: Match,
}

/// Looks for files that other files name, each folder listed once.
#[derive(Debug, Default)]
pub struct Finder {
    reach: Reach,
    /// By folder: the alphabetically first entry by its name in lower case.
    listings: HashMap<PathBuf, HashMap<String, OsString>>,
}

impl Finder {
    /// One that looks for files within `reach` first, and lists no folder outside.
    pub fn new(reach: &Reach) -> Self {
        Finder { reach: reach.clone(), listings: HashMap::new() }
    }

    /// Looks for the file that a scene in `folder` calls `name`: `\` counts as `/`; a Windows path with a drive
    /// or server is looked for by its last part. A file out of reach is the answer only where there is no other.
    pub fn find(&mut self, folder: &Path, name: &[u8]) -> Option<Found> {
        let name: Vec<u8> = name.iter().map(|&b| if b == b'\\' { b'/' } else { b }).collect();
        let foreign =
            matches!(*name.as_slice(), [b'a'..=b'z' | b'A'..=b'Z', b':', ..]) || name.starts_with(b"//");
        if name.is_empty() || name.contains(&0) {
            return None;
        }
        let mut outside = None;
        if !foreign {
            let path = folder.join(path_from_bytes(&name));
            if path.exists() {
                let found = Some(Found { path, how: Match::Exact });
                if found.as_ref().is_some_and(|found| self.reach.holds(&found.path)) {
                    return found;
                }
                outside = found;
            }
            if let Some(path) = self.find_in_any_case(folder, &path_from_bytes(&name)) {
                return Some(Found { path, how: Match::OtherCase });
            }
        }
        let last = name.rsplit(|&b| b == b'/').next();
        let Some(last) = last.filter(|last| !last.is_empty() && last.len() < name.len()) else {
            return outside;
        };
        let last = path_from_bytes(last);
        let beside = folder.join(&last);
        let path = if beside.exists() { Some(beside) } else { self.find_in_any_case(folder, &last) };
        path.map(|path| Found { path, how: Match::OtherFolder }).or(outside)
    }

    /// Walks `name` from `folder`, taking the alphabetically first entry that differs in case where none fits.
    fn find_in_any_case(&mut self, folder: &Path, name: &Path) -> Option<PathBuf> {
        let mut path = folder.to_path_buf();
        for component in name.components() {
            let next = path.join(component);
            let Component::Normal(wanted) = component else {
                path = next;
                continue;
            };
            if next.exists() {
                path = next;
                continue;
            }
            let fitting = self.listing(&path).get(&wanted.to_string_lossy().to_lowercase())?.clone();
            path = path.join(fitting);
        }
        // A link that leads nowhere is listed, too.
        path.exists().then_some(path)
    }

    /// The entries of a folder; none where it cannot or may not be listed.
    pub(crate) fn listing(&mut self, folder: &Path) -> &HashMap<String, OsString> {
        let reach = &self.reach;
        self.listings.entry(folder.to_path_buf()).or_insert_with(|| {
            let listed = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
            let mut entries = HashMap::new();
            if !reach.holds(listed) {
                return entries;
            }
            for entry in std::fs::read_dir(listed).into_iter().flatten().flatten() {
                let name = entry.file_name();
                let kept =
                    entries.entry(name.to_string_lossy().to_lowercase()).or_insert_with(|| name.clone());
                if name < *kept {
                    *kept = name;
                }
            }
            entries
        })
    }
}
