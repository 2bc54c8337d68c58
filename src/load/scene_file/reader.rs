//! Typed reading of the tree. Every key is asked for by name and range; a key that nobody asked for is an
//! error with a suggestion, so a misspelt word never passes in silence.

use super::tree::{Entries, Entry, Node, Origin, Value, locate};
use crate::error::{Error, Result, nearest, unknown_word_advice};
use crate::math::{DVec3, Rgb};
use std::ops::RangeInclusive;
use std::path::Path;

/// Coordinates and lengths: what the intersectors can hold.
pub(crate) const COORDINATE: RangeInclusive<f64> = -1e18..=1e18;
/// Lengths that must not vanish.
pub(crate) const LENGTH: RangeInclusive<f64> = 1e-18..=1e18;
/// Shares of light: reflectances.
pub(crate) const SHARE: RangeInclusive<f64> = 0.0..=1.0;
/// Radiance, intensity.
pub(crate) const LIGHT: RangeInclusive<f64> = 0.0..=1e12;

/// A table that is being read.
pub(crate) struct Section<'t> {
    /// Dotted name for messages, e.g. `film.filter`; empty at the top.
    name: String,
    entries: &'t Entries,
    file: &'t Path,
    asked: Vec<&'static str>,
    /// Keys that somebody else reads.
    taken: Vec<&'t str>,
}

/// A value with its dotted name.
#[derive(Clone)]
pub(crate) struct Field<'t> {
    name: String,
    node: &'t Node,
    file: &'t Path,
}

impl<'t> Section<'t> {
    /// The whole file.
    pub fn top(entries: &'t Entries, file: &'t Path) -> Self {
        Section { name: String::new(), entries, file, asked: Vec::new(), taken: Vec::new() }
    }

    fn full_name(&self, key: &str) -> String {
        if self.name.is_empty() { key.to_string() } else { format!("{}.{key}", self.name) }
    }

    fn field(&self, key: &str, entry: &'t Entry) -> Field<'t> {
        Field { name: self.full_name(key), node: &entry.node, file: self.file }
    }

    /// The value of `key`, if it is there. Asking makes the key a known one.
    pub fn get(&mut self, key: &'static str) -> Option<Field<'t>> {
        self.asked.push(key);
        if self.taken.contains(&key) {
            return None;
        }
        self.entries.get(key).map(|entry| self.field(key, entry))
    }

    /// The entries that `which` is true of, by name; for everybody else they are not there.
    pub fn take(&mut self, which: impl Fn(&Field<'t>) -> bool) -> Vec<(&'t str, Field<'t>)> {
        let mut taken = self.all();
        taken.retain(|(key, field)| !self.asked.contains(key) && which(field));
        self.taken.extend(taken.iter().map(|(key, _)| *key));
        taken
    }

    /// Reads `key` where it is there.
    pub fn read<T>(
        &mut self,
        key: &'static str,
        how: impl FnOnce(Field<'t>) -> Result<T>,
    ) -> Result<Option<T>> {
        self.get(key).map(how).transpose()
    }

    /// Every entry by its free name, for tables of named things.
    pub fn all(&self) -> Vec<(&'t str, Field<'t>)> {
        self.entries.iter().map(|(key, entry)| (key.as_str(), self.field(key, entry))).collect()
    }

    /// The error for a table, `field`, without the `key` that it needs; a key much like it is named.
    pub fn missing(&self, field: &Field<'_>, key: &str) -> Error {
        let error = field.error(format!("{} has no {key}", field.name));
        let others = self.entries.keys().map(String::as_str).filter(|other| !self.asked.contains(other));
        match nearest(key, others) {
            Some(other) => error.advise(format!("it has \"{other}\"")),
            None => error,
        }
    }

    /// Refuses every key that was not asked for.
    pub fn finish(self) -> Result<()> {
        let is_known = |key: &str| self.asked.contains(&key) || self.taken.contains(&key);
        let unknown = self.entries.iter().filter(|(key, _)| !is_known(key));
        // The tree is sorted by name; people read files from the top.
        let first = unknown.min_by_key(|(_, entry)| match entry.key_origin {
            Origin::File { line, column } => (line, column),
            Origin::Flag(_) => (u64::MAX, 0),
        });
        match first {
            None => Ok(()),
            Some((key, entry)) => {
                let section = if self.name.is_empty() { String::new() } else { format!(" in {}", self.name) };
                let error = Error::new(format!("unknown key \"{key}\"{section}"))
                    .advise(unknown_word_advice(key, &self.asked));
                Err(locate(error, &entry.key_origin, self.file))
            }
        }
    }
}

impl<'t> Field<'t> {
    /// The dotted name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Where it stands: line for findings, 0 for a flag.
    pub fn line(&self) -> u64 {
        match self.node.origin {
            Origin::File { line, .. } => line,
            Origin::Flag(_) => 0,
        }
    }

    /// The file it stands in, or would.
    pub fn file(&self) -> &'t Path {
        self.file
    }

    /// True for a table with a `texture`.
    pub fn is_texture(&self) -> bool {
        matches!(&self.node.value, Value::Table(entries) if entries.contains_key("texture"))
    }

    /// An error about this value.
    pub fn error(&self, message: impl Into<String>) -> Error {
        self.locate(Error::new(message))
    }

    /// `error` at this value's place.
    pub fn locate(&self, error: Error) -> Error {
        locate(error, &self.node.origin, self.file)
    }

    pub fn must_be(&self, what: &str) -> Error {
        self.error(format!("{} must be {what}, not {}", self.name, self.node.value.show()))
    }

    fn float(&self) -> Option<f64> {
        match self.node.value {
            Value::Float(x) => Some(x),
            Value::Integer(i) => Some(i as f64),
            _ => None,
        }
    }

    /// A number of the range.
    pub fn number(&self, range: RangeInclusive<f64>) -> Result<f64> {
        self.float().filter(|x| range.contains(x)).ok_or_else(|| self.must_be(&describe(&range)))
    }

    /// A whole number of the range; also written as text, since TOML's own integers end at 2⁶³.
    pub fn integer(&self, range: RangeInclusive<u64>) -> Result<u64> {
        let integer = match &self.node.value {
            Value::Integer(i) => Some(*i),
            Value::Text(text) => text.parse().ok(),
            _ => None,
        };
        let integer = integer.and_then(|i| u64::try_from(i).ok()).filter(|i| range.contains(i));
        integer
            .ok_or_else(|| self.must_be(&format!("a whole number from {} to {}", range.start(), range.end())))
    }

    /// A whole number that fits `u32`; `range` in `u32`.
    pub fn integer32(&self, range: RangeInclusive<u32>) -> Result<u32> {
        let wide = self.integer(u64::from(*range.start())..=u64::from(*range.end()))?;
        u32::try_from(wide).map_err(|_| self.must_be("smaller"))
    }

    /// `true` or `false`.
    pub fn bool(&self) -> Result<bool> {
        match self.node.value {
            Value::Bool(b) => Ok(b),
            _ => Err(self.must_be("true or false")),
        }
    }

    /// Text.
    pub fn text(&self) -> Result<&'t str> {
        match &self.node.value {
            Value::Text(text) => Ok(text),
            _ => Err(self.must_be("text")),
        }
    }

    /// A word of a list: looked up by `from_name`; words in `later` are known and not yet there.
    pub fn word<T>(&self, later: &[&str], from_name: impl FnOnce(&str) -> Result<T>) -> Result<T> {
        let word = self.text()?;
        match from_name(word) {
            Err(_) if later.contains(&word) => {
                Err(self.error(format!("{} \"{word}\" is not supported by this version", self.name)))
            }
            other => other.map_err(|e| self.locate(e)),
        }
    }

    /// The items of a list; `what` for the message.
    pub fn list(&self, what: &str) -> Result<Vec<Field<'t>>> {
        match &self.node.value {
            Value::List(items) => Ok(items
                .iter()
                .enumerate()
                .map(|(i, node)| Field { name: format!("{}.{i}", self.name), node, file: self.file })
                .collect()),
            _ => Err(self.must_be(what)),
        }
    }

    /// Exactly `N` numbers of the range.
    pub fn numbers<const N: usize>(&self, range: RangeInclusive<f64>) -> Result<[f64; N]> {
        let what = format!("a list of {N} numbers");
        let items = self.list(&what)?;
        if items.len() != N {
            return Err(self.must_be(&what));
        }
        let mut numbers = [0.0; N];
        for (number, item) in numbers.iter_mut().zip(items) {
            *number = item.number(range.clone())?;
        }
        Ok(numbers)
    }

    /// Exactly `N` whole numbers of the range.
    pub fn integers<const N: usize>(&self, range: RangeInclusive<u32>) -> Result<[u32; N]> {
        let what = format!("a list of {N} whole numbers");
        let items = self.list(&what)?;
        if items.len() != N {
            return Err(self.must_be(&what));
        }
        let mut numbers = [0; N];
        for (number, item) in numbers.iter_mut().zip(items) {
            *number = item.integer32(range.clone())?;
        }
        Ok(numbers)
    }

    /// A point or direction in the file's coordinates.
    pub fn point(&self) -> Result<DVec3> {
        self.numbers(COORDINATE).map(DVec3::from_array)
    }

    /// A colour: three numbers of the range, or one for all three.
    pub fn color(&self, range: RangeInclusive<f64>) -> Result<Rgb> {
        let what = format!("a colour [r, g, b], or one number for all three, {}", describe_range(&range));
        match &self.node.value {
            Value::Float(_) | Value::Integer(_) => {
                let x = self.float().filter(|x| range.contains(x)).ok_or_else(|| self.must_be(&what))?;
                Ok(Rgb::splat(x as f32))
            }
            Value::List(items) if items.len() == 3 => {
                let [r, g, b] = self.numbers(range)?;
                Ok(Rgb::new(r as f32, g as f32, b as f32))
            }
            Value::Table(entries) if entries.contains_key("texture") => {
                Err(self.error(format!("{} takes no texture", self.name)))
            }
            _ => Err(self.must_be(&what)),
        }
    }

    /// A table.
    pub fn section(&self) -> Result<Section<'t>> {
        match &self.node.value {
            Value::Table(entries) => {
                let (asked, taken) = (Vec::new(), Vec::new());
                Ok(Section { name: self.name.clone(), entries, file: self.file, asked, taken })
            }
            Value::List(items) if matches!(items.first().map(|i| &i.value), Some(Value::Table(_))) => {
                Err(self.must_be("one table").advise(format!("write [{}] in single brackets", self.name)))
            }
            _ => Err(self.must_be("a table")),
        }
    }

    /// A table, or the word that is short for a table with that `type`.
    pub fn shorthand(&self) -> Result<Shorthand<'t>> {
        match &self.node.value {
            Value::Table(_) => self.section().map(Shorthand::Table),
            Value::Text(_) => Ok(Shorthand::Word(self.clone())),
            _ => Err(self.must_be("a name or a table")),
        }
    }
}

/// What [`Field::shorthand`] finds.
pub(crate) enum Shorthand<'t> {
    /// A name alone.
    Word(Field<'t>),
    /// A table, perhaps with a `type`.
    Table(Section<'t>),
}

fn describe(range: &RangeInclusive<f64>) -> String {
    format!("a number {}", describe_range(range))
}

fn describe_range(range: &RangeInclusive<f64>) -> String {
    format!("from {} to {}", show(*range.start()), show(*range.end()))
}

/// Large and tiny limits in powers of ten, others as they are.
fn show(x: f64) -> String {
    if x != 0.0 && (x.abs() >= 1e6 || x.abs() < 1e-4) { format!("{x:e}") } else { format!("{x}") }
}
