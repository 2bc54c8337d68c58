//! What the program is made of: every direct dependency has its reason in `docs/dependencies.md`, and everything comes
//! from where it may, under a licence that is listed there. Asks cargo, offline, about what it has built with.

use serde_json::Value;
use std::collections::BTreeSet;
use std::fs;
use std::path::Path;
use std::process::Command;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// What is used on this machine, and nothing from the network.
fn packages() -> Vec<Value> {
    let mut command = Command::new(env!("CARGO"));
    command.args(["metadata", "--format-version", "1", "--offline", "--locked"]);
    command.args(["--filter-platform", &format!("{}-unknown-linux-gnu", std::env::consts::ARCH)]);
    if !cfg!(feature = "embree") {
        command.arg("--no-default-features");
    }
    let output = command.current_dir(root()).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let mut metadata: Value = serde_json::from_slice(&output.stdout).unwrap();
    serde_json::from_value(metadata["packages"].take()).unwrap()
}

fn text<'v>(package: &'v Value, key: &str) -> &'v str {
    package[key].as_str().unwrap_or_default()
}

/// First cells of the document's tables.
fn explained(document: &str) -> BTreeSet<String> {
    let cells = document.lines().filter_map(|line| line.strip_prefix("| `")?.split_once('`'));
    cells.map(|(name, _)| name.to_string()).collect()
}

#[test]
fn every_dependency_has_its_reason() {
    let document = fs::read_to_string(root().join("docs/dependencies.md")).unwrap();
    let of_ours = |package: &Value| -> Vec<String> {
        let all = package["dependencies"].as_array().unwrap().iter();
        all.map(|dependency| text(dependency, "name").to_string()).collect()
    };
    let packages = packages();
    let ours: Vec<&Value> = packages.iter().filter(|package| package["source"].is_null()).collect();
    assert!(ours.iter().any(|package| package["name"] == "drt"));
    let mut used: BTreeSet<String> = ours.into_iter().flat_map(of_ours).collect();
    let build = fs::read_to_string(root().join("embree-sys/Cargo.toml")).unwrap();
    for manifest in [fs::read_to_string(root().join("fuzz/Cargo.toml")).unwrap(), build] {
        let manifest: toml::Table = manifest.parse().unwrap();
        for key in ["dependencies", "build-dependencies"] {
            let table = manifest.get(key).and_then(toml::Value::as_table).cloned().unwrap_or_default();
            used.extend(table.into_iter().map(|(name, _)| name).filter(|name| name != "drt"));
        }
    }
    assert_eq!(explained(&document), used, "docs/dependencies.md and the manifests differ");
}

#[test]
fn sources_and_licences_are_those_that_are_listed() {
    let document = fs::read_to_string(root().join("docs/dependencies.md")).unwrap();
    let (_, listed) = document.split_once("## Licences").unwrap();
    let listed: BTreeSet<&str> = listed.split('`').skip(1).step_by(2).collect();
    let config: toml::Table = fs::read_to_string(root().join("deny.toml")).unwrap().parse().unwrap();
    let allowed = config["licenses"]["allow"].as_array().unwrap().iter();
    assert_eq!(listed, allowed.map(|licence| licence.as_str().unwrap()).collect(), "deny.toml lists others");
    let packages = packages();
    assert!(packages.len() > 50, "{}", packages.len());
    for package in &packages {
        let (name, licence) = (text(package, "name"), text(package, "license"));
        assert!(is_allowed(licence, &listed), "{name} has the licence {licence:?}");
        let source = package["source"].as_str();
        let path = Path::new(text(package, "manifest_path"));
        match source {
            None => assert!(path.starts_with(root()), "{name} is from {}", path.display()),
            Some(source) => {
                assert_eq!(source, "registry+https://github.com/rust-lang/crates.io-index", "{name}");
            }
        }
    }
}

/// An SPDX expression without nested parentheses: every part of an `AND` must offer something listed.
fn is_allowed(expression: &str, listed: &BTreeSet<&str>) -> bool {
    let choice = |part: &str| {
        let part = part.trim().trim_start_matches('(').trim_end_matches(')');
        part.split(" OR ").flat_map(|one| one.split('/')).any(|one| listed.contains(one.trim()))
    };
    expression.split(" AND ").all(choice)
}

#[test]
fn licences_are_understood() {
    let listed = BTreeSet::from(["MIT", "Apache-2.0 WITH LLVM-exception", "Unicode-3.0"]);
    for expression in ["MIT", "GPL-3.0 OR MIT", "MIT/Apache-2.0", "(MIT OR Apache-2.0) AND Unicode-3.0"] {
        assert!(is_allowed(expression, &listed), "{expression}");
    }
    for expression in ["", "GPL-3.0", "MIT AND GPL-3.0", "(MIT OR ISC) AND GPL-3.0", "Apache-2.0"] {
        assert!(!is_allowed(expression, &listed), "{expression}");
    }
}
