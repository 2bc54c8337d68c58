//! The flags about memory: `--max-memory` and `--compact`.

use super::args::bytes;
use clap::Args;
use drt::error::{Error, Result};
use drt::load::Override;
use drt::memory;

/// The least that `--max-memory` may be: the program and its libraries alone take about half of it.
const LEAST: u64 = 64 << 20;

/// What may be taken of the machine's memory.
#[derive(Args)]
pub struct MemoryArgs {
    /// Take at most this much memory, e.g. 2G; what needs more is refused before it is begun, with the figures
    ///
    /// Without it the limit is the control group's (of a container or batch system), that of ulimit -v, or what the
    /// machine has free, whichever is least.
    #[arg(long, value_name = "SIZE", help_heading = "Machine", allow_hyphen_values = true)]
    pub max_memory: Option<String>,

    /// Make Embree's structure a third as large; rays take about a quarter longer
    ///
    /// Short for --set render.compact=true. 70 bytes a triangle in all instead of 130; hits at edges may differ in their
    /// last bits.
    #[arg(long, help_heading = "Machine")]
    pub compact: bool,
}

impl MemoryArgs {
    /// Holds the process to the limit.
    ///
    /// # Errors
    /// No size, or one that nothing would fit into.
    pub fn limit(&self) -> Result<()> {
        let Some(word) = &self.max_memory else { return Ok(()) };
        let limit = bytes("--max-memory", word)?;
        if limit < LEAST {
            return Err(Error::usage(format!("--max-memory {word}: must be at least {}M", LEAST >> 20)));
        }
        memory::limit_process(limit);
        Ok(())
    }

    /// The scene keys that the flags stand for.
    pub fn overrides(&self) -> Result<Option<Override>> {
        self.compact.then(|| Override::flag("--compact", "render.compact", "true")).transpose()
    }
}
