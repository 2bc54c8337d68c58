//! The program as its users meet it: words in, files, messages and exit codes out.

mod bounds;
mod cache;
mod check;
mod converge;
mod dependencies;
mod diff;
mod faults;
mod files;
mod formats;
mod gallery;
mod guide;
mod memory;
mod mistakes;
mod pictures;
mod readme;
mod replay;
mod resume;
mod rows_command;
mod rows_files;
mod rows_numbers;
mod rows_output;
mod rows_textures;
mod secure;
mod series;
mod universal;
mod usage;

use assert_cmd::Command;
use std::path::Path;
use tempfile::TempDir;

/// What the program said and how it ended.
pub struct Ended {
    /// Exit code; `None` after a signal.
    pub code: Option<i32>,
    /// Standard output.
    pub out: String,
    /// Standard error.
    pub err: String,
}

impl Ended {
    /// Fails unless it ended with `code`, and with exactly one `error:` line (none for 0) that holds `words`.
    #[track_caller]
    pub fn expect(&self, code: i32, words: &[&str]) -> &Self {
        assert_eq!(self.code, Some(code), "{}", self.err);
        let errors: Vec<&str> = self.err.lines().filter(|l| l.starts_with("error: ")).collect();
        assert_eq!(errors.len(), usize::from(code != 0), "{}", self.err);
        assert!(!self.err.contains("panicked"), "{}", self.err);
        for word in words {
            assert!(errors.iter().any(|e| e.contains(word)), "{word:?} not in: {}", self.err);
        }
        self
    }
}

/// Runs drt in `folder`.
pub fn drt<S: AsRef<std::ffi::OsStr>>(folder: &Path, words: &[S]) -> Ended {
    let mut command = Command::cargo_bin("drt").expect("the binary");
    let output = command.current_dir(folder).args(words).output().expect("it runs");
    Ended {
        code: output.status.code(),
        out: String::from_utf8_lossy(&output.stdout).into_owned(),
        err: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

/// A folder with a tetrahedron `t.obj` and a small scene `s.toml` of it.
pub fn folder() -> TempDir {
    let folder = TempDir::new().expect("a folder");
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
    let scene = "[film]\nsize = [16, 12]\n[render]\nspp = 2\n[[mesh]]\nfile = \"t.obj\"\n\
                 [[light]]\ntype = \"environment\"\n";
    std::fs::write(folder.path().join("t.obj"), mesh).expect("written");
    std::fs::write(folder.path().join("s.toml"), scene).expect("written");
    folder
}

/// Names in a folder, sorted.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let mut names: Vec<String> =
        entries.map(|e| e.expect("an entry").file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    names
}
