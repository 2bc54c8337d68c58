//! TOML text becomes a tree whose every node knows where it came from: a place in the file, or a word of
//! the command line.

use crate::error::{Error, Result};
use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Where a value came from.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum Origin {
    /// 1-based line and column of the scene file.
    File { line: u64, column: u64 },
    /// A flag, as the user would write it, e.g. `--spp` or `--set film.filter`.
    Flag(Arc<str>),
}

/// A value with its origin.
#[derive(Clone, Debug)]
pub(crate) struct Node {
    pub value: Value,
    pub origin: Origin,
}

/// A table's entry: the key's own origin is where an unknown key is reported.
#[derive(Clone, Debug)]
pub(crate) struct Entry {
    pub key_origin: Origin,
    pub node: Node,
}

/// The entries of a table by name.
pub(crate) type Entries = BTreeMap<String, Entry>;

/// TOML's kinds of values. Integers are wider than TOML's, so that a `u64` seed fits.
#[derive(Clone, Debug)]
pub(crate) enum Value {
    Bool(bool),
    Integer(i128),
    Float(f64),
    Text(String),
    List(Vec<Node>),
    Table(Entries),
}

impl Value {
    /// The value as a message shows it: short, on one line.
    pub fn show(&self) -> String {
        match self {
            Value::Bool(b) => b.to_string(),
            Value::Integer(i) => i.to_string(),
            Value::Float(x) => format!("{x}"),
            Value::Text(t) if t.chars().count() > 60 => {
                format!("\"{}…\"", t.chars().take(60).collect::<String>())
            }
            Value::Text(t) => format!("\"{t}\""),
            Value::List(items) => format!("a list of {}", items.len()),
            Value::Table(_) => "a table".to_string(),
        }
    }
}

impl Node {
    /// A node that a flag of the command line stands for.
    pub fn from_flag(value: Value, flag: &Arc<str>) -> Node {
        Node { value, origin: Origin::Flag(flag.clone()) }
    }
}

/// Puts the place of `origin` into an error about it, and the blame where it belongs.
pub(crate) fn locate(mut error: Error, origin: &Origin, file: &Path) -> Error {
    match origin {
        Origin::File { line, column } => {
            error.blame = crate::error::Blame::Work;
            error.at(file).line(*line).column(*column)
        }
        Origin::Flag(flag) => {
            error.blame = crate::error::Blame::Usage;
            error.message = format!("{flag}: {}", error.message);
            error
        }
    }
}

/// Where lines begin, to turn byte offsets into lines and columns.
struct Lines<'t> {
    text: &'t [u8],
    starts: Vec<usize>,
    /// How many characters begin before each [`Lines::STEP`] bytes, so that a long line's places are soon counted.
    before: Vec<usize>,
}

impl<'t> Lines<'t> {
    const STEP: usize = 256;

    fn new(text: &'t str) -> Self {
        let text = text.as_bytes();
        let ends = text.iter().enumerate().filter(|(_, b)| **b == b'\n').map(|(i, _)| i + 1);
        let starts = std::iter::once(0).chain(ends).collect();
        let mut sum = 0;
        let before = text.chunks(Self::STEP).map(|step| {
            let before = sum;
            sum += characters(step);
            before
        });
        Lines { text, starts, before: before.collect() }
    }

    /// Characters that begin before `offset`.
    fn characters_before(&self, offset: usize) -> usize {
        let step = (offset / Self::STEP).min(self.before.len().saturating_sub(1));
        let rest = self.text.get(step * Self::STEP..offset).unwrap_or_default();
        self.before.get(step).copied().unwrap_or(0) + characters(rest)
    }

    fn origin(&self, offset: usize) -> Origin {
        let line = self.starts.partition_point(|start| *start <= offset).max(1);
        let start = self.starts.get(line - 1).copied().unwrap_or(0);
        let column = self.characters_before(offset).saturating_sub(self.characters_before(start));
        Origin::File { line: line as u64, column: column as u64 + 1 }
    }
}

/// How many characters of UTF-8 begin in `bytes`.
fn characters(bytes: &[u8]) -> usize {
    bytes.iter().filter(|byte| **byte & 0xc0 != 0x80).count()
}

/// Parses a scene file's text.
///
/// # Errors
/// What is no TOML, with line and column.
pub(crate) fn parse(text: &str, file: &Path) -> Result<Entries> {
    let lines = Lines::new(text);
    let table = DeTable::parse(text).map_err(|e| {
        let origin = lines.origin(e.span().map_or(0, |span| span.start));
        let error = Error::new(e.message().replace('\n', ", ")).advise(advice(e.message()));
        locate(error, &origin, file)
    })?;
    let place = |span: std::ops::Range<usize>| lines.origin(span.start);
    entries(table.into_inner(), &place)
        .map_err(|(origin, message)| locate(Error::new(message), &origin, file))
}

/// What to do about text that is no TOML, by words of the parser's message: it says what it expected, in the
/// grammar's terms, and people want to know what to write.
#[rustfmt::skip] // a table
fn advice(message: &str) -> &'static str {
    const BY_WORDS: &[(&str, &str)] = &[
        ("duplicate", "a key or a [section] may stand only once; [[mesh]] and [[light]] may repeat"),
        ("escape", "in \"…\" a backslash begins an escape: write paths with /, or in single quotes"),
        ("carriage return", "end lines with LF or CRLF"),
        ("basic string", "the text has no closing quote"),
        ("literal string, expected `'`", "the text has no closing quote"),
        ("key with no value", "write key = value; a comment begins with #"),
        ("key-value pair", "write key = value; a comment begins with #"),
        ("array", "a list is [1, 2, 3]: commas between its items, ] at its end"),
        ("mantissa", NUMBERS),
        ("fraction", NUMBERS),
        ("float", NUMBERS),
        ("expected newline", NUMBERS),
    ];
    const NUMBERS: &str = "numbers have digits on both sides of a point, no comma and no unit: 0.5, 40.0";
    const VALUES: &str = "a value is a number, true, false, \"text\" in quotes, or a list [1, 2, 3]";
    BY_WORDS.iter().find(|(word, _)| message.contains(word)).map_or(VALUES, |(_, advice)| advice)
}

/// Parses what stands behind `=` of `--set KEY=VALUE`: a TOML value, or else a bare word.
///
/// # Errors
/// What looks like a TOML string, list or table and is none.
pub(crate) fn parse_flag_value(text: &str, flag: &Arc<str>) -> Result<Node> {
    let here = Origin::Flag(flag.clone());
    let place = |_: std::ops::Range<usize>| here.clone();
    let bare = || Node::from_flag(Value::Text(text.to_string()), flag);
    match DeValue::parse(text) {
        Ok(value) => node(value, &place).map_err(|(_, message)| Error::usage(format!("{flag}: {message}"))),
        Err(e) if text.trim_start().starts_with(['[', '{', '"', '\'']) => {
            Err(Error::usage(format!("{flag}: {}", e.message().replace('\n', ", ")))
                .advise("write the value as in a scene file, e.g. [1, 2, 3] or \"text\""))
        }
        Err(_) => Ok(bare()),
    }
}

type Place<'p> = dyn Fn(std::ops::Range<usize>) -> Origin + 'p;
type Failure = (Origin, String);

fn entries(table: DeTable<'_>, place: &Place<'_>) -> Result<Entries, Failure> {
    table
        .into_iter()
        .map(|(key, value)| {
            let key_origin = place(key.span());
            Ok((key.into_inner().into_owned(), Entry { key_origin, node: node(value, place)? }))
        })
        .collect()
}

fn node(spanned: Spanned<DeValue<'_>>, place: &Place<'_>) -> Result<Node, Failure> {
    let origin = place(spanned.span());
    let value = match spanned.into_inner() {
        DeValue::Boolean(b) => Value::Bool(b),
        DeValue::String(text) => Value::Text(text.into_owned()),
        DeValue::Datetime(time) => Value::Text(time.to_string()),
        DeValue::Integer(i) => match i128::from_str_radix(i.as_str(), i.radix()) {
            Ok(integer) => Value::Integer(integer),
            Err(_) => return Err((origin, format!("the number {i} is too large"))),
        },
        DeValue::Float(x) => match x.as_str().parse() {
            Ok(float) => Value::Float(float),
            Err(_) => return Err((origin, format!("{} is no number", x.as_str()))),
        },
        DeValue::Array(items) => {
            let nodes: Result<Vec<Node>, Failure> = items.into_iter().map(|item| node(item, place)).collect();
            Value::List(nodes?)
        }
        DeValue::Table(table) => Value::Table(entries(table, place)?),
    };
    Ok(Node { value, origin })
}
