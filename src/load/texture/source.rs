//! Where the pictures of a texture are: one, or the tiles of a UDIM set; in files of their own or inside another.

use crate::load::open::{Finder, Match, Reach, path_from_bytes};
use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Where a picture is.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Place {
    /// In a file of its own.
    File(PathBuf),
    /// Inside a mesh file.
    Inside(Inside),
}

/// A picture inside a mesh file.
#[derive(Clone)]
pub(crate) struct Inside {
    /// The mesh file.
    pub file: PathBuf,
    /// Which of its pictures.
    pub number: usize,
    /// The picture as a file of its own would have it.
    pub bytes: Arc<Vec<u8>>,
}

impl Inside {
    fn key(&self) -> (&Path, usize) {
        (&self.file, self.number)
    }
}

impl std::fmt::Debug for Inside {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.key().fmt(f)
    }
}

impl PartialEq for Inside {
    fn eq(&self, other: &Inside) -> bool {
        self.key() == other.key()
    }
}

impl Eq for Inside {}

impl std::hash::Hash for Inside {
    fn hash<H: std::hash::Hasher>(&self, state: &mut H) {
        self.key().hash(state);
    }
}

impl Place {
    /// The picture's own file.
    pub fn path(&self) -> Option<&PathBuf> {
        match self {
            Place::File(path) => Some(path),
            Place::Inside(_) => None,
        }
    }

    /// Whether it is there, readable or not.
    pub fn exists(&self) -> bool {
        self.path().is_none_or(|path| path.exists())
    }
}

/// Tiles by number, ascending.
pub(crate) type Set = Arc<[(u32, Place)]>;

/// The pictures of a texture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Source {
    /// One picture.
    One(Place),
    /// Tiles of a UDIM set by number, ascending; one list for all that name the set.
    Tiles(Set),
}

impl Source {
    /// Every picture.
    pub fn places(&self) -> impl Iterator<Item = &Place> {
        let (one, tiles) = match self {
            Source::One(place) => (Some(place), [].as_slice()),
            Source::Tiles(tiles) => (None, tiles.as_ref()),
        };
        one.into_iter().chain(tiles.iter().map(|tile| &tile.1))
    }
}

/// Looks for the files of many textures; each folder is listed once, and each set looked for once.
#[derive(Debug)]
pub(crate) struct Sources {
    finder: Finder,
    /// By folder and by what stands before and after the number.
    sets: HashMap<(PathBuf, [Vec<u8>; 2]), Set>,
}

impl Sources {
    /// Files within `reach`.
    pub fn new(reach: &Reach) -> Self {
        Sources { finder: Finder::new(reach), sets: HashMap::new() }
    }

    /// The files that a scene in `folder` calls `name`, and how the name led to them.
    pub fn find(&mut self, folder: &Path, name: &[u8]) -> Option<(Source, Match)> {
        let Some(at) = token(name) else {
            let found = self.finder.find(folder, name)?;
            return Some((Source::One(Place::File(found.path)), found.how));
        };
        let slashes: Vec<u8> = name.iter().map(|&b| if b == b'\\' { b'/' } else { b }).collect();
        let start = slashes.iter().take(at).rposition(|&b| b == b'/').map_or(0, |slash| slash + 1);
        let end = at + TOKEN.len();
        let (prefix, suffix) = (slashes.get(start..at)?, slashes.get(end..)?);
        let inside = folder.join(path_from_bytes(slashes.get(..start)?));
        let folders = [(inside, Match::Exact), (folder.to_path_buf(), Match::OtherFolder)];
        folders.into_iter().find_map(|(folder, how)| {
            let key = (folder, [prefix.to_vec(), suffix.to_vec()]);
            let tiles = match self.sets.get(&key) {
                Some(tiles) => tiles.clone(),
                None => {
                    let tiles: Set = tiles(&mut self.finder, &key.0, prefix, suffix).into();
                    self.sets.insert(key, tiles.clone());
                    tiles
                }
            };
            (!tiles.is_empty()).then_some((Source::Tiles(tiles), how))
        })
    }
}

const TOKEN: &[u8] = b"<UDIM>";

fn token(name: &[u8]) -> Option<usize> {
    name.windows(TOKEN.len()).position(|word| word.eq_ignore_ascii_case(TOKEN))
}

/// The tiles among a folder's files: `prefix`, four digits, `suffix`, in upper or lower case.
fn tiles(finder: &mut Finder, folder: &Path, prefix: &[u8], suffix: &[u8]) -> Vec<(u32, Place)> {
    let [prefix, suffix] = [prefix, suffix].map(|part| String::from_utf8_lossy(part).to_lowercase());
    let number = |name: &str| -> Option<u32> {
        let digits = name.strip_prefix(prefix.as_str())?.strip_suffix(suffix.as_str())?;
        let is_number = digits.len() == 4 && digits.bytes().all(|b| b.is_ascii_digit());
        digits.parse().ok().filter(|number| is_number && (1001..=9999).contains(number))
    };
    let entries = finder.listing(folder).iter();
    let mut tiles: Vec<(u32, PathBuf)> =
        entries.filter_map(|(name, entry)| Some((number(name)?, folder.join(entry)))).collect();
    tiles.sort();
    tiles.into_iter().map(|(number, path)| (number, Place::File(path))).collect()
}
