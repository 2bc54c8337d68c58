//! The same rays through every backend, instruction set and build quality, and who is right where they differ.
//!
//! [`rays`] records a real render's rays and [`aimed`] makes those that go wrong most easily; [`contestants`] lists
//! who is asked; [`compare`] asks, and lets [`court`] judge every difference in f64 against all triangles near
//! the ray ([`scan`]); [`outcome`] is what was found, [`report`] says it as a table and as JSON; [`reproducer`] cuts a real disagreement down to a few
//! triangles and one ray that can be asked again. Only the figures of time depend on a clock or on threads.

pub mod aimed;
pub mod class;
pub mod compare;
pub mod contestants;
pub mod court;
pub mod outcome;
pub mod rays;
pub mod report;
pub mod reproducer;
pub mod scan;

#[cfg(test)]
mod tests;

pub use class::Class;
pub use compare::run;
pub use contestants::Contestant;
pub use outcome::{Case, Outcome, Report};
pub use rays::{Kind, RaySet};

/// What the caller hears and says while work goes on. Called from several threads.
pub struct Hooks<'a> {
    /// Told now and then the share done, 0 to 1.
    pub progress: &'a (dyn Fn(f64) + Sync),
    /// Asked often; `true` ends the work with what is finished.
    pub stop: &'a (dyn Fn() -> bool + Sync),
}

impl Hooks<'_> {
    /// Hears nothing and never stops.
    pub const NONE: Hooks<'static> = Hooks { progress: &|_| (), stop: &|| false };
}
