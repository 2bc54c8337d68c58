//! Keeping a render's progress: restored before the first ray, saved now and then by a thread of its own, and at the end.

use super::picture::Picture;
use super::record;
use crate::checkpoint::{self, Checkpoint, Header};
use crate::error::{Error, Result};
use crate::film::Film;
use crate::load::cancelled;
use crate::sampler::SamplerKind;
use crate::scene::Settings;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Condvar, Mutex, PoisonError};
use std::time::Duration;

/// Where progress is kept, and what to go on from.
pub struct Keep<'a> {
    /// The checkpoint.
    pub file: &'a Path,
    /// Time between two saves.
    pub every: Duration,
    /// What to go on from; `None` begins anew.
    pub from: Option<&'a Checkpoint>,
    /// Told when saving failed; the render goes on, what was saved before stays, and the next time it is tried again.
    pub trouble: &'a (dyn Fn(&Error) + Sync),
}

/// A render that is kept.
pub struct Keeper<'a> {
    keep: &'a Keep<'a>,
    header: Header,
    film: &'a Film,
    tiles: &'a [usize],
    /// Grows with every block that is done.
    progress: &'a AtomicU64,
}

impl<'a> Keeper<'a> {
    /// Restores `film`, where there is something to go on from.
    ///
    /// # Errors
    /// A checkpoint of another render; one that cannot be extended; stopped.
    pub fn new(
        keep: &'a Keep<'a>,
        picture: &Picture<'_>,
        film: &'a Film,
        tiles: &'a [usize],
        progress: &'a AtomicU64,
    ) -> Result<Keeper<'a>> {
        let s = picture.settings;
        let mut identity = record::identity(s, picture.scene, Some(picture.accel));
        for (part, digest) in picture.scene.fingerprint(picture.hooks.stop).ok_or_else(cancelled)? {
            identity["scene"][part] = digest.into();
        }
        if let Some(from) = keep.from {
            from.belongs_to(&identity)?;
            check_extension(from.header().spp, s).map_err(|e| e.at(keep.file))?;
            from.restore(film, tiles, s.spp)?;
        }
        let (layers, tile_count) = (!s.aovs.is_empty(), tiles.len());
        let header = Header { identity, spp: s.spp, layers, tiles: tile_count, samples: (0, 0) };
        Ok(Keeper { keep, header, film, tiles, progress })
    }

    /// Does `work`, saving now and then, and once more when it is done.
    ///
    /// # Errors
    /// No thread can be started.
    pub fn while_saving<R>(&self, work: impl FnOnce() -> R) -> Result<R> {
        let end = End::default();
        let at_first = self.progress.load(Ordering::Relaxed);
        let (result, saved) = std::thread::scope(|scope| {
            let saver = std::thread::Builder::new().name("checkpoint".to_string());
            let saver = saver.spawn_scoped(scope, || self.save_until(&end, at_first));
            let saver = saver.map_err(|e| Error::new(format!("cannot start a thread: {e}")))?;
            let result = {
                // Also when the work panics: the thread would be waited for.
                let _end = Ends(&end);
                work()
            };
            Ok((result, saver.join().unwrap_or(None)))
        })?;
        let progress = self.progress.load(Ordering::Relaxed);
        let is_extended = self.keep.from.is_some_and(|from| from.header().spp != self.header.spp);
        // Without a sample there is nothing that would be worth the place of an older checkpoint.
        if progress > 0 && (saved != Some(progress) || is_extended) {
            self.save();
        }
        Ok(result)
    }

    /// Saves whenever it is time and something was done. Says what progress the file has.
    fn save_until(&self, end: &End, at_first: u64) -> Option<u64> {
        let mut saved = self.keep.from.map(|_| at_first);
        let mut looked = at_first;
        while !end.came_within(self.keep.every) {
            // Read first: blocks that end while it is saved count for the next time.
            let progress = self.progress.load(Ordering::Relaxed);
            if progress != looked && self.save() {
                (saved, looked) = (Some(progress), progress);
            }
        }
        saved
    }

    fn save(&self) -> bool {
        let saved = checkpoint::write(self.keep.file, &self.header, self.film, self.tiles);
        saved.inspect_err(|e| (self.keep.trouble)(e)).is_ok()
    }
}

/// Refuses more or fewer samples where the points of those that are there would have been others.
fn check_extension(was: u32, s: &Settings) -> Result<()> {
    let fixed = match (s.rule.grid(), s.sampler) {
        (Some(_), _) => format!("the points of film.rule = \"{}\"", s.rule.name()),
        (None, SamplerKind::Stratified) => "the points of the stratified sampler".to_string(),
        _ => return Ok(()),
    };
    if was == s.spp {
        return Ok(());
    }
    Err(Error::new(format!("{fixed} depend on their number, which was {was} and is {} now", s.spp))
        .advise(format!("go on with --spp {was}, or begin anew with another --checkpoint")))
}

/// Tells the saving thread that the work is over.
#[derive(Default)]
struct End {
    came: Mutex<bool>,
    changed: Condvar,
}

impl End {
    /// Waits until it comes, or for `time`.
    fn came_within(&self, time: Duration) -> bool {
        let came = self.came.lock().unwrap_or_else(PoisonError::into_inner);
        let waited = self.changed.wait_timeout_while(came, time, |came| !*came);
        *waited.unwrap_or_else(PoisonError::into_inner).0
    }
}

struct Ends<'a>(&'a End);

impl Drop for Ends<'_> {
    fn drop(&mut self) {
        *self.0.came.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.0.changed.notify_all();
    }
}
