//! One error type for the whole program, and the findings (warnings) that a lenient reader collects.
//!
//! An [`Error`] says what happened, where (file, line, column) and what to do about it, in one line.
//! A [`Findings`] list is what went wrong without stopping the work: counted by kind, capped in length.

mod words;

pub use words::{lookup, name_in, nearest, unknown_word_advice};

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};

/// `Result` with drt's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Whose fault an error is; decides the exit code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Blame {
    /// The call's words or a value in the scene file's stead (`--set`): exit code 2.
    Usage,
    /// Everything else (a file, the disk, memory): exit code 1.
    Work,
}

/// What happened, where, and what to do about it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Error {
    /// Whose fault it is.
    pub blame: Blame,
    /// What happened, without a full stop.
    pub message: String,
    /// The file it is about.
    pub file: Option<PathBuf>,
    /// 1-based line in that file.
    pub line: Option<u64>,
    /// 1-based column in that line, in characters.
    pub column: Option<u64>,
    /// What to do about it, without a full stop.
    pub advice: Option<String>,
}

impl Error {
    /// A failure of the work (exit code 1).
    pub fn new(message: impl Into<String>) -> Self {
        Error {
            blame: Blame::Work,
            message: message.into(),
            file: None,
            line: None,
            column: None,
            advice: None,
        }
    }

    /// Wrong usage (exit code 2).
    pub fn usage(message: impl Into<String>) -> Self {
        Error { blame: Blame::Usage, ..Error::new(message) }
    }

    /// An operating system's error about `file`.
    pub fn io(doing: &str, file: &Path, source: &std::io::Error) -> Self {
        Error::new(format!("cannot {doing}: {}", plain_os_reason(source))).at(file)
    }

    /// Names the file the error is about.
    pub fn at(mut self, file: impl Into<PathBuf>) -> Self {
        self.file = Some(file.into());
        self
    }

    /// Names the 1-based line.
    pub fn line(mut self, line: u64) -> Self {
        self.line = Some(line);
        self
    }

    /// Names the 1-based column.
    pub fn column(mut self, column: u64) -> Self {
        self.column = Some(column);
        self
    }

    /// Says what to do about it.
    pub fn advise(mut self, advice: impl Into<String>) -> Self {
        self.advice = Some(advice.into()).filter(|advice| !advice.is_empty());
        self
    }
}

/// The reason without Rust's "(os error N)".
fn plain_os_reason(source: &std::io::Error) -> String {
    let text = source.to_string();
    match text.rfind(" (os error") {
        Some(end) => text[..end].to_string(),
        None => text,
    }
}

/// `path` for a message: on one line, control characters escaped.
pub fn show_path(path: &Path) -> String {
    one_line(&path.to_string_lossy())
}

/// `text` with control characters escaped, so that a message stays on one line.
pub fn one_line(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        if c.is_control() { out.extend(c.escape_default()) } else { out.push(c) }
    }
    out
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(file) = &self.file {
            write!(f, "{}:", show_path(file))?;
            if let Some(line) = self.line {
                write!(f, "{line}:")?;
                if let Some(column) = self.column {
                    write!(f, "{column}:")?;
                }
            }
            write!(f, " ")?;
        }
        write!(f, "{}", one_line(&self.message))?;
        if let Some(advice) = &self.advice {
            write!(f, "; {}", one_line(advice))?;
        }
        Ok(())
    }
}

impl std::error::Error for Error {}

/// How bad a [`Finding`] is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Severity {
    /// Worth knowing; nothing was lost.
    Note,
    /// Something was skipped or replaced; `--strict` makes it an error.
    Warning,
    /// Wrong by the format's own rules (an index that points nowhere).
    Error,
}

impl Severity {
    /// The word that `drt check` prints.
    pub fn name(self) -> &'static str {
        match self {
            Severity::Note => "note",
            Severity::Warning => "warning",
            Severity::Error => "error",
        }
    }
}

/// One thing that a reader noticed and went on from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Finding {
    /// The file it is in.
    pub file: PathBuf,
    /// 1-based line; 0 where no line applies.
    pub line: u64,
    /// A stable short name in kebab-case, e.g. `face-index-out-of-range`.
    pub kind: &'static str,
    /// One sentence for people.
    pub message: String,
    /// How bad it is.
    pub severity: Severity,
}

/// Findings, counted by kind; each kind keeps its first [`Findings::KEPT`] in full.
#[derive(Clone, Debug, Default)]
pub struct Findings {
    kinds: BTreeMap<&'static str, KindOfFinding>,
}

#[derive(Clone, Debug)]
struct KindOfFinding {
    count: u64,
    severity: Severity,
    kept: Vec<Finding>,
}

impl Findings {
    /// How many findings of a kind are kept in full; the rest are only counted.
    pub const KEPT: usize = 100;

    /// Adds one finding.
    pub fn push(&mut self, finding: Finding) {
        let entry = self.kinds.entry(finding.kind).or_insert_with(|| KindOfFinding {
            count: 0,
            severity: finding.severity,
            kept: Vec::new(),
        });
        entry.count += 1;
        entry.severity = entry.severity.max(finding.severity);
        if entry.kept.len() < Self::KEPT {
            entry.kept.push(finding);
        }
    }

    /// Adds all of `other`, after what is here.
    pub fn append(&mut self, other: Findings) {
        for (kind, theirs) in other.kinds {
            let ours = self.kinds.entry(kind).or_insert_with(|| KindOfFinding {
                count: 0,
                severity: theirs.severity,
                kept: Vec::new(),
            });
            ours.count += theirs.count;
            ours.severity = ours.severity.max(theirs.severity);
            let room = Self::KEPT.saturating_sub(ours.kept.len());
            ours.kept.extend(theirs.kept.into_iter().take(room));
        }
    }

    /// Counts `count` further findings of a kind without keeping their text.
    pub fn count_more(&mut self, kind: &'static str, severity: Severity, count: u64) {
        if count > 0 {
            let entry = self.kinds.entry(kind).or_insert_with(|| KindOfFinding {
                count: 0,
                severity,
                kept: Vec::new(),
            });
            entry.count += count;
            entry.severity = entry.severity.max(severity);
        }
    }

    /// Counts by kind, in alphabetical order.
    pub fn counts(&self) -> impl Iterator<Item = (&'static str, u64, Severity)> + '_ {
        self.kinds.iter().map(|(kind, k)| (*kind, k.count, k.severity))
    }

    /// How many findings of `kind` there are.
    pub fn count(&self, kind: &str) -> u64 {
        self.kinds.get(kind).map_or(0, |k| k.count)
    }

    /// How many findings are at least as bad as `severity`.
    pub fn at_least(&self, severity: Severity) -> u64 {
        self.kinds.values().filter(|k| k.severity >= severity).map(|k| k.count).sum()
    }

    /// The findings kept in full, by kind and then in the order they were found.
    pub fn kept(&self) -> impl Iterator<Item = &Finding> + '_ {
        self.kinds.values().flat_map(|k| k.kept.iter())
    }

    /// True when nothing was found.
    pub fn is_empty(&self) -> bool {
        self.kinds.is_empty()
    }
}
