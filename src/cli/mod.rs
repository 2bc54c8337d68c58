//! The command line: one file a subcommand, and the only code that prints.

mod args;
mod cache;
mod check;
mod checkpoint;
mod compare;
mod console;
mod converge;
mod diff;
mod help;
mod input;
mod machine;
mod memory;
mod panics;
mod paths;
mod progress;
mod render;
mod secure;
mod signals;
mod stats;
mod words;

use args::{Cli, Command};
use clap::{CommandFactory, FromArgMatches};
use console::{Console, write_stdout};
use drt::error::{Blame, Error};
use std::process::ExitCode;

/// Why a subcommand did not end well.
enum Failure {
    /// An error; its blame is the exit code.
    Error(Error),
    /// A signal, and what became of the work.
    Stopped { signal: i32, message: String },
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Failure::Error(error)
    }
}

/// Runs the program and says how it ended.
pub fn main() -> ExitCode {
    panics::silence();
    signals::outlive_file_size_limit();
    let ended = panics::catch(|| match parse() {
        Ok(Some(cli)) => run(cli),
        Ok(None) => Ok(()),
        Err(error) => Err(error.into()),
    });
    let code = match ended {
        Ok(Ok(())) => 0,
        Ok(Err(Failure::Error(error))) => {
            Console::error(&error.to_string());
            if error.blame == Blame::Usage { 2 } else { 1 }
        }
        Ok(Err(Failure::Stopped { signal, message })) => {
            Console::error(&message);
            128 + signal as u8
        }
        Err(panic) => {
            Console::error(&format!("internal error: {panic}; please report it"));
            1
        }
    };
    ExitCode::from(code)
}

/// The parsed words; `None` when help was asked for and given.
fn parse() -> Result<Option<Cli>, Error> {
    let command = Cli::command().after_long_help(help::topics()).after_help(help::SHORT);
    let command = command.mut_subcommand("converge", |converge| converge.after_help(help::converge()));
    let command = command.mut_subcommand("diff-backends", |diff| diff.after_help(help::DIFF));
    let parsed = command.try_get_matches().and_then(|matches| Cli::from_arg_matches(&matches));
    match parsed {
        Ok(cli) => Ok(Some(cli)),
        Err(e) if !e.use_stderr() => write_stdout(&e.render().to_string()).map(|()| None),
        Err(e) => Err(words::usage_error(&e, std::env::args_os().skip(1))),
    }
}

fn run(cli: Cli) -> Result<(), Failure> {
    if cli.version {
        return Ok(write_stdout(&help::version())?);
    }
    match cli.command {
        Some(Command::Render(render)) => render::run(*render),
        Some(Command::Check(check)) => check::run(&check),
        Some(Command::Compare(compare)) => compare::run(&compare),
        Some(Command::Converge(converge)) => converge::run(*converge),
        Some(Command::DiffBackends(diff)) => diff::run(diff),
        None => render::run(cli.render),
    }
}
