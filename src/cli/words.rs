//! Clap's errors in one line, like all others.

use drt::error::{Error, one_line};

/// The first sentence and the tip of a clap error, which it spreads over a paragraph with the usage.
pub fn usage_error(error: &clap::Error) -> Error {
    let text = error.render().to_string();
    let mut paragraphs = text.split("\n\n");
    let first = paragraphs.next().unwrap_or_default();
    let first = first.strip_prefix("error: ").unwrap_or(first);
    let words: Vec<&str> = first.split_whitespace().collect();
    let message = one_line(words.join(" ").trim_end_matches(':'));
    let tip = text.lines().find_map(|line| line.trim().strip_prefix("tip: "));
    let advice = match tip {
        Some(tip) => format!("{}; see drt --help", one_line(tip)),
        None => "see drt --help".to_string(),
    };
    Error::usage(message).advise(advice)
}
