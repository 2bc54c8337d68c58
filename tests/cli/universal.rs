//! What holds for every run, however hostile its input (the universal invariant of the table of failures): the exit
//! code is one of five, a failure is one `error:` line, and an output path holds its old bytes or a whole picture.

use super::{Ended, names};
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// A run that has to keep the invariant. The time limit judges nothing: it ends a program that hangs.
pub struct Run<'a> {
    dir: &'a Path,
    words: Vec<String>,
    outputs: Vec<String>,
    limits: String,
    may_be_mute: bool,
}

impl<'a> Run<'a> {
    /// Runs drt in `dir` with `words`; what follows each `-o` and `--stats` is an output.
    pub fn new(dir: &'a Path, words: &[&str]) -> Run<'a> {
        let outputs = words.windows(2).filter(|pair| pair[0] == "-o" || pair[0] == "--stats");
        Run {
            dir,
            outputs: outputs.map(|pair| pair[1].to_string()).collect(),
            words: words.iter().map(ToString::to_string).collect(),
            limits: String::new(),
            may_be_mute: false,
        }
    }

    /// Shell commands before the program, such as `ulimit -f 1`.
    pub fn limits(mut self, commands: &str) -> Self {
        self.limits = format!("{commands}; ");
        self
    }

    /// Writing to standard error may fail, so that a failure may have no words.
    pub fn maybe_mute(mut self) -> Self {
        self.may_be_mute = true;
        self
    }

    /// Runs it and checks the invariant.
    #[track_caller]
    pub fn check(self) -> Ended {
        let before = picture_of(self.dir);
        let script = format!("{}exec \"$0\" \"$@\"", self.limits);
        let program = assert_cmd::cargo::cargo_bin("drt");
        let mut command = assert_cmd::Command::new("sh");
        command.arg("-c").arg(script).arg(program).args(&self.words).current_dir(self.dir);
        let output = command.timeout(Duration::from_secs(120)).output().expect("it runs");
        let ended = Ended {
            code: output.status.code(),
            out: String::from_utf8_lossy(&output.stdout).into_owned(),
            err: String::from_utf8_lossy(&output.stderr).into_owned(),
        };
        self.judge(&ended, &before);
        ended
    }

    #[track_caller]
    fn judge(&self, ended: &Ended, before: &BTreeMap<String, Vec<u8>>) {
        let said = format!("{:?} ended with {:?}: {}", self.words, ended.code, ended.err);
        let code = ended.code.unwrap_or(-1);
        assert!([0, 1, 2, 130, 143].contains(&code), "{said}");
        assert!(!said.contains("panicked at") && !said.contains("internal error"), "{said}");
        let errors = ended.err.lines().filter(|line| line.starts_with("error: ")).count();
        assert!(errors == usize::from(code != 0) || self.may_be_mute && errors == 0, "{said}");
        let after = picture_of(self.dir);
        for (name, bytes) in &after {
            assert!(!name.starts_with(".drt-"), "a temporary file is left: {name}; {said}");
            match before.get(name) {
                Some(old) if old == bytes => {}
                _ if !self.outputs.contains(name) => {
                    let is_default = self.outputs.is_empty() && code != 2 && name.ends_with(".png");
                    assert!(is_default, "{name} was written unasked; {said}");
                    whole(&self.dir.join(name), &said);
                }
                _ => whole(&self.dir.join(name), &said),
            }
        }
        assert!(before.keys().all(|name| after.contains_key(name)), "a file is gone; {said}");
    }
}

/// Fails unless `path` is a picture that can be decoded, or JSON.
#[track_caller]
fn whole(path: &Path, said: &str) {
    if path.extension().is_some_and(|e| e == "json") {
        let text = fs::read(path).expect("readable");
        assert!(serde_json::from_slice::<serde_json::Value>(&text).is_ok(), "{path:?} is no JSON; {said}");
        return;
    }
    let picture = drt::load::picture::read(path);
    assert!(picture.is_ok(), "{path:?}: {:?}; {said}", picture.err());
}

/// The regular files of a folder with their bytes; links are followed.
fn picture_of(dir: &Path) -> BTreeMap<String, Vec<u8>> {
    let small = |path: &Path| fs::metadata(path).is_ok_and(|m| m.is_file() && m.len() < 1 << 26);
    let files = names(dir).into_iter().filter(|name| small(&dir.join(name)));
    files.map(|name| (name.clone(), fs::read(dir.join(name)).unwrap_or_default())).collect()
}

/// Every backend of this build by name, with 1 and 2 threads.
pub fn engines() -> impl Iterator<Item = [&'static str; 4]> {
    let backends = drt::accel::Backend::ALL.iter().map(|b| b.name());
    backends.flat_map(|b| ["1", "2"].map(|threads| ["--backend", b, "--threads", threads]))
}

/// `words`, a tiny picture, and the engine's words.
pub fn tiny<'w>(words: &[&'w str], engine: &[&'w str]) -> Vec<&'w str> {
    [words, &["--size", "16x12", "--spp", "1"], engine].concat()
}

/// True when the program `name` is installed; says so when it is not.
pub fn installed(name: &str) -> bool {
    let found = Command::new("sh").args(["-c", &format!("command -v {name}")]).stdout(Stdio::null()).status();
    let found = found.is_ok_and(|status| status.success());
    if !found {
        eprintln!("SKIPPED a part of this test: {name} is not installed");
    }
    found
}
