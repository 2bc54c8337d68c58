//! Runs a target on every file of some folders, once: what `coverage.sh` measures.

use std::path::PathBuf;
use std::process::ExitCode;

fn main() -> ExitCode {
    let mut arguments = std::env::args().skip(1);
    let name = arguments.next().unwrap_or_default();
    let Some((_, run)) = drt_fuzz::TARGETS.iter().find(|row| row.0 == name) else {
        eprintln!("usage: cover TARGET FOLDER...");
        return ExitCode::from(2);
    };
    drt_fuzz::alone();
    let mut count = 0;
    for folder in arguments.map(PathBuf::from) {
        let files = folder.read_dir().into_iter().flatten().flatten();
        for file in files.filter_map(|entry| std::fs::read(entry.path()).ok()) {
            run(&file);
            count += 1;
        }
    }
    println!("{count} inputs");
    ExitCode::SUCCESS
}
