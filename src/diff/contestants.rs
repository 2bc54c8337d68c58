//! Who is asked: every backend with every instruction set of this machine and every build quality.

use crate::accel::{Backend, BuildOptions, Intersector, Quality};
use crate::error::Result;
use crate::math::isa::Isa;
use crate::shape::Mesh;
use std::sync::Arc;

/// Builds an intersector.
pub type Build = dyn Fn(&[Arc<Mesh>], &BuildOptions<'_>) -> Result<Box<dyn Intersector>> + Sync;

/// A way to intersect.
pub struct Contestant {
    /// The backend's name.
    pub backend: String,
    /// The instruction set.
    pub isa: Isa,
    /// The effort of the build.
    pub quality: Quality,
    /// Builds it.
    pub build: Box<Build>,
}

impl Contestant {
    /// A backend of this drt.
    pub fn of(backend: Backend, isa: Isa, quality: Quality) -> Contestant {
        let build = move |meshes: &[Arc<Mesh>], options: &BuildOptions<'_>| backend.build(meshes, options);
        Contestant { backend: backend.name().to_string(), isa, quality, build: Box::new(build) }
    }

    /// All of them. First comes the one that the others are compared with: our hierarchy, whose answer is that of
    /// testing every triangle, while Embree is known to lose rays through vertices.
    pub fn all() -> Vec<Contestant> {
        let mut all = Vec::new();
        for backend in Backend::ALL.iter().rev().copied() {
            for isa in Isa::ALL.into_iter().rev().filter(|isa| *isa <= Isa::best()) {
                all.extend(QUALITIES.map(|quality| Contestant::of(backend, isa, quality)));
            }
        }
        all
    }

    /// e.g. `bvh avx512 medium`.
    pub fn name(&self) -> String {
        format!("{} {} {}", self.backend, self.isa.name(), self.quality.name())
    }

    /// Builds it over `meshes` on at most `threads` threads; a `progress` of `false` cancels.
    ///
    /// # Errors
    /// The backend's own, or [`crate::accel::cancelled`].
    pub fn intersector(
        &self,
        meshes: &[Arc<Mesh>],
        threads: usize,
        progress: &(dyn Fn(f64) -> bool + Sync),
    ) -> Result<Box<dyn Intersector>> {
        let (quality, isa) = (self.quality, Some(self.isa));
        (self.build)(meshes, &BuildOptions { quality, isa, threads, progress, compact: false })
    }
}

/// The qualities in which structures differ, the usual one first. Embree knows no better than medium where it is
/// robust, and the hierarchy's high is its medium.
const QUALITIES: [Quality; 2] = [Quality::Medium, Quality::Low];
