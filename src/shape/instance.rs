//! A mesh in another place: the triangles once, and where they stand as often as one likes.

use super::{Bounds64, Mesh, Motion, Surface};
use crate::math::{Aabb, DVec3, Vec3};
use glam::{DAffine3, DMat3};
use std::sync::Arc;

/// One step on the way from a mesh's coordinates to the scene's.
#[derive(Clone, Debug, PartialEq)]
pub enum Stage {
    /// At all times the same.
    Fixed(DAffine3),
    /// Depends on the time.
    Moving(Arc<Motion>),
}

/// A mesh in a place of its own.
#[derive(Clone, Debug, PartialEq)]
pub struct Instance {
    /// Index in [`Instances::meshes`].
    pub mesh: u32,
    /// Instead of the mesh's own materials.
    pub material: Option<u32>,
    course: Course,
}

#[derive(Clone, Debug, PartialEq)]
enum Course {
    Rest(DAffine3),
    Moving(Vec<Stage>),
}

impl Instance {
    /// `mesh` moved through `stages`, the first one first, from its own coordinates to the scene's.
    pub fn new(mesh: u32, material: Option<u32>, stages: Vec<Stage>) -> Instance {
        let fixed = stages.iter().try_fold(DAffine3::IDENTITY, |done, stage| match stage {
            Stage::Fixed(next) => Some(*next * done),
            Stage::Moving(_) => None,
        });
        Instance { mesh, material, course: fixed.map_or(Course::Moving(stages), Course::Rest) }
    }

    /// `mesh` at rest.
    pub fn at_rest(mesh: u32, material: Option<u32>, transform: DAffine3) -> Instance {
        Instance { mesh, material, course: Course::Rest(transform) }
    }

    /// From the mesh's coordinates to the scene's at a time.
    #[inline]
    pub fn transform(&self, time: f64) -> DAffine3 {
        match &self.course {
            Course::Rest(transform) => *transform,
            Course::Moving(stages) => stages.iter().fold(DAffine3::IDENTITY, |done, stage| match stage {
                Stage::Fixed(next) => *next * done,
                Stage::Moving(motion) => motion.at(time) * done,
            }),
        }
    }

    /// The transform at a sample's time: 0 as the shutter opens, 1 as it closes.
    #[inline]
    pub fn during(&self, [open, close]: [f64; 2], time: f32) -> DAffine3 {
        match &self.course {
            Course::Rest(transform) => *transform,
            Course::Moving(_) => self.transform(open + (close - open) * f64::from(time)),
        }
    }

    /// The transform, where it is the same at all times.
    #[inline]
    pub fn rest(&self) -> Option<&DAffine3> {
        match &self.course {
            Course::Rest(transform) => Some(transform),
            Course::Moving(_) => None,
        }
    }

    /// True when it stays where it is between the two times.
    pub fn rests(&self, shutter: [f64; 2]) -> bool {
        match &self.course {
            Course::Rest(_) => true,
            Course::Moving(stages) => stages.iter().all(|stage| match stage {
                Stage::Fixed(_) => true,
                Stage::Moving(motion) => motion.rests(shutter),
            }),
        }
    }

    /// A box around a mesh with the box `mesh` at all times of the shutter.
    pub fn bounds(&self, mesh: &Aabb, shutter: [f64; 2]) -> Bounds64 {
        let mesh = Bounds64::of(mesh);
        if mesh.is_empty() {
            return mesh;
        }
        match &self.course {
            Course::Rest(transform) => mesh.moved(transform),
            Course::Moving(stages) => stages.iter().fold(mesh, |bounds, stage| match stage {
                Stage::Fixed(transform) => bounds.moved(transform),
                Stage::Moving(motion) => motion.bounds(&bounds, shutter),
            }),
        }
    }
}

/// Meshes that stand in several places or move, and the places.
#[derive(Clone, Debug, Default)]
pub struct Instances {
    /// The meshes, in coordinates of their own.
    pub meshes: Vec<Arc<Mesh>>,
    /// Where they stand.
    pub places: Vec<Instance>,
}

impl Instances {
    /// The box around the instance at index `i` over the shutter.
    pub fn bounds(&self, i: usize, shutter: [f64; 2]) -> Bounds64 {
        let place = self.places.get(i);
        let mesh = place.and_then(|place| self.meshes.get(place.mesh as usize));
        place.zip(mesh).map_or(Bounds64::EMPTY, |(place, mesh)| place.bounds(&mesh.bounds(), shutter))
    }

    /// Every instance as a mesh in scene coordinates, as it stands at a time: for those who know no instances.
    pub fn copies(&self, time: f64) -> impl Iterator<Item = Mesh> + '_ {
        self.places.iter().filter_map(move |place| {
            let mesh = self.meshes.get(place.mesh as usize)?;
            let mut copy = mesh.placed(&place.transform(time));
            if let Some(material) = place.material {
                copy.materials = super::FaceMaterials::Uniform(material);
            }
            Some(copy)
        })
    }
}

impl Mesh {
    /// A copy whose positions and normals are transformed. Triangles keep their corners' order, so that a mirror turns
    /// the geometric normals around.
    #[must_use]
    pub fn placed(&self, transform: &DAffine3) -> Mesh {
        let mut mesh = self.clone();
        for position in mesh.positions.iter_mut() {
            let p = transform.transform_point3(DVec3::from(position.map(f64::from)));
            *position = p.as_vec3().to_array();
        }
        let normal = normal_matrix(&transform.matrix3);
        if let Some(normals) = &mut mesh.normals {
            for value in &mut normals.values {
                let n = normal * DVec3::from(value.map(f64::from));
                *value = n.normalize_or_zero().as_vec3().to_array();
            }
        }
        mesh
    }
}

/// The inverse transpose times the determinant's magnitude: how normals go, and their outside stays outside.
#[inline(always)]
fn normal_matrix(m: &DMat3) -> DMat3 {
    let (a, b, c) = (m.x_axis, m.y_axis, m.z_axis);
    let side = a.dot(b.cross(c)).signum();
    DMat3::from_cols(b.cross(c) * side, c.cross(a) * side, a.cross(b) * side)
}

impl Surface {
    /// A point of a mesh as a point of the scene. `size`: the largest coordinates that it was made of.
    ///
    /// The error is the distance, along the normal, that a ray must keep from here so that in the mesh's coordinates it
    /// keeps the distance that [`Surface::faceted`] states there, and the rounding of the scene's coordinates.
    #[inline(always)]
    #[must_use]
    pub fn placed(&self, transform: &DAffine3) -> Surface {
        let linear = &transform.matrix3;
        let normals = normal_matrix(linear);
        let turned = |n: Vec3| normals * n.as_dvec3();
        let (p, n) = (self.p.as_dvec3(), turned(self.ng));
        let length = n.length();
        let ng = (n * (1.0 / length)).as_vec3();
        let ng = if ng.is_finite() { ng } else { Vec3::Z };
        let ns = turned(self.ns).try_normalize().map_or(ng, |ns| ns.as_vec3());
        // A shift by s along the scene's unit normal moves off the mesh's plane by s times this.
        let off =
            self.ng.as_dvec3().dot(DAffine3::from_mat3(*linear).inverse().transform_vector3(ng.as_dvec3()));
        let sum = |v: Vec3| f64::from(v.x.abs() + v.y.abs() + v.z.abs());
        let own = f64::from(self.error) * sum(self.ng) / off.abs();
        let world = transform.transform_point3(p);
        let size = world.abs().max(transform.translation.abs()).max_element();
        let rounding = f64::from(super::surface::ROUNDING) * size;
        Surface { p: world.as_vec3(), error: (own / sum(ng) + rounding) as f32, ng, ns, uv: self.uv }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::ray::leave;

    /// Points that leave a surface by its error stay off it in the mesh's own coordinates, by as much as there.
    #[test]
    fn errors_follow_stretches_mirrors_and_shifts() {
        let a = DMat3::from_cols(
            DVec3::new(1.0, 0.3, 0.0),
            DVec3::new(-0.5, 1e-3, 0.2),
            DVec3::new(0.1, 0.0, -300.0),
        );
        for (linear, shift) in
            [(a, DVec3::ZERO), (a, DVec3::splat(1e4)), (-a, DVec3::X), (a * 1e-6, DVec3::X)]
        {
            let transform = DAffine3 { matrix3: linear, translation: shift };
            let own = Surface::faceted(
                &Mesh::new(vec![[1.0, 2.0, 3.0], [2.0, 2.0, 3.5], [1.0, 4.0, 3.0]], vec![[0, 1, 2]]),
                0,
                0.2,
                0.3,
            );
            let placed = own.placed(&transform);
            for side in [1.0, -1.0] {
                let off = leave(placed.p, placed.error, placed.ng, placed.ng * side);
                let back = transform.inverse().transform_point3(off.as_dvec3()) - own.p.as_dvec3();
                let distance = back.dot(own.ng.as_dvec3()) * f64::from(side);
                assert!(
                    distance >= 0.99 * f64::from(own.error),
                    "{distance} of {} under {linear}",
                    own.error
                );
            }
        }
    }

    #[test]
    fn the_outside_of_a_mirrored_mesh_stays_outside() {
        let mesh = Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]);
        let mirror = DAffine3::from_scale(DVec3::new(-1.0, 1.0, 1.0));
        let surface = Surface::faceted(&mesh, 0, 0.25, 0.25).placed(&mirror);
        assert_eq!((surface.ng, surface.p), (Vec3::Z, Vec3::new(-0.25, 0.25, 0.0)));
    }
}
