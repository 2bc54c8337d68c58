//! Clap's errors in one line, like all others.

use super::args::Cli;
use clap::CommandFactory;
use clap::error::ErrorKind;
use drt::error::{Error, one_line};
use std::ffi::OsString;

/// The first sentence and the tip of a clap error, which it spreads over a paragraph with the usage.
pub fn usage_error(error: &clap::Error, typed: impl Iterator<Item = OsString>) -> Error {
    let text = error.render().to_string();
    let mut paragraphs = text.split("\n\n");
    let first = paragraphs.next().unwrap_or_default();
    let first = first.strip_prefix("error: ").unwrap_or(first);
    let words: Vec<&str> = first.split_whitespace().collect();
    let message = one_line(words.join(" ").trim_end_matches(':'));
    if let Some(word) = surplus_word(&words) {
        return Error::usage(format!("unexpected word {word}")).advise(
            "one input at a time, the flags' values right behind them, and -o before the picture's name; \
             see drt --help",
        );
    }
    if let Some(flag) = with_one_dash(error, typed) {
        return Error::usage(format!("unexpected argument '-{flag}'"))
            .advise(format!("did you mean --{flag}? Flags of several letters have two dashes"));
    }
    let tip = text.lines().find_map(|line| line.trim().strip_prefix("tip: "));
    // What nobody types by mistake: a value that begins with a dash.
    let tip = tip.filter(|tip| !tip.contains("as a value, use"));
    let advice = match tip {
        Some(tip) => format!("{}; see drt --help", one_line(tip)),
        None => "see drt --help".to_string(),
    };
    Error::usage(message).advise(advice)
}

/// The long flag that was `typed` with a single dash, which clap takes for a flag of one letter.
fn with_one_dash(error: &clap::Error, mut typed: impl Iterator<Item = OsString>) -> Option<String> {
    if error.kind() != ErrorKind::UnknownArgument {
        return None;
    }
    let root = Cli::command();
    let commands = || std::iter::once(&root).chain(root.get_subcommands());
    let is_flag = |word: &str| commands().flat_map(|c| c.get_arguments()).any(|a| a.get_long() == Some(word));
    typed.find_map(|word| {
        let name = word.to_str()?.strip_prefix('-')?;
        let name = name.split('=').next().unwrap_or(name);
        (name.len() > 1 && is_flag(name)).then(|| name.to_string())
    })
}

/// The word that clap took for a subcommand because an input had been given before.
fn surplus_word<'w>(message: &[&'w str]) -> Option<&'w str> {
    match message {
        ["the", "subcommand", word, "cannot", "be", "used", "with" | "with:", ..] => Some(word),
        _ => None,
    }
}
