//! drt.
pub mod error;
pub mod math;
pub mod output;
pub mod shape;
pub mod accel;
pub mod bsdf;
pub mod light;
pub mod camera;
pub mod film;
pub mod scene;
pub mod load;
pub mod sampler;
pub mod integrator;
pub mod render;
