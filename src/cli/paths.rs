//! Where results go: checked before any work is done for them.

use drt::error::{Error, Result};
use drt::output;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// The pictures that are asked for, else the input's name with `.png` in the current folder.
pub fn outputs(asked: &[PathBuf], input: &Path) -> Vec<PathBuf> {
    if !asked.is_empty() {
        return asked.to_vec();
    }
    let mut name = stem(input);
    name.push(".png");
    vec![name.into()]
}

/// A file's name without its extension, and without that of the mesh that it is packed around.
fn stem(input: &Path) -> std::ffi::OsString {
    if input == Path::new(drt::load::STDIN) {
        return "stdin".into();
    }
    let stem = drt::load::unpack::strip(input);
    stem.file_stem().unwrap_or("picture".as_ref()).to_os_string()
}

/// Checks that all of it can be written, to different places. `checkpoint` has its own check besides.
///
/// # Errors
/// A place that cannot be written, or one named twice.
pub fn check(outputs: &[PathBuf], stats: Option<&Path>, checkpoint: Option<&Path>) -> Result<()> {
    for output in outputs {
        output::check_path(output)?;
    }
    if let Some(stats) = stats {
        output::check_writable(stats)?;
    }
    check_distinct(&outputs.iter().map(PathBuf::as_path).chain(stats).chain(checkpoint).collect::<Vec<_>>())
}

/// [`check`] for files that are no pictures.
///
/// # Errors
/// As [`check`].
pub fn check_files(outputs: &[PathBuf]) -> Result<()> {
    for output in outputs {
        output::check_writable(output)?;
    }
    check_distinct(&outputs.iter().map(PathBuf::as_path).collect::<Vec<_>>())
}

fn check_distinct(all: &[&Path]) -> Result<()> {
    for (i, path) in all.iter().enumerate() {
        if all.iter().skip(i + 1).any(|other| is_same(path, other)) {
            return Err(Error::usage("named twice as an output")
                .at(*path)
                .advise("give each output a name of its own"));
        }
    }
    Ok(())
}

/// Refuses to write over what is read. `others`: files besides the outputs that are written.
///
/// # Errors
/// An output that is one of `inputs`.
pub fn check_inputs<'p>(
    outputs: &[PathBuf],
    others: &[Option<&Path>],
    inputs: impl Iterator<Item = &'p Path>,
) -> Result<()> {
    let others = others.iter().copied().flatten();
    let all: Vec<&Path> = outputs.iter().map(PathBuf::as_path).chain(others).collect();
    // Standard input and standard output share a name and nothing else.
    for input in inputs.filter(|input| *input != Path::new(drt::load::STDIN)) {
        if let Some(output) = all.iter().find(|output| is_same(output, input)) {
            return Err(Error::new("is both input and output").at(*output).advise("write to another file"));
        }
    }
    Ok(())
}

/// The same file, by its number where it exists, else by folder and name.
fn is_same(a: &Path, b: &Path) -> bool {
    match (fs::metadata(a), fs::metadata(b)) {
        // Devices may be named as often as one likes.
        (Ok(a), Ok(b)) => a.is_file() && (a.dev(), a.ino()) == (b.dev(), b.ino()),
        (Err(_), Err(_)) => a == b || (a.file_name() == b.file_name() && folder(a) == folder(b)),
        _ => false,
    }
}

fn folder(path: &Path) -> Option<PathBuf> {
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    fs::canonicalize(parent).ok()
}
