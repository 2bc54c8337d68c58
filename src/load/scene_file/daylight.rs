//! `type = "sun-sky"`: where the sun stands and how clear the air is.

use super::light::unit;
use super::reader::{Field, LIGHT, SHARE, Section};
use crate::error::Result;
use crate::light::panorama::{self, Panorama};
use crate::light::preetham::{Daylight, SIN_SUN};
use crate::light::{Environment, Light, Sun};
use crate::load::auto::Bearings;
use crate::math::{DVec3, Rgb, Vec3};
use std::f64::consts::PI;
use std::sync::Arc;

/// Texels of the map that the sky is kept as.
const MAP: [usize; 2] = [512, 256];

/// Daylight as a file says it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct SunSkyPlan {
    place: Place,
    turbidity: f64,
    scale: f64,
    ground: Rgb,
    sun: bool,
    up: Option<DVec3>,
}

/// Where the sun stands.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Place {
    /// Along this unit direction, to it or from it: above the horizon.
    Direction(DVec3),
    /// Degrees above the horizon, and from north (−z where y is up) over east (+x).
    Angles { elevation: f64, azimuth: f64 },
}

/// Reads what `type` leaves.
pub(super) fn read(light: &mut Section<'_>) -> Result<SunSkyPlan> {
    let direction = light.get("direction");
    let elevation = light.read("elevation", |f| f.number(0.0..=90.0))?;
    let azimuth = light.get("azimuth");
    let place = match (&direction, elevation, &azimuth) {
        (Some(field), Some(_), _) | (Some(field), _, Some(_)) => {
            return Err(field
                .error(format!("{} and elevation or azimuth both place the sun", field.name()))
                .advise("give one of them"));
        }
        (Some(field), None, None) => Place::Direction(unit(field.clone())?),
        (None, elevation, azimuth) => Place::Angles {
            elevation: elevation.unwrap_or(45.0),
            azimuth: azimuth.as_ref().map(|f| f.number(-360.0..=360.0)).transpose()?.unwrap_or(135.0),
        },
    };
    Ok(SunSkyPlan {
        place,
        turbidity: light.read("turbidity", |f| f.number(2.0..=10.0))?.unwrap_or(3.0),
        scale: light.read("scale", |f| f.number(LIGHT))?.unwrap_or(1.0),
        ground: light.read("ground", |f: Field<'_>| f.color(SHARE))?.unwrap_or(Rgb::splat(0.2)),
        sun: light.read("sun", |f| f.bool())?.unwrap_or(true),
        up: light.read("up", unit)?,
    })
}

impl SunSkyPlan {
    /// The sky and the sun; `up` for a plan that says none.
    pub fn lights(&self, up: DVec3) -> Vec<Light> {
        let up = self.up.unwrap_or(up).normalize_or(DVec3::Y);
        let front = Bearings::new(up).front;
        let (to_sun, elevation) = self.sun_place(up, front);
        let day = Daylight::new(self.turbidity, elevation);
        let irradiance = day.sun();
        let axes = panorama::axes(up, front, 0.0);
        let mut lights = Vec::new();
        let texels = self.texels(&day, axes, to_sun, irradiance * libm::sin(elevation) as f32);
        if let Some(map) = Panorama::new(MAP, texels, axes) {
            lights.push(Light::Environment(Environment::Panorama(Arc::new(map))));
        }
        if self.sun {
            let radiance = irradiance * (self.scale / (PI * SIN_SUN * SIN_SUN)) as f32;
            lights.push(Light::Sun(Sun {
                direction: to_sun.as_vec3(),
                radiance,
                sin_radius: SIN_SUN as f32,
            }));
        }
        lights
    }

    /// The unit direction to the sun, and its elevation in radians.
    fn sun_place(&self, up: DVec3, front: DVec3) -> (DVec3, f64) {
        let to_sun = match self.place {
            Place::Direction(d) => d * if d.dot(up) < 0.0 { -1.0 } else { 1.0 },
            Place::Angles { elevation, azimuth } => {
                let (e, a) = (elevation.to_radians(), azimuth.to_radians());
                let east = up.cross(front);
                let level = east * libm::sin(a) - front * libm::cos(a);
                (level * libm::cos(e) + up * libm::sin(e)).normalize()
            }
        };
        (to_sun, libm::asin(to_sun.dot(up).clamp(0.0, 1.0)))
    }

    /// The map: the sky above the horizon, and below it a ground that reflects what falls on it, `direct` from the sun
    /// (none without one).
    fn texels(&self, day: &Daylight, axes: [Vec3; 3], to_sun: DVec3, direct: Rgb) -> Vec<[f32; 3]> {
        let [width, height] = MAP;
        let [x, y, z] = axes.map(|a| a.as_dvec3());
        let mut texels = vec![[0.0; 3]; width * height];
        let mut level = DVec3::ZERO;
        for (i, texel) in texels.iter_mut().enumerate().take(width * height / 2) {
            let theta = PI * ((i / width) as f64 + 0.5) / height as f64;
            let phi = 2.0 * PI * ((i % width) as f64 + 0.5) / width as f64;
            let (sin, cos) = (libm::sin(theta), libm::cos(theta));
            let d = x * (sin * libm::sin(phi)) + y * cos - z * (sin * libm::cos(phi));
            let radiance = day.sky(cos, libm::acos(d.dot(to_sun).clamp(-1.0, 1.0)));
            level += radiance.as_dvec3() * (cos * sin * 2.0 * PI * PI / (width * height) as f64);
            *texel = (radiance * self.scale as f32).to_array();
        }
        let direct = if self.sun { direct } else { Rgb::ZERO };
        let ground = self.ground * (level.as_vec3() + direct) * (self.scale / PI) as f32;
        texels[width * height / 2..].fill(ground.to_array());
        texels
    }
}
