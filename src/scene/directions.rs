//! How many directions the distribution integrator follows, by depth.

use crate::error::{Error, Result};
use crate::quadrature::hemisphere::{Cells, Fan, HemisphereRule};

/// Cells of the hemisphere by depth: those of the first hit first, the last ones for all deeper hits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Directions {
    cells: [Cells; Self::MOST],
    depths: usize,
}

impl Directions {
    /// Entries at most.
    pub const MOST: usize = 16;

    /// Rays of one camera ray at most: beyond this a picture would take years.
    const MOST_RAYS: f64 = 1e9;

    /// Sixteen directions at the first hit, one at every other.
    pub const USUAL: Directions = {
        let mut cells = [Cells { theta: 1, phi: 1 }; Self::MOST];
        cells[0] = Cells { theta: 4, phi: 4 };
        Directions { cells, depths: 2 }
    };

    /// `cells` by depth.
    ///
    /// # Errors
    /// None, or more than [`Directions::MOST`].
    pub fn new(cells: &[Cells]) -> Result<Directions> {
        if cells.is_empty() || cells.len() > Self::MOST {
            let (count, most) = (cells.len(), Self::MOST);
            return Err(Error::new(format!("directions has {count} entries; 1 to {most} are possible"))
                .advise("the last entry counts for all deeper hits"));
        }
        let mut all = [Cells { theta: 1, phi: 1 }; Self::MOST];
        for (to, from) in all.iter_mut().zip(cells) {
            *to = *from;
        }
        Ok(Directions { cells: all, depths: cells.len() })
    }

    /// The entries.
    pub fn cells(&self) -> &[Cells] {
        self.cells.get(..self.depths).unwrap_or_default()
    }

    /// The cells at the hit that is reached after `depth` scattering events.
    pub fn at(&self, depth: usize) -> Cells {
        self.cells[depth.min(self.depths - 1)]
    }

    /// Rays that follow one camera ray in a closed scene without mirrors and glass: Σ over depths of the product
    /// of all directions up to there.
    pub fn rays(&self, rule: HemisphereRule, max_depth: u32) -> f64 {
        let (mut rays, mut nodes) = (0.0, 1.0);
        for depth in 0..max_depth as usize {
            let count = f64::from(rule.count(self.at(depth)));
            if depth >= self.depths && count == 1.0 {
                return rays + nodes * f64::from(max_depth - depth as u32);
            }
            nodes *= count;
            rays += nodes;
            if rays > Self::MOST_RAYS {
                break;
            }
        }
        rays
    }

    /// Refuses what cannot be rendered.
    ///
    /// # Errors
    /// A vertex without or with too many directions; a tree of rays that never ends.
    pub fn check(&self, rule: HemisphereRule, max_depth: u32) -> Result<()> {
        for cells in self.cells() {
            Fan::new(rule, *cells)?;
        }
        let rays = self.rays(rule, max_depth);
        if rays > Self::MOST_RAYS {
            return Err(Error::new(format!(
                "these directions to depth {max_depth} mean more than {:e} rays for every camera ray",
                Self::MOST_RAYS
            ))
            .advise("let directions end with 1, or set max_depth to 1, 2 or 3"));
        }
        Ok(())
    }
}
