//! Passes embree-sys's metadata on: the Embree version that `drt --version` prints.
fn main() {
    let version = std::env::var("DEP_EMBREE_VERSION").unwrap_or_default();
    println!("cargo::rustc-env=DRT_EMBREE_VERSION={version}");
    println!("cargo::rerun-if-changed=build.rs");
}
