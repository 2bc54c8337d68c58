//! What a checkpoint belongs to, and the first thing that is different about another render.

use crate::error::{Error, Result};
use serde_json::Value;

/// Refuses a render `now` that is not the one `then`; a key that `now` does not state counts for nothing.
///
/// # Errors
/// The first difference, by its name where it has one.
pub fn compare(then: &Value, now: &Value) -> Result<()> {
    let Some((key, then, now)) = difference(then, now, String::new()) else { return Ok(()) };
    let error = match key.split_once('.') {
        Some(("scene", part)) => Error::new(format!("the checkpoint belongs to a scene with other {part}"))
            .advise("give the scene that it belongs to, or another --checkpoint"),
        Some(("drt", "version")) => {
            Error::new(format!("the checkpoint was written by drt {}, and this is {}", show(then), show(now)))
                .advise("finish it with that version, or begin anew")
        }
        Some(("drt", key)) => {
            Error::new(format!("the checkpoint has {key} = {}, and now it is {}", show(then), show(now)))
                .advise(format!("set {key} as it was, or give another --checkpoint"))
        }
        _ => Error::new("the checkpoint belongs to a render with other settings")
            .advise("set them as they were, or give another --checkpoint"),
    };
    Err(error)
}

/// The dotted key and both values of the first difference.
fn difference<'v>(then: &'v Value, now: &'v Value, key: String) -> Option<(String, &'v Value, &'v Value)> {
    match (then, now) {
        (Value::Object(was), Value::Object(is)) => is.iter().find_map(|(name, now)| {
            let key = if key.is_empty() { name.clone() } else { format!("{key}.{name}") };
            difference(was.get(name).unwrap_or(&Value::Null), now, key)
        }),
        _ => (then != now).then_some((key, then, now)),
    }
}

/// A value as a scene file would say it.
fn show(value: &Value) -> String {
    match value {
        Value::Null => "nothing".to_string(),
        Value::String(word) => word.clone(),
        other => other.to_string(),
    }
}
