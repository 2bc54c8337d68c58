//! `[[mesh]]`: files, where they stand, and what they are made of.

use super::reader::{COORDINATE, Field, Section};
use crate::error::{Error, Result, unknown_word_advice};
use crate::load::place::{NormalsMode, Transform};
use crate::math::{DMat4, DVec3};
use std::path::{Path, PathBuf};

/// A mesh as the scene file names it.
#[derive(Clone)]
pub(crate) struct MeshPlan<'t> {
    /// The file, relative to the scene file's folder resolved.
    pub file: PathBuf,
    /// The value that names the file, for errors.
    pub field: Field<'t>,
    /// From the file's coordinates to the scene file's.
    pub transform: Transform,
    /// The material's name, instead of the file's own materials.
    pub material: Option<Field<'t>>,
    /// Which shading normals.
    pub normals: NormalsMode,
}

/// Reads every mesh; relative paths are relative to `folder`.
pub(super) fn read_all<'t>(field: &Field<'t>, folder: &Path) -> Result<Vec<MeshPlan<'t>>> {
    let items = field.list("a list of tables, [[mesh]]")?;
    items.into_iter().map(|item| read(item.section()?, &item, folder)).collect()
}

fn read<'t>(mut mesh: Section<'t>, field: &Field<'t>, folder: &Path) -> Result<MeshPlan<'t>> {
    mesh.not_yet(&["motion"])?;
    let file = mesh.get("file").ok_or_else(|| {
        let error = mesh.missing(field, "file");
        if error.advice.is_some() { error } else { error.advise("e.g. file = \"bunny.obj\"") }
    })?;
    check_name(&file)?;
    let material = mesh.get("material");
    if let Some(material) = &material {
        material.text()?;
    }
    let transform = mesh.read("transform", transform)?;
    let normals = mesh.read("normals", normals_word)?;
    let crease = mesh.get("crease");
    let normals = match (normals.unwrap_or(NormalsMode::File), crease) {
        (NormalsMode::Smooth { .. }, Some(crease)) => {
            NormalsMode::Smooth { crease: crease.number(0.0..=180.0)? }
        }
        (_, Some(crease)) => {
            return Err(crease.error(format!("{} goes with normals = \"smooth\"", crease.name())));
        }
        (normals, None) => normals,
    };
    mesh.finish()?;
    Ok(MeshPlan {
        file: folder.join(file.text()?),
        field: file,
        transform: transform.unwrap_or(Transform::IDENTITY),
        material,
        normals,
    })
}

/// Refuses what cannot be a mesh by its name, as the command line does.
fn check_name(file: &Field<'_>) -> Result<()> {
    let name = Path::new(file.text()?);
    match name.extension().map(|e| e.to_string_lossy().to_lowercase()) {
        _ if name.as_os_str().is_empty() => {
            Err(file.error(format!("{} is empty", file.name())).advise("e.g. file = \"bunny.obj\""))
        }
        Some(kind)
            if matches!(kind.as_str(), "stl" | "ply" | "gltf" | "glb" | "fbx" | "dae" | "3ds" | "toml") =>
        {
            Err(file
                .error(format!("cannot read meshes of the kind \".{kind}\""))
                .advise("convert it to .obj first"))
        }
        _ => Ok(()),
    }
}

fn normals_word(field: Field<'_>) -> Result<NormalsMode> {
    field.word(&[], |word| match word {
        "file" => Ok(NormalsMode::File),
        "flat" => Ok(NormalsMode::Flat),
        "smooth" => Ok(NormalsMode::Smooth { crease: 180.0 }),
        _ => Err(Error::new(format!("unknown normals \"{word}\""))
            .advise(unknown_word_advice(word, &["file", "flat", "smooth"]))),
    })
}

/// Scale, then rotate, then translate; or a matrix of 16 numbers, row by row.
fn transform(field: Field<'_>) -> Result<Transform> {
    let mut table = field.section()?;
    let matrix = table.read("matrix", matrix)?;
    let scale = table.read("scale", scale)?;
    let rotate = table.read("rotate", rotation)?;
    let translate = table.read("translate", |f| f.point())?;
    table.finish()?;
    if matrix.is_some() && (scale.is_some() || rotate.is_some() || translate.is_some()) {
        return Err(field
            .error(format!("{}.matrix stands alone", field.name()))
            .advise("leave out the other keys"));
    }
    let steps = DMat4::from_translation(translate.unwrap_or(DVec3::ZERO))
        * rotate.unwrap_or(DMat4::IDENTITY)
        * DMat4::from_scale(scale.unwrap_or(DVec3::ONE));
    Transform::new(matrix.unwrap_or(steps)).ok_or_else(|| {
        field
            .error(format!("{} flattens the mesh or leaves the range of numbers", field.name()))
            .advise("a transform must be invertible")
    })
}

fn scale(field: Field<'_>) -> Result<DVec3> {
    let scale = match field.list("") {
        Ok(_) => DVec3::from_array(field.numbers(COORDINATE)?),
        Err(_) => DVec3::splat(field.number(COORDINATE)?),
    };
    if scale.cmpeq(DVec3::ZERO).any() {
        return Err(field.error(format!("{} must not be 0", field.name())));
    }
    Ok(scale)
}

fn rotation(field: Field<'_>) -> Result<DMat4> {
    let mut table = field.section().map_err(|e| e.advise("e.g. { axis = [0, 1, 0], angle = 30 }"))?;
    let axis = table.get("axis").ok_or_else(|| table.missing(&field, "axis"))?;
    let direction = axis.point()?.try_normalize();
    let direction = direction.ok_or_else(|| axis.error(format!("{} has no direction", axis.name())))?;
    let angle =
        table.read("angle", |f| f.number(-1e6..=1e6))?.ok_or_else(|| table.missing(&field, "angle"))?;
    table.finish()?;
    Ok(rotation_matrix(direction, angle))
}

/// Rodrigues' formula. Multiples of 90° are exact, and libm's functions are the same on every machine.
fn rotation_matrix(axis: DVec3, degrees: f64) -> DMat4 {
    let turn = degrees.rem_euclid(360.0);
    let (sin, cos) = match turn {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        _ => (libm::sin(turn.to_radians()), libm::cos(turn.to_radians())),
    };
    let column = |v: DVec3| (v * cos + axis.cross(v) * sin + axis * (axis.dot(v) * (1.0 - cos))).extend(0.0);
    DMat4::from_cols(column(DVec3::X), column(DVec3::Y), column(DVec3::Z), DVec3::ZERO.extend(1.0))
}

fn matrix(field: Field<'_>) -> Result<DMat4> {
    let rows: [f64; 16] = field.numbers(COORDINATE)?;
    let matrix = DMat4::from_cols_array(&rows).transpose();
    if matrix.row(3).to_array() != [0.0, 0.0, 0.0, 1.0] {
        return Err(field
            .error(format!("{} must end with the row 0, 0, 0, 1", field.name()))
            .advise("the 16 numbers go row by row, the translation last in each of the first three rows"));
    }
    Ok(matrix)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rotations_follow_the_right_hand_and_quarter_turns_are_exact() {
        let turned = rotation_matrix(DVec3::Y, 90.0).transform_point3(DVec3::Z);
        assert_eq!(turned, DVec3::X);
        assert_eq!(rotation_matrix(DVec3::X, -90.0).transform_point3(DVec3::Z), DVec3::Y);
        let eighth = rotation_matrix(DVec3::Z, 45.0).transform_point3(DVec3::X);
        assert!((eighth - DVec3::new(0.5f64.sqrt(), 0.5f64.sqrt(), 0.0)).length() < 1e-15);
    }
}
