//! docs/notes.md: every equation and section of the notes has its row, and every command in it runs.

use crate::folder;
use std::path::Path;
use std::process::Command;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn guide() -> String {
    std::fs::read_to_string(root().join("docs/notes.md")).unwrap()
}

/// What stands in backticks and begins with `drt `.
fn commands(text: &str) -> Vec<&str> {
    text.split('`').skip(1).step_by(2).filter(|code| code.starts_with("drt ")).collect()
}

#[test]
fn every_equation_and_section_has_its_place() {
    let text = guide();
    for n in 1..=20 {
        let rows = text.lines().filter(|line| line.starts_with("| (") && line.contains(&format!("({n})")));
        assert!(
            rows.clone().any(|row| !commands(row).is_empty()),
            "equation ({n}) has no row with a command"
        );
    }
    for n in 1..=9 {
        let section = text.split(&format!("\n## 13.{n} ")).nth(1).unwrap_or_else(|| panic!("13.{n}"));
        let section = section.split("\n## ").next().unwrap();
        assert!(!commands(section).is_empty(), "section 13.{n} has no command");
    }
    // The files and functions that it names exist.
    for code in text.split('`').skip(1).step_by(2).filter(|code| code.starts_with("src/")) {
        assert!(root().join(code).exists(), "{code}");
    }
}

#[test]
fn every_command_runs() {
    let text = guide();
    let all = commands(&text);
    assert!(all.len() >= 30, "only {} commands found", all.len());
    let folder = folder();
    std::os::unix::fs::symlink(root().join("scenes"), folder.path().join("scenes")).unwrap();
    let program = std::path::Path::new(env!("CARGO_BIN_EXE_drt"));
    let path = format!("{}:{}", program.parent().unwrap().display(), std::env::var("PATH").unwrap());
    for command in all {
        let run =
            Command::new("sh").args(["-c", command]).env("PATH", &path).current_dir(folder.path()).output();
        let run = run.unwrap();
        let said = String::from_utf8_lossy(&run.stderr);
        assert!(run.status.success(), "{command}\n{said}");
        assert!(!said.contains("warning:"), "{command}\n{said}");
        if let Some(output) = command.split(" -o ").nth(1) {
            assert!(folder.path().join(output.trim()).exists(), "{command}");
        }
    }
}

#[test]
fn pictures_are_there_and_small() {
    for file in guide().split("](pictures/").skip(1).filter_map(|rest| rest.split(')').next()) {
        let bytes = std::fs::metadata(root().join("docs/pictures").join(file)).unwrap().len();
        assert!(bytes > 0 && bytes < 200_000, "{file}: {bytes} bytes");
    }
}
