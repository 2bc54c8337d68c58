//! How fast rules of integration converge: error against the number of samples, and the slope of it.

pub mod fit;
