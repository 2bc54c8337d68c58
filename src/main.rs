//! drt.
fn main() {}
