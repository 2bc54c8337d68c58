//! How large coordinates may be.
//!
//! Embree takes distances from v·(e×e), v a corner's offset and e the edges, and finds its triangles at infinity where
//! that leaves the range of f32: it takes the wrong one of two, silently. A build cannot be asked, since no ray is known
//! then; so whoever is about to render asks here.

use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::shape::Mesh;
use std::sync::Arc;

/// Of 16 times there is a factor of 2 for the normal, and one of 8 for rays from far away.
const SPARE: f64 = 16.0;

/// Below this largest coordinate, edges cannot be long enough: 16·(2c)²·c is within f32.
const UNSUSPICIOUS: f32 = 1e12;

/// Refuses meshes whose coordinates and edges are together beyond what Embree can compute with.
///
/// # Errors
/// Names both sizes, and the backend that can.
pub fn check(meshes: &[Arc<Mesh>]) -> Result<()> {
    for mesh in meshes {
        let bounds = mesh.bounds();
        let farthest = bounds.min.abs().max(bounds.max.abs()).max_element();
        if farthest <= UNSUSPICIOUS {
            continue;
        }
        let edges = |[a, b, c]: [Vec3; 3]| [b - a, c - b, a - c].map(|e| e.as_dvec3().length());
        let of_triangle = |t: usize| edges(mesh.triangle(t)).into_iter().fold(0.0, f64::max);
        let longest = (0..mesh.indices.len()).map(of_triangle).fold(0.0, f64::max);
        if SPARE * longest * longest * f64::from(farthest) > f64::from(f32::MAX) {
            return Err(Error::new(format!(
                "coordinates up to {farthest:.1e} with edges of {longest:.1e} are beyond what Embree can compute with"
            ))
            .advise("use the backend \"bvh\" (--backend bvh), or larger units, so that coordinates stay below 1e12"));
        }
    }
    Ok(())
}
