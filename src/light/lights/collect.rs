//! Which triangles and lamps of a scene are lights with a place, and what a tree of lights needs to know of them.

use super::{Emitter, Lights, NONE, Owners};
use crate::light::bounds::{Cone, LightBounds};
use crate::light::patch::Patch;
use crate::math::{Aabb, Vec3, luminance};
use crate::shape::Mesh;

impl Lights {
    /// Adds the emissive triangles of a mesh, two that make a rectangle as one.
    pub(super) fn collect_patches(&mut self, id: u32, mesh: &Mesh, bounds: &mut Vec<LightBounds>) -> Owners {
        let shines = |t: usize| {
            let emission = self.emissions.get(mesh.materials.get(t) as usize);
            emission.is_some_and(|e| luminance(e.radiance) > 0.0)
        };
        // Most scenes have no such material, and millions of triangles.
        if !self.emissions.iter().any(|e| luminance(e.radiance) > 0.0) {
            return Owners::default();
        }
        let Some(first) = (0..mesh.indices.len()).find(|t| shines(*t)) else { return Owners::default() };
        let end = (first..mesh.indices.len()).rev().find(|t| shines(*t)).map_or(first, |t| t + 1);
        let mut emitters = vec![NONE; end - first];
        let mut t = first;
        while t < end {
            let material = mesh.materials.get(t);
            let shining = self.emissions.get(material as usize).filter(|e| luminance(e.radiance) > 0.0);
            let pair = t + 1 < end && mesh.materials.get(t + 1) == material;
            // A picture is looked up in one triangle.
            let rectangle = shining.filter(|e| pair && !e.varies()).and_then(|_| Patch::new(mesh, t, true));
            let size = 1 + usize::from(rectangle.is_some());
            let patch = rectangle.or_else(|| shining.and_then(|_| Patch::new(mesh, t, false)));
            if let (Some(patch), Some(emission)) = (patch, shining) {
                emitters[t - first..t - first + size].fill(self.emitters.len() as u32);
                bounds.push(patch.bounds(emission.luminance_over(mesh, t), emission.two_sided));
                self.emitters.push(Emitter::Patch { patch: self.patches.len() as u32, material });
                self.patches.push(patch);
                self.sources.push([id, t as u32]);
            }
            t += size;
        }
        Owners { first: first as u32, emitters }
    }

    /// Adds points and spots (if `deltas`) and spheres.
    pub(super) fn collect_others(&mut self, deltas: bool, bounds: &mut Vec<LightBounds>) {
        let at = |p: Vec3, radius: f32, cone: Cone, strength: f32| LightBounds {
            bounds: Aabb::EMPTY.grow(p - radius).grow(p + radius),
            cone,
            two_sided: false,
            strength,
        };
        for (i, p) in self.points.iter().enumerate().filter(|_| deltas) {
            self.emitters.push(Emitter::Point(i as u32));
            bounds.push(at(p.position, 0.0, Cone::ALL, luminance(p.intensity)));
        }
        for (i, s) in self.spots.iter().enumerate().filter(|_| deltas) {
            self.emitters.push(Emitter::Spot(i as u32));
            // Just beyond the cone's edge, where rounding may think itself outside.
            let cone = Cone { axis: s.direction, cos_normals: s.cos_outer, cos_light: 0.999 };
            bounds.push(at(s.position, 0.0, cone, luminance(s.intensity)));
        }
        for (i, s) in self.spheres.iter().enumerate() {
            self.sphere_emitter.push(self.emitters.len() as u32);
            self.emitters.push(Emitter::Sphere(i as u32));
            let strength = std::f32::consts::PI * s.radius * s.radius * luminance(s.radiance);
            bounds.push(at(s.center, s.radius, Cone::ALL, strength));
        }
    }
}
