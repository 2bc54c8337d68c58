//! `--set KEY=VALUE`, and every flag that is short for it: values from the command line go into the tree
//! before it is read, so that they meet the same checks as the file's.

use super::tree::{Entries, Entry, Node, Origin, Value, parse_flag_value};
use crate::error::{Error, Result};
use std::sync::Arc;

/// A key of the scene file with a value from the command line.
#[derive(Clone, Debug)]
pub struct Override {
    path: Vec<String>,
    flag: Arc<str>,
    value: Node,
}

impl Override {
    /// `KEY=VALUE` as behind `--set`.
    ///
    /// # Errors
    /// No `=`, an empty part of the key, or a value that is no TOML.
    pub fn parse(text: &str) -> Result<Override> {
        let shape = || {
            Error::usage(format!("--set {text}: not of the form KEY=VALUE"))
                .advise("for example --set film.filter=gaussian")
        };
        let (key, value) = text.split_once('=').ok_or_else(shape)?;
        let path = split_key(key.trim()).ok_or_else(shape)?;
        let flag: Arc<str> = format!("--set {}", key.trim()).into();
        Ok(Override { path, value: parse_flag_value(value.trim(), &flag)?, flag })
    }

    /// The flag `flag` with the word `value`, which stands for the key `key`.
    ///
    /// # Errors
    /// A word that begins like a TOML list, table or string and is none.
    pub fn flag(flag: &str, key: &str, value: &str) -> Result<Override> {
        let flag: Arc<str> = flag.into();
        let value = parse_flag_value(value, &flag)?;
        Ok(Override { path: key.split('.').map(str::to_string).collect(), value, flag })
    }

    /// The flag `flag` with a name, which stands for the key `key`; a name is text whatever it looks like.
    pub fn name(flag: &str, key: &str, name: &str) -> Override {
        Override::value(flag, key, Value::Text(name.to_string()))
    }

    /// The flag `flag` with several words (names or whole numbers), which stand for the list `key`.
    pub fn list<'w>(flag: &str, key: &str, words: impl IntoIterator<Item = &'w str>) -> Override {
        let origin: Arc<str> = flag.into();
        let item = |word: &str| Node::from_flag(Value::Text(word.trim().to_string()), &origin);
        Override::value(flag, key, Value::List(words.into_iter().map(item).collect()))
    }

    fn value(flag: &str, key: &str, value: Value) -> Override {
        let flag: Arc<str> = flag.into();
        let path = key.split('.').map(str::to_string).collect();
        Override { path, value: Node::from_flag(value, &flag), flag }
    }

    /// Puts the value into the tree.
    ///
    /// # Errors
    /// A key below a value that has none, or an index outside its list.
    pub(crate) fn apply(self, tree: &mut Entries) -> Result<()> {
        let Override { path, flag, value } = self;
        let mut walk = Walk { flag, done: String::new() };
        let Some((first, rest)) = path.split_first() else { return Ok(()) };
        let origin = Origin::Flag(walk.flag.clone());
        walk.done.push_str(first);
        match rest {
            [] => {
                tree.insert(first.clone(), Entry { key_origin: origin, node: value });
                Ok(())
            }
            [next, ..] => {
                let entry = tree.entry(first.clone()).or_insert_with(|| walk.missing(first, next));
                walk.set(&mut entry.node, rest, value)
            }
        }
    }
}

/// The dotted parts of a key; a part in quotes may hold dots. `None` when a part is empty.
fn split_key(key: &str) -> Option<Vec<String>> {
    let mut parts = vec![String::new()];
    let mut quoted = false;
    for c in key.chars() {
        match c {
            '"' => quoted = !quoted,
            '.' if !quoted => parts.push(String::new()),
            _ => parts.last_mut()?.push(c),
        }
    }
    (!quoted && parts.iter().all(|p| !p.is_empty())).then_some(parts)
}

/// The way from the top of the tree to the place of the value.
struct Walk {
    flag: Arc<str>,
    /// The part of the key already walked, for messages.
    done: String,
}

impl Walk {
    /// What a missing `key` with the child `next` is taken for: `mesh.0` and `light.0` are lists.
    fn missing(&self, key: &str, next: &str) -> Entry {
        let is_list = matches!(key, "mesh" | "light") && next.parse::<usize>().is_ok();
        let value = if is_list { Value::List(Vec::new()) } else { Value::Table(Entries::new()) };
        Entry { key_origin: Origin::Flag(self.flag.clone()), node: Node::from_flag(value, &self.flag) }
    }

    /// Sets `value` below `node`, where `path` is not empty.
    fn set(&mut self, node: &mut Node, path: &[String], value: Node) -> Result<()> {
        let Some((key, rest)) = path.split_first() else {
            *node = value;
            return Ok(());
        };
        self.promote(node);
        let parent = std::mem::take(&mut self.done);
        self.done = format!("{parent}.{key}");
        match &mut node.value {
            Value::Table(entries) => {
                let next = rest.first().map_or("", String::as_str);
                let entry = entries.entry(key.clone()).or_insert_with(|| self.missing(key, next));
                self.set(&mut entry.node, rest, value)
            }
            Value::List(items) => {
                let count = items.len();
                let index = key.parse::<usize>().ok().filter(|i| *i <= count).ok_or_else(|| {
                    Error::usage(format!("{}: {parent} is a list of {count}, it has no \"{key}\"", self.flag))
                        .advise(format!("count from 0; {parent}.{count} adds one"))
                })?;
                if index == count {
                    items.push(Node::from_flag(Value::Table(Entries::new()), &self.flag));
                }
                match items.get_mut(index) {
                    Some(item) => self.set(item, rest, value),
                    None => Ok(()),
                }
            }
            other => {
                Err(Error::usage(format!("{}: {parent} is {}, it has no keys", self.flag, other.show())))
            }
        }
    }

    /// A shorthand (`filter = "gaussian"`) becomes its table (`{ type = "gaussian" }`).
    fn promote(&self, node: &mut Node) {
        if let Value::Text(_) = node.value {
            let kind = node.clone();
            let entry = Entry { key_origin: kind.origin.clone(), node: kind };
            node.value = Value::Table(Entries::from([("type".to_string(), entry)]));
        }
    }
}
