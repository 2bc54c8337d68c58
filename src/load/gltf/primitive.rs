//! The triangles of a mesh's primitives, in their place.

use super::Document;
use super::accessor::Accessor;
use super::item::Item;
use super::skin::Skin;
use crate::error::Result;
use crate::load::obj::builder::{Builder, Corner};
use crate::math::{DMat4, DVec3};
use crate::shape::NO_INDEX;
use glam::{DAffine2, DMat3, DVec2};

/// How indices make triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Mode {
    Triangles,
    Strip,
    Fan,
}

/// The attributes of a primitive.
pub(super) struct Primitive {
    mode: Mode,
    positions: Accessor,
    normals: Option<Accessor>,
    uvs: Option<Accessor>,
    indices: Option<Accessor>,
    /// Joints and weights, four a vertex.
    skin: Option<[Accessor; 2]>,
    /// Displacements of positions and normals, and how much of each.
    morphs: Vec<(f64, Option<Accessor>, Option<Accessor>)>,
    /// What is done to texture coordinates.
    uv_transform: DAffine2,
}

impl Primitive {
    /// Reads a primitive; `None` where it has no triangles. `uv_set`: which texture coordinates its material wants, and
    /// what is done to them; `weights`: how much of each morph target.
    ///
    /// # Errors
    /// Accessors that do not exist or fit.
    pub fn of(
        item: &Item<'_>,
        document: &Document<'_>,
        uv_set: usize,
        uv_transform: DAffine2,
        weights: &[f64],
    ) -> Result<Option<Primitive>> {
        let mode = match item.size("mode", Some(4))? {
            4 => Mode::Triangles,
            5 => Mode::Strip,
            6 => Mode::Fan,
            _ => return Ok(None),
        };
        let attributes = item.need("attributes")?;
        let of = |item: &Item<'_>, name: &str| item.index(name)?.map(|a| document.accessor(a)).transpose();
        let Some(positions) = of(&attributes, "POSITION")? else { return Ok(None) };
        let (joints, shares) = (of(&attributes, "JOINTS_0")?, of(&attributes, "WEIGHTS_0")?);
        let mut morphs = Vec::new();
        for (target, weight) in item.list("targets").zip(weights).filter(|(_, weight)| **weight != 0.0) {
            morphs.push((*weight, of(&target, "POSITION")?, of(&target, "NORMAL")?));
        }
        Ok(Some(Primitive {
            mode,
            positions,
            normals: of(&attributes, "NORMAL")?,
            uvs: of(&attributes, &format!("TEXCOORD_{uv_set}"))?,
            indices: of(item, "indices")?,
            skin: joints.zip(shares).map(|(joints, shares)| [joints, shares]),
            morphs,
            uv_transform,
        }))
    }

    /// Vertices and, at most, triangles.
    pub fn size(&self) -> u64 {
        self.positions.count.max(self.indices.as_ref().map_or(0, |i| i.count)) as u64
    }

    /// Adds its triangles, moved by `matrix`, or by the joints of `skin`.
    ///
    /// # Errors
    /// As [`Builder::position`].
    pub fn add(&self, matrix: &DMat4, skin: Option<&Skin>, builder: &mut Builder<'_>) -> Result<()> {
        let [positions, uvs, normals] = builder.counts();
        self.add_vertices(matrix, skin, builder)?;
        if let Some(accessor) = &self.uvs {
            for i in 0..accessor.count {
                let [u, v] =
                    self.uv_transform.transform_point2(DVec2::from(accessor.element::<2>(i))).to_array();
                // Pictures hang from the top here, and stand on the bottom there.
                builder.uv([u as f32, (1.0 - v) as f32])?;
            }
        }
        let mirrors = DMat3::from_mat4(*matrix).determinant() < 0.0 && skin.is_none();
        let indices = self.indices.as_ref();
        let count = indices.map_or(self.positions.count, |indices| indices.count);
        let index = |i: usize| indices.map_or(i, |indices| indices.number(i, 0) as usize);
        let below = |i: usize, of: Option<&Accessor>, base: u64| match of {
            Some(accessor) if i < accessor.count => (base + i as u64) as u32,
            _ => NO_INDEX,
        };
        let corner = |i: usize| Corner {
            position: (positions + i as u64) as u32,
            uv: below(i, self.uvs.as_ref(), uvs),
            normal: below(i, self.normals.as_ref(), normals),
        };
        let triangles = match self.mode {
            Mode::Triangles => count / 3,
            Mode::Strip | Mode::Fan => count.saturating_sub(2),
        };
        for t in 0..triangles {
            let mut triangle = match self.mode {
                Mode::Triangles => [3 * t, 3 * t + 1, 3 * t + 2],
                Mode::Strip => [t, t + 1 + t % 2, t + 2 - t % 2],
                Mode::Fan => [t + 1, t + 2, 0],
            }
            .map(index);
            if mirrors {
                triangle.swap(1, 2);
            }
            let [a, b, c] = triangle;
            match triangle.iter().find(|i| **i >= self.positions.count) {
                Some(beyond) => builder.face_without(positions as i64 + *beyond as i64)?,
                // Strips are joined by triangles that have a vertex twice.
                None if self.mode == Mode::Strip && (a == b || b == c || c == a) => {}
                None => builder.face(&triangle.map(corner))?,
            }
        }
        Ok(())
    }

    fn add_vertices(&self, matrix: &DMat4, skin: Option<&Skin>, builder: &mut Builder<'_>) -> Result<()> {
        let is_still = *matrix == DMat4::IDENTITY && skin.is_none() && self.morphs.is_empty();
        let turn = |matrix: &DMat4| DMat3::from_mat4(*matrix).inverse().transpose();
        let all = turn(matrix);
        for i in 0..self.positions.count {
            let mut place = DVec3::from_array(self.positions.element(i));
            let mut normal = self.normals.as_ref().map(|normals| DVec3::from_array(normals.element(i)));
            if !is_still {
                for (weight, position, turned) in &self.morphs {
                    place += *weight * position.as_ref().map_or(DVec3::ZERO, |a| a.element(i).into());
                    let more = *weight * turned.as_ref().map_or(DVec3::ZERO, |a| a.element(i).into());
                    normal = normal.map(|n| n + more);
                }
                let joined = skin.zip(self.skin.as_ref());
                let joined =
                    joined.map(|(skin, [joints, shares])| skin.blend(joints.element(i), shares.element(i)));
                place = joined.as_ref().unwrap_or(matrix).transform_point3(place);
                // Lengths of normals do not matter, but f32 must hold them.
                normal = normal.map(|n| (joined.as_ref().map_or(all, turn) * n).normalize_or_zero());
            }
            builder.position(place.to_array().map(|x| (x, x as f32)))?;
            if let Some(normal) = normal.filter(|_| self.normals.as_ref().is_some_and(|n| i < n.count)) {
                builder.normal(normal.as_vec3().to_array())?;
            }
        }
        Ok(())
    }
}
