//! `[[light]]`: lights that are no geometry.

use super::reader::{Field, LIGHT, Section};
use crate::error::{Error, Result, unknown_word_advice};
use crate::light::Light;
use crate::load::auto::Sky;
use crate::math::{DVec3, Rgb};

/// A light in the file's own coordinates.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum LightPlan {
    /// The same radiance from everywhere.
    Constant(Rgb),
    /// A built-in sky, brighter by a factor.
    Sky { sky: Sky, up: Option<DVec3>, scale: f32 },
    /// A point.
    Point { position: DVec3, intensity: Rgb },
    /// Parallel light; a unit direction.
    Directional { direction: DVec3, irradiance: Rgb },
    /// A spherical lamp.
    Sphere { center: DVec3, radius: f64, radiance: Rgb },
    /// A flat lamp that faces edge_u × edge_v.
    Rectangle { corner: DVec3, edges: [DVec3; 2], radiance: Rgb, two_sided: bool },
}

impl LightPlan {
    /// True for light from infinitely far away.
    pub fn is_environment(&self) -> bool {
        matches!(self, LightPlan::Constant(_) | LightPlan::Sky { .. })
    }
}

/// Reads every light; at most one environment.
pub(super) fn read_all(field: &Field<'_>) -> Result<Vec<LightPlan>> {
    let mut lights: Vec<LightPlan> = Vec::new();
    for item in field.list("a list of tables, [[light]]")? {
        let light = read(item.section()?, &item)?;
        if light.is_environment() && lights.iter().any(LightPlan::is_environment) {
            return Err(item.error("a second environment").advise("a scene has one; add their radiances up"));
        }
        lights.push(light);
    }
    Ok(lights)
}

/// The kinds of light that a file may name.
enum Kind {
    Environment,
    Point,
    Directional,
    Sphere,
    Rectangle,
}

fn kind(word: &str) -> Result<Kind> {
    match word {
        "environment" => Ok(Kind::Environment),
        "point" => Ok(Kind::Point),
        "directional" => Ok(Kind::Directional),
        "sphere" => Ok(Kind::Sphere),
        "rectangle" => Ok(Kind::Rectangle),
        _ => {
            let known: Vec<&str> = Light::NAMES.iter().map(|n| n.0).collect();
            Err(Error::new(format!("unknown light \"{word}\"")).advise(unknown_word_advice(word, &known)))
        }
    }
}

fn read(mut light: Section<'_>, field: &Field<'_>) -> Result<LightPlan> {
    const LATER: &[&str] = &["spot", "sun-sky"];
    let kind = light.read("type", |f| f.word(LATER, kind))?;
    let kind = kind.ok_or_else(|| {
        field.error(format!("{} has no type", field.name())).advise("e.g. type = \"environment\"")
    })?;
    let point = |light: &mut Section<'_>, key: &'static str| {
        light.read(key, |f| f.point())?.ok_or_else(|| light.missing(field, key))
    };
    let color = |light: &mut Section<'_>, key: &'static str| {
        light.read(key, |f| f.color(LIGHT))?.ok_or_else(|| light.missing(field, key))
    };
    let plan = match kind {
        Kind::Environment => environment(&mut light)?,
        Kind::Point => LightPlan::Point {
            position: point(&mut light, "position")?,
            intensity: color(&mut light, "intensity")?,
        },
        Kind::Directional => LightPlan::Directional {
            direction: light.read("direction", unit)?.ok_or_else(|| light.missing(field, "direction"))?,
            irradiance: color(&mut light, "irradiance")?,
        },
        Kind::Sphere => LightPlan::Sphere {
            center: point(&mut light, "center")?,
            radius: light
                .read("radius", |f| f.number(1e-9..=1e9))?
                .ok_or_else(|| light.missing(field, "radius"))?,
            radiance: color(&mut light, "radiance")?,
        },
        Kind::Rectangle => {
            let corner = point(&mut light, "corner")?;
            let edges = [point(&mut light, "edge_u")?, point(&mut light, "edge_v")?];
            if edges[0].cross(edges[1]) == DVec3::ZERO {
                return Err(field.error(format!("{}: edge_u and edge_v span no area", field.name())));
            }
            let radiance = color(&mut light, "radiance")?;
            let two_sided = light.read("two_sided", |f| f.bool())?.unwrap_or(true);
            LightPlan::Rectangle { corner, edges, radiance, two_sided }
        }
    };
    light.finish()?;
    Ok(plan)
}

fn environment(light: &mut Section<'_>) -> Result<LightPlan> {
    light.not_yet(&["file", "rotate"])?;
    let radiance = light.read("radiance", |f| f.color(LIGHT))?;
    let scale = light.read("scale", |f| f.number(LIGHT))?.unwrap_or(1.0) as f32;
    let up = light.get("up");
    let Some(sky) = light.get("sky") else {
        if let Some(up) = up {
            return Err(up.error(format!("{} goes with sky", up.name())));
        }
        return Ok(LightPlan::Constant(radiance.unwrap_or(Rgb::ONE) * scale));
    };
    if radiance.is_some() {
        return Err(sky.error("sky and radiance exclude each other").advise("scale makes a sky brighter"));
    }
    Ok(LightPlan::Sky { sky: sky.word(&[], Sky::from_name)?, up: up.map(unit).transpose()?, scale })
}

/// A direction of any length but zero.
fn unit(field: Field<'_>) -> Result<DVec3> {
    let no_direction = || field.error(format!("{} has no direction", field.name()));
    field.point()?.try_normalize().ok_or_else(no_direction)
}
