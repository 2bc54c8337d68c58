//! What a structure takes in memory while it is built, in bytes a triangle; measured on meshes of 0.3 to 5 million
//! triangles.

use super::{Backend, Quality};
use crate::memory;

/// What the usual layouts take at the peak of a build: Embree's 112 (low) to 119 (medium), our BVH's at most 100.
const USUAL: u64 = 120;
/// Embree's compact layout, which the BVH has not: what Embree asks for. About half of it is ever touched.
#[cfg(feature = "embree")]
const COMPACT: u64 = 90;
/// What a copy of a mesh takes, a triangle and a vertex: Embree's low quality joins several meshes to one. (Not where all
/// but one are a few triangles that are set aside, which is not known before they are read.)
#[cfg(feature = "embree")]
const JOINED: u64 = 12;

/// What is built over.
#[derive(Clone, Copy, Debug, Default)]
pub struct Extent {
    /// Triangles of all meshes.
    pub triangles: u64,
    /// Their vertices.
    pub vertices: u64,
    /// Meshes.
    pub meshes: u64,
}

impl Backend {
    /// Bytes that a build takes at its peak, on top of the meshes.
    #[cfg_attr(not(feature = "embree"), allow(unused_variables))]
    pub fn need(self, over: Extent, quality: Quality, compact: bool) -> u64 {
        let usual = over.triangles.saturating_mul(USUAL);
        match self {
            Backend::Bvh => usual,
            #[cfg(feature = "embree")]
            Backend::Embree => {
                let is_low = quality == Quality::Low;
                let each = if compact { COMPACT } else { USUAL };
                let copies = if is_low && over.meshes > 1 { over.triangles + over.vertices } else { 0 };
                over.triangles.saturating_mul(each).saturating_add(copies.saturating_mul(JOINED))
            }
        }
    }

    /// The samples that a picture must have for two triangles before a structure of medium quality is worth its longer build.
    ///
    /// CPU seconds from the file on, low and medium, Embree: over five million triangles 4.7 and 6.3 with 0.8 samples a
    /// triangle, 14.5 and 15.0 with 3.4; over 870,000 2.2 and 2.2 with 4.8, 7.8 and 7.4 with 19. The BVH's low one is as fast to
    /// build and loses half its speed; 1.5 samples a triangle are extrapolated from one scene.
    pub fn low_below(self) -> u64 {
        match self {
            Backend::Bvh => 3,
            #[cfg(feature = "embree")]
            Backend::Embree => 8,
        }
    }

    /// Whether the usual layout over so many triangles would not fit into the memory that is left, and there is a smaller
    /// one.
    pub fn is_memory_short(self, triangles: u64) -> bool {
        self.is_short(triangles, memory::left().map(|left| left.bytes))
    }

    /// Whether the backend has a layout that is smaller than the usual one.
    pub fn has_compact(self) -> bool {
        self != Backend::Bvh
    }

    /// As [`Backend::is_memory_short`], in `available` bytes. Some is kept free for what is left out here (small scenes, the film, other programs).
    pub(super) fn is_short(self, triangles: u64, available: Option<u64>) -> bool {
        let needed = triangles.saturating_mul(USUAL + USUAL / 10);
        self.has_compact() && available.is_some_and(|available| needed > available)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_compact_layout_is_taken_when_the_usual_one_does_not_fit() {
        for backend in Backend::ALL.iter().copied() {
            let is_short = |triangles, available| backend.is_short(triangles, available);
            assert_eq!(is_short(1_000_000, Some(131_999_999)), backend.has_compact());
            assert_eq!(is_short(u64::MAX, Some(u64::MAX - 1)), backend.has_compact());
            assert!(!is_short(1_000_000, Some(132_000_000)));
            assert!(!is_short(u64::MAX, None) && !is_short(0, Some(0)));
        }
    }

    #[test]
    fn needs_of_anything_are_numbers() {
        let all = Extent { triangles: u64::MAX / 2, vertices: u64::MAX / 2, meshes: 2 };
        for backend in Backend::ALL.iter().copied() {
            for quality in [Quality::Low, Quality::Medium, Quality::High] {
                let over = Extent { triangles: 1_000_000, vertices: 500_000, meshes: 1 };
                let (usual, compact) =
                    (backend.need(over, quality, false), backend.need(over, quality, true));
                assert_eq!(compact < usual, backend.has_compact());
                assert_eq!(backend.need(all, quality, false), u64::MAX);
                assert_eq!(backend.need(Extent::default(), quality, true), 0);
            }
        }
    }
}
