//! `[camera]`: what the file says; what it leaves open is found when the meshes are known.

use super::reader::{COORDINATE, Field, LENGTH, Section};
use super::transform::{TIME, motion};
use crate::camera::{Aperture, Camera, CameraSpec, Projection, Window};
use crate::error::{Error, Result, unknown_word_advice};
use crate::load::auto;
use crate::load::framing::{CameraPlan, Lens};
use crate::math::DVec3;
use crate::shape::Motion;
use std::sync::Arc;

/// Reads the section.
pub(super) fn read(mut camera: Section<'_>) -> Result<CameraPlan> {
    let projection = camera.read("type", |f| f.word(&[], projection))?;
    let projection = projection.unwrap_or(Projection::Perspective);
    let position = camera.get("position");
    let look_at = camera.get("look_at");
    let up = camera.get("up");
    let plan = CameraPlan {
        projection,
        position: position.as_ref().map(Field::point).transpose()?,
        look_at: look_at.as_ref().map(Field::point).transpose()?,
        up: up.as_ref().map(Field::point).transpose()?,
        lens: lens(&mut camera, projection)?,
        aperture: aperture(&mut camera)?,
        focus_distance: camera.read("focus_distance", |f| f.number(LENGTH))?,
        shutter: camera.read("shutter", shutter)?.unwrap_or_default(),
        motion: camera.read("motion", rigid_motion)?,
        fps: camera.read("fps", |f| f.number(1e-6..=1e9))?.unwrap_or(auto::FPS),
    };
    camera.finish()?;
    if let (None, Some(look_at)) = (&position, &look_at) {
        return Err(look_at
            .error("camera.look_at stands without camera.position")
            .advise("give both, or neither for a camera that frames the scene"));
    }
    if let (Some(DVec3::ZERO), Some(up)) = (plan.up, &up) {
        return Err(up.error("camera.up must have a direction, not [0, 0, 0]"));
    }
    if let (Some(position), Some(look_at)) = (&position, &look_at) {
        check_view(&plan, position, look_at, up.as_ref())?;
    }
    Ok(plan)
}

/// When the shutter opens and closes.
fn shutter(field: Field<'_>) -> Result<[f64; 2]> {
    let [open, close] = field.numbers(TIME)?;
    if open > close {
        return Err(field
            .error(format!("{} closes before it opens", field.name()))
            .advise("shutter = [open, close], in seconds"));
    }
    Ok([open, close])
}

/// A camera turns and goes, and keeps its size.
fn rigid_motion(field: Field<'_>) -> Result<Arc<Motion>> {
    let motion = motion(field.clone())?;
    if !motion.is_rigid() {
        return Err(field
            .error(format!("{} must keep the camera's size", field.name()))
            .advise("use rotate and translate only"));
    }
    Ok(motion)
}

fn projection(word: &str) -> Result<Projection> {
    match word {
        "perspective" => Ok(Projection::Perspective),
        "orthographic" => Ok(Projection::Orthographic),
        "panorama" => Ok(Projection::Panorama),
        _ => {
            let known: Vec<&str> = Projection::NAMES.iter().map(|n| n.0).collect();
            Err(Error::new(format!("unknown camera type \"{word}\""))
                .advise(unknown_word_advice(word, &known)))
        }
    }
}

/// The opening of the lens. A rotation is counted in turns from here on.
fn aperture(camera: &mut Section<'_>) -> Result<Aperture> {
    let radius = camera.read("aperture", |f| f.number(0.0..=1e18))?.unwrap_or(0.0) as f32;
    let blades = camera.read("blades", |f| match f.integer32(0..=64)? {
        1 | 2 => Err(f.must_be("0 for a round opening, or 3 to 64 blades")),
        blades => Ok(blades),
    })?;
    let rotation = camera.read("blade_rotation", |f| f.number(-36_000.0..=36_000.0))?.unwrap_or(0.0);
    let rotation = (rotation / 360.0).rem_euclid(1.0) as f32;
    Ok(Aperture { radius, blades: blades.unwrap_or(0), rotation })
}

/// `fov`, `plane` or `height`: one of them, and the one that the projection has.
fn lens(camera: &mut Section<'_>, projection: Projection) -> Result<Lens> {
    let (fov, plane, height) = (camera.get("fov"), camera.get("plane"), camera.get("height"));
    if let (Projection::Panorama, Some(field)) =
        (projection, fov.as_ref().or(plane.as_ref()).or(height.as_ref()))
    {
        return Err(field
            .error(format!("{} is not for the panorama camera", field.name()))
            .advise("a panorama shows all directions"));
    }
    match (projection, &fov, &plane, &height) {
        (_, Some(_), Some(plane), _) => Err(plane
            .error("camera.plane and camera.fov both set the picture's width")
            .advise("give one of them")),
        (Projection::Perspective, _, _, Some(height)) => Err(height
            .error("camera.height is for the orthographic camera")
            .advise("a perspective camera has fov, in degrees")),
        (Projection::Orthographic, Some(fov), _, _) => Err(fov
            .error("camera.fov is for the perspective camera")
            .advise("an orthographic camera has height, in metres")),
        (Projection::Orthographic, _, Some(plane), Some(_)) => Err(plane
            .error("camera.plane and camera.height both set the picture's height")
            .advise("give one of them")),
        (_, _, Some(plane), _) => plane_window(plane).map(Lens::Plane),
        (_, Some(fov), _, _) => fov.number(0.001..=179.9).map(Lens::Fov),
        (_, _, _, Some(height)) => height.number(LENGTH).map(Lens::Height),
        (_, None, None, None) => Ok(Lens::Usual),
    }
}

/// The image plane of the notes' eq. (5) and section 13.1.
fn plane_window(field: &Field<'_>) -> Result<Window> {
    let mut plane = field.section()?;
    let mut border = |key: &'static str| {
        plane.read(key, |f| f.number(COORDINATE))?.ok_or_else(|| {
            field
                .error(format!("{} has no {key}", field.name()))
                .advise("it needs left, right, top and bottom")
        })
    };
    let (left, right) = (border("left")?, border("right")?);
    let (top, bottom) = (border("top")?, border("bottom")?);
    let distance = plane.read("distance", |f| f.number(LENGTH))?.unwrap_or(1.0);
    plane.finish()?;
    if left == right || top == bottom {
        return Err(field.error(format!("{} is empty", field.name())));
    }
    Ok(Window { left, right, top, bottom, distance })
}

/// Refuses a view without a direction, at the value that spoils it.
fn check_view(
    plan: &CameraPlan,
    position: &Field<'_>,
    look_at: &Field<'_>,
    up: Option<&Field<'_>>,
) -> Result<()> {
    let (Some(eye), Some(target)) = (plan.position, plan.look_at) else { return Ok(()) };
    let spec = CameraSpec {
        projection: plan.projection,
        position: eye,
        look_at: target,
        up: plan.up.unwrap_or(DVec3::Y),
        window: CameraSpec::fov_window(40.0, [1, 1]),
        aperture: Aperture::default(),
        focus_distance: 1.0,
        shutter: [0.0; 2],
        motion: None,
        fps: auto::FPS,
    };
    match Camera::new(&spec, DVec3::ZERO) {
        Ok(_) => Ok(()),
        Err(e) if eye == target => Err(position.locate(e)),
        Err(e) => Err(up.unwrap_or(look_at).locate(e)),
    }
}
