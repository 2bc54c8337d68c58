//! Meshes in several places and in motion: two levels, above any backend.
//!
//! The backend builds one structure over the meshes at rest, and one for each mesh that has instances, in the mesh's
//! own coordinates. Above them stands a tree over the boxes of all instances ([`tree`]). Rays that enter an instance's
//! box go into the mesh's coordinates, each at its own time, and the mesh's structure is asked. Directions are not
//! made unit there, so distances are the same in both worlds.
//!
//! # The same answer everywhere
//! Rays are transformed in f64 and rounded once: what a mesh's structure sees is a ray displaced by half a unit of
//! rounding of its coordinates, as if a vertex were. Boxes are enlarged by more than that. So, as with one
//! level, a hit is a function of the ray and one triangle, whatever the tree; of equal distances the lowest id wins.

mod bounds;
mod tree;

use super::{
    Backend, BuildOptions, Checked, Coherence, Hits, Intersector, LANES, MISS, Mask, Rays, lanes_of,
};
use crate::error::{Error, Result};
use crate::math::Aabb;
use crate::math::isa::{self, Isa, Kernel, Set};
use crate::shape::{Instance, Instances, Mesh};
use bounds::around;
use glam::DAffine3;
use std::sync::Arc;
use tree::{Lanes, Tree};

/// Everything that rays meet.
#[derive(Clone, Copy, Debug)]
pub struct Geometry<'a> {
    /// Meshes at rest, in scene coordinates.
    pub meshes: &'a [Arc<Mesh>],
    /// Meshes in several places or in motion. In [`Hits::mesh`] their ids follow those of the meshes at rest.
    pub instances: &'a Instances,
    /// When the shutter opens and closes, in seconds: times 0 and 1 of a ray.
    pub shutter: [f64; 2],
}

/// A place as rays need it.
enum Way {
    /// From the scene's coordinates into the mesh's.
    Rest(DAffine3),
    /// Depends on the ray's time.
    Moving,
}

/// The two levels.
pub struct TwoLevel {
    /// The meshes at rest; `None` where there is none.
    rest: Option<Box<dyn Intersector>>,
    /// The id of the first instance.
    first: u32,
    meshes: Vec<Box<dyn Intersector>>,
    /// By mesh.
    bounds: Vec<Aabb>,
    places: Vec<Instance>,
    ways: Vec<Way>,
    tree: Tree,
    shutter: [f64; 2],
    isa: Isa,
}

impl TwoLevel {
    /// Builds the structures with `backend`.
    ///
    /// # Errors
    /// As the backend's build; more instances than ids.
    pub fn build(backend: Backend, geometry: &Geometry<'_>, options: &BuildOptions<'_>) -> Result<TwoLevel> {
        let Instances { meshes, places } = geometry.instances;
        if geometry.meshes.len() + places.len() >= 1 << 31 {
            return Err(Error::new("more than 2³¹ meshes and instances"));
        }
        let weight = |meshes: &[Arc<Mesh>]| meshes.iter().map(|m| m.indices.len() as f64).sum::<f64>();
        let whole = (weight(geometry.meshes) + weight(meshes)).max(1.0);
        let mut done = 0.0;
        let mut build = |part: &[Arc<Mesh>]| {
            let (begun, share) = (done, weight(part) / whole);
            done += share;
            let progress = |s: f64| (options.progress)(begun + share * s);
            backend.build(part, &BuildOptions { progress: &progress, ..*options })
        };
        let rest = if geometry.meshes.is_empty() { None } else { Some(build(geometry.meshes)?) };
        let of_mesh: Result<Vec<_>> = meshes.iter().map(|mesh| build(std::slice::from_ref(mesh))).collect();
        let way = |place: &Instance| place.rest().map_or(Way::Moving, |there| Way::Rest(there.inverse()));
        let mut two = TwoLevel {
            rest,
            first: geometry.meshes.len() as u32,
            meshes: of_mesh?,
            bounds: meshes.iter().map(|mesh| mesh.bounds()).collect(),
            places: places.clone(),
            ways: places.iter().map(way).collect(),
            tree: Tree::default(),
            shutter: geometry.shutter,
            isa: options.isa.unwrap_or_else(Isa::best),
        };
        two.set_shutter(geometry.shutter);
        Ok(two)
    }

    /// The rays `lanes` in the coordinates of the mesh of instance `i`, ending at `far`.
    fn in_mesh(&self, i: usize, rays: Checked<'_>, lanes: Mask, far: &[f32; LANES]) -> Rays {
        let mut own = Rays::default();
        for lane in lanes_of(lanes) {
            let moved;
            let into = match &self.ways[i] {
                Way::Rest(into) => into,
                Way::Moving => {
                    let [open, close] = self.shutter;
                    let time = open + (close - open) * f64::from(rays.times()[lane]);
                    moved = self.places[i].transform(time).inverse();
                    &moved
                }
            };
            let (o, d) = (rays.rays().o(lane).as_dvec3(), rays.rays().d(lane).as_dvec3());
            let (o, d) = (into.transform_point3(o).as_vec3(), into.transform_vector3(d).as_vec3());
            own.set(lane, o, d, rays.rays().tmin[lane], far[lane]);
        }
        own
    }
}

impl Intersector for TwoLevel {
    fn closest(&self, rays: Checked<'_>, coherence: Coherence, hits: &mut Hits) {
        match &self.rest {
            Some(rest) => rest.closest(rays, coherence, hits),
            None => {
                for lane in lanes_of(rays.active()) {
                    (hits.t[lane], hits.u[lane], hits.v[lane]) = (f32::INFINITY, 0.0, 0.0);
                    (hits.mesh[lane], hits.triangle[lane]) = (MISS, MISS);
                }
            }
        }
        isa::run(self.isa, Closest { two: self, rays, coherence, hits });
    }

    fn occluded(&self, rays: Checked<'_>, coherence: Coherence) -> Mask {
        let blocked = self.rest.as_ref().map_or(0, |rest| rest.occluded(rays, coherence));
        isa::run(self.isa, Occluded { two: self, rays, blocked })
    }

    fn set_shutter(&mut self, shutter: [f64; 2]) {
        self.shutter = shutter;
        let boxed = |place: &Instance| around(place, &self.bounds[place.mesh as usize], shutter);
        self.tree = Tree::new(&self.places.iter().map(boxed).collect::<Vec<_>>());
    }

    fn bytes(&self) -> usize {
        let below: usize = self.rest.iter().chain(&self.meshes).map(|part| part.bytes()).sum();
        below + self.tree.bytes() + self.ways.len() * size_of::<Way>()
    }

    fn compact(&self) -> bool {
        self.rest.iter().chain(&self.meshes).any(|part| part.compact())
    }

    fn isa(&self) -> &str {
        self.rest.iter().chain(&self.meshes).map(|part| part.isa()).next().unwrap_or("generic")
    }
}

struct Closest<'a> {
    two: &'a TwoLevel,
    rays: Checked<'a>,
    coherence: Coherence,
    hits: &'a mut Hits,
}

impl Kernel for Closest<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Set>(self) {
        let Closest { two, rays, coherence, hits } = self;
        let mut lanes = Lanes::new(rays);
        for lane in lanes_of(rays.active()) {
            if hits.mesh[lane] != MISS {
                lanes.far[lane] = hits.t[lane];
            }
        }
        let mut found = Hits::default();
        two.tree.visit(&mut lanes, rays.active(), |lanes, i, inside| {
            let own = two.in_mesh(i, rays, inside, &lanes.far);
            let checked = own.check(inside);
            let mesh = two.places[i].mesh as usize;
            found.mesh = [MISS; LANES];
            two.meshes[mesh].closest(checked, coherence, &mut found);
            let id = two.first + i as u32;
            for lane in lanes_of(checked.active()) {
                let t = found.t[lane];
                let is_nearer = t < lanes.far[lane] || (t == lanes.far[lane] && id < hits.mesh[lane]);
                if found.mesh[lane] != MISS && is_nearer {
                    (hits.t[lane], hits.u[lane], hits.v[lane]) = (t, found.u[lane], found.v[lane]);
                    (hits.mesh[lane], hits.triangle[lane]) = (id, found.triangle[lane]);
                    lanes.far[lane] = t;
                }
            }
            0
        });
    }
}

struct Occluded<'a> {
    two: &'a TwoLevel,
    rays: Checked<'a>,
    blocked: Mask,
}

impl Kernel for Occluded<'_> {
    type Output = Mask;

    #[inline(always)]
    fn run<S: Set>(self) -> Mask {
        let Occluded { two, rays, mut blocked } = self;
        let mut lanes = Lanes::new(rays);
        two.tree.visit(&mut lanes, rays.active() & !blocked, |lanes, i, inside| {
            let own = two.in_mesh(i, rays, inside, &lanes.far);
            let mesh = two.places[i].mesh as usize;
            let found = two.meshes[mesh].occluded(own.check(inside), Coherence::Incoherent);
            blocked |= found;
            found
        });
        blocked
    }
}

#[cfg(test)]
mod tests;
