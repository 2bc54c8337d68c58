//! How an input is opened that is no scene file.

use clap::Args;
use drt::error::Result;
use drt::load::{Format, Opening};

/// The flags of every subcommand that reads a mesh.
#[derive(Args)]
pub struct InputArgs {
    /// The format of the input mesh (obj, ply, stl …), whatever its name says
    #[arg(long, value_name = "NAME", help_heading = "Input")]
    pub format: Option<String>,

    /// What a .gz or .zst may unpack to, e.g. 16G; 256M, or 64 times its size if that is more, by default
    #[arg(long, value_name = "SIZE", help_heading = "Input", allow_hyphen_values = true)]
    pub max_unpacked: Option<String>,
}

impl InputArgs {
    /// What the flags say.
    ///
    /// # Errors
    /// An unknown format; no number of bytes.
    pub fn opening(&self) -> Result<Opening> {
        let format =
            self.format.as_deref().map(|name| super::render::at_flag("--format", Format::named(name)));
        let max = self.max_unpacked.as_deref().map(|word| super::args::bytes("--max-unpacked", word));
        Ok(Opening { format: format.transpose()?, max_unpacked: max.transpose()? })
    }
}
