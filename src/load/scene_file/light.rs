//! `[[light]]`: lights that are no geometry.

use super::Home;
use super::daylight::{self, SunSkyPlan};
use super::reader::{Field, LIGHT, SHARE, Section};
use crate::error::{Error, Result, show_path, unknown_word_advice};
use crate::light::Light;
use crate::load::auto::Sky;
use crate::load::sky::{SkyPicture, is_picture};
use crate::math::{DVec3, Rgb};
use std::path::Path;

/// A light in the file's own coordinates.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum LightPlan {
    /// The same radiance from everywhere.
    Constant(Rgb),
    /// A built-in sky, brighter by a factor.
    Sky { sky: Sky, up: Option<DVec3>, scale: f32 },
    /// A picture of all directions: brighter by a factor, turned by degrees.
    Picture { picture: SkyPicture, scale: f32, rotate: f64, up: Option<DVec3> },
    /// A sun and its sky.
    SunSky(SunSkyPlan),
    /// A point.
    Point { position: DVec3, intensity: Rgb },
    /// A point that shines into a cone around a unit direction; the cosines of its half angle and of where its edge
    /// begins.
    Spot { position: DVec3, direction: DVec3, cos_outer: f64, cos_inner: f64, intensity: Rgb },
    /// Parallel light; a unit direction.
    Directional { direction: DVec3, irradiance: Rgb },
    /// A spherical lamp.
    Sphere { center: DVec3, radius: f64, radiance: Rgb },
    /// A flat lamp that faces edge_u × edge_v.
    Rectangle { corner: DVec3, edges: [DVec3; 2], radiance: Rgb, two_sided: bool },
}

impl LightPlan {
    /// Sets the zenith of a map or of daylight where the file does not; built-in skies have the camera's.
    pub fn set_up(&mut self, zenith: DVec3) {
        match self {
            LightPlan::Picture { up, .. } => _ = up.get_or_insert(zenith),
            LightPlan::SunSky(daylight) => daylight.set_up(zenith),
            _ => {}
        }
    }

    /// True for light from infinitely far away.
    pub fn is_environment(&self) -> bool {
        matches!(self, Self::Constant(_) | Self::Sky { .. } | Self::Picture { .. } | Self::SunSky(_))
    }
}

/// Reads every light; at most one environment.
pub(super) fn read_all(field: &Field<'_>, home: &Home<'_>) -> Result<Vec<LightPlan>> {
    let mut lights: Vec<LightPlan> = Vec::new();
    for item in field.list("a list of tables, [[light]]")? {
        let light = read(item.section()?, &item, home)?;
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
    SunSky,
    Point,
    Spot,
    Directional,
    Sphere,
    Rectangle,
}

fn kind(word: &str) -> Result<Kind> {
    match word {
        "environment" => Ok(Kind::Environment),
        "sun-sky" => Ok(Kind::SunSky),
        "point" => Ok(Kind::Point),
        "spot" => Ok(Kind::Spot),
        "directional" => Ok(Kind::Directional),
        "sphere" => Ok(Kind::Sphere),
        "rectangle" => Ok(Kind::Rectangle),
        _ => {
            let known: Vec<&str> = Light::NAMES.iter().map(|n| n.0).collect();
            Err(Error::new(format!("unknown light \"{word}\"")).advise(unknown_word_advice(word, &known)))
        }
    }
}

fn read(mut light: Section<'_>, field: &Field<'_>, home: &Home<'_>) -> Result<LightPlan> {
    let kind = light.read("type", |f| f.word(&[], kind))?;
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
        Kind::Environment => environment(&mut light, home)?,
        Kind::SunSky => LightPlan::SunSky(daylight::read(&mut light)?),
        Kind::Spot => spot(&mut light, field)?,
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

/// Intensity on the axis; the edge takes the share `falloff` of the half angle.
fn spot(light: &mut Section<'_>, field: &Field<'_>) -> Result<LightPlan> {
    let position = light.read("position", |f| f.point())?.ok_or_else(|| light.missing(field, "position"))?;
    let direction = light.read("direction", unit)?.ok_or_else(|| light.missing(field, "direction"))?;
    let intensity =
        light.read("intensity", |f| f.color(LIGHT))?.ok_or_else(|| light.missing(field, "intensity"))?;
    let angle =
        light.read("angle", |f| f.number(0.01..=180.0))?.ok_or_else(|| light.missing(field, "angle"))?;
    let falloff = light.read("falloff", |f| f.number(SHARE))?.unwrap_or(0.25);
    let cos = |degrees: f64| libm::cos(degrees.to_radians());
    let (cos_outer, cos_inner) = (cos(angle), cos(angle * (1.0 - falloff)));
    Ok(LightPlan::Spot { position, direction, cos_outer, cos_inner, intensity })
}

fn environment(light: &mut Section<'_>, home: &Home<'_>) -> Result<LightPlan> {
    let radiance = light.read("radiance", |f| f.color(LIGHT))?;
    let scale = light.read("scale", |f| f.number(LIGHT))?.unwrap_or(1.0) as f32;
    let up = light.get("up");
    let rotate = light.get("rotate");
    if let Some(file) = light.get("file") {
        if let Some(other) = light.get("sky").or(light.get("radiance")) {
            return Err(other
                .error(format!("{} and file exclude each other", other.name()))
                .advise("scale makes a picture brighter"));
        }
        let rotate = rotate.map(|f| f.number(-36_000.0..=36_000.0)).transpose()?.unwrap_or(0.0);
        let up = up.map(unit).transpose()?;
        return Ok(LightPlan::Picture { picture: picture(&file, home)?, scale, rotate, up });
    }
    if let Some(rotate) = rotate {
        return Err(rotate.error(format!("{} goes with file", rotate.name())));
    }
    let Some(sky) = light.get("sky") else {
        if let Some(up) = up {
            return Err(up.error(format!("{} goes with sky", up.name())));
        }
        return Ok(LightPlan::Constant(radiance.unwrap_or(Rgb::ONE) * scale));
    };
    if radiance.is_some() {
        return Err(sky.error("sky and radiance exclude each other").advise("scale makes a sky brighter"));
    }
    if is_picture(sky.text()?) {
        return Err(sky
            .error(format!("{} names a built-in sky", sky.name()))
            .advise("a picture is given by file = \"…\""));
    }
    Ok(LightPlan::Sky { sky: sky.word(&[], Sky::from_name)?, up: up.map(unit).transpose()?, scale })
}

/// Reads the picture that `file` names.
fn picture(file: &Field<'_>, home: &Home<'_>) -> Result<SkyPicture> {
    let name = Path::new(file.text()?);
    if name.as_os_str().is_empty() {
        return Err(file.error(format!("{} is empty", file.name())).advise("e.g. file = \"sky.exr\""));
    }
    let path = home.folder.join(name);
    SkyPicture::read(&path, home.reach).map_err(|why| {
        let mut error = file.error(format!("{}: {}", show_path(&path), why.message));
        let relative = "a relative path starts in the scene file's folder";
        error.advice = why.advice.or_else(|| name.is_relative().then(|| relative.to_string()));
        error
    })
}

/// A direction of any length but zero.
pub(super) fn unit(field: Field<'_>) -> Result<DVec3> {
    let no_direction = || field.error(format!("{} has no direction", field.name()));
    field.point()?.try_normalize().ok_or_else(no_direction)
}
