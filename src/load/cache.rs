//! A folder of meshes that were read before (`--cache DIR`).
//!
//! **Content-addressed.** An entry's name is the digest (BLAKE3) of the mesh file's bytes and of the reader's
//! `READER` number. So it serves every copy of the file, and what was changed is never taken for what it was.
//!
//! **Known files are not read again.** Beside the entries, a note a path keeps the digest that the file had together
//! with its device, number, size, and times of change. Only where all of that is the same, and the file had not been
//! changed for two seconds when the note was made (clocks are coarse), the digest is taken from there; this is how
//! version control systems tell whether a file was changed. The time of the last status change, which programs cannot
//! set, is among it.
//!
//! **Checked.** An entry ends with a digest of all of it and is looked through like a file of somebody else: one that
//! is damaged, cut, or of another version is left aside, said ([`UNUSABLE`]) and written anew. Entries appear whole or not at
//! all, no link is followed to write them, and only their owner can read them. That the folder cannot be written is
//! said too, and no reason to fail.
//!
//! What a file's reader said ([`crate::error::Findings`], counts) is kept with the mesh: warnings and `--strict` are the
//! same with the cache and without it. The acceleration structure of the BVH backend is kept as well ([`Cache::bvh`]);
//! Embree's cannot be. Libraries and textures are not kept, but read anew each time.

mod entry;
mod note;
mod tree;
mod wire;

use super::obj::ObjFile;
use crate::error::{Error, Finding, Findings, Result, Severity};
use note::Identity;
use std::fs::{self, File};
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Counts up whenever the reader makes something else of a file, or the form of the entries changes.
const READER: u32 = 1;

/// The finding about an entry that could not be used.
pub const UNUSABLE: &str = "cache-entry-unusable";
/// The finding about an entry that could not be written.
pub const NOT_WRITTEN: &str = "cache-not-written";

/// A digest.
type Key = [u8; 32];

/// The folder.
#[derive(Debug)]
pub struct Cache {
    folder: PathBuf,
    hits: AtomicUsize,
    misses: AtomicUsize,
    trees: AtomicUsize,
    /// Findings about structures.
    said: Mutex<Findings>,
}

impl Cache {
    /// The cache in `folder`, which is made if it is not there.
    ///
    /// # Errors
    /// It is no folder and cannot be made one.
    pub fn open(folder: &Path) -> Result<Cache> {
        let made = fs::create_dir_all(folder).and_then(|()| fs::read_dir(folder)).map(drop);
        made.map_err(|e| {
            Error::io("use the cache", folder, &e).advise("name a folder, or leave --cache out")
        })?;
        let none = AtomicUsize::default;
        let said = Mutex::default();
        Ok(Cache { folder: folder.to_path_buf(), hits: none(), misses: none(), trees: none(), said })
    }

    /// How many files came from the cache, and how many had to be read.
    pub fn served(&self) -> (usize, usize) {
        (self.hits.load(Ordering::Relaxed), self.misses.load(Ordering::Relaxed))
    }

    /// Whether the acceleration structure came from the cache.
    pub fn had_tree(&self) -> bool {
        self.trees.load(Ordering::Relaxed) > 0
    }

    /// What was noticed about entries since it was last asked, but for those of mesh files, which are among their
    /// readers' findings.
    pub fn take_findings(&self) -> Findings {
        self.said.lock().map(|mut said| std::mem::take(&mut *said)).unwrap_or_default()
    }

    fn say(&self, finding: Finding) {
        if let Ok(mut said) = self.said.lock() {
            said.push(finding);
        }
    }

    /// The mesh of `file`, which is called `name`: from the cache, or by `read`, and then in the cache. `limits`: what
    /// besides the file's content decides whether it can be read. `progress` hears shares as from a reader. Where
    /// `file` stands does not change.
    ///
    /// # Errors
    /// As `read`; the file cannot be read; cancelled.
    pub(super) fn through(
        &self,
        (name, file): (&Path, &File),
        limits: &[u64],
        progress: &dyn Fn(f64) -> bool,
        read: impl FnOnce() -> Result<ObjFile>,
    ) -> Result<ObjFile> {
        let failed = |e: std::io::Error| Error::io("read", name, &e);
        let identity = Identity::of(file).map_err(failed)?;
        let note = self.folder.join(note::file_name(name));
        let content = match note::read(&note, &identity) {
            Some(content) => content,
            None => digest(file, progress).map_err(failed)?.ok_or_else(super::cancelled)?,
        };
        let path = self.folder.join(entry::file_name(&content, limits));
        let mut said = Vec::new();
        match entry::read(&path, &content, name) {
            Ok(Some(mesh)) => {
                self.hits.fetch_add(1, Ordering::Relaxed);
                note::write(&note, &identity, &content);
                return Ok(mesh);
            }
            Ok(None) => {}
            Err(why) => said.push(finding(&path, UNUSABLE, format!("{why}; the mesh was read anew"))),
        }
        self.misses.fetch_add(1, Ordering::Relaxed);
        let mut mesh = read()?;
        // What was changed while it was read is nobody's content.
        if Identity::of(file).is_ok_and(|after| after == identity) {
            match entry::write(&path, &content, &mesh) {
                Ok(()) => note::write(&note, &identity, &content),
                Err(why) => {
                    said.push(finding(&path, NOT_WRITTEN, format!("the mesh is not kept: {}", why.message)))
                }
            }
        }
        said.into_iter().for_each(|finding| mesh.findings.push(finding));
        Ok(mesh)
    }
}

fn finding(path: &Path, kind: &'static str, message: String) -> Finding {
    Finding { file: path.to_path_buf(), line: 0, kind, message, severity: Severity::Note }
}

/// The digest of all of `file`; `None` when `progress` cancelled.
fn digest(file: &File, progress: &dyn Fn(f64) -> bool) -> std::io::Result<Option<Key>> {
    let mut hasher = blake3::Hasher::new();
    let mut buffer = vec![0; 1 << 20];
    let mut at = 0;
    loop {
        if !progress(0.0) {
            return Ok(None);
        }
        match file.read_at(&mut buffer, at) {
            Ok(0) => return Ok(Some(*hasher.finalize().as_bytes())),
            Ok(got) => {
                hasher.update(buffer.get(..got).unwrap_or_default());
                at += got as u64;
            }
            Err(e) if e.kind() == std::io::ErrorKind::Interrupted => {}
            Err(e) => return Err(e),
        }
    }
}

/// A digest in hexadecimal digits.
fn hex(key: &Key) -> String {
    key.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests;
