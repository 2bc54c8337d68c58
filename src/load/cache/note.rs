//! What a path's file was when its digest was taken.

use super::wire::{self, Sink};
use super::{Key, READER, hex};
use crate::output::file::write_private;
use std::fs::File;
use std::io;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

const MAGIC: [u8; 8] = *b"drtnote\n";

/// How long a file must have been left alone, in seconds: within that a clock may show the same time twice (two seconds
/// is the coarsest, FAT's).
const SETTLED: i64 = 2;

/// What tells one state of a file from another without reading it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Identity {
    /// Device, number, size; seconds and nanoseconds of the last change of content and of status.
    figures: [u64; 7],
}

impl Identity {
    pub fn of(file: &File) -> io::Result<Identity> {
        let m = file.metadata()?;
        let times = [m.mtime(), m.mtime_nsec(), m.ctime(), m.ctime_nsec()].map(|t| t as u64);
        Ok(Identity { figures: [m.dev(), m.ino(), m.len(), times[0], times[1], times[2], times[3]] })
    }

    /// Whether the file has been left alone for so long that a later change would show.
    fn is_settled(&self) -> bool {
        let now = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |d| d.as_secs() as i64);
        let [.., changed, _, status, _] = self.figures;
        (changed as i64).max(status as i64) + SETTLED < now
    }
}

/// The name of a path's note.
pub(super) fn file_name(path: &Path) -> String {
    let path = path.canonicalize().unwrap_or_else(|_| path.to_path_buf());
    let digest = blake3::hash(path.as_os_str().as_bytes());
    format!("{}.note", hex(digest.as_bytes()))
}

/// The digest of the file's content, where the note at `path` is about the very state of it.
pub(super) fn read(path: &Path, identity: &Identity) -> Option<Key> {
    let mut source = wire::Source::open(path, MAGIC).ok()??;
    let mut figures = [0; 7];
    for figure in &mut figures {
        *figure = source.number().ok()?;
    }
    let reader = source.number().ok()?;
    let content = source.key().ok()?;
    source.finish().ok()?;
    (figures == identity.figures && reader == u64::from(READER)).then_some(content)
}

/// Notes it. That fails without a word: the next run takes the digest once more.
pub(super) fn write(path: &Path, identity: &Identity, content: &Key) {
    if !identity.is_settled() || read(path, identity) == Some(*content) {
        return;
    }
    let _ = write_private(path, |file| {
        let mut sink = Sink::new(file, MAGIC)?;
        for figure in identity.figures {
            sink.number(figure)?;
        }
        sink.number(u64::from(READER))?;
        sink.bytes(content)?;
        sink.finish()
    });
}
