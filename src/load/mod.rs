//! Files become plain data.
//!
//! Readers are lenient: what is wrong with a file is skipped or replaced and reported as
//! [`crate::error::Findings`] by file and line; only what makes the whole file useless is an error.

pub mod mtl;
pub mod obj;
pub mod open;
