//! Triangle meshes and the points on them.
//!
//! A [`Mesh`] is plain data shared by the loader, the acceleration structures (which read its buffers in
//! place) and shading. Vertices that share a position are stored once; normals and texture coordinates
//! have indices of their own only where they differ from the positions'. Each face has a material id.

mod mesh;
mod normals;
pub(crate) mod surface;
pub use mesh::{Attribute, FaceMaterials, Mesh, NO_INDEX, Positions};
pub use surface::{Surface, geometric_normal};
