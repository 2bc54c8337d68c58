//! Our own bounding volume hierarchy: eight children a node, watertight triangles, the same bits everywhere.
//!
//! The parts are apart so that each can be replaced by another form. `build` (with `split`, `bins`, `partition`) makes
//! the tree, by `collapse` from two children a node to eight, `morton` the one of low quality, and `spatial` the additional
//! splits of high quality; `tree` is what they make. `ray` prepares a chunk of rays. `node` and `triangle` are the two
//! kernels over eight and four lanes in their plain form, `avx` the same operations as intrinsics, `kernel` the choice
//! between them and the hints to the memory. `traverse` walks, the rays of a chunk in turns where the structure is
//! larger than a core's cache; `few` does without the tree where there are only some tens of triangles (`filter`); and
//! `meeting` says of one triangle a lane where it is met. `stored` makes a tree numbers, and numbers a tree.
//!
//! A hit is a function of the ray and of one triangle alone; boxes only leave triangles out that cannot be
//! hit (proofs in `node` and `triangle`), and ties go to the lowest id. Hits at edges are settled once more among
//! the triangles around them (`accel/settle.rs`), by a rule that knows no tree either. So the answer does not
//! depend on the tree, the build's quality, the threads, the instruction set or the rays traced together: it is
//! bit for bit that of testing every triangle, and the tests hold it to that.

#[cfg(target_arch = "x86_64")]
mod avx;
mod bins;
mod bounds;
mod build;
mod collapse;
mod few;
mod filter;
mod kernel;
mod meeting;
mod morton;
mod near;
mod node;
mod order;
mod partition;
mod parts;
mod ray;
mod spatial;
mod split;
pub mod stored;
mod traverse;
mod tree;
mod triangle;

#[cfg(test)]
mod tests;

use super::settle::{Triangles, settle};
use super::{BuildOptions, Checked, Coherence, Hits, Intersector, LANES, MISS, Mask};
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::math::isa::{self, Isa, Kernel, Set};
use crate::shape::Mesh;
use few::Few;
pub(super) use few::Slabs;
use meeting::Meetings;
use ray::Prepared;
use std::cell::Cell;
use std::sync::Arc;
use traverse::Stacks;
use tree::{Place, Tree};

/// A built hierarchy. It keeps its own copy of the triangles and none of the meshes.
pub struct Bvh {
    tree: build::Built,
    few: Option<Few>,
    in_turns: bool,
    isa: Isa,
}

/// Up to this many bytes a structure stays in the caches, and a ray loses little by waiting for it; larger ones are
/// traversed in turns ([`traverse`]). Measured with a third-level cache of 32 MiB: structures of 6 and 22 MB are traced
/// 5 to 10 % faster ray by ray, one of 36 MB 14 % (camera rays) to 66 % (second bounces) slower. What splits in space add
/// to a structure does not count: a ray visits less of it, not more. A hall of long thin triangles of 32 MB, 22 without
/// splits, is traced 25 % (camera), 5 % (first bounces), 7 % (occlusion) and 14 % (shadow) faster ray by ray, and
/// 4 % slower on second bounces.
const NEAR_BY: usize = 24 << 20;

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
        Ok(Bvh::over(tree, options.isa))
    }

    fn over(tree: build::Built, isa: Option<Isa>) -> Bvh {
        let few = Few::new(&tree.blocks);
        let in_turns = tree.bytes() as f64 > NEAR_BY as f64 * tree.leaves_of_one;
        Bvh { tree, few, in_turns, isa: isa.unwrap_or_else(Isa::best) }
    }

    /// As [`Intersector::closest`], but hits at edges are not settled, and there are other triangles in the box `others`.
    /// Returns which hits are in doubt, and which rays meet that box on their way to what they hit here.
    #[cfg(feature = "embree")]
    pub(super) fn closest_beside(&self, others: &Slabs, rays: Checked<'_>, hits: &mut Hits) -> [Mask; 2] {
        let few = self.few.as_ref();
        let closest = Closest { tree: self.tree(), few, others: Some(others), rays, hits };
        let (_, in_doubt, left) = isa::run(self.isa, closest);
        [in_doubt, left]
    }

    /// As [`Intersector::occluded`], and which of the other rays meet the box `others`.
    #[cfg(feature = "embree")]
    pub(super) fn occluded_beside(&self, others: &Slabs, rays: Checked<'_>) -> [Mask; 2] {
        isa::run(self.isa, Occluded { tree: self.tree(), few: self.few.as_ref(), others: Some(others), rays })
    }

    /// Whether it has no triangle.
    #[cfg(feature = "embree")]
    pub(super) fn is_empty(&self) -> bool {
        self.tree.blocks.is_empty()
    }

    /// Calls `each` with mesh, triangle and corners of all triangles whose boxes come within `radius` of `point`.
    #[cfg(feature = "embree")]
    pub(super) fn around(&self, point: Vec3, radius: f32, each: &mut dyn FnMut([u32; 2], [Vec3; 3])) {
        self.tree().around(point, radius, each);
    }

    fn tree(&self) -> Tree<'_> {
        Tree { nodes: &self.tree.nodes, blocks: &self.tree.blocks, in_turns: self.in_turns }
    }
}

impl Intersector for Bvh {
    fn closest(&self, rays: Checked<'_>, _: Coherence, hits: &mut Hits) {
        let tree = self.tree();
        let (places, in_doubt, _) =
            isa::run(self.isa, Closest { tree, few: self.few.as_ref(), others: None, rays, hits });
        settle(&Placed { tree, places }, rays.rays(), in_doubt, hits);
    }

    fn occluded(&self, rays: Checked<'_>, _: Coherence) -> Mask {
        let [hit, _] =
            isa::run(self.isa, Occluded { tree: self.tree(), few: self.few.as_ref(), others: None, rays });
        hit
    }

    fn bytes(&self) -> usize {
        self.tree.bytes()
    }

    /// Always `generic`: every instruction set gives the same bits.
    fn isa(&self) -> &str {
        "generic"
    }
}

thread_local! {
    static STACKS: Cell<Option<Box<Stacks>>> = const { Cell::new(None) };
}

/// This thread's stacks. Taken and put back: whatever is called in a closure (as `with_borrow_mut` would) may become a
/// function of its own, compiled without the instruction set, and then is several times as slow.
#[inline]
fn take_stacks() -> Box<Stacks> {
    STACKS.take().unwrap_or_else(Stacks::new)
}

struct Closest<'a> {
    tree: Tree<'a>,
    few: Option<&'a Few>,
    /// Around triangles that are not in the tree.
    others: Option<&'a Slabs>,
    rays: Checked<'a>,
    hits: &'a mut Hits,
}

impl Kernel for Closest<'_> {
    type Output = ([Place; LANES], Mask, Mask);

    /// Where the triangles are that were hit, which hits are in doubt, and which rays meet the others' box before.
    #[inline(always)]
    fn run<S: Set>(self) -> ([Place; LANES], Mask, Mask) {
        let Closest { tree, few, others, rays, hits } = self;
        let prepared = Prepared::new(rays.rays(), if tree.blocks.is_empty() { 0 } else { rays.active() });
        let (found, meetings) = match few {
            Some(few) if prepared.live != 0 => few.closest::<S>(&tree, rays.rays(), &prepared),
            _ => {
                let mut stacks = take_stacks();
                let found = tree.closest::<S>(&prepared, &mut stacks);
                STACKS.set(Some(stacks));
                let meetings = match found.hit {
                    0 => Meetings::NONE,
                    _ => Meetings::of::<S>(&tree, &found.place, &prepared),
                };
                (found, meetings)
            }
        };
        for i in 0..LANES {
            let hit = found.hit >> i & 1 == 1;
            let [mesh, triangle] = if hit { tree.ids(found.place[i]) } else { [MISS; 2] };
            if rays.active() >> i & 1 == 1 {
                hits.t[i] = if hit { (meetings.t[i] as f64 * prepared.up[i]) as f32 } else { f32::INFINITY };
                hits.u[i] = if hit { meetings.u[i] } else { 0.0 };
                hits.v[i] = if hit { meetings.v[i] } else { 0.0 };
                hits.mesh[i] = mesh;
                hits.triangle[i] = triangle;
            }
        }
        let in_doubt =
            if found.hit == 0 { 0 } else { meetings.in_doubt(rays.rays(), found.hit & rays.active()) };
        let left = match others {
            Some(others) => {
                let ends = std::array::from_fn(|i| match found.hit >> i & 1 {
                    1 => meetings.t[i],
                    _ => prepared.tmax[i],
                });
                others.met::<S>(&prepared, &ends)
            }
            None => 0,
        };
        (found.place, in_doubt, left)
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
        self.tree.triangle(self.places[lane])
    }

    fn around(&self, point: Vec3, radius: f32, each: &mut dyn FnMut([u32; 2], [Vec3; 3])) {
        self.tree.around(point, radius, each);
    }
}

struct Occluded<'a> {
    tree: Tree<'a>,
    few: Option<&'a Few>,
    others: Option<&'a Slabs>,
    rays: Checked<'a>,
}

impl Kernel for Occluded<'_> {
    type Output = [Mask; 2];

    /// What is hit, and which of the other rays meet the others' box.
    #[inline(always)]
    fn run<S: Set>(self) -> [Mask; 2] {
        let Occluded { tree, few, others, rays } = self;
        if tree.blocks.is_empty() {
            return [0; 2];
        }
        let prepared = Prepared::new(rays.rays(), rays.active());
        let hit = match few {
            Some(few) => few.occluded::<S>(&tree, rays.rays(), &prepared),
            None => {
                let mut stacks = take_stacks();
                let hit = tree.occluded::<S>(&prepared, &mut stacks);
                STACKS.set(Some(stacks));
                hit
            }
        };
        let left = others.map_or(0, |others| others.met::<S>(&prepared, &prepared.tmax));
        [hit, left & !hit]
    }
}
