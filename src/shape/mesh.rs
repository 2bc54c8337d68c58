//! The triangle mesh.

use crate::math::{Aabb, Vec2, Vec3};

/// In an attribute's index: this corner has no normal (or texture coordinate).
pub const NO_INDEX: u32 = u32::MAX;

/// Vertex positions, followed in memory by 24 readable zero bytes.
///
/// Embree loads each float3 with a 16-byte read, so a shared buffer needs readable memory after its last
/// element. The padding is part of the allocation and hidden from every slice.
#[derive(Clone, Debug)]
pub struct Positions(Vec<[f32; 3]>);

impl Positions {
    /// Elements of padding behind the last position.
    pub const PADDING: usize = 2;

    /// Takes positions over and pads them. Reserve [`Positions::PADDING`] spare elements to avoid a copy.
    pub fn new(mut positions: Vec<[f32; 3]>) -> Self {
        positions.extend([[0.0; 3]; Self::PADDING]);
        Positions(positions)
    }
}

impl std::ops::Deref for Positions {
    type Target = [[f32; 3]];
    #[inline]
    fn deref(&self) -> &[[f32; 3]] {
        &self.0[..self.0.len() - Self::PADDING]
    }
}

impl std::ops::DerefMut for Positions {
    fn deref_mut(&mut self) -> &mut [[f32; 3]] {
        let end = self.0.len() - Self::PADDING;
        &mut self.0[..end]
    }
}

impl Default for Positions {
    fn default() -> Self {
        Positions::new(Vec::new())
    }
}

/// A value per triangle corner: normals or texture coordinates.
#[derive(Clone, Debug)]
pub struct Attribute<T> {
    /// The values.
    pub values: Vec<T>,
    /// Three indices into `values` a triangle ([`NO_INDEX`]: none); `None` when they equal the position indices.
    pub indices: Option<Vec<[u32; 3]>>,
}

impl<T: Copy> Attribute<T> {
    /// The three corner values of a triangle whose position indices are `corners`; `None` where one is missing.
    #[inline]
    pub fn corners(&self, triangle: usize, corners: [u32; 3]) -> Option<[T; 3]> {
        let [a, b, c] = match &self.indices {
            Some(own) => own[triangle],
            None => corners,
        };
        Some([*self.values.get(a as usize)?, *self.values.get(b as usize)?, *self.values.get(c as usize)?])
    }
}

/// Which material each triangle has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum FaceMaterials {
    /// One for all.
    Uniform(u32),
    /// One a triangle.
    PerFace(Vec<u32>),
}

impl FaceMaterials {
    /// The material id of a triangle.
    #[inline]
    pub fn get(&self, triangle: usize) -> u32 {
        match self {
            FaceMaterials::Uniform(id) => *id,
            FaceMaterials::PerFace(ids) => ids[triangle],
        }
    }
}

/// A triangle mesh. Invariants: every index in `indices` is below `positions.len()`, positions are finite
/// and below 1e18 in magnitude, and every index of an attribute is in range or [`NO_INDEX`].
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Positions,
    /// Three position indices a triangle, counter-clockwise seen from the side `ng` points to.
    pub indices: Vec<[u32; 3]>,
    /// Shading normals, not necessarily unit; `None`: faceted.
    pub normals: Option<Attribute<[f32; 3]>>,
    /// Texture coordinates.
    pub uvs: Option<Attribute<[f32; 2]>>,
    /// Material ids.
    pub materials: FaceMaterials,
}

impl Mesh {
    /// A mesh of positions and triangles alone, with material 0.
    pub fn new(positions: Vec<[f32; 3]>, indices: Vec<[u32; 3]>) -> Self {
        Mesh {
            positions: Positions::new(positions),
            indices,
            normals: None,
            uvs: None,
            materials: FaceMaterials::Uniform(0),
        }
    }

    /// The three corners of a triangle.
    #[inline(always)]
    pub fn triangle(&self, triangle: usize) -> [Vec3; 3] {
        let [a, b, c] = self.indices[triangle];
        let p = &self.positions;
        [Vec3::from(p[a as usize]), Vec3::from(p[b as usize]), Vec3::from(p[c as usize])]
    }

    /// The texture coordinates of a triangle's corners; `None` where it has none.
    #[inline]
    pub fn triangle_uvs(&self, triangle: usize) -> Option<[Vec2; 3]> {
        let corners = self.uvs.as_ref()?.corners(triangle, self.indices[triangle])?;
        Some(corners.map(Vec2::from))
    }

    /// The texture coordinates at a place with barycentric weights `u` (second corner) and `v` (third corner).
    #[inline]
    pub fn uv(&self, triangle: usize, u: f32, v: f32) -> Option<Vec2> {
        let [a, b, c] = self.triangle_uvs(triangle)?;
        Some(a * (1.0 - u - v) + b * u + c * v)
    }

    /// The texture coordinates at the point `p` of a triangle, by the areas that it cuts the triangle into.
    pub fn uv_at(&self, triangle: usize, p: Vec3) -> Option<Vec2> {
        let [a, b, c] = self.triangle(triangle);
        let n = (b - a).cross(c - a);
        let whole = n.length_squared();
        let u = (p - a).cross(c - a).dot(n) / whole;
        let v = (b - a).cross(p - a).dot(n) / whole;
        if u.is_finite() && v.is_finite() { self.uv(triangle, u, v) } else { None }
    }

    /// The smallest box around all triangles' corners (unreferenced vertices do not count).
    pub fn bounds(&self) -> Aabb {
        let corners = self.indices.iter().flatten();
        corners.fold(Aabb::EMPTY, |b, &i| b.grow(Vec3::from(self.positions[i as usize])))
    }

    /// Bytes the buffers hold.
    pub fn bytes(&self) -> usize {
        let attribute =
            |values: usize, own: &Option<Vec<[u32; 3]>>| values + own.as_ref().map_or(0, |i| i.len() * 12);
        let normals = self.normals.as_ref().map_or(0, |n| attribute(n.values.len() * 12, &n.indices));
        let uvs = self.uvs.as_ref().map_or(0, |t| attribute(t.values.len() * 8, &t.indices));
        let materials = match &self.materials {
            FaceMaterials::Uniform(_) => 0,
            FaceMaterials::PerFace(ids) => ids.len() * 4,
        };
        self.positions.len() * 12 + self.indices.len() * 12 + normals + uvs + materials
    }
}
