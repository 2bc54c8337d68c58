//! The lecture notes as specification: every rule for the pixel and for the hemisphere against sums done by hand,
//! closed forms and the path integrator, on every backend. Statistics as in `physics/`.

mod distribution;
#[path = "../physics/harness.rs"]
#[allow(dead_code)] // the physics suite needs more of it
mod harness;
mod hemisphere;
mod pixel;
