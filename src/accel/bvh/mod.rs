//! Our own bounding volume hierarchy.
use super::{BuildOptions, Checked, Coherence, Hits, Intersector, Mask};
use crate::error::Result;
use crate::shape::Mesh;
use std::sync::Arc;
/// Placeholder until the branch lands.
pub struct Bvh;
impl Bvh {
    /// Builds.
    pub fn build(_: &[Arc<Mesh>], _: &BuildOptions<'_>) -> Result<Self> { Ok(Bvh) }
}
impl Intersector for Bvh {
    fn closest(&self, _: Checked<'_>, _: Coherence, _: &mut Hits) {}
    fn occluded(&self, _: Checked<'_>, _: Coherence) -> Mask { 0 }
    fn bytes(&self) -> usize { 0 }
    fn isa(&self) -> &str { "generic" }
}
