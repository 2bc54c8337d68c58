//! The flag about meshes that were read before: `--cache`.

use super::console::Console;
use clap::Args;
use drt::error::Result;
use drt::load::cache::Cache;
use std::path::PathBuf;

/// Where meshes are kept.
#[derive(Args)]
pub struct CacheArgs {
    /// Keep what was read of mesh files in this folder, and take it from there next time
    ///
    /// An entry is found by the content of the mesh file, whatever its name; one that is damaged or of another version is
    /// written anew. Pictures, warnings and --strict are the same with it and without it. It takes about a third of the
    /// file's size, and with our BVH, which is kept too, as much as the file besides; anything in the folder may be deleted at any time.
    #[arg(long, value_name = "DIR", help_heading = "Machine")]
    pub cache: Option<PathBuf>,
}

impl CacheArgs {
    /// Opens the cache that is asked for.
    ///
    /// # Errors
    /// The folder cannot be made or listed.
    pub fn open(&self) -> Result<Option<Cache>> {
        self.cache.as_deref().map(Cache::open).transpose()
    }

    /// Says what it was good for.
    pub fn report(&self, cache: &Cache, console: Console) {
        console.findings(&cache.take_findings());
        let (hits, misses) = cache.served();
        let tree = if cache.had_tree() { " and the acceleration structure" } else { "" };
        console.detail(&format!("the cache had {hits} of {} mesh files{tree}", hits + misses));
    }
}
