//! Skins at rest: joints carry the vertices to where the document's nodes stand.

use super::Document;
use super::nodes::Nodes;
use crate::error::Result;
use crate::math::DMat4;

/// The matrices of a skin's joints.
pub(super) struct Skin {
    joints: Vec<DMat4>,
}

impl Skin {
    /// Skin `index` of the document.
    ///
    /// # Errors
    /// Joints or matrices that do not exist.
    pub fn of(document: &Document<'_>, nodes: &Nodes<'_>, index: usize) -> Result<Skin> {
        let item = document.root.at("skins", index)?;
        let inverse = item.index("inverseBindMatrices")?.map(|a| document.accessor(a)).transpose()?;
        let mut joints = Vec::new();
        for (i, joint) in item.list("joints").enumerate() {
            let place = nodes.matrices.get(joint.as_index()?).copied();
            let place = place.ok_or_else(|| joint.error("names a node that does not exist"))?;
            let inverse = inverse.as_ref().map_or(DMat4::IDENTITY, |a| DMat4::from_cols_array(&a.element(i)));
            joints.push(place * inverse);
        }
        Ok(Skin { joints })
    }

    /// The mean of four joints' matrices.
    pub fn blend(&self, joints: [f64; 4], shares: [f64; 4]) -> DMat4 {
        let sum: f64 = shares.iter().sum();
        let mut blend = DMat4::ZERO;
        for (joint, share) in joints.into_iter().zip(shares).filter(|(_, share)| *share != 0.0) {
            blend += self.joints.get(joint as usize).copied().unwrap_or(DMat4::IDENTITY) * (share / sum);
        }
        if blend == DMat4::ZERO { DMat4::IDENTITY } else { blend }
    }
}
