//! Triangle meshes and the points on them.
//!
//! A [`Mesh`] is plain data shared by the loader, the acceleration structures (which read its buffers in
//! place) and shading. Vertices that share a position are stored once; normals and texture coordinates
//! have indices of their own only where they differ from the positions'. Each face has a material id. An [`Instance`] is
//! a mesh in another place, which may depend on the time ([`Motion`]).

mod bounds;
mod instance;
mod mesh;
mod motion;
mod normals;
pub(crate) mod surface;
mod surfaces;
pub use bounds::Bounds64;
pub use instance::{Instance, Instances, Stage};
pub use mesh::{Attribute, FaceMaterials, Mesh, NO_INDEX, Positions};
pub use motion::{Motion, Pose, rotation};
pub use surface::{Surface, geometric_normal};
pub use surfaces::{Corners, Surfaces};
