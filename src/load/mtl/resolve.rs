//! From the `mtllib` statements of an OBJ to a definition for each of its materials.

use super::{MtlMaterial, read};
use crate::error::{Finding, Findings, Severity};
use crate::load::obj::Library;
use crate::load::open::{Finder, Found, Match, Reach, real};
use std::collections::{HashMap, HashSet};
use std::path::{Path, PathBuf};

/// The definitions of an OBJ's materials.
#[derive(Clone, Debug, Default)]
pub struct Resolved {
    /// One for each name that was asked for; `None` where no library defines it.
    pub materials: Vec<Option<MtlMaterial>>,
    /// How many names the libraries define, asked for or not.
    pub defined: u64,
    /// The libraries that were read, in their order.
    pub libraries: Vec<PathBuf>,
    /// What was missing, replaced or ignored; the libraries' own findings included.
    pub findings: Findings,
}

/// Reads every library that the OBJ file `obj` names and looks up `names` (its `usemtl` names) in them.
///
/// What follows `mtllib` is one name with spaces or several names: the former is tried first. Names are
/// relative to the OBJ's folder; where no such file exists, one that differs in case is taken, then one of
/// that name in the OBJ's own folder. Of several definitions of one name the last holds. Nothing here is
/// an error: a library that cannot be read is a warning, and one outside of `reach` is not read. The empty name needs no definition, nor does one that is
/// `defined` elsewhere.
pub fn resolve(
    obj: &Path,
    libraries: &[Library],
    names: &[Vec<u8>],
    defined: &dyn Fn(&[u8]) -> bool,
    reach: &Reach,
) -> Resolved {
    let mut resolver = Resolver {
        obj,
        reach,
        finder: Finder::new(reach),
        line: 0,
        out: Resolved::default(),
        read: HashSet::new(),
        last: HashMap::new(),
    };
    for library in libraries {
        resolver.line = library.line;
        resolver.library(&library.names);
    }
    resolver.line = 0;
    resolver.out.defined = resolver.last.len() as u64;
    for name in names {
        let material = resolver.last.get(name).cloned();
        if material.is_none() && !name.is_empty() && !defined(name) {
            let message = format!("no library defines \"{}\"; the default material is used", shown(name));
            resolver.note("material-unknown", Severity::Warning, message);
        }
        resolver.out.materials.push(material);
    }
    resolver.out
}

struct Resolver<'a> {
    obj: &'a Path,
    reach: &'a Reach,
    finder: Finder,
    line: u64,
    out: Resolved,
    /// Libraries that were read, or could not be, by their real paths: a library has many names and is read once.
    read: HashSet<PathBuf>,
    last: HashMap<Vec<u8>, MtlMaterial>,
}

impl Resolver<'_> {
    fn note(&mut self, kind: &'static str, severity: Severity, message: String) {
        let file = self.obj.to_path_buf();
        self.out.findings.push(Finding { file, line: self.line, kind, message, severity });
    }

    fn library(&mut self, names: &[u8]) {
        let folder = self.obj.parent().unwrap_or(Path::new(""));
        if let Some(found) = self.finder.find(folder, names) {
            return self.read(names, found);
        }
        let words: Vec<&[u8]> = super::words(names).collect();
        let found: Vec<_> = words.iter().map(|word| self.finder.find(folder, word)).collect();
        if words.len() < 2 || found.iter().all(Option::is_none) {
            return self.missing(names);
        }
        for (word, found) in words.into_iter().zip(found) {
            match found {
                Some(found) => self.read(word, found),
                None => self.missing(word),
            }
        }
    }

    fn missing(&mut self, name: &[u8]) {
        let message = format!("material library \"{}\" was not found", shown(name));
        self.note("mtllib-missing", Severity::Warning, message);
    }

    fn read(&mut self, name: &[u8], found: Found) {
        match found.how {
            Match::Exact => {}
            Match::OtherCase => {
                let message = format!("\"{}\" was found as a name that differs in case", shown(name));
                self.note("mtllib-other-case", Severity::Warning, message);
            }
            Match::OtherFolder => {
                let message = format!("\"{}\" was found in the OBJ's own folder", shown(name));
                self.note("mtllib-other-folder", Severity::Warning, message);
            }
        }
        if !self.read.insert(real(&found.path)) {
            return;
        }
        let library = match read(&found.path, self.reach) {
            Ok(library) => library,
            Err(error) => {
                let message =
                    format!("material library \"{}\" cannot be read: {}", shown(name), error.message);
                let refused = !self.reach.holds(&found.path);
                let kind = if refused { "path-refused" } else { "mtllib-unreadable" };
                return self.note(kind, Severity::Warning, message);
            }
        };
        self.out.findings.append(library.findings);
        for material in library.materials {
            let (line, file) = (material.line, material.library.clone());
            if self.last.insert(material.name.clone(), material).is_some() {
                let message =
                    "a material of this name was defined before; the last definition holds".to_string();
                let (kind, severity) = ("material-redefined", Severity::Warning);
                self.out.findings.push(Finding { file, line, kind, message, severity });
            }
        }
        self.out.libraries.push(found.path);
    }
}

/// A name from the OBJ, shortened for a message.
pub(in crate::load) fn shown(name: &[u8]) -> String {
    let text = String::from_utf8_lossy(name);
    let short: String = text.chars().take(100).collect();
    let dots = if short.len() < text.len() { "…" } else { "" };
    crate::error::one_line(&format!("{short}{dots}"))
}
