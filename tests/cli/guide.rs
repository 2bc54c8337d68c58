//! docs/scene-file.md names every key that the program knows. docs/notes.md: every equation and section of the notes has its row, and every command in it runs.

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

/// The program is asked for the keys it knows in each section, by one that it does not.
#[test]
fn every_key_of_a_scene_file_is_documented() {
    let text = std::fs::read_to_string(root().join("docs/scene-file.md")).unwrap();
    let folder = folder();
    let sections = [
        ("## `[camera]`", "[camera]\nzzzzzz = 1\n"),
        ("## `[film]`", "[film]\nzzzzzz = 1\n"),
        ("## `[render]`", "[render]\nzzzzzz = 1\n"),
        ("## `[[mesh]]`", "[[mesh]]\nfile = \"t.obj\"\nzzzzzz = 1\n"),
        ("# Scene files", "zzzzzz = 1\n"),
    ];
    for (heading, scene) in sections {
        let told = text.split(&format!("{heading}\n")).nth(1).unwrap_or_else(|| panic!("{heading}"));
        let told = told.split("\n## ").next().unwrap();
        std::fs::write(folder.path().join("z.toml"), scene).unwrap();
        let ended = crate::drt(folder.path(), &["z.toml"]);
        ended.expect(1, &["unknown key", "; known: "]);
        let known: Vec<&str> = ended.err.trim().split("; known: ").nth(1).unwrap().split(", ").collect();
        assert!(known.len() > 5, "{known:?}");
        for key in known {
            let forms = [format!("`{key}`"), format!("[{key}]"), format!("[{key}."), format!("[[{key}")];
            assert!(forms.iter().any(|form| told.contains(form)), "{heading} does not name {key}");
        }
    }
}

/// The scene that the page begins with renders.
#[test]
fn the_scene_of_the_page_renders() {
    let text = std::fs::read_to_string(root().join("docs/scene-file.md")).unwrap();
    let scene = text.split("```toml\n").nth(1).unwrap().split("```").next().unwrap();
    let folder = folder();
    std::fs::copy(folder.path().join("t.obj"), folder.path().join("bunny.obj")).unwrap();
    std::fs::write(folder.path().join("page.toml"), scene).unwrap();
    crate::drt(folder.path(), &["page.toml", "--spp", "1", "-q"]).expect(0, &[]);
}
