//! What a rule estimates, and what it is compared with.

use crate::compare;
use crate::error::{Error, Result};

/// A number, or a picture's linear R, G, B row by row: to the errors both are lists.
#[derive(Clone, Debug, PartialEq)]
pub struct Value(pub Vec<f64>);

/// What errors are measured against.
#[derive(Clone, Debug, PartialEq)]
pub struct Reference {
    /// Where it comes from, for captions.
    pub description: String,
    /// The value taken for true.
    pub value: Value,
    /// The estimated RMSE of it; 0 for a closed form.
    pub rmse: f64,
    /// Relative to the value, less than this is rounding of the results.
    pub rounding: f64,
}

/// Mean squared differences.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Squares {
    /// Mean of (a − b)².
    pub mse: f64,
    /// Mean of (a − b)²/(b² + 0.01).
    pub rel_mse: f64,
}

impl Value {
    /// One number.
    pub fn number(value: f64) -> Value {
        Value(vec![value])
    }

    /// A picture's colours.
    pub fn picture(image: &crate::film::Image) -> Value {
        Value(image.rgb_pixels().iter().flatten().map(|&v| f64::from(v)).collect())
    }

    /// Whether it can be compared at all.
    pub fn is_finite(&self) -> bool {
        self.0.iter().all(|v| v.is_finite())
    }

    /// The mean of two of the same kind.
    pub fn mean_with(&self, other: &Value) -> Value {
        Value(self.0.iter().zip(&other.0).map(|(a, b)| 0.5 * (a + b)).collect())
    }

    /// How far this is from `truth`.
    ///
    /// # Errors
    /// Different sizes, or values that are not finite.
    pub(super) fn squares(&self, truth: &Value) -> Result<Squares> {
        if self.0.len() != truth.0.len() || self.0.is_empty() {
            return Err(Error::new("the reference has another size than the results"));
        }
        let mut sum = Squares::default();
        for (a, b) in self.0.iter().zip(&truth.0) {
            sum.mse += (a - b) * (a - b);
            sum.rel_mse += compare::relative_square(*a, *b);
        }
        if !sum.mse.is_finite() {
            return Err(Error::new("a result is not finite"));
        }
        let count = self.0.len() as f64;
        Ok(Squares { mse: sum.mse / count, rel_mse: sum.rel_mse / count })
    }
}

/// [`Reference::rounding`] of f64 numbers: sums of a million with room to spare.
pub const F64: f64 = 1e-13;

/// [`Reference::rounding`] of pictures, which are f32.
pub const F32: f64 = 2e-7;

/// A point counts for the fit when its error is so many times the reference's: at twice, what the reference adds to
/// it is a tenth.
const ABOVE_REFERENCE: f64 = 2.0;

impl Reference {
    /// An error that is nothing but rounding.
    pub(super) fn is_rounding(&self, rmse: f64) -> bool {
        let squares: f64 = self.value.0.iter().map(|v| v * v).sum();
        rmse <= self.rounding * (squares / self.value.0.len() as f64).sqrt()
    }

    /// An error that says more about the rule than about the reference.
    pub(super) fn is_below(&self, rmse: f64) -> bool {
        rmse > ABOVE_REFERENCE * self.rmse
    }
}
