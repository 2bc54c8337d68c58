//! Who is measured: one file a kind, one line here.

mod bvh;
mod chunks;
mod obvhs;
mod singles;
#[cfg(feature = "embree")]
mod yardstick;

use crate::contest::Contestant;

/// Who all are compared with.
pub fn yardstick() -> Contestant {
    #[cfg(feature = "embree")]
    return yardstick::contestant();
    #[cfg(not(feature = "embree"))]
    return all().swap_remove(0);
}

/// Everybody, the yardstick first.
pub fn all() -> Vec<Contestant> {
    let mut all = Vec::new();
    #[cfg(feature = "embree")]
    all.push(yardstick::contestant());
    all.extend(chunks::contestants());
    all.extend(obvhs::contestants());
    all.extend(bvh::contestants());
    all
}
