//! The formats of mesh files. A format is a file beside this one and a row of [`FORMATS`], which the help and the
//! messages walk.

use super::cache::Cache;
use super::input::{Input, ReadingProgress, STDIN};
use super::object::Object;
use super::open::Reach;
use super::unpack::{self, Packing};
use super::{gltf, obj, ply, stl, wavefront};
use crate::accel::need::Extent;
use crate::error::{Error, Result, unknown_word_advice};
use crate::scene::need::Meshes;
use std::fs::File;
use std::path::Path;

/// A format of mesh files.
pub struct Format {
    /// Its name, after `--format`.
    pub name: &'static str,
    /// What it is.
    pub meaning: &'static str,
    /// Extensions in lower case, without the dot.
    pub extensions: &'static [&'static str],
    /// Whether a file that begins with these bytes may be one. Asked in the order of [`FORMATS`].
    pub(super) begins: fn(&[u8]) -> bool,
    /// What the mesh in an open, unpacked file of so many bytes will take in memory, where a look tells that.
    pub(super) forecast: fn(&File, u64) -> Option<(Extent, Meshes)>,
    /// Reads one.
    pub(super) read: fn(Input<'_>, &Reading<'_>) -> Result<Object>,
}

/// Every format; the last one takes what begins with any text.
pub static FORMATS: &[&Format] = &[&gltf::FORMAT, &ply::FORMAT, &stl::FORMAT, &wavefront::FORMAT];

impl std::fmt::Debug for Format {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(self.name)
    }
}

/// What is asked of a reader.
#[derive(Clone, Copy)]
pub(crate) struct Reading<'a> {
    /// Progress, limits, and what is kept.
    pub options: obj::ReadOptions<'a>,
    /// How the file is opened.
    pub opening: Opening,
    /// The files that may be read, this one and those that it names.
    pub reach: &'a Reach,
    /// Copies of meshes that a file shows in several places may have so many triangles together; beyond, each is kept
    /// once, where the format knows places.
    pub most_copied: u64,
    /// The materials that need no definition.
    pub defined: &'a dyn Fn(&[u8]) -> bool,
    /// Where meshes that were read before are kept.
    pub cache: Option<&'a Cache>,
}

impl<'a> Reading<'a> {
    /// The whole file; `progress` hears the share done, and its `false` cancels.
    pub fn new(progress: ReadingProgress<'a>) -> Reading<'a> {
        let options = obj::ReadOptions { progress, ..obj::ReadOptions::default() };
        let (opening, reach) = (Opening::default(), &Reach::Anywhere);
        Reading { options, opening, reach, most_copied: u64::MAX, defined: &|_| false, cache: None }
    }
}

/// How a mesh file is opened.
#[derive(Clone, Copy, Debug, Default)]
pub struct Opening {
    /// Its format, whatever its name says.
    pub format: Option<&'static Format>,
    /// The most bytes that may come out of a packed file; `None`: 256 MiB, or 64 times its size if that is more.
    pub max_unpacked: Option<u64>,
}

impl Opening {
    /// The format of a file of that name which begins with `head`.
    fn format_of(&self, file: &Path, head: &[u8]) -> Option<&'static Format> {
        let by_content = || FORMATS.iter().copied().find(|format| (format.begins)(head));
        self.format.or_else(|| Format::by_name(file)).or_else(by_content)
    }
}

impl Format {
    /// The format of that name.
    ///
    /// # Errors
    /// An unknown name, with the one that was probably meant.
    pub fn named(name: &str) -> Result<&'static Format> {
        let known: Vec<&str> = FORMATS.iter().map(|format| format.name).collect();
        let format = FORMATS.iter().find(|format| format.name == name || format.extensions.contains(&name));
        format.copied().ok_or_else(|| {
            Error::usage(format!("unknown format \"{name}\"")).advise(unknown_word_advice(name, &known))
        })
    }

    /// The format that the name of a file tells, behind the extension of a packing.
    pub(super) fn by_name(file: &Path) -> Option<&'static Format> {
        let name = unpack::strip(file);
        let extension = name.extension()?.to_string_lossy().to_lowercase();
        FORMATS.iter().find(|format| format.extensions.contains(&extension.as_str())).copied()
    }

    /// Every extension of every format.
    pub fn all_extensions() -> Vec<&'static str> {
        FORMATS.iter().flat_map(|format| format.extensions).copied().collect()
    }
}

/// Whether `input` is a mesh file (or standard input) and no scene file.
///
/// # Errors
/// A name that tells neither.
pub(crate) fn is_mesh(input: &Path, opening: &Opening) -> Result<bool> {
    if opening.format.is_some() || input == Path::new(STDIN) || Format::by_name(input).is_some() {
        return Ok(true);
    }
    let extension = |name: &Path| name.extension().map(|e| e.to_string_lossy().to_lowercase());
    let (own, unpacked) = (extension(input), extension(&unpack::strip(input)));
    let mut known = Format::all_extensions();
    known.push("toml");
    match unpacked.as_deref() {
        Some("toml") if own == unpacked => Ok(false),
        // Only its packing is known: its first bytes will tell.
        None if own.is_some() => Ok(true),
        None => Err(Error::new("the name has no extension, so its format is unknown")
            .at(input)
            .advise("name a mesh .obj or a scene .toml, or state --format")),
        Some(other) => Err(Error::new(format!("cannot read files of the kind \".{other}\""))
            .at(input)
            .advise(unknown_word_advice(other, &known))),
    }
}

/// What the mesh in `file` will take in memory, where a look at it tells that.
///
/// # Errors
/// It cannot be opened.
pub(crate) fn forecast(file: &Path, opening: &Opening, reach: &Reach) -> Result<Option<(Extent, Meshes)>> {
    if file == Path::new(STDIN) {
        return Ok(None);
    }
    let (open, bytes) = reach.open(file)?;
    // What cannot be read now cannot be read later, and the reader will say why.
    let head = super::input::beginning(&mut &open).unwrap_or_default();
    let format = Packing::of(&head).map_or_else(|| opening.format_of(file, &head), |_| None);
    Ok(format.and_then(|format| (format.forecast)(&open, bytes)))
}

/// Reads the mesh file `file`, or standard input where it is `-`.
///
/// # Errors
/// It cannot be opened, read or unpacked; what its format's reader refuses.
pub(crate) fn read(file: &Path, reading: &Reading<'_>) -> Result<Object> {
    let opening = &reading.opening;
    let input = Input::open(file, reading.reach, opening.max_unpacked, reading.options.progress)?;
    let Some(format) = opening.format_of(file, &input.head) else {
        let error = Error::new("its first bytes are those of no mesh format that is known").at(input.name);
        let names: Vec<&str> = FORMATS.iter().map(|format| format.name).collect();
        return Err(match input.head.is_empty() {
            true => Error::new("is empty").at(input.name),
            false => error.advise(format!("state --format, one of {}", names.join(", "))),
        });
    };
    (format.read)(input, reading)
}

/// What the reader of its format makes of a file with that name and content.
#[cfg(test)]
pub(crate) fn read_bytes(name: &str, bytes: &[u8]) -> Result<Object> {
    let folder = tempfile::TempDir::new().expect("a folder");
    let file = folder.path().join(name);
    std::fs::write(&file, bytes).expect("written");
    read(&file, &Reading::new(&|_| true))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_tell_the_format() {
        let by_name = |name: &str| Format::by_name(Path::new(name)).map(|format| format.name);
        for (name, format) in [
            ("a.obj", Some("obj")),
            ("a.PLY", Some("ply")),
            ("a.obj.gz", Some("obj")),
            ("a.b.Stl.ZST", Some("stl")),
            ("a.gz", None),
            ("a.toml", None),
            ("a.obj.gz.gz", None),
            ("ply", None),
        ] {
            assert_eq!(by_name(name), format, "{name}");
        }
        let is_mesh = |name: &str| is_mesh(Path::new(name), &Opening::default());
        assert!(is_mesh("-").unwrap() && is_mesh("a.gz").unwrap() && !is_mesh("a.toml").unwrap());
        for name in ["a", "a.fbx", "a.toml.gz"] {
            assert!(is_mesh(name).is_err(), "{name}");
        }
        let opening = Opening { format: Some(Format::named("ply").unwrap()), ..Opening::default() };
        assert!(super::is_mesh(Path::new("scan.dat"), &opening).unwrap());
    }

    #[test]
    fn a_word_begins_at_most_one_format() {
        for (head, name) in [
            (b"glTF\x02\0\0\0".as_slice(), "gltf"),
            (b" {\n \"asset\": {", "gltf"),
            (b"ply\nformat ascii 1.0\n", "ply"),
            (b"solid cube\n facet normal 0 0 1\n", "stl"),
            (b"# Blender\nv 0 0 0\n", "obj"),
            (b"\nmtllib a.mtl\n", "obj"),
        ] {
            let found: Vec<&str> = FORMATS.iter().filter(|f| (f.begins)(head)).map(|f| f.name).collect();
            assert_eq!(found, [name]);
        }
    }
}
