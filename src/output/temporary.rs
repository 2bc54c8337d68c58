//! Files on their way to a name: without one of their own where the file system can do that, else hidden and locked.
//!
//! A file made with `O_TMPFILE` has no name while it is written, so that whatever ends the program leaves nothing
//! behind. A rename needs a name, so it gets a hidden one for the moment before. Where there is no `O_TMPFILE` it has
//! that name from the start. The name tells the output by a hash; the file is locked (`flock`) as long as the program
//! lives, so that the next run on the same output can tell what nobody holds any more, and removes it.

use rustix::fs::{self as sys, AtFlags, CWD, FlockOperation, Mode, OFlags};
use rustix::io::Errno;
use std::fs::{self, File};
use std::hash::{BuildHasher, RandomState};
use std::io;
use std::os::fd::AsRawFd;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// How often another name is tried when one is taken.
const TRIES: usize = 100;

/// A file under way; removed when dropped.
pub(super) struct Temporary {
    file: File,
    /// Its name, once it has one.
    name: Option<PathBuf>,
}

impl Temporary {
    /// A new file for `target`, in its folder, with `mode` less the umask.
    pub fn new(target: &Path, mode: u32) -> io::Result<Temporary> {
        let mode = Mode::from_raw_mode(mode);
        // The way from an open file to a name leads through /proc.
        if Path::new("/proc/self/fd").exists() {
            let flags = OFlags::TMPFILE | OFlags::RDWR | OFlags::CLOEXEC;
            match sys::openat(CWD, folder_of(target), flags, mode) {
                Ok(file) => return Ok(Temporary { file: file.into(), name: None }),
                // What file systems and kernels say that have no such files.
                Err(Errno::OPNOTSUPP | Errno::ISDIR | Errno::NOENT | Errno::INVAL) => {}
                Err(e) => return Err(e.into()),
            }
        }
        Temporary::named(target, mode)
    }

    /// One with a name.
    pub(super) fn named(target: &Path, mode: Mode) -> io::Result<Temporary> {
        let flags = OFlags::CREATE | OFlags::EXCL | OFlags::NOFOLLOW | OFlags::RDWR | OFlags::CLOEXEC;
        let open = |name: &Path| sys::openat(CWD, name, flags, mode);
        for _ in 0..TRIES {
            let (name, file) = with_free_name(target, open)?;
            let temporary = Temporary { file: file.into(), name: Some(name) };
            lock(&temporary.file);
            // Another run may have taken it for abandoned before it was locked.
            if temporary.file.metadata()?.nlink() > 0 {
                return Ok(temporary);
            }
        }
        Err(io::Error::other("temporary files vanish"))
    }

    /// The file.
    pub fn file(&mut self) -> &mut File {
        &mut self.file
    }

    /// Gives it the name `target`, whatever has that name now.
    pub fn rename_over(mut self, target: &Path) -> io::Result<()> {
        let name = match self.name.take() {
            Some(name) => name,
            None => {
                lock(&self.file);
                let open = format!("/proc/self/fd/{}", self.file.as_raw_fd());
                let link = |name: &Path| sys::linkat(CWD, &*open, CWD, name, AtFlags::SYMLINK_FOLLOW);
                with_free_name(target, link)?.0
            }
        };
        let renamed = fs::rename(&name, target);
        if renamed.is_err() {
            self.name = Some(name);
        }
        renamed
    }
}

impl Drop for Temporary {
    fn drop(&mut self) {
        if let Some(name) = &self.name {
            // Nothing more can be done about it; the next run tries again.
            let _ = fs::remove_file(name);
        }
    }
}

/// Removes what runs that were killed left for `target`: its temporary files that nobody holds.
pub(super) fn sweep(target: &Path) {
    let prefix = prefix(target);
    // This is for tidiness alone: where anything fails, files stay.
    for entry in fs::read_dir(folder_of(target)).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let name = name.as_encoded_bytes();
        if name.starts_with(prefix.as_bytes()) && name.ends_with(SUFFIX.as_bytes()) {
            let flags = OFlags::NOFOLLOW | OFlags::NONBLOCK | OFlags::RDONLY | OFlags::CLOEXEC;
            let Ok(file) = sys::openat(CWD, entry.path(), flags, Mode::empty()) else { continue };
            if sys::flock(&file, FlockOperation::NonBlockingLockExclusive).is_ok() {
                let _ = fs::remove_file(entry.path());
            }
        }
    }
}

/// Says that somebody holds the file. File systems without locks cannot tell, and there nothing is swept.
fn lock(file: &File) {
    let _ = sys::flock(file, FlockOperation::NonBlockingLockExclusive);
}

const SUFFIX: &str = ".tmp";

/// How the names of `target`'s temporary files begin.
fn prefix(target: &Path) -> String {
    let name = target.file_name().unwrap_or_default();
    let hash = blake3::hash(name.as_encoded_bytes()).to_hex();
    format!(".drt-{}-", hash.get(..16).unwrap_or_default())
}

/// Calls `make` with random names until one is free.
fn with_free_name<T>(target: &Path, make: impl Fn(&Path) -> Result<T, Errno>) -> io::Result<(PathBuf, T)> {
    let (folder, prefix) = (folder_of(target), prefix(target));
    for i in 0..TRIES {
        let random = RandomState::new().hash_one(i);
        let name = folder.join(format!("{prefix}{random:016x}{SUFFIX}"));
        match make(&name) {
            Err(Errno::EXIST) => {}
            made => return Ok((name, made?)),
        }
    }
    Err(Errno::EXIST.into())
}

/// The folder that `file` is in.
pub(super) fn folder_of(file: &Path) -> &Path {
    match file.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    }
}
