//! `--secure`: which files an input may name.

use clap::Args;
use drt::error::Result;
use drt::load::open::Reach;
use std::path::Path;

/// The flag that every command with an input has.
#[derive(Args)]
pub struct SecureArgs {
    /// Read no file outside of the input's folder, whatever the input names
    ///
    /// For files of others: libraries, textures, meshes and skies that an input names are read only where they are,
    /// links followed, in the input's folder or below it. What is elsewhere is refused with the line that names it.
    #[arg(long, help_heading = "Files")]
    pub secure: bool,
}

impl SecureArgs {
    /// The files that `input` may name.
    ///
    /// # Errors
    /// Its folder cannot be opened.
    pub fn reach(&self, input: &Path) -> Result<Reach> {
        if self.secure { Reach::folder_of(input) } else { Ok(Reach::Anywhere) }
    }
}
