//! The film: what samples of a pixel become. Sums are f64; the filter is sampled, not splatted, so that a
//! sample touches one pixel; layers have names from the start.

mod block;
pub mod filter;
mod image;
pub mod rule;
mod store;

pub use block::{block, is_whole};
pub use filter::Filter;
pub use image::{Channel, Data, Image};
pub use rule::{PixelPoints, PixelRule};
pub use store::{Aov, Develop, Film, FilmUse, FirstHit, Saved, Tile};
