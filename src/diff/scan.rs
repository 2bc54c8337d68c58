//! Every triangle near a ray, measured in f64: the judge's own way to find them, shared with no backend.
//!
//! What the ray's line passes by more than the tolerance is left out by a tree of boxes (`scan/tree.rs`); that is all there is
//! to trust.

mod pieces;
mod tree;

use crate::accel::brute::{Measure, Ray64, has_area};
use crate::accel::judge::{ACROSS, Seen};
use crate::math::{DVec3, Vec3};
use crate::shape::Mesh;
use rayon::prelude::*;
use std::ops::ControlFlow;
use std::sync::Arc;
use tree::{Line, Tree};

/// How many times farther [`Scan::around`] looks: edges at a few minutes of arc to the ray.
const WIDE: f64 = 64.0;

/// A triangle that a ray passes within rounding.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near {
    pub seen: Seen,
    pub mesh: u32,
    pub triangle: u32,
}

/// All triangles with area.
pub(super) struct Scan {
    meshes: Vec<Arc<Mesh>>,
    tree: Tree,
    largest: f64,
}

impl Scan {
    pub fn new(meshes: &[Arc<Mesh>]) -> Scan {
        let tree = Tree::new(pieces::of(meshes));
        let largest = f64::from(tree.bounds().iter().fold(Vec3::ZERO, |w, p| w.max(p.abs())).max_element());
        Scan { meshes: meshes.to_vec(), tree, largest }
    }

    /// The triangles that the ray's line does not pass outside of by more than the tolerance, by distance; those that
    /// it runs along only where f64 can tell where.
    pub fn near(&self, ray: &Ray64) -> Vec<Near> {
        self.within(ray, self.slack(ray))
    }

    /// As [`Scan::near`], with all those whose tolerance is larger since the ray runs along one of their edges.
    pub fn around(&self, ray: &Ray64) -> Vec<Near> {
        self.within(ray, WIDE * self.slack(ray))
    }

    fn within(&self, ray: &Ray64, slack: f64) -> Vec<Near> {
        let mut found = Vec::new();
        let _ = self.tree.along(&Line::new(ray.o, ray.d, slack), &mut |ids| {
            found.push(ids);
            ControlFlow::Continue(())
        });
        // Long triangles are in the tree in pieces.
        found.sort_unstable();
        found.dedup();
        let see = |[mesh, triangle]: [u32; 2]| {
            let corners = self.corners([mesh, triangle]);
            // What is passed by twice the tolerance needs no exact sides.
            if Measure::of(ray, corners).is_some_and(|rough| rough.inset < -slack) {
                return None;
            }
            let seen = Seen::of(ray, corners)?;
            (!seen.outside()).then_some(Near { seen, mesh, triangle })
        };
        let mut near: Vec<Near> = found.into_iter().filter_map(see).collect();
        near.sort_by(|a, b| a.seen.measure.t.total_cmp(&b.seen.measure.t));
        near
    }

    /// True when a triangle is met on the interval.
    pub fn any(&self, ray: &Ray64) -> bool {
        let meets = |ids: [u32; 2]| {
            let m = Seen::of(ray, self.corners(ids)).map(|seen| seen.measure);
            m.is_some_and(|m| m.inset >= 0.0 && ray.tmin <= m.t && m.t <= ray.tmax)
        };
        let each = &mut |ids| if meets(ids) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        self.tree.along(&Line::new(ray.o, ray.d, self.slack(ray)), each).is_break()
    }

    /// Twice the tolerance: what the boxes' f32 and f64 lose is far below that.
    fn slack(&self, ray: &Ray64) -> f64 {
        2.0 * ACROSS * f64::from(f32::EPSILON) * self.largest.max(ray.o.abs().max_element())
    }

    fn corners(&self, [mesh, triangle]: [u32; 2]) -> [DVec3; 3] {
        self.meshes[mesh as usize].triangle(triangle as usize).map(|p| p.as_dvec3())
    }

    /// The `most` triangles (mesh, triangle) whose middles are nearest to `point`.
    pub fn nearest_to(&self, point: DVec3, most: usize) -> Vec<[u32; 2]> {
        let mut all: Vec<(f64, [u32; 2])> = Vec::new();
        for (id, mesh) in self.meshes.iter().enumerate() {
            let away = |triangle: usize| {
                let corners = mesh.triangle(triangle);
                let middle = corners.iter().map(|p| p.as_dvec3()).sum::<DVec3>() / 3.0;
                has_area(corners).then(|| (middle.distance_squared(point), [id as u32, triangle as u32]))
            };
            all.par_extend((0..mesh.indices.len()).into_par_iter().filter_map(away));
        }
        all.par_sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        all.truncate(most);
        all.into_iter().map(|(_, ids)| ids).collect()
    }
}
