//! Shading normals computed from the triangles.

use super::{Attribute, Mesh};
use crate::math::DVec3;

/// A corner is compared with at most this many faces around its vertex, so that the hub of a large fan does
/// not cost its valence squared.
const MOST_NEIGHBOURS: usize = 256;

impl Mesh {
    /// Normals that are the mean of the faces around each vertex, weighted by the faces' angles there
    /// (Thürmer and Wüthrich 1998), so that a face cut into more triangles counts the same.
    ///
    /// Only faces that meet at no more than `crease` degrees are smoothed over; 180 smooths everywhere.
    #[must_use]
    pub fn smooth_normals(&self, crease: f64) -> Attribute<[f32; 3]> {
        if crease >= 180.0 {
            return Attribute { values: self.vertex_normals(), indices: None };
        }
        let faces: Vec<DVec3> = (0..self.indices.len()).map(|t| self.face_normal(t)).collect();
        let around = FacesAround::new(self);
        let least_cos = libm::cos(crease.to_radians()) - 1e-9;
        let mut values = Vec::with_capacity(3 * faces.len());
        for (t, corners) in self.indices.iter().enumerate() {
            let own = faces.get(t).copied().unwrap_or(DVec3::ZERO);
            for vertex in corners {
                let neighbours = around.get(*vertex);
                let step = neighbours.len().div_ceil(MOST_NEIGHBOURS).max(1);
                let weighted = neighbours.iter().step_by(step).map(|&(face, corner)| {
                    let n = faces.get(face as usize).copied().unwrap_or(DVec3::ZERO);
                    // A face without area has no normal: it neither gives nor asks for a crease.
                    let smooth = own == DVec3::ZERO || n.dot(own) >= least_cos;
                    if smooth { n * self.corner_angle(face as usize, corner.into()) } else { DVec3::ZERO }
                });
                let sum: DVec3 = weighted.sum();
                values.push(sum.normalize_or(own).as_vec3().to_array());
            }
        }
        let indices = (0..faces.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect();
        Attribute { values, indices: Some(indices) }
    }

    /// One normal a vertex, from all faces around it.
    fn vertex_normals(&self) -> Vec<[f32; 3]> {
        let mut sums = vec![DVec3::ZERO; self.positions.len()];
        for (t, corners) in self.indices.iter().enumerate() {
            let n = self.face_normal(t);
            for (corner, vertex) in corners.iter().enumerate() {
                if let Some(sum) = sums.get_mut(*vertex as usize) {
                    *sum += n * self.corner_angle(t, corner);
                }
            }
        }
        sums.into_iter().map(|sum| sum.normalize_or_zero().as_vec3().to_array()).collect()
    }

    /// Unit normal in f64; zero for a triangle without area.
    fn face_normal(&self, triangle: usize) -> DVec3 {
        let [a, b, c] = self.triangle(triangle).map(|p| p.as_dvec3());
        (b - a).cross(c - a).normalize_or_zero()
    }

    /// The triangle's inner angle at a corner, in radians.
    fn corner_angle(&self, triangle: usize, corner: usize) -> f64 {
        let [a, b, c] = self.triangle(triangle).map(|p| p.as_dvec3());
        let (p, q, r) = match corner {
            0 => (a, b, c),
            1 => (b, c, a),
            _ => (c, a, b),
        };
        let (u, v) = (q - p, r - p);
        libm::atan2(u.cross(v).length(), u.dot(v))
    }
}

/// For each vertex the faces around it and which of their corners it is, in the faces' order.
struct FacesAround {
    starts: Vec<u32>,
    faces: Vec<(u32, u8)>,
}

impl FacesAround {
    fn new(mesh: &Mesh) -> Self {
        let mut starts = vec![0u32; mesh.positions.len() + 2];
        for vertex in mesh.indices.iter().flatten() {
            starts[*vertex as usize + 2] += 1;
        }
        for i in 1..starts.len() {
            starts[i] += starts[i - 1];
        }
        // While filling, `starts[v + 1]` runs from the start to the end of v's part.
        let mut faces = vec![(0, 0); 3 * mesh.indices.len()];
        for (t, corners) in mesh.indices.iter().enumerate() {
            for (corner, vertex) in corners.iter().enumerate() {
                let at = &mut starts[*vertex as usize + 1];
                faces[*at as usize] = (t as u32, corner as u8);
                *at += 1;
            }
        }
        FacesAround { starts, faces }
    }

    fn get(&self, vertex: u32) -> &[(u32, u8)] {
        let v = vertex as usize;
        self.faces.get(self.starts[v] as usize..self.starts[v + 1] as usize).unwrap_or_default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A unit cube around the origin, its square sides cut along different diagonals.
    fn cube() -> Mesh {
        let positions = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2 & 1].map(|b| b as f32 - 0.5)).collect();
        let quads = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let cut = |(i, [a, b, c, d]): (usize, [u32; 4])| {
            if i % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
        };
        Mesh::new(positions, quads.into_iter().enumerate().flat_map(cut).collect())
    }

    #[test]
    fn angle_weights_do_not_see_how_squares_were_cut() {
        let mesh = cube();
        let normals = mesh.smooth_normals(180.0);
        for (n, p) in normals.values.iter().zip(mesh.positions.iter()) {
            let (n, p) = (DVec3::from(n.map(f64::from)), DVec3::from(p.map(f64::from)));
            assert!((n - p.normalize()).length() < 1e-6, "{n} at {p}");
        }
        assert!(normals.indices.is_none());
    }

    #[test]
    fn a_crease_keeps_the_cube_faceted_and_a_wider_one_does_not() {
        let mesh = cube();
        let sharp = mesh.smooth_normals(60.0);
        let wide = mesh.smooth_normals(90.0);
        for t in 0..mesh.indices.len() {
            let face = mesh.face_normal(t).as_vec3();
            for (sharp, wide) in sharp
                .corners(t, mesh.indices[t])
                .unwrap()
                .into_iter()
                .zip(wide.corners(t, mesh.indices[t]).unwrap())
            {
                assert!((crate::math::Vec3::from(sharp) - face).length() < 1e-6);
                assert!((crate::math::Vec3::from(wide).dot(face) - 1.0 / 3f32.sqrt()).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn triangles_without_area_get_finite_normals() {
        let mut mesh = cube();
        mesh.indices.push([0, 0, 1]);
        mesh.indices.push([2, 2, 2]);
        for crease in [0.0, 60.0, 180.0] {
            assert!(mesh.smooth_normals(crease).values.iter().flatten().all(|x| x.is_finite()));
        }
    }
}
