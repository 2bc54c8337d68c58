//! Emissive triangles of instances: each stands where its instance stands at the time of the sample.
//!
//! At one time it is a triangle like any other, so its points are chosen as those of a triangle at rest, and their
//! density per solid angle is that of the triangle where it is. What is weighed to choose a light does not know the time:
//! the box around all of the triangle's way, and every direction that it may turn to.

use super::{Emitter, Lights, Owners};
use crate::light::bounds::{Cone, LightBounds};
use crate::light::patch::{self, Patch, PatchPoint};
use crate::light::{Emission, LightSample};
use crate::math::{Aabb, Vec2, Vec3, luminance};
use crate::shape::{Bounds64, Instance, Instances, Mesh, Surface};
use glam::DAffine3;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Emissive triangles of all instances together, at most; each takes some 200 bytes. Where there are more, those of
/// instances are found by the rays that meet them, and light samples are taken of the others.
pub const MOST: usize = 1 << 22;

/// From the first to the last emissive triangle of an instance there may be so many times [`MOST`], of all together: a
/// number each.
const SPARSE: usize = 16;

/// An instance that shines.
#[derive(Clone, Debug)]
pub struct Lamp {
    mesh: Arc<Mesh>,
    place: Instance,
    shutter: [f64; 2],
}

impl Lamp {
    #[inline]
    fn corners(&self, t: u32, transform: &DAffine3) -> [Vec3; 3] {
        self.mesh.triangle(t as usize).map(|p| transform.transform_point3(p.as_dvec3()).as_vec3())
    }

    /// Triangle `t` as it stands under `transform`, but for its normal.
    #[inline]
    fn patch(&self, t: u32, transform: &DAffine3) -> Patch {
        Patch::Triangle { corners: self.corners(t, transform), ng: Vec3::ZERO }
    }

    /// Where triangle `t` is while the shutter is open, and where it may shine.
    fn bounds(&self, t: u32, emission: &Emission) -> LightBounds {
        let own = self.mesh.triangle(t as usize).iter().fold(Aabb::EMPTY, |b, p| b.grow(*p));
        let Bounds64 { min, max } = self.place.bounds(&own, self.shutter);
        let area = |time: f32| self.patch(t, &self.place.during(self.shutter, time)).area();
        // One that is nothing at both ends may be something between.
        let area = [0.0, 0.5, 1.0].map(area).into_iter().fold(0.0, f64::max);
        let cone = self.place.rest().map_or(Cone::ALL, |transform| {
            let axis = Surface::faceted(&self.mesh, t, 0.3, 0.3).placed(transform).ng;
            Cone { axis, cos_normals: 1.0, cos_light: 0.0 }
        });
        LightBounds {
            bounds: Aabb { min: min.as_vec3(), max: max.as_vec3() },
            cone,
            two_sided: emission.two_sided,
            strength: (f64::from(emission.luminance_over(&self.mesh, t as usize)) * area) as f32,
        }
    }

    /// A point of triangle `t` at `time` for a receiver at `from`, its texture coordinates, and the area that densities
    /// see.
    #[inline]
    fn sample(&self, t: u32, from: Vec3, time: f32, u: [f32; 2]) -> (PatchPoint, Option<Vec2>, f32) {
        let transform = self.place.during(self.shutter, time);
        let corners = self.corners(t, &transform);
        let ([b, c], by_solid_angle) = patch::choose(&corners, from, u);
        // The very point that a ray would meet there.
        let Surface { p, error, ng, .. } = Surface::faceted(&self.mesh, t, b, c).placed(&transform);
        (PatchPoint { p, error, ng, by_solid_angle }, self.mesh.uv(t as usize, b, c), patch::area(&corners))
    }
}

impl Lights {
    /// Adds the emissive triangles of `instances`, unless there are more than `most`.
    pub(super) fn collect_lamps(
        &mut self,
        instances: &Instances,
        shutter: [f64; 2],
        most: usize,
        bounds: &mut Vec<LightBounds>,
    ) {
        let shines = |id: u32| self.emissions.get(id as usize).is_some_and(|e| luminance(e.radiance) > 0.0);
        if !(0..self.emissions.len() as u32).any(shines) {
            return;
        }
        // Looked for once a mesh, however many places it has: all of its triangles, and those that shine by themselves.
        let (mut all, mut own) = (BTreeMap::new(), BTreeMap::new());
        let mut triangles_of = |place: &Instance| {
            let mesh = &instances.meshes[place.mesh as usize];
            let triangles = 0..mesh.indices.len() as u32;
            let list = match place.material {
                Some(id) if !shines(id) => return Arc::default(),
                Some(_) => all.entry(place.mesh).or_insert_with(|| Arc::new(triangles.collect())),
                None => own.entry(place.mesh).or_insert_with(|| {
                    Arc::new(triangles.filter(|t| shines(mesh.materials.get(*t as usize))).collect())
                }),
            };
            Arc::clone(list)
        };
        let found: Vec<Arc<Vec<u32>>> = instances.places.iter().map(&mut triangles_of).collect();
        let count = found.iter().map(|triangles| triangles.len()).fold(0, usize::saturating_add);
        let span = |triangles: &Arc<Vec<u32>>| match [triangles.first(), triangles.last()] {
            [Some(first), Some(last)] => (last - first) as usize + 1,
            _ => 0,
        };
        let spans = found.iter().map(span).fold(0, usize::saturating_add);
        self.has_unsampled = count > most || spans > most.saturating_mul(SPARSE);
        if self.has_unsampled {
            return;
        }
        for (place, triangles) in instances.places.iter().zip(found) {
            let mesh = Arc::clone(&instances.meshes[place.mesh as usize]);
            let owners = self.collect_lamp(Lamp { mesh, place: place.clone(), shutter }, &triangles, bounds);
            self.owners.push(owners);
        }
    }

    fn collect_lamp(&mut self, lamp: Lamp, triangles: &[u32], bounds: &mut Vec<LightBounds>) -> Owners {
        let [Some(&first), Some(&last)] = [triangles.first(), triangles.last()] else {
            return Owners::default();
        };
        let mut emitters = vec![super::NONE; (last - first) as usize + 1];
        for &triangle in triangles {
            let material = lamp.place.material.unwrap_or_else(|| lamp.mesh.materials.get(triangle as usize));
            let Some(emission) = self.emissions.get(material as usize) else { continue };
            let around = lamp.bounds(triangle, emission);
            // What has no area sends nothing, and its normal is no number.
            if around.strength > 0.0 && around.strength.is_finite() {
                emitters[(triangle - first) as usize] = self.emitters.len() as u32;
                self.emitters.push(Emitter::Lamp { lamp: self.lamps.len() as u32, triangle, material });
                bounds.push(around);
            }
        }
        self.lamps.push(lamp);
        Owners { first, emitters }
    }

    /// A light sample of a triangle of an instance, as it stands at `time`.
    #[inline]
    pub(super) fn sample_lamp(
        &self,
        from: &Surface,
        [lamp, triangle, material]: [u32; 3],
        chance: f32,
        time: f32,
        u: [f32; 2],
    ) -> Option<LightSample> {
        let (point, uv, area) = self.lamps.get(lamp as usize)?.sample(triangle, from.p, time, u);
        let emission = self.emissions.get(material as usize)?;
        let radiance = if emission.varies() { emission.there(uv) } else { emission.radiance };
        patch::light_sample(from, &point, (radiance, emission.two_sided), area, chance)
    }

    /// The density with which [`Lights::sample_lamp`] would have chosen a point.
    #[inline]
    pub(super) fn pdf_of_lamp(
        &self,
        [lamp, triangle]: [u32; 2],
        from: Vec3,
        time: f32,
        d2: f32,
        cos: f32,
    ) -> f32 {
        let lamp = &self.lamps[lamp as usize];
        lamp.patch(triangle, &lamp.place.during(lamp.shutter, time)).pdf(from, d2, cos)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::{Receiver, Sampled};
    use crate::math::Rgb;
    use crate::shape::FaceMaterials;

    /// Two places of a mesh with three triangles, the middle one dark: four lamps, or none where three are too many.
    #[test]
    fn lamps_are_collected_up_to_a_limit() {
        let mut mesh = Mesh::new(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]; 3]);
        mesh.materials = FaceMaterials::PerFace(vec![1, 0, 1]);
        let places =
            [0.0, 2.0].map(|x| Instance::at_rest(0, None, DAffine3::from_translation(glam::DVec3::X * x)));
        let instances = Instances { meshes: vec![Arc::new(mesh)], places: places.to_vec() };
        let emission = |radiance| Emission { radiance, two_sided: true, texture: None, opacity: None };
        let emissions = vec![emission(Rgb::ZERO), emission(Rgb::ONE)];
        let sampled = Sampled { alone: false, deltas: true };
        let new = |instances| Lights::new(&[], (instances, [0.0; 2]), emissions.clone(), &[], sampled);
        let nothing = Instances::default();
        let none = new(&nothing);
        assert!(none.is_empty() && !none.has_unsampled);
        // The middle ones are dark, and would have a number each.
        let mut sparse = instances.clone();
        let mut long = (*instances.meshes[0]).clone();
        (long.indices, long.materials) =
            (vec![[0, 1, 2]; 80], FaceMaterials::PerFace([vec![1], vec![0; 78], vec![1]].concat()));
        sparse.meshes = vec![Arc::new(long)];
        let mut lights = none.clone();
        lights.collect_lamps(&sparse, [0.0; 2], 5, &mut Vec::new());
        assert!(lights.has_unsampled);
        for (most, count) in [(4, 4), (3, 0)] {
            let mut lights = none.clone();
            let mut bounds = Vec::new();
            lights.collect_lamps(&instances, [0.0; 2], most, &mut bounds);
            assert_eq!((bounds.len(), lights.has_unsampled), (count, count == 0));
            assert_eq!((lights.samples(0), lights.samples(1)), (count > 0, count > 0));
        }
        let lights = new(&instances);
        let from = Receiver::new(Vec3::new(0.3, 0.3, 1.0), Receiver::ALL_AROUND);
        let chances: f32 = (0..4).map(|i| lights.chance(i, &from)).sum();
        assert!((chances - 1.0).abs() < 1e-5, "{chances}");
    }
}
