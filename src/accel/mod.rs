//! Rays meet triangles: one trait, three backends.
//!
//! `accel` knows triangles and ids, no materials, lights or textures. A backend is built by value from
//! meshes and asked through `&self` by any number of threads. Questions come in chunks of [`LANES`] rays
//! in structure-of-arrays form with a mask of active lanes; a backend is free to trace them as packets or
//! one by one. No ray reaches a backend unchecked: a question takes [`Checked`] rays, and
//! [`Rays::check`] is the only way to make them (a NaN would abort the process inside Debian's Embree,
//! whose assertions are compiled in).
//!
//! The interval of a ray is `tmin ≤ t ≤ tmax`; a zero direction or `tmin > tmax` is a clean miss.
//! Both sides of a triangle are hit. Barycentrics are Embree's: `p = (1−u−v)·v0 + u·v1 + v·v2`.
//! Triangles of zero area are never hit.
//!
//! Meshes that stand in several places or move are one level above all backends (`instances`).
//!
//! # Used on its own
//! The module needs nothing but meshes: [`Backend::build`], then [`Intersector::closest`] and
//! [`Intersector::occluded`] for chunks of rays, or [`Intersector::closest_one`] for one (`examples/trace.rs` is
//! a whole program).
//!
//! ```
//! use drt::accel::{Backend, BuildOptions, Intersector};
//! use drt::math::Vec3;
//! use drt::shape::Mesh;
//! use std::sync::Arc;
//!
//! # fn main() -> drt::error::Result<()> {
//! let floor = Mesh::new(vec![[0.0, 0.0, 0.0], [0.0, 0.0, 4.0], [4.0, 0.0, 0.0]], vec![[0, 1, 2]]);
//! for backend in Backend::ALL {
//!     let accel = backend.build(&[Arc::new(floor.clone())], &BuildOptions::default())?;
//!     let hit = accel.closest_one(Vec3::new(1.0, 3.0, 2.0), Vec3::NEG_Y, 0.0, f32::INFINITY);
//!     assert!(hit.is_some_and(|hit| hit.t == 3.0 && (hit.u, hit.v) == (0.5, 0.25)));
//! }
//! # Ok(())
//! # }
//! ```

pub mod brute;
pub mod bvh;
#[cfg(feature = "embree")]
pub mod embree;
mod instances;
pub mod judge;
pub mod need;
mod rays;
pub(crate) mod settle;

use crate::error::{Error, Result, unknown_word_advice};
use crate::math::Vec3;
use crate::math::isa::Isa;
use crate::shape::Mesh;
pub use instances::Geometry;
pub(crate) use rays::lanes_of;
pub use rays::{Checked, Hit, Hits, LANES, LARGEST, MISS, Mask, Rays};
use std::sync::Arc;

/// What is known about the rays of a chunk. Changes the speed, and at most the last bits of a hit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Coherence {
    /// Nearly the same origin and direction: camera rays.
    Coherent,
    /// Anything else.
    Incoherent,
}

/// A built acceleration structure.
pub trait Intersector: Send + Sync {
    /// The closest hit of every active lane; a miss sets [`MISS`].
    fn closest(&self, rays: Checked<'_>, coherence: Coherence, hits: &mut Hits);

    /// The active lanes on whose interval anything is hit.
    fn occluded(&self, rays: Checked<'_>, coherence: Coherence) -> Mask;

    /// The closest hit of one ray on `tmin ≤ t ≤ tmax`; `None` also where [`Rays::check`] refuses it. For a ray now
    /// and then: chunks are several times as fast.
    fn closest_one(&self, o: Vec3, d: Vec3, tmin: f32, tmax: f32) -> Option<Hit> {
        let (mut rays, mut hits) = (Rays::default(), Hits::default());
        rays.set(0, o, d, tmin, tmax);
        self.closest(rays.check(1), Coherence::Incoherent, &mut hits);
        hits.get(0)
    }

    /// From now on the shutter opens and closes at other times (seconds). Only what moves depends on it.
    fn set_shutter(&mut self, _shutter: [f64; 2]) {}

    /// Whether chunks of rays into one octant are traced faster as [`Coherence::Coherent`], wherever they start: worth
    /// their sorting. True where the scene is so small that every ray meets most of the structure.
    fn gains_from_octants(&self) -> bool {
        false
    }

    /// Bytes of the structure itself, without the meshes' buffers.
    fn bytes(&self) -> usize;

    /// Whether the backend has a compact layout and took it; goes into the picture's settings as well.
    fn compact(&self) -> bool {
        false
    }

    /// The instruction set the backend traces with, e.g. `avx512`; goes into the picture's settings,
    /// since it can change the last bits of a hit.
    fn isa(&self) -> &str;
}

/// How much work goes into the structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quality {
    /// Fast to build, slower to trace: short jobs.
    Low,
    /// The ordinary one.
    Medium,
    /// Slow to build; as `Medium` where a backend knows no better.
    High,
}

impl Quality {
    /// The name in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Quality::Low => "low",
            Quality::Medium => "medium",
            Quality::High => "high",
        }
    }
}

/// What a build is asked for.
pub struct BuildOptions<'a> {
    /// Effort.
    pub quality: Quality,
    /// Smaller structure, slower rays (Embree's compact flag); the BVH has one layout and ignores it.
    pub compact: bool,
    /// Pins the instruction set; `None`: the best this machine has.
    pub isa: Option<Isa>,
    /// At most this many threads build; 0: as many as the machine runs. Never changes the structure.
    pub threads: usize,
    /// Called now and then, possibly from several threads, with the share done (0 to 1); `false` cancels
    /// the build, which then fails with [`cancelled`].
    pub progress: &'a (dyn Fn(f64) -> bool + Sync),
}

impl Default for BuildOptions<'_> {
    fn default() -> Self {
        BuildOptions { quality: Quality::Medium, compact: false, isa: None, threads: 0, progress: &|_| true }
    }
}

/// The error of a build that its progress callback cancelled.
pub fn cancelled() -> Error {
    Error::new("building the acceleration structure was cancelled")
}

/// The backends that a picture can be rendered with. (The judge, [`brute`], is for tests.)
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Backend {
    /// Debian's Embree.
    #[cfg(feature = "embree")]
    Embree,
    /// Our own bounding volume hierarchy.
    Bvh,
}

impl Backend {
    /// Every backend that this build of drt has, the default first.
    pub const ALL: &'static [Backend] = &[
        #[cfg(feature = "embree")]
        Backend::Embree,
        Backend::Bvh,
    ];

    /// The name on the command line and in scene files.
    pub fn name(self) -> &'static str {
        match self {
            #[cfg(feature = "embree")]
            Backend::Embree => "embree",
            Backend::Bvh => "bvh",
        }
    }

    /// The backend of that name.
    pub fn from_name(name: &str) -> Result<Backend> {
        if let Some(found) = Self::ALL.iter().find(|b| b.name() == name) {
            return Ok(*found);
        }
        if name == "embree" {
            return Err(Error::usage("this drt was built without Embree")
                .advise("use the backend \"bvh\", or build with the feature `embree`"));
        }
        let known: Vec<&str> = Self::ALL.iter().map(|b| b.name()).collect();
        Err(Error::usage(format!("unknown backend \"{name}\"")).advise(unknown_word_advice(name, &known)))
    }

    /// Refuses meshes with coordinates that the backend would silently compute wrongly with. The BVH takes all that there
    /// are; Embree those of up to 1e12, and larger ones where the triangles are small.
    ///
    /// # Errors
    /// Names the sizes, and the backend that can.
    pub fn check_range(
        self,
        #[cfg_attr(not(feature = "embree"), allow(unused))] meshes: &[Arc<Mesh>],
    ) -> Result<()> {
        match self {
            #[cfg(feature = "embree")]
            Backend::Embree => embree::range::check(meshes),
            Backend::Bvh => Ok(()),
        }
    }

    /// Builds the structure over `meshes`; a hit names a mesh by its index here.
    pub fn build(self, meshes: &[Arc<Mesh>], options: &BuildOptions<'_>) -> Result<Box<dyn Intersector>> {
        match self {
            #[cfg(feature = "embree")]
            Backend::Embree => Ok(Box::new(embree::Embree::build(meshes, options)?)),
            Backend::Bvh => Ok(Box::new(bvh::Bvh::build(meshes, options)?)),
        }
    }

    /// Builds the structure over meshes at rest and instances; without any of the latter, as [`Backend::build`].
    ///
    /// # Errors
    /// As [`Backend::build`].
    pub fn build_all(
        self,
        geometry: &Geometry<'_>,
        options: &BuildOptions<'_>,
    ) -> Result<Box<dyn Intersector>> {
        if geometry.instances.places.is_empty() {
            return self.build(geometry.meshes, options);
        }
        Ok(Box::new(instances::TwoLevel::build(self, geometry, options)?))
    }
}
