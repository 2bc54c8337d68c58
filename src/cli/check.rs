//! `drt check INPUT`: what is in the file and what is wrong with it.

mod as_json;
mod page;

use super::console::{summary, write_stdout};
use super::secure::SecureArgs;
use super::signals::Signals;
use super::{Failure, machine};
use clap::Args;
use drt::check::{self, Report};
use drt::error::{Error, Result, Severity, unknown_word_advice};
use drt::load::open::Reach;
use std::path::{Path, PathBuf};

/// The flags of `drt check`.
#[derive(Args)]
pub struct CheckArgs {
    /// A mesh (`-` is standard input) or a scene file (.toml)
    #[arg(value_name = "MESH|SCENE.toml")]
    pub input: PathBuf,

    #[command(flatten)]
    pub opening: super::input::InputArgs,

    /// Write all of it as JSON to standard output
    #[arg(long)]
    pub json: bool,

    /// Fail on warnings too
    #[arg(long)]
    pub strict: bool,

    /// Compare what is read with another reader's result: tobj (in builds with the feature of that name)
    #[arg(long, value_name = "READER")]
    pub against: Option<String>,

    #[command(flatten)]
    pub files: SecureArgs,
}

/// Checks, prints, and fails if something is wrong.
///
/// # Errors
/// A file that cannot be read; errors in it, with `--strict` also warnings; a signal.
pub fn run(args: &CheckArgs) -> Result<(), Failure> {
    let against = args.against.as_deref().map(against).transpose()?;
    let opening = args.opening.opening()?;
    let signals = Signals::listen()?;
    signals.nothing_to_lose("checking");
    let threads = machine::threads();
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|e| Error::new(format!("cannot start {threads} threads: {e}")))?;
    let progress = |_| !signals.stop();
    let work = || {
        let reach = args.files.reach(&args.input)?;
        let mut report = check::check(&args.input, opening, &reach, &progress)?;
        if let Some(against) = against {
            report.findings.append(against(&args.input, &reach, &progress)?);
        }
        Ok(report)
    };
    let report = pool.install(work).map_err(|error| match signals.received() {
        Some((signal, name)) => {
            Failure::Stopped { signal, message: format!("stopped by {name} while checking") }
        }
        None => Failure::Error(error),
    })?;
    write_stdout(&if args.json { as_json::text(&report) } else { page::text(&report) })?;
    Ok(judge(&report, args.strict)?)
}

/// The first error, or with `strict` the first warning, with how many there are.
fn judge(report: &Report, strict: bool) -> Result<()> {
    let findings = &report.findings;
    let (least, word) = match findings.at_least(Severity::Error) {
        0 if strict => (Severity::Warning, "warnings, and --strict allows none"),
        _ => (Severity::Error, "errors"),
    };
    let bad = findings.counts().filter(|(_, _, severity)| *severity >= least);
    let Some((kind, count, _)) = bad.into_iter().next() else { return Ok(()) };
    let first = summary(findings, kind, count);
    let total = findings.at_least(least);
    Err(Error::new(if total == count { first } else { format!("{first}; {total} {word}") }))
}

type Against = fn(&Path, &Reach, &(dyn Fn(f64) -> bool + Sync)) -> Result<drt::error::Findings>;

/// The comparison with the reader of that name.
fn against(name: &str) -> Result<Against> {
    match name {
        #[cfg(feature = "tobj")]
        "tobj" => Ok(check::against_tobj::compare),
        #[cfg(not(feature = "tobj"))]
        "tobj" => Err(Error::usage("--against tobj: this build has no tobj")
            .advise("build it with cargo build --release --features tobj")),
        _ => Err(Error::usage(format!("--against: unknown reader \"{name}\""))
            .advise(unknown_word_advice(name, &["tobj"]))),
    }
}
