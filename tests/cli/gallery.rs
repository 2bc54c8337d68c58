//! docs/gallery.md: its pictures are there and small, and every scene that it names renders.

use crate::{drt, folder};
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn page(name: &str) -> String {
    fs::read_to_string(root().join("docs").join(name)).unwrap()
}

/// The scene files that a text names.
fn scenes(text: &str) -> BTreeSet<String> {
    let words = text.split(|c: char| c.is_whitespace() || "`()[]".contains(c));
    words.filter(|w| w.starts_with("scenes/") && w.ends_with(".toml")).map(str::to_string).collect()
}

/// What `![…](…)` shows in a text, as files beside docs/gallery.md.
fn pictures(text: &str) -> Vec<String> {
    text.split("![")
        .skip(1)
        .filter_map(|rest| rest.split_once("](")?.1.split(')').next())
        .map(str::to_string)
        .collect()
}

#[test]
fn pictures_are_there_and_small() {
    let named = pictures(&page("gallery.md"));
    assert!(named.len() >= 10, "{named:?}");
    let readme = pictures(&fs::read_to_string(root().join("README.md")).unwrap());
    assert!(!readme.is_empty());
    let files =
        named.iter().map(|f| root().join("docs").join(f)).chain(readme.iter().map(|f| root().join(f)));
    for file in files {
        let bytes = fs::metadata(&file).unwrap_or_else(|e| panic!("{}: {e}", file.display())).len();
        assert!(bytes > 0 && bytes < 200_000, "{}: {bytes} bytes", file.display());
    }
    // None is left over.
    for name in crate::names(&root().join("docs/gallery")) {
        assert!(named.contains(&format!("gallery/{name}")), "docs/gallery/{name} is shown nowhere");
    }
}

/// Each section has a picture, a command with a scene that is there, and a line in the script that makes them all.
#[test]
fn every_section_says_how_its_picture_was_made() {
    let text = page("gallery.md");
    let script = page("make_gallery.sh");
    for section in text.split("\n## ").skip(1) {
        let title = section.lines().next().unwrap_or_default();
        let scenes = scenes(section);
        let [scene] = Vec::from_iter(&scenes)[..] else { panic!("{title}: {scenes:?}") };
        assert!(section.contains("drt scenes/"), "{title} has no command");
        let stem = Path::new(scene).file_stem().unwrap().to_string_lossy();
        let shown = pictures(section);
        let [picture] = &shown[..] else { panic!("{title}: {shown:?}") };
        assert_eq!(Path::new(picture).file_stem().unwrap().to_string_lossy(), stem, "{title}");
        let mut made = script.split(|c: char| !c.is_alphanumeric() && c != '-');
        assert!(!picture.starts_with("gallery/") || made.any(|word| word == stem), "{stem} is not made");
        if !scene.starts_with("scenes/data/") {
            let bytes = fs::metadata(root().join(scene)).unwrap_or_else(|e| panic!("{scene}: {e}")).len();
            assert!(bytes < 200_000, "{scene}: {bytes} bytes");
        }
    }
}

/// Every scene of the gallery renders without a warning, with the shapes that the scripts make in place.
#[test]
fn every_scene_of_the_gallery_renders() {
    let folder = folder();
    let here = folder.path().join("scenes");
    fs::create_dir(&here).unwrap();
    for name in crate::names(&root().join("scenes")).iter().filter(|name| *name != "data") {
        fs::copy(root().join("scenes").join(name), here.join(name)).unwrap();
    }
    for script in ["shapes", "billiards", "lamps"] {
        let made = Command::new("python3").arg(here.join(format!("make_{script}.py"))).output();
        let Ok(made) = made else {
            println!("SKIPPED: no python3 to make the shapes");
            return;
        };
        assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    }
    // The scan has to be fetched; a ball stands in for it here.
    fs::copy(here.join("ball.obj"), here.join("data/dragon.obj")).unwrap();
    let forest = ["make_forest.py", "data/dragon.obj", "--count", "20", "-o", "data/dragons.toml"];
    let made = Command::new("python3").args(forest).current_dir(&here).output().unwrap();
    assert!(made.status.success(), "{}", String::from_utf8_lossy(&made.stderr));
    for scene in scenes(&page("gallery.md")) {
        let words = [scene.as_str(), "--size", "32x20", "--spp", "1", "-o", "x.png"];
        let ended = drt(folder.path(), &words);
        ended.expect(0, &[]);
        assert!(!ended.err.contains("warning:"), "{scene}: {}", ended.err);
    }
}
