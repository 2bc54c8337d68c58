//! `tests/README.md` names tests; they must exist.

use std::fs;
use std::path::Path;

#[test]
fn every_test_that_the_readme_names_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = fs::read_to_string(root.join("tests/README.md")).unwrap();
    // Every second piece between backticks is inside them.
    let quoted = text.split('`').skip(1).step_by(2);
    let names: Vec<(&str, &str)> = quoted.filter_map(|name| name.split_once(".rs::")).collect();
    assert!(names.len() > 60, "{}", names.len());
    for (file, function) in names {
        let file = format!("{file}.rs");
        let in_tests = root.join("tests").join(&file);
        let path = if in_tests.exists() { in_tests } else { root.join(&file) };
        let source = fs::read_to_string(&path).unwrap_or_else(|e| panic!("{file}: {e}"));
        assert!(source.contains(&format!("fn {function}(")), "{file} has no {function}");
    }
}
