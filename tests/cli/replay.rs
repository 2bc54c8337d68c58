//! The fuzz targets' own functions, on their seeds, on what runs made of them and on everything that was ever found (`fuzz/README.md`).

// What only the targets call is there as well.
#[allow(dead_code)]
#[path = "../../fuzz/src/lib.rs"]
mod targets;

use std::fs;
use std::path::{Path, PathBuf};

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten();
    let mut files: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    files.sort();
    files
}

/// A18: what once broke a promise keeps it now.
#[test]
fn a18_what_fuzzing_found() {
    let fuzz = Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz");
    for (name, run) in targets::TARGETS {
        let seeds = files(&fuzz.join("seeds").join(name));
        assert!(seeds.len() >= 3, "{name} has {} seeds", seeds.len());
        let more = ["grown", "found"].into_iter().flat_map(|folder| files(&fuzz.join(folder).join(name)));
        for file in seeds.into_iter().chain(more) {
            eprintln!("{}", file.display());
            run(&fs::read(&file).unwrap());
        }
    }
    for folder in ["seeds", "grown", "found"].map(|folder| fuzz.join(folder)) {
        for target in files(&folder).iter().filter(|path| path.is_dir()) {
            let name = target.file_name().unwrap().to_string_lossy();
            assert!(targets::TARGETS.iter().any(|row| row.0 == name), "{name} is no target");
        }
    }
}

/// Every key of scene files is in a seed, and most of what is refused. A seed that is refused by mistake leads nowhere.
#[test]
fn seeds_of_scene_files_are_refused_where_they_say_so() {
    let seeds = files(&Path::new(env!("CARGO_MANIFEST_DIR")).join("fuzz/seeds/scene_toml"));
    for file in seeds {
        let name = file.file_name().unwrap().to_string_lossy();
        // There is Embree or there is not.
        if name != "no_embree" {
            assert_eq!(
                targets::scene_toml::reads(&fs::read(&file).unwrap()),
                !name.starts_with("no_"),
                "{name}"
            );
        }
    }
}
