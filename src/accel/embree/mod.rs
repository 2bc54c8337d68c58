//! Embree as a backend: the only user of its C interface.
//!
//! [`Embree::build`] makes a device, one scene and one geometry a mesh (a few triangles beside large meshes are kept out
//! of it, and met by our own test: `aside.rs`), commits, and only then returns: an
//! uncommitted scene cannot be expressed, and a committed one is never changed again. Errors of the library
//! become a [`Result`] after device, geometry and commit, never per ray.
//!
//! The scene is always *robust* (watertight); the default flags lose rays at shared edges. Hits at edges are
//! settled once more (`accel/settle.rs`), so that a ray from outside a closed body meets its outside.
//!
//! # The same tree everywhere
//! A picture must not depend on threads or on the processor's model, so the following is pinned:
//! - The instruction set is always named (`isa=`), also where the best one is wanted, and so is
//!   `frequency_level`: Embree chooses between 4- and 8-wide trees by it, from a table of processor models.
//! - Quality *medium* gives one tree over all triangles, whatever the threads: partitions differ in order
//!   only, and leaves are sorted. *High* is the same as *medium* in a robust scene; it is mapped to it.
//! - Quality *low* is a Morton tree a geometry under a top level whose order is a race between threads,
//!   and rays take 2–5 times as long through many of them. So all meshes go into one geometry there
//!   (`merged.rs`), which is as deterministic as *medium*.

mod aside;
pub mod bare;
mod chunk;
mod device;
mod doubt;
mod merged;
mod near;
pub mod range;
mod scene;
mod shared;
mod trace;
mod weights;

#[cfg(test)]
mod guard;
#[cfg(test)]
mod tests;

use super::settle::{Triangles, in_doubt, settle};
use super::{BuildOptions, Checked, Coherence, Hits, Intersector, Mask, Quality, Rays, cancelled};
use crate::error::{Error, Result};
use crate::math::Vec3;
use crate::math::isa::Isa;
use crate::memory::{self, Limit};
use crate::shape::Mesh;
use aside::Aside;
use device::Device;
use merged::Merged;
use scene::Scene;
use shared::Shared;
use std::borrow::Cow;
use std::sync::Arc;
use trace::Width;

/// Meshes in a committed Embree scene.
pub struct Embree {
    // Dropped in this order: the scene reads the buffers and reports its memory to the device's counter.
    scene: Scene,
    device: Device,
    geometry: Geometry,
    /// What the scene does not hold.
    aside: Option<Aside>,
    meshes: Vec<Arc<Mesh>>,
    /// The longest edge of each mesh.
    longest: Vec<f32>,
    compact: bool,
    /// At most [`FEW_TRIANGLES`].
    few: bool,
    width: Width,
    isa: &'static str,
    /// What the code around Embree's is compiled for.
    set: Isa,
}

/// The buffers that the scene reads for as long as it lives.
enum Geometry {
    /// A geometry a mesh; its id is the mesh's index.
    Shared(Shared),
    /// One geometry for all meshes.
    Merged(Merged),
}

impl Embree {
    /// Builds over `meshes`; a hit names a mesh by its index there.
    ///
    /// # Errors
    /// An instruction set that this machine lacks, buffers beyond Embree's limits, too little memory, or a
    /// build that the progress callback cancelled.
    pub fn build(meshes: &[Arc<Mesh>], options: &BuildOptions<'_>) -> Result<Self> {
        let isa = options.isa.unwrap_or_else(Isa::best);
        if isa > Isa::best() {
            return Err(Error::usage(format!("this machine has no {}", isa.name()))
                .advise(format!("its best is \"{}\"", Isa::best().name())));
        }
        Self::build_as(meshes, options, isa.name(), true, memory_left())
    }

    /// Without the robust flag: rays slip through edges and vertices. For comparisons alone.
    #[doc(hidden)]
    pub fn build_fast(meshes: &[Arc<Mesh>], options: &BuildOptions<'_>) -> Result<Self> {
        let isa = options.isa.unwrap_or_else(Isa::best).min(Isa::best());
        Self::build_as(meshes, options, isa.name(), false, memory_left())
    }

    /// Builds with the kernels that Embree calls `isa`, of which it has more than drt, in `memory` bytes.
    fn build_as(
        meshes: &[Arc<Mesh>],
        options: &BuildOptions<'_>,
        isa: &'static str,
        robust: bool,
        memory: Option<u64>,
    ) -> Result<Self> {
        if !(options.progress)(0.0) {
            return Err(cancelled());
        }
        for (index, mesh) in meshes.iter().enumerate() {
            check_limits(index, mesh.positions.len() as u64, mesh.indices.len() as u64)?;
        }
        let (large, aside) = match Aside::split(meshes, options)? {
            Some((large, aside)) => (Cow::Owned(large), Some(aside)),
            None => (Cow::Borrowed(meshes), None),
        };
        let geometry = match options.quality {
            Quality::Low if Merged::pays(&large) => Geometry::Merged(Merged::new(&large)?),
            _ => Geometry::Shared(Shared::new(&large)?),
        };
        let device = Device::new(isa, options.threads, memory)?;
        let mut uncommitted = scene::Uncommitted::new(&device, options.quality, robust, options.compact)?;
        match &geometry {
            Geometry::Shared(shared) => {
                for (id, buffers) in shared.buffers().enumerate() {
                    uncommitted.attach(id as u32, buffers)?;
                }
            }
            Geometry::Merged(merged) => uncommitted.attach(0, merged.buffers())?,
        }
        let scene = uncommitted.commit(options.progress)?;
        let longest = match &geometry {
            Geometry::Shared(shared) => shared.longest(),
            Geometry::Merged(merged) => merged.longest(),
        };
        let width = Width::native(&device);
        Ok(Embree {
            scene,
            device,
            geometry,
            aside,
            meshes: meshes.to_vec(),
            longest,
            compact: options.compact,
            few: meshes.iter().map(|mesh| mesh.indices.len()).sum::<usize>() <= FEW_TRIANGLES,
            width,
            isa,
            set: options.isa.unwrap_or_else(Isa::best),
        })
    }
}

impl Intersector for Embree {
    fn closest(&self, rays: Checked<'_>, coherence: Coherence, hits: &mut Hits) {
        let doubtful = self.trace(rays, coherence, hits);
        let rays = rays.rays();
        if doubtful != 0 {
            weights::weigh(|hits, lane| self.hit(hits, lane), rays, doubtful, hits);
            settle(self, rays, in_doubt(self, rays, doubtful, hits), hits);
        }
    }

    fn occluded(&self, rays: Checked<'_>, _: Coherence) -> Mask {
        self.any(rays)
    }

    fn gains_from_octants(&self) -> bool {
        self.few
    }

    fn bytes(&self) -> usize {
        let own = match &self.geometry {
            Geometry::Shared(shared) => shared.bytes(),
            Geometry::Merged(merged) => merged.bytes(),
        };
        self.device.bytes() + own + self.aside.as_ref().map_or(0, Aside::bytes)
    }

    fn compact(&self) -> bool {
        self.compact
    }

    fn isa(&self) -> &str {
        self.isa
    }
}

impl Triangles for Embree {
    #[inline(always)]
    fn hit(&self, hits: &Hits, lane: usize) -> [Vec3; 3] {
        self.meshes[hits.mesh[lane] as usize].triangle(hits.triangle[lane] as usize)
    }

    // First all names, then all corners, then what is done with them: the corners are mostly in no cache, and are so
    // waited for together instead of one after the other.
    fn around(&self, point: Vec3, radius: f32, each: &mut dyn FnMut([u32; 2], [Vec3; 3])) {
        let mut ids = Vec::with_capacity(64);
        near::around(&self.scene, point, radius, &mut |geometry, triangle| {
            ids.push(match &self.geometry {
                Geometry::Shared(_) => [geometry, triangle],
                Geometry::Merged(merged) => merged.name(triangle),
            });
        });
        let corners = |&[mesh, triangle]: &[u32; 2]| self.meshes[mesh as usize].triangle(triangle as usize);
        let corners: Vec<[Vec3; 3]> = ids.iter().map(corners).collect();
        for (ids, corners) in ids.into_iter().zip(corners) {
            each(ids, corners);
        }
        if let Some(aside) = &self.aside {
            aside.around(point, radius, each);
        }
    }

    fn ask(&self, rays: &Rays, active: Mask) -> Option<Hits> {
        let mut hits = Hits::default();
        let _ = self.trace(rays.check(active), Coherence::Incoherent, &mut hits);
        Some(hits)
    }
}

/// Bytes that Embree may take. Of the address space its threads take some that it does not count.
fn memory_left() -> Option<u64> {
    memory::left().map(|left| match left.limit {
        Limit::AddressSpace => left.bytes.saturating_sub(memory::HEADROOM as u64),
        _ => left.bytes,
    })
}

/// Up to so many triangles, packets of bounce rays into one octant gain from Embree's coherent flag, wherever they start:
/// in the Cornell box (32 triangles) 64 ns a ray instead of 101; over 0.9 million triangles 466 instead of 305.
const FEW_TRIANGLES: usize = 64;

/// Embree addresses vertices by 32-bit numbers of 4-byte words, so a buffer ends at 16 GiB; ids have 32
/// bits and all ones mean "none".
fn check_limits(mesh: usize, vertices: u64, triangles: u64) -> Result<()> {
    const LARGEST_BUFFER: u64 = 16 << 30;
    let bytes = (vertices + crate::shape::Positions::PADDING as u64).saturating_mul(12);
    if bytes > LARGEST_BUFFER {
        return Err(Error::new(format!(
            "mesh {mesh} has {vertices} vertices, {bytes} bytes; Embree's limit is {LARGEST_BUFFER} bytes"
        ))
        .advise("split the mesh, or use the backend \"bvh\""));
    }
    if triangles >= u64::from(u32::MAX) || mesh >= u32::MAX as usize {
        return Err(Error::new(format!(
            "mesh {mesh} has {triangles} triangles; Embree's limit is {} meshes and triangles a mesh",
            u32::MAX - 1
        ))
        .advise("split the mesh"));
    }
    Ok(())
}
