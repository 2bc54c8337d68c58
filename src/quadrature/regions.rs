//! Regions of different sizes, side by side over [0, D].

use super::{Density, check_count};
use crate::error::{Error, Result};

/// The regions of (19): region i reaches from `edges[i]` to `edges[i + 1]`, and d_i is its length.
#[derive(Clone, Debug, PartialEq)]
pub struct Regions {
    edges: Vec<f64>,
}

impl Regions {
    /// Regions between neighbouring `edges`, which rise from 0 to D.
    ///
    /// # Errors
    /// No region, one without length, or a first edge other than 0.
    pub fn from_edges(edges: Vec<f64>) -> Result<Regions> {
        check_count("region", edges.len().saturating_sub(1))?;
        if edges.first() != Some(&0.0) {
            return Err(Error::new("the first region must begin at 0"));
        }
        // Said this way round, an edge that is not a number is refused too.
        let rises = |pair: &[f64]| pair[0] < pair[1] && pair[1].is_finite();
        match edges.windows(2).position(|pair| !rises(pair)) {
            Some(i) => Err(Error::new(format!("region {} of {} is empty", i + 1, edges.len() - 1))),
            None => Ok(Regions { edges }),
        }
    }

    /// Regions of the sizes d_i, from 0 on.
    ///
    /// # Errors
    /// No region, or one without length.
    pub fn from_sizes(sizes: &[f64]) -> Result<Regions> {
        let ends = sizes.iter().scan(0.0, |end, size| {
            *end += size;
            Some(*end)
        });
        Regions::from_edges(std::iter::once(0.0).chain(ends).collect())
    }

    /// `count` regions that share `density` equally: narrow where it is high (13.7, "more densely in regions where
    /// the function values are large").
    ///
    /// # Errors
    /// No region, or one so narrow that it has no length in f64.
    pub fn equal_shares(density: &(impl Density + ?Sized), count: usize) -> Result<Regions> {
        check_count("region", count)?;
        Regions::from_edges((0..=count).map(|i| density.inverse(i as f64 / count as f64)).collect())
    }

    /// How many there are.
    #[allow(clippy::len_without_is_empty)] // There is at least one.
    pub fn len(&self) -> usize {
        self.edges.len() - 1
    }

    /// Begin and size of each region.
    pub fn iter(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        self.edges.windows(2).map(|pair| (pair[0], pair[1] - pair[0]))
    }
}
