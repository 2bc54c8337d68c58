//! drt.
pub mod error;
pub mod math;
pub mod shape;
pub mod accel;
