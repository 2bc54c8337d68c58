//! Attribute indices of triangles that cost no memory as long as they equal the position indices.

use super::memory::{OutOfMemory, grow};
use crate::shape::NO_INDEX;

/// The indices of one attribute (normals, texture coordinates) for a list of triangles.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub(super) enum Corners {
    /// No corner has one.
    #[default]
    Absent,
    /// Each corner's equals its position's index.
    Same,
    /// Listed.
    Own(Vec<[u32; 3]>),
}

impl Corners {
    /// What `Absent` and `Same` stand for.
    fn implied(&self, positions: [u32; 3]) -> [u32; 3] {
        if *self == Corners::Same { positions } else { [NO_INDEX; 3] }
    }

    /// The list, written out if it was only implied. `positions` are the triangles there are.
    pub fn listed(&mut self, positions: &[[u32; 3]]) -> Result<&mut Vec<[u32; 3]>, OutOfMemory> {
        if !matches!(self, Corners::Own(_)) {
            let mut list = Vec::new();
            grow(&mut list, positions.len())?;
            list.extend(positions.iter().map(|&p| self.implied(p)));
            *self = Corners::Own(list);
        }
        match self {
            Corners::Own(list) => Ok(list),
            Corners::Absent | Corners::Same => Err(OutOfMemory),
        }
    }

    /// Adds the last of `positions`' triangles. Indices are compared as they stand, since the list is
    /// written out before what they are `relative` to is added; only −1 must not be taken for [`NO_INDEX`].
    #[inline]
    pub fn push(&mut self, own: [u32; 3], positions: &[[u32; 3]], relative: bool) -> Result<(), OutOfMemory> {
        let Some((last, before)) = positions.split_last() else { return Ok(()) };
        match self {
            Corners::Same if own == *last => return Ok(()),
            Corners::Absent if own == [NO_INDEX; 3] && !relative => return Ok(()),
            Corners::Absent if before.is_empty() && own == *last => {
                *self = Corners::Same;
                return Ok(());
            }
            _ => {}
        }
        let list = self.listed(before)?;
        grow(list, 1)?;
        list.push(own);
        Ok(())
    }

    /// Adds those of another list of triangles, `more_positions`, which `positions` does not yet hold.
    pub fn append(
        &mut self,
        more: &Corners,
        positions: &[[u32; 3]],
        more_positions: &[[u32; 3]],
    ) -> Result<(), OutOfMemory> {
        if more_positions.is_empty() {
            return Ok(());
        }
        match (&*self, more) {
            (Corners::Same, Corners::Same) | (Corners::Absent, Corners::Absent) => return Ok(()),
            (Corners::Absent, Corners::Same) if positions.is_empty() => {
                *self = Corners::Same;
                return Ok(());
            }
            _ => {}
        }
        let list = self.listed(positions)?;
        grow(list, more_positions.len())?;
        match more {
            Corners::Own(more) => list.extend_from_slice(more),
            implied => list.extend(more_positions.iter().map(|&p| implied.implied(p))),
        }
        Ok(())
    }

    /// Goes back to an implied form where the list says no more than that.
    pub fn compress(&mut self, positions: &[[u32; 3]]) {
        if let Corners::Own(list) = self {
            if list.iter().all(|&own| own == [NO_INDEX; 3]) {
                *self = Corners::Absent;
            } else if list == positions {
                *self = Corners::Same;
            }
        }
    }

    /// Empties it, keeping the memory of a list.
    pub fn clear(&mut self) {
        *self = Corners::Absent;
    }
}
