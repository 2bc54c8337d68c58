//! The same rays through every backend, instruction set and build quality, and who is right where they differ.
//!
//! [`rays`] records a real render's rays and [`aimed`] makes those that go wrong most easily; [`contestants`] lists
//! who is asked; [`compare`] asks, and lets [`court`] judge every difference in f64 against all triangles near
//! the ray ([`scan`]); [`outcome`] is what was found, [`report`] says it as a table and as JSON; [`reproducer`] cuts a real disagreement down to a few
//! triangles and one ray that can be asked again. Backends know no instances: [`at_rest`] makes copies of them, as they
//! stand when the shutter opens. Only the figures of time depend on a clock or on threads.

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

use crate::error::{Error, Result};
use crate::scene::Scene;
use crate::shape::Instance;
use std::sync::Arc;

/// Triangles that copies of instances may have, all together.
const MOST_COPIED: u64 = 30_000_000;

/// The scene without instances: each a copy where it stands as the shutter opens, which stays closed then.
///
/// # Errors
/// So many triangles that they would hardly fit into memory.
pub fn at_rest(mut scene: Scene) -> Result<Scene> {
    let instances = std::mem::take(&mut scene.instances);
    let open = scene.camera.shutter[0];
    scene.camera.shutter = [open; 2];
    let triangles =
        |i: &Instance| instances.meshes.get(i.mesh as usize).map_or(0, |m| m.indices.len() as u64);
    let all: u64 = instances.places.iter().map(triangles).sum();
    if all > MOST_COPIED {
        return Err(Error::new(format!(
            "backends are compared over copies of all instances, and those would have {all} triangles"
        ))
        .advise(format!("leave some out; {MOST_COPIED} triangles are the limit")));
    }
    scene.meshes.extend(instances.copies(open).map(Arc::new));
    Ok(scene)
}

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
