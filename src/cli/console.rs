//! What people read: messages on stderr, answers on stdout. A closed pipe is no reason to fail.

use drt::error::{Error, Findings, Result, Severity, one_line, show_path};
use std::io::{self, ErrorKind, Write};
use std::path::Path;

/// How much is said.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Verbosity {
    /// Errors alone.
    Quiet,
    /// Errors, warnings, what was written.
    Normal,
    /// Phases and figures as well.
    Verbose,
}

/// Messages on stderr.
#[derive(Clone, Copy, Debug)]
pub struct Console {
    /// How much is said.
    pub verbosity: Verbosity,
}

/// Writes one line to stderr. Nobody is left to tell when that fails.
pub fn line_to_stderr(text: &str) {
    let _ = writeln!(io::stderr().lock(), "{text}");
}

/// Writes to stdout. A reader that went away (`| head`) had enough: that is no error.
pub fn write_stdout(text: &str) -> Result<()> {
    let mut out = io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(e) if e.kind() != ErrorKind::BrokenPipe => {
            Err(Error::io("write", Path::new("standard output"), &e))
        }
        _ => Ok(()),
    }
}

impl Console {
    /// The one line of a failure.
    pub fn error(message: &str) {
        line_to_stderr(&format!("error: {message}"));
    }

    /// Worth saying unless quiet was asked for.
    pub fn say(self, message: &str) {
        if self.verbosity >= Verbosity::Normal {
            line_to_stderr(message);
        }
    }

    /// Worth saying to those who asked for more.
    pub fn detail(self, message: &str) {
        if self.verbosity >= Verbosity::Verbose {
            line_to_stderr(message);
        }
    }

    /// One line a kind of finding, with its first place and its count.
    pub fn findings(self, findings: &Findings) {
        for (kind, count, severity) in findings.counts() {
            let word = if severity == Severity::Note { "note" } else { "warning" };
            self.say(&format!("{word}: {}", summary(findings, kind, count)));
        }
    }
}

/// The first finding of a kind, and how many more there are.
pub fn summary(findings: &Findings, kind: &str, count: u64) -> String {
    let first = findings.kept().find(|f| f.kind == kind);
    let first = first.map_or_else(String::new, |f| {
        let place = show_path(&f.file);
        let line = if f.line > 0 { format!("{}:", f.line) } else { String::new() };
        format!("{place}:{line} {}", one_line(&f.message))
    });
    match count {
        1 => first,
        _ => format!("{first} ({kind}: {count} in all)"),
    }
}
