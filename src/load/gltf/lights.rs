//! The first camera, and the lights of `KHR_lights_punctual`.
//!
//! Photometric numbers are taken as radiometric ones, as other path tracers of glTF do: 1 candela is 1 W/sr and 1 nit
//! of emission 1 W/(m² sr), so that lamps and emissive surfaces keep their ratio.

use super::item::Item;
use super::nodes::{Nodes, Placed};
use crate::error::Result;
use crate::load::framing::Lens;
use crate::load::object::FileCamera;
use crate::load::scene_file::LightPlan;
use crate::math::{DVec3, Rgb};

/// The camera of the first node that has one.
///
/// # Errors
/// A camera that does not exist.
pub(super) fn camera(root: &Item<'_>, nodes: &Nodes<'_>) -> Result<Option<FileCamera>> {
    for placed in &nodes.placed {
        let Some(camera) = placed.node.index("camera")? else { continue };
        let camera = root.at("cameras", camera)?;
        let lens = if let Some(lens) = camera.get("perspective") {
            let fov = lens.number("yfov", 0.0)?.to_degrees();
            (0.001..=179.9).contains(&fov).then_some(Lens::Fov(fov))
        } else if let Some(lens) = camera.get("orthographic") {
            let height = 2.0 * lens.number("ymag", 0.0)?.abs();
            (1e-18..=1e18).contains(&height).then_some(Lens::Height(height))
        } else {
            None
        };
        let ([forward, up], Some(lens)) = (axes(placed, [-DVec3::Z, DVec3::Y]), lens) else { continue };
        if forward.cross(up).length() > 1e-6 {
            return Ok(Some(FileCamera { position: origin(placed), forward, up, lens }));
        }
    }
    Ok(None)
}

/// Where a node stands.
fn origin(placed: &Placed<'_>) -> DVec3 {
    placed.matrix.transform_point3(DVec3::ZERO)
}

/// Unit directions of a node's own; zero where it flattens them.
fn axes<const N: usize>(placed: &Placed<'_>, own: [DVec3; N]) -> [DVec3; N] {
    own.map(|axis| placed.matrix.transform_vector3(axis).normalize_or_zero())
}

/// Every light that a node carries.
///
/// # Errors
/// A light that does not exist, or numbers that are none.
pub(super) fn lights(root: &Item<'_>, nodes: &Nodes<'_>) -> Result<Vec<LightPlan>> {
    let mut lights = Vec::new();
    for placed in &nodes.placed {
        let Some(named) = placed.node.extension("KHR_lights_punctual") else { continue };
        let all = root.extension("KHR_lights_punctual");
        let all = all.ok_or_else(|| named.error("names a light, and the document has none"))?;
        let light = all.at("lights", named.size("light", None)?)?;
        lights.extend(light_of(&light, placed)?);
    }
    Ok(lights)
}

fn light_of(light: &Item<'_>, placed: &Placed<'_>) -> Result<Option<LightPlan>> {
    let color = light.numbers("color", [1.0; 3])?;
    let strength = light.number("intensity", 1.0)?;
    let power = Rgb::from(color.map(|c| (c * strength).clamp(0.0, 1e12) as f32));
    let (position, [direction]) = (origin(placed), axes(placed, [-DVec3::Z]));
    if direction == DVec3::ZERO || !position.is_finite() {
        return Ok(None);
    }
    Ok(Some(match light.text("type") {
        Some("directional") => LightPlan::Directional { direction, irradiance: power },
        Some("point") => LightPlan::Point { position, intensity: power },
        Some("spot") => {
            let right_angle = std::f64::consts::FRAC_PI_2;
            let cone = light.get("spot");
            let angle =
                |key: &str, usual: f64| cone.as_ref().map_or(Ok(usual), |cone| cone.number(key, usual));
            let outer = angle("outerConeAngle", right_angle / 2.0)?.clamp(1e-4, right_angle);
            let inner = angle("innerConeAngle", 0.0)?.clamp(0.0, outer);
            let (cos_outer, cos_inner) = (libm::cos(outer), libm::cos(inner));
            LightPlan::Spot { position, direction, cos_outer, cos_inner, intensity: power }
        }
        _ => return Ok(None),
    }))
}
