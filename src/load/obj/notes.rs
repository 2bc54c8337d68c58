//! What a reader noticed, cheaply: a kind, a line and a number.
//!
//! Blocks are parsed in any order and some faces are judged only at the end of the file, so notes are
//! kept by the smallest line, not by arrival: the same list on any number of threads and any block size.

use crate::error::{Finding, Findings, Severity};
use std::path::Path;

/// Declares the kinds: name in Rust, name for people, severity, sentence (`#` is replaced by the number).
macro_rules! kinds {
    ($($(#[$doc:meta])* $variant:ident $name:literal $severity:ident $message:literal;)*) => {
        /// A kind of finding.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        #[repr(u8)]
        pub(super) enum Kind { $($variant),* }

        impl Kind {
            const ALL: &'static [Kind] = &[$(Kind::$variant),*];

            fn about(self) -> (&'static str, Severity, &'static str) {
                match self { $(Kind::$variant => ($name, Severity::$severity, $message)),* }
            }
        }
    };
}

kinds! {
    FaceIndex "face-index-out-of-range" Error "face skipped: vertex # does not exist (vertices count from 1)";
    NormalIndex "normal-index-out-of-range" Error "face kept without its normal: normal # does not exist (they count from 1)";
    UvIndex "uv-index-out-of-range" Error "face kept without its texture coordinate: # does not exist (they count from 1)";
    FaceFewCorners "face-too-few-corners" Warning "face skipped: it has # corners, at least 3 are needed";
    FaceMalformed "face-malformed" Warning "face skipped: its corner # is none of v, v/vt, v//vn, v/vt/vn";
    FaceBadVertex "face-vertex-unusable" Warning "face skipped: its vertex # has no usable position";
    VertexUnreadable "vertex-unreadable" Warning "vertex # has not three decimal numbers; faces that use it are skipped";
    VertexTooLarge "vertex-too-large" Warning "vertex # is not finite or beyond 1e18; faces that use it are skipped";
    NormalUnreadable "normal-unreadable" Warning "normal # has not three decimal numbers; the geometric normal is used";
    NormalZero "normal-zero" Note "normal # is zero or not finite; the geometric normal is used";
    UvUnreadable "uv-unreadable" Warning "texture coordinate # is no decimal number or beyond 1e18; it is left out";
    FaceZeroArea "face-zero-area" Note "a triangle without area was dropped";
    FaceDuplicate "face-duplicate" Note "a triangle that repeats another (same corners, winding and material) was dropped";
    PointsAndLines "points-and-lines-ignored" Note "points and lines are not rendered";
    FreeForm "free-form-ignored" Note "free-form curves and surfaces are not rendered";
    Command "command-ignored" Note "call and csh are never followed";
    UnknownStatement "unknown-statement" Note "a statement that OBJ does not have was ignored";
    NoMaterialName "material-name-missing" Note "usemtl without a name: the default material is used";
    NoLibraryName "mtllib-name-missing" Note "mtllib without a name was ignored";
}

/// The name and severity of the kind of finding that is called `name`.
pub(in crate::load) fn kind_of_finding(name: &[u8]) -> Option<(&'static str, Severity)> {
    let about = Kind::ALL.iter().map(|kind| kind.about());
    about.map(|(kind, severity, _)| (kind, severity)).find(|(kind, _)| kind.as_bytes() == name)
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Note {
    line: u64,
    detail: i64,
}

#[derive(Clone, Debug, Default)]
struct NotesOfKind {
    count: u64,
    first: Vec<Note>,
}

/// Notes by kind; each kind keeps those of the smallest lines.
#[derive(Clone, Debug)]
pub(super) struct Notes {
    kinds: Vec<NotesOfKind>,
}

impl Default for Notes {
    fn default() -> Self {
        Notes { kinds: vec![NotesOfKind::default(); Kind::ALL.len()] }
    }
}

impl Notes {
    /// Adds a note; `detail` is the number its sentence mentions.
    #[cold]
    pub fn add(&mut self, kind: Kind, line: u64, detail: i64) {
        if let Some(of_kind) = self.kinds.get_mut(kind as usize) {
            of_kind.count += 1;
            of_kind.first.push(Note { line, detail });
            of_kind.trim(2 * Findings::KEPT);
        }
    }

    /// Counts `count` notes that have no line.
    pub fn add_without_line(&mut self, kind: Kind, count: u64) {
        if count > 0 {
            self.add(kind, 0, 0);
            if let Some(of_kind) = self.kinds.get_mut(kind as usize) {
                of_kind.count += count - 1;
            }
        }
    }

    /// Takes over a block's notes whose line 0 is the file's line `first_line`; leaves `block` empty.
    /// `first_element(kind)` is what its numbers count from.
    pub fn append(&mut self, block: &mut Notes, first_line: u64, first_element: impl Fn(Kind) -> i64) {
        for ((ours, theirs), kind) in self.kinds.iter_mut().zip(&mut block.kinds).zip(Kind::ALL) {
            if theirs.count == 0 {
                continue;
            }
            ours.count += std::mem::take(&mut theirs.count);
            let element = first_element(*kind);
            let moved = theirs
                .first
                .drain(..)
                .map(|n| Note { line: n.line + first_line, detail: n.detail + element });
            ours.first.extend(moved);
            ours.trim(2 * Findings::KEPT);
        }
    }

    /// The findings, in the order of the lines.
    pub fn into_findings(self, file: &Path) -> Findings {
        let mut findings = Findings::default();
        for (mut of_kind, kind) in self.kinds.into_iter().zip(Kind::ALL) {
            of_kind.trim(Findings::KEPT);
            of_kind.first.sort_unstable();
            let (name, severity, message) = kind.about();
            let shown = of_kind.first.len() as u64;
            for note in of_kind.first {
                let message = message.replace('#', &note.detail.to_string());
                findings.push(Finding {
                    file: file.to_path_buf(),
                    line: note.line,
                    kind: name,
                    message,
                    severity,
                });
            }
            findings.count_more(name, severity, of_kind.count.saturating_sub(shown));
        }
        findings
    }
}

impl NotesOfKind {
    /// Keeps the first [`Findings::KEPT`] once there are more than `limit`.
    fn trim(&mut self, limit: usize) {
        if self.first.len() > limit {
            self.first.sort_unstable();
            self.first.truncate(Findings::KEPT);
        }
    }
}
