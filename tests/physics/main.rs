//! The physics as specification: scenes with exact answers, rendered from scene files on every backend.
//!
//! Statistics: each check renders 64 fixed seeds and looks at the mean of the 64 image means. It passes only
//! when the mean is within 6.37 standard errors (Student's t at a family-wise error of 1e-6 over 40 checks) of
//! the exact answer, **and** the standard error is small enough that a bias of one percent would have been
//! caught (δ/9.46): too noisy is a failure, never a pass. Each check must also refuse the same answer off by
//! one percent, so none can pass by being blunt (see `harness::Statistics::verdict`).

mod brushed;
mod closed;
mod convergence;
mod cutouts;
mod direct;
mod every_scene;
mod harness;
mod indoors;
mod instances;
mod invariance;
mod lamps;
mod lenses;
mod many;
mod materials;
mod motion;
mod relief;
mod skies;
mod surfaces;
mod textures;
