//! The notes' rules of integration, each formula in one place.

pub mod hemisphere;
