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
}

impl LightPlan {
    /// True for light from infinitely far away.
    pub fn is_environment(&self) -> bool {
        !matches!(self, LightPlan::Point { .. })
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
}

fn kind(word: &str) -> Result<Kind> {
    match word {
        "environment" => Ok(Kind::Environment),
        "point" => Ok(Kind::Point),
        _ => {
            let known: Vec<&str> = Light::NAMES.iter().map(|n| n.0).collect();
            Err(Error::new(format!("unknown light \"{word}\"")).advise(unknown_word_advice(word, &known)))
        }
    }
}

fn read(mut light: Section<'_>, field: &Field<'_>) -> Result<LightPlan> {
    const LATER: &[&str] = &["spot", "directional", "sphere", "rectangle", "sun-sky"];
    let missing = |key: &str| field.error(format!("{} has no {key}", field.name()));
    let kind = light.read("type", |f| f.word(LATER, kind))?;
    let plan = match kind.ok_or_else(|| missing("type").advise("e.g. type = \"environment\""))? {
        Kind::Environment => environment(&mut light)?,
        Kind::Point => LightPlan::Point {
            position: light.read("position", |f| f.point())?.ok_or_else(|| missing("position"))?,
            intensity: light.read("intensity", |f| f.color(LIGHT))?.ok_or_else(|| missing("intensity"))?,
        },
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
    let up = up.map(|f| {
        f.point()
            .and_then(|p| p.try_normalize().ok_or_else(|| f.error(format!("{} has no direction", f.name()))))
    });
    Ok(LightPlan::Sky { sky: sky.word(&[], Sky::from_name)?, up: up.transpose()?, scale })
}
