//! A value of the JSON document with the way to it: `meshes[3].primitives[0].indices`. What is missing or of the
//! wrong kind is said by that way; nothing of the document itself is repeated.

use crate::error::{Error, Result};
use serde_json::Value;
use std::path::Path;

/// A value and where it stands.
#[derive(Clone)]
pub(super) struct Item<'d> {
    pub value: &'d Value,
    pub way: String,
    file: &'d Path,
}

impl<'d> Item<'d> {
    /// The whole document.
    pub fn root(value: &'d Value, file: &'d Path) -> Item<'d> {
        Item { value, way: String::new(), file }
    }

    /// What is wrong with it.
    pub fn error(&self, what: &str) -> Error {
        let separator = if self.way.is_empty() { "" } else { " " };
        Error::new(format!("{}{separator}{what}", self.way)).at(self.file)
    }

    /// The member of that name, if it is there.
    pub fn get(&self, key: &str) -> Option<Item<'d>> {
        let value = self.value.get(key).filter(|value| !value.is_null())?;
        let dot = if self.way.is_empty() { "" } else { "." };
        Some(Item { value, way: format!("{}{dot}{key}", self.way), file: self.file })
    }

    /// The member of that name.
    ///
    /// # Errors
    /// It is not there.
    pub fn need(&self, key: &str) -> Result<Item<'d>> {
        self.get(key).ok_or_else(|| self.error(&format!("has no \"{key}\"")))
    }

    /// What an extension says of it.
    pub fn extension(&self, name: &str) -> Option<Item<'d>> {
        self.get("extensions")?.get(name)
    }

    /// Item `index` of the list of that name.
    ///
    /// # Errors
    /// It is not there.
    pub fn at(&self, key: &str, index: usize) -> Result<Item<'d>> {
        let list = self.need(key)?;
        let way = format!("{}[{index}]", list.way);
        match list.value.get(index) {
            Some(value) => Ok(Item { value, way, file: self.file }),
            None => Err(Error::new(format!("{way} does not exist")).at(self.file)),
        }
    }

    /// How many items the list of that name has; 0 where it is not there.
    pub fn count(&self, key: &str) -> usize {
        self.value.get(key).and_then(Value::as_array).map_or(0, Vec::len)
    }

    /// The items of the list of that name.
    pub fn list(&self, key: &str) -> impl Iterator<Item = Item<'d>> + use<'d> {
        let list = self.get(key);
        let count = self.count(key);
        (0..count).filter_map(move |i| {
            let list = list.as_ref()?;
            Some(Item { value: list.value.get(i)?, way: format!("{}[{i}]", list.way), file: list.file })
        })
    }

    /// A member that names an item of a list: an index from 0.
    ///
    /// # Errors
    /// It is no index.
    pub fn index(&self, key: &str) -> Result<Option<usize>> {
        self.get(key).map(|item| item.as_index()).transpose()
    }

    /// The value as an index from 0.
    ///
    /// # Errors
    /// It is none.
    pub fn as_index(&self) -> Result<usize> {
        let index = self.value.as_u64().and_then(|index| usize::try_from(index).ok());
        index.ok_or_else(|| self.error("must be a whole number"))
    }

    /// A number of bytes or things.
    ///
    /// # Errors
    /// It is none; without a default, it is not there.
    pub fn size(&self, key: &str, default: Option<usize>) -> Result<usize> {
        match (self.index(key)?, default) {
            (Some(size), _) => Ok(size),
            (None, Some(default)) => Ok(default),
            (None, None) => Err(self.error(&format!("has no \"{key}\""))),
        }
    }

    /// A number, or `default` where it is not there.
    ///
    /// # Errors
    /// It is none.
    pub fn number(&self, key: &str, default: f64) -> Result<f64> {
        let Some(item) = self.get(key) else { return Ok(default) };
        item.value.as_f64().ok_or_else(|| item.error("must be a number"))
    }

    /// A list of numbers, or `default` where it is not there.
    ///
    /// # Errors
    /// It is none of so many numbers.
    pub fn numbers<const N: usize>(&self, key: &str, default: [f64; N]) -> Result<[f64; N]> {
        let Some(item) = self.get(key) else { return Ok(default) };
        let numbers = item.value.as_array().filter(|list| list.len() == N);
        let numbers: Option<Vec<f64>> = numbers.and_then(|list| list.iter().map(Value::as_f64).collect());
        let numbers = numbers.and_then(|list| <[f64; N]>::try_from(list).ok());
        numbers.ok_or_else(|| item.error(&format!("must be a list of {N} numbers")))
    }

    /// A word.
    pub fn text(&self, key: &str) -> Option<&'d str> {
        self.value.get(key).and_then(Value::as_str)
    }
}
