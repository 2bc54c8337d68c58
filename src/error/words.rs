//! Words that are none of those known, and what was probably meant.

use super::{Error, Result};

/// The name in `known` that `word` most likely was meant to be.
///
/// Slips of the fingers (a letter wrong, missing, too many, two exchanged: Damerau's four) may make up a third of the
/// word, which leaves short names their neighbours: "tpo" is "top", but "x" is not "y". Words that somebody only
/// began or wrote at greater length ("env", "triangles") come after that.
pub fn nearest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let word = word.to_lowercase();
    let mut best: Option<(usize, f64, &str)> = None;
    for candidate in known {
        let lower = candidate.to_lowercase();
        let Some(slips) = slips(&word, &lower) else { continue };
        let likeness = strsim::jaro_winkler(&word, &lower);
        let is_better = |&(s, l, _): &(usize, f64, &str)| slips < s || (slips == s && likeness > l);
        if best.as_ref().is_none_or(is_better) {
            best = Some((slips, likeness, candidate));
        }
    }
    best.map(|(_, _, name)| name)
}

/// How far the words are apart; `None` where nobody takes one for the other.
fn slips(word: &str, name: &str) -> Option<usize> {
    let length = word.chars().count().max(name.chars().count());
    // Long words take long to compare, and no name is that long.
    if length > 100 {
        return None;
    }
    let slips = strsim::damerau_levenshtein(word, name);
    let begun = word.len() >= 3 && name.starts_with(word) || name.len() >= 3 && word.starts_with(name);
    (slips <= length / 3 || begun).then_some(slips)
}

/// The advice for a word that is none of `known`: a suggestion when one is near, and the whole list; nothing where there is
/// none.
pub fn unknown_word_advice(word: &str, known: &[&str]) -> String {
    if known.is_empty() {
        return String::new();
    }
    let list = known.join(", ");
    match nearest(word, known.iter().copied()) {
        Some(name) => format!("did you mean \"{name}\"? (known: {list})"),
        None => format!("known: {list}"),
    }
}

/// The value of `word` in a list of (name, meaning, value); `what` is what the list is of.
///
/// # Errors
/// A word that is not in the list, with the one that was probably meant.
pub fn lookup<T: Copy>(what: &str, word: &str, table: &[(&'static str, &'static str, T)]) -> Result<T> {
    table.iter().find(|row| row.0 == word).map(|row| row.2).ok_or_else(|| {
        let known: Vec<&str> = table.iter().map(|row| row.0).collect();
        Error::usage(format!("unknown {what} \"{word}\"")).advise(unknown_word_advice(word, &known))
    })
}

/// The name of a value in such a list.
pub fn name_in<T: PartialEq>(value: &T, table: &[(&'static str, &'static str, T)]) -> &'static str {
    table.iter().find(|row| row.2 == *value).map_or("", |row| row.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const VIEWS: [&str; 8] = ["three-quarter", "front", "back", "left", "right", "top", "bottom", "iso"];

    #[test]
    fn slips_of_the_fingers_are_understood() {
        for (word, meant) in [
            ("tpo", "top"),
            ("to", "top"),
            ("topp", "top"),
            ("t op", "top"),
            ("TOP", "top"),
            ("rihgt", "right"),
            ("lfet", "left"),
            ("frnt", "front"),
            ("botom", "bottom"),
            ("threequarter", "three-quarter"),
            ("three_quarter", "three-quarter"),
            ("isometric", "iso"),
            ("thr", "three-quarter"),
        ] {
            assert_eq!(nearest(word, VIEWS), Some(meant), "{word}");
        }
        for (word, meant) in
            [("sp p", "spp"), ("ssp", "spp"), ("psp", "spp"), ("sed", "seed"), ("siez", "size")]
        {
            assert_eq!(nearest(word, ["size", "spp", "seed", "sampler"]), Some(meant), "{word}");
        }
    }

    #[test]
    fn other_words_are_not_guessed_at() {
        for word in ["", "t", "side", "under", "xyz", "ta", &"top".repeat(1000)] {
            assert_eq!(nearest(word, VIEWS), None, "{word}");
        }
        assert_eq!(nearest("x", ["y", "z", "-y", "-z"]), None);
        assert_eq!(nearest("obj2", ["obj", "toml"]), Some("obj"));
        assert_eq!(nearest("stl", ["obj", "toml"]), None);
    }

    #[test]
    fn the_nearest_wins_and_a_tie_goes_to_the_same_beginning() {
        assert_eq!(nearest("fron", ["frown", "front", "from"]), Some("front"));
        assert_eq!(nearest("tap", ["tip", "top", "tapes"]), Some("tip"), "the first of equals");
        assert_eq!(nearest("sampels", ["samples", "sampler"]), Some("samples"));
    }

    #[test]
    fn the_advice_lists_what_is_known() {
        assert_eq!(unknown_word_advice("tpo", &["top", "iso"]), "did you mean \"top\"? (known: top, iso)");
        assert_eq!(unknown_word_advice("x", &["top", "iso"]), "known: top, iso");
    }
}
