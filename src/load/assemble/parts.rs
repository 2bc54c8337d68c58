//! What a file itself shows in several places: each mesh once, and an instance for every place of every placement.

use super::places::{Placement, kind};
use crate::error::{Error, Result};
use crate::load::object::Part;
use crate::load::place::{Transform, place};
use crate::load::scene_file::MOST_PLACES;
use crate::math::DVec3;
use crate::shape::{Instance, Instances, Stage};
use glam::DAffine3;
use std::collections::HashMap;
use std::sync::Arc;

/// Adds the parts of a file for its `placements`, in a scene whose coordinates begin at `origin`.
///
/// # Errors
/// As [`place`]; more than [`MOST_PLACES`].
pub fn place_parts<'p>(
    parts: Vec<Part>,
    placements: impl Iterator<Item = &'p Placement> + Clone,
    origin: DVec3,
    instances: &mut Instances,
) -> Result<()> {
    // Placements with the same normals and materials share a mesh.
    let (mut known, mut firsts) = (HashMap::new(), Vec::new());
    let which = placements.clone().map(|p| {
        *known.entry((kind(p), p.choice.key())).or_insert_with(|| {
            firsts.push(p);
            firsts.len() - 1
        })
    });
    let which: Vec<usize> = which.collect();
    let count = parts.iter().map(|part| part.places.len()).fold(0, usize::saturating_add);
    let count = count.saturating_mul(which.len()).saturating_add(instances.places.len());
    if count > MOST_PLACES {
        let error = format!("the scene has {count} places, more than {MOST_PLACES}");
        return Err(Error::new(error).advise("place the file less often"));
    }
    for part in parts {
        let Part { mesh, origin: from, places } = part;
        let base = instances.meshes.len();
        let mut mesh = Some(mesh);
        for (k, first) in firsts.iter().enumerate() {
            // The last one takes the memory over.
            let own = if k + 1 == firsts.len() { mesh.take() } else { mesh.clone() };
            let Some(mut own) = own else { continue };
            first.choice.dress(&mut own);
            instances.meshes.push(Arc::new(place(own, from, from, &Transform::IDENTITY, first.normals)?));
        }
        for (p, which) in placements.clone().zip(&which) {
            for at in &places {
                let first = p.transform.affine() * *at * DAffine3::from_translation(from);
                let last = Stage::Fixed(DAffine3::from_translation(-origin));
                let course = [Stage::Fixed(first)].into_iter().chain(p.course.iter().cloned()).chain([last]);
                instances.places.push(Instance::new((base + which) as u32, None, course.collect()));
            }
        }
    }
    Ok(())
}
