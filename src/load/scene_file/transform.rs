//! `transform` and `motion`: where things stand, once or by time.

use super::reader::{COORDINATE, Field, Section};
use crate::error::Result;
use crate::load::place::Transform;
use crate::math::{DMat4, DVec3};
use crate::shape::{Motion, Pose};
use std::ops::RangeInclusive;
use std::sync::Arc;

/// Points of time, in seconds.
pub(super) const TIME: RangeInclusive<f64> = -1e9..=1e9;

/// The keys of a transform.
struct Steps {
    matrix: Option<DMat4>,
    scale: Option<DVec3>,
    turn: Option<(DVec3, f64)>,
    translate: Option<DVec3>,
}

impl Steps {
    /// Reads the keys out of `table`, which stands in `field`.
    fn read(table: &mut Section<'_>, field: &Field<'_>) -> Result<Steps> {
        let matrix = table.read("matrix", matrix)?;
        let scale = table.read("scale", scale)?;
        let turn = table.read("rotate", turn)?;
        let translate = table.read("translate", |f| f.point())?;
        if matrix.is_some() && (scale.is_some() || turn.is_some() || translate.is_some()) {
            return Err(field
                .error(format!("{}.matrix stands alone", field.name()))
                .advise("leave out the other keys"));
        }
        Ok(Steps { matrix, scale, turn, translate })
    }

    /// Scale, then rotate, then translate; or the matrix. `None` where it cannot be inverted.
    fn pose(&self) -> Option<Pose> {
        let steps =
            || Pose::new(self.scale.unwrap_or(DVec3::ONE), self.turn, self.translate.unwrap_or(DVec3::ZERO));
        self.matrix.map_or_else(|| Some(steps()), Pose::of_matrix)
    }

    fn transform(&self) -> Option<Transform> {
        let matrix = self.matrix.or_else(|| self.pose().map(|pose| DMat4::from(pose.affine())));
        matrix.and_then(Transform::new)
    }
}

/// A transform: scale, rotate and translate, in this order, or a matrix of 16 numbers, row by row.
pub(super) fn transform(field: Field<'_>) -> Result<Transform> {
    let mut table = field.section()?;
    let transform = transform_in(&mut table, &field)?;
    table.finish()?;
    Ok(transform)
}

/// The same, where the keys stand among others.
pub(super) fn transform_in(table: &mut Section<'_>, field: &Field<'_>) -> Result<Transform> {
    let steps = Steps::read(table, field)?;
    steps.transform().ok_or_else(|| {
        field
            .error(format!("{} flattens the mesh or leaves the range of numbers", field.name()))
            .advise("a transform must be invertible")
    })
}

/// A list of tables, each a transform with its `time`.
pub(super) fn motion(field: Field<'_>) -> Result<Arc<Motion>> {
    let what = "a list of poses by time, [{ time = 0.0, … }, { time = 1.0, … }]";
    let mut poses: Vec<(f64, Pose)> = Vec::new();
    for item in field.list(what)? {
        let mut table = item.section()?;
        let time = table.read("time", |f| f.number(TIME))?.ok_or_else(|| table.missing(&item, "time"))?;
        let steps = Steps::read(&mut table, &item)?;
        table.finish()?;
        let pose = steps.transform().and_then(|_| steps.pose()).ok_or_else(|| {
            item.error(format!("{} flattens the mesh or leaves the range of numbers", item.name()))
                .advise("a pose must be invertible")
        })?;
        poses.push((time, pose));
        // Again and again, so that a mistake is told where it stands.
        if let Err(error) = Motion::new(poses.get(poses.len().saturating_sub(2)..).unwrap_or_default()) {
            return Err(item.locate(error));
        }
    }
    if poses.is_empty() {
        return Err(field.must_be(what));
    }
    Motion::new(&poses).map(Arc::new).map_err(|e| field.locate(e))
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

/// Unit axis and degrees.
fn turn(field: Field<'_>) -> Result<(DVec3, f64)> {
    let mut table = field.section().map_err(|e| e.advise("e.g. { axis = [0, 1, 0], angle = 30 }"))?;
    let axis = table.get("axis").ok_or_else(|| table.missing(&field, "axis"))?;
    let direction = axis.point()?.try_normalize();
    let direction = direction.ok_or_else(|| axis.error(format!("{} has no direction", axis.name())))?;
    let angle =
        table.read("angle", |f| f.number(-1e6..=1e6))?.ok_or_else(|| table.missing(&field, "angle"))?;
    table.finish()?;
    Ok((direction, angle))
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
