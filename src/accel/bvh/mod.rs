//! Our own bounding volume hierarchy: eight children a node, watertight triangles, the same bits everywhere.
//!
//! The parts are apart so that each can be replaced by another form: `build` (with `split`, `bins`, `partition`)
//! makes the tree, `morton` the one of low quality and `spatial` the additional splits of high quality, `node` and `triangle` are the two kernels over eight and four lanes, written so that the
//! compiler vectorises them, `ray` prepares a ray for both, and `traverse` walks.
//!
//! A hit is a function of the ray and of one triangle alone; boxes only leave triangles out that cannot be
//! hit (proofs in `node` and `triangle`), and ties go to the lowest id. Hits at edges are settled once more among
//! the triangles around them (`accel/settle.rs`), by a rule that knows no tree either. So the answer does not
//! depend on the tree, the build's quality, the threads, the instruction set or the rays traced together: it is
//! bit for bit that of testing every triangle, and the tests hold it to that.

mod bins;
mod bounds;
mod build;
mod morton;
mod near;
mod node;
mod partition;
mod parts;
mod ray;
mod spatial;
mod split;
mod traverse;
mod triangle;

#[cfg(test)]
mod tests;

use super::settle::{Triangles, settle};
use super::{BuildOptions, Checked, Coherence, Hits, Intersector, LANES, MISS, Mask};
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::math::isa::{self, Isa, Kernel};
use crate::shape::Mesh;
use ray::Ray;
use std::sync::Arc;
use traverse::{Place, Stack, Tree};

/// A built hierarchy. It keeps its own copy of the triangles and none of the meshes.
pub struct Bvh {
    tree: build::Built,
    isa: Isa,
}

impl Bvh {
    /// Builds the hierarchy. Triangles of zero area are left out. Fails when memory runs out, when there are
    /// more than 2²⁸ triangles, or when the progress callback cancels.
    pub fn build(meshes: &[Arc<Mesh>], options: &BuildOptions<'_>) -> Result<Self> {
        let build = || build::build(meshes, options);
        let tree = if options.threads == 0 || options.threads >= rayon::current_num_threads() {
            build()?
        } else {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(options.threads).build();
            pool.map_err(|e| Error::new(format!("cannot start threads for the build: {e}")))?
                .install(build)?
        };
        Ok(Bvh { tree, isa: options.isa.unwrap_or_else(Isa::best) })
    }

    fn tree(&self) -> Option<Tree<'_>> {
        let (nodes, blocks) = (&self.tree.nodes[..], &self.tree.blocks[..]);
        (!nodes.is_empty()).then_some(Tree { nodes, blocks })
    }
}

impl Intersector for Bvh {
    fn closest(&self, rays: Checked<'_>, _: Coherence, hits: &mut Hits) {
        let tree = self.tree();
        let mut places = [Place::default(); LANES];
        isa::run(self.isa, Closest { tree, rays, hits, places: &mut places });
        if let Some(tree) = tree {
            settle(&Placed { tree, places }, rays.rays(), rays.active(), hits);
        }
    }

    fn occluded(&self, rays: Checked<'_>, _: Coherence) -> Mask {
        self.tree().map_or(0, |tree| isa::run(self.isa, Occluded { tree, rays }))
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.tree.nodes[..]) + size_of_val(&self.tree.blocks[..])
    }

    /// Always `generic`: every instruction set gives the same bits.
    fn isa(&self) -> &str {
        "generic"
    }
}

#[inline(always)]
fn ray(rays: &Checked<'_>, lane: usize) -> Option<Ray> {
    let r = rays.rays();
    let origin = [r.ox[lane], r.oy[lane], r.oz[lane]];
    let direction = [r.dx[lane], r.dy[lane], r.dz[lane]];
    Ray::new(origin, direction, r.tmin[lane], r.tmax[lane])
}

struct Closest<'a> {
    tree: Option<Tree<'a>>,
    rays: Checked<'a>,
    hits: &'a mut Hits,
    places: &'a mut [Place; LANES],
}

impl Kernel for Closest<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let mut stack = Stack::default();
        for lane in (0..LANES).filter(|&lane| self.rays.active() >> lane & 1 == 1) {
            let ray = ray(&self.rays, lane);
            let hit = match (&self.tree, &ray) {
                (Some(tree), Some(ray)) => tree.closest(ray, &mut stack).map(|hit| (hit, ray)),
                _ => None,
            };
            let (t, u, v, mesh, triangle) = match hit {
                Some(((hit, place), ray)) => {
                    self.places[lane] = place;
                    (ray.unscale(hit.t), hit.u, hit.v, (hit.id >> 32) as u32, hit.id as u32)
                }
                None => (f32::INFINITY, 0.0, 0.0, MISS, MISS),
            };
            self.hits.t[lane] = t;
            self.hits.u[lane] = u;
            self.hits.v[lane] = v;
            self.hits.mesh[lane] = mesh;
            self.hits.triangle[lane] = triangle;
        }
    }
}

/// The tree, and where the triangles are that a chunk hit.
struct Placed<'a> {
    tree: Tree<'a>,
    places: [Place; LANES],
}

impl Triangles for Placed<'_> {
    #[inline(always)]
    fn hit(&self, _: &Hits, lane: usize) -> [Vec3; 3] {
        let Place { block, lane } = self.places[lane];
        self.tree.blocks[block as usize].triangle_at(lane as usize)
    }

    fn around(&self, point: Vec3, radius: f32, each: &mut dyn FnMut([u32; 2], [Vec3; 3])) {
        self.tree.around(point, radius, &mut |index, lane| {
            let block = &self.tree.blocks[index];
            each(block.ids(lane), block.triangle_at(lane));
        });
    }
}

struct Occluded<'a> {
    tree: Tree<'a>,
    rays: Checked<'a>,
}

impl Kernel for Occluded<'_> {
    type Output = Mask;

    #[inline(always)]
    fn run(self) -> Mask {
        let mut stack = Stack::default();
        let mut found = 0;
        for lane in (0..LANES).filter(|&lane| self.rays.active() >> lane & 1 == 1) {
            if ray(&self.rays, lane).is_some_and(|ray| self.tree.occluded(&ray, &mut stack)) {
                found |= 1 << lane;
            }
        }
        found
    }
}
