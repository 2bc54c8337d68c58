//! Meshes take their places: transforms are worked into the vertices in f64, relative to the scene's origin,
//! so that a scene far from the file's origin keeps its shape in f32.

use crate::error::{Error, Result};
use crate::math::{Aabb, DMat4, DVec3};
use crate::shape::{Bounds64, FaceMaterials, Mesh};
use glam::{DAffine3, DMat3};
use rayon::prelude::*;

/// Which shading normals a mesh gets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum NormalsMode {
    /// The file's; faceted where it has none.
    File,
    /// Faceted.
    Flat,
    /// Computed; edges sharper than `crease` degrees stay.
    Smooth { crease: f64 },
}

/// An invertible affine transform.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Transform {
    matrix: DMat4,
    /// The inverse transpose of the linear part: how normals go.
    normal: DMat3,
}

impl Transform {
    pub const IDENTITY: Transform = Transform { matrix: DMat4::IDENTITY, normal: DMat3::IDENTITY };

    /// `None` when the matrix flattens space or holds numbers beyond all bounds.
    pub fn new(matrix: DMat4) -> Option<Transform> {
        let linear = DMat3::from_mat4(matrix);
        let inverse = linear.inverse();
        // The size of rounding against the size of the matrix: below it the determinant is noise.
        let size = linear.to_cols_array().into_iter().fold(0.0f64, |m, x| m.max(x.abs()));
        let sound = matrix.is_finite() && inverse.is_finite() && size > 0.0;
        let relative = (linear * (1.0 / size)).determinant().abs();
        (sound && relative > 1e-30).then(|| Transform { matrix, normal: inverse.transpose() })
    }

    /// The matrix.
    pub fn matrix(&self) -> DMat4 {
        self.matrix
    }

    /// The transform as instances have it.
    pub fn affine(&self) -> DAffine3 {
        DAffine3::from_mat4(self.matrix)
    }

    /// This one, then `outer`; `None` where the two together leave the range of numbers.
    pub fn then(&self, outer: &Transform) -> Option<Transform> {
        if self.is_identity() { Some(*outer) } else { Transform::new(outer.matrix * self.matrix) }
    }

    /// As [`Extent::add`] and others want it.
    pub fn of_affine(affine: &DAffine3) -> Option<Transform> {
        Transform::new(DMat4::from(*affine))
    }

    /// The matrix's numbers, to tell transforms apart.
    pub fn bits(&self) -> [u64; 16] {
        self.matrix.to_cols_array().map(f64::to_bits)
    }

    pub fn is_identity(&self) -> bool {
        self.matrix == DMat4::IDENTITY
    }

    /// The box around what lies in `bounds`, whose coordinates are relative to `origin`, once it is moved.
    pub fn extent(&self, bounds: &Aabb, origin: DVec3) -> Bounds64 {
        let own = Bounds64::of(bounds);
        let absolute = Bounds64 { min: own.min + origin, max: own.max + origin };
        absolute.moved(&DAffine3::from_mat4(self.matrix))
    }

    /// Turns right-handed things into left-handed ones.
    fn mirrors(&self) -> bool {
        DMat3::from_mat4(self.matrix).determinant() < 0.0
    }
}

/// Where scene coordinates begin, with everything in the box `extent`: zero, unless all lies so far away that f32 would
/// lose the shape; then a multiple of a power of two near the middle, so that the subtraction is exact.
pub(crate) fn origin_for(extent: &Bounds64) -> DVec3 {
    const FAR: f64 = 0.5;
    let size = (extent.max - extent.min).max_element();
    let middle = (extent.min + extent.max) * 0.5;
    if !(size > 0.0 && middle.is_finite() && middle.abs().max_element() > FAR * size) {
        return DVec3::ZERO;
    }
    let unit = libm::ldexp(1.0, libm::frexp(size).1);
    (middle / unit).round() * unit
}

/// The mesh, relative to `from`, in its place relative to `to`; nothing is touched where nothing changes.
///
/// Counter-clockwise stays the outside: a transform that mirrors also turns the triangles around.
///
/// # Errors
/// Coordinates beyond what the intersectors can hold.
pub(crate) fn place(
    mut mesh: Mesh,
    from: DVec3,
    to: DVec3,
    transform: &Transform,
    normals: NormalsMode,
) -> Result<Mesh> {
    if !(transform.is_identity() && from == to) {
        move_positions(&mut mesh, from, to, transform)?;
    }
    match normals {
        NormalsMode::File if !transform.is_identity() => turn_normals(&mut mesh, transform),
        NormalsMode::File => {}
        NormalsMode::Flat | NormalsMode::Smooth { .. } => mesh.normals = None,
    }
    if transform.mirrors() {
        turn_around(&mut mesh);
    }
    if let NormalsMode::Smooth { crease } = normals {
        mesh.normals = Some(mesh.smooth_normals(crease));
    }
    Ok(mesh)
}

fn move_positions(mesh: &mut Mesh, from: DVec3, to: DVec3, transform: &Transform) -> Result<()> {
    let linear = DMat3::from_mat4(transform.matrix);
    let shift = transform.matrix.transform_point3(from) - to;
    let identity = transform.is_identity();
    mesh.positions.par_iter_mut().with_min_len(4096).for_each(|position| {
        let p = DVec3::from(position.map(f64::from));
        let moved = if identity { p + (from - to) } else { linear * p + shift };
        *position = moved.as_vec3().to_array();
    });
    let limit = crate::accel::LARGEST;
    let too_far = |p: &[f32; 3]| p.iter().any(|x| x.is_nan() || x.abs() > limit);
    if mesh.positions.par_iter().with_min_len(4096).any(too_far) {
        return Err(Error::new("the transform moves vertices beyond 1e18").advise("use smaller numbers"));
    }
    Ok(())
}

fn turn_normals(mesh: &mut Mesh, transform: &Transform) {
    let Some(normals) = &mut mesh.normals else { return };
    normals.values.par_iter_mut().with_min_len(4096).for_each(|value| {
        let n = transform.normal * DVec3::from(value.map(f64::from));
        *value = n.normalize_or_zero().as_vec3().to_array();
    });
}

/// Second and third corner change places, in every index.
fn turn_around(mesh: &mut Mesh) {
    let swap = |indices: &mut Vec<[u32; 3]>| indices.iter_mut().for_each(|t| t.swap(1, 2));
    swap(&mut mesh.indices);
    if let Some(indices) = mesh.normals.as_mut().and_then(|n| n.indices.as_mut()) {
        swap(indices);
    }
    if let Some(indices) = mesh.uvs.as_mut().and_then(|t| t.indices.as_mut()) {
        swap(indices);
    }
}

/// Material ids of the file become ids of the scene: `ids[file's id]`.
pub(crate) fn rename_materials(mesh: &mut Mesh, ids: &[u32]) {
    let unchanged = ids.iter().enumerate().all(|(i, id)| *id as usize == i);
    let rename = |id: &mut u32| *id = ids.get(*id as usize).copied().unwrap_or(0);
    match &mut mesh.materials {
        _ if unchanged => {}
        FaceMaterials::Uniform(id) => rename(id),
        FaceMaterials::PerFace(face_ids) => face_ids.iter_mut().for_each(rename),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::Vec3;
    use crate::shape::geometric_normal;

    fn tetrahedron() -> Mesh {
        let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mut mesh = Mesh::new(positions, vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]);
        mesh.normals = Some(mesh.smooth_normals(0.0));
        mesh
    }

    /// Normals of every face point away from the middle, and file normals stay normal to their faces.
    fn check_outside(mesh: &Mesh) {
        let middle =
            mesh.positions.iter().map(|p| Vec3::from(*p)).sum::<Vec3>() / mesh.positions.len() as f32;
        for t in 0..mesh.indices.len() {
            let [a, b, c] = mesh.triangle(t);
            let ng = geometric_normal(a, b, c);
            assert!(ng.dot(a - middle) > 0.0, "triangle {t}");
            let normals = mesh.normals.as_ref().unwrap().corners(t, mesh.indices[t]).unwrap();
            for n in normals {
                assert!((Vec3::from(n).normalize() - ng).length() < 1e-5, "triangle {t}: {n:?} not {ng}");
            }
        }
    }

    #[test]
    fn counter_clockwise_stays_outside_under_every_transform() {
        let mirror = DMat4::from_scale(DVec3::new(-2.0, 3.0, 0.5));
        let shear = DMat4::from_cols_array(&[
            1.0, 0.3, 0.0, 0.0, 0.7, 1.0, 0.0, 0.0, 0.0, -0.4, 1.0, 0.0, 5.0, 6.0, 7.0, 1.0,
        ]);
        for matrix in [DMat4::IDENTITY, mirror, shear, shear * mirror, DMat4::from_scale(DVec3::splat(-1.0))]
        {
            let transform = Transform::new(matrix).unwrap();
            let mesh = place(tetrahedron(), DVec3::ZERO, DVec3::ZERO, &transform, NormalsMode::File).unwrap();
            check_outside(&mesh);
            let crease = NormalsMode::Smooth { crease: 1.0 };
            check_outside(&place(tetrahedron(), DVec3::ZERO, DVec3::ZERO, &transform, crease).unwrap());
        }
    }

    #[test]
    fn far_meshes_keep_their_shape() {
        let far = DVec3::new(1e7, -2e7, 3e7);
        let transform = Transform::new(DMat4::from_scale(DVec3::splat(2.0))).unwrap();
        let origin = origin_for(&transform.extent(&tetrahedron().bounds(), far));
        assert!((origin - far * 2.0).length() < 4.0, "{origin}");
        let mesh = place(tetrahedron(), far, origin, &transform, NormalsMode::File).unwrap();
        for (p, q) in mesh.positions.iter().zip(tetrahedron().positions.iter()) {
            let exact = (DVec3::from(q.map(f64::from)) + far) * 2.0 - origin;
            assert_eq!(DVec3::from(p.map(f64::from)), exact);
        }
    }

    #[test]
    fn near_scenes_keep_the_files_coordinates_and_their_memory() {
        let mesh = tetrahedron();
        let extent = Transform::IDENTITY.extent(&mesh.bounds(), DVec3::new(0.25, 0.0, 0.0));
        assert_eq!(origin_for(&extent), DVec3::ZERO);
        assert_eq!(origin_for(&Bounds64::EMPTY), DVec3::ZERO);
        let before = mesh.positions.as_ptr();
        let placed = place(mesh, DVec3::ZERO, DVec3::ZERO, &Transform::IDENTITY, NormalsMode::File).unwrap();
        assert_eq!(placed.positions.as_ptr(), before);
    }

    #[test]
    fn flat_and_impossible_transforms_are_refused() {
        assert!(Transform::new(DMat4::from_scale(DVec3::new(1.0, 0.0, 1.0))).is_none());
        assert!(Transform::new(DMat4::from_scale(DVec3::splat(1e-300))).is_none());
        assert!(Transform::new(DMat4::from_scale(DVec3::splat(1e-9))).is_some());
        let huge = Transform::new(DMat4::from_scale(DVec3::splat(1e18))).unwrap();
        let mut mesh = tetrahedron();
        mesh.positions[1] = [5.0, 0.0, 0.0];
        assert!(place(mesh, DVec3::ZERO, DVec3::ZERO, &huge, NormalsMode::File).is_err());
    }

    #[test]
    fn face_materials_are_renamed_in_place() {
        let mut mesh = tetrahedron();
        mesh.materials = FaceMaterials::PerFace(vec![0, 1, 2, 1]);
        rename_materials(&mut mesh, &[5, 3, 4]);
        assert_eq!(mesh.materials, FaceMaterials::PerFace(vec![5, 3, 4, 3]));
    }
}
