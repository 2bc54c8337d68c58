//! Light from infinitely far away.

use super::Panorama;
use crate::math::approx::sin_cos_turn;
use crate::math::warp::{SPHERE_PDF, sphere};
use crate::math::{Frame, Rgb, Vec3};
use std::f32::consts::TAU;
use std::sync::Arc;

/// Radiance as a function of direction alone.
#[derive(Clone, Debug, PartialEq)]
pub enum Environment {
    /// The same from everywhere.
    Constant(Rgb),
    /// The sky of bare meshes: a gradient from the ground's bounce over the horizon to the zenith, and a
    /// soft key light, radiance `key·exp(sharpness·(cos γ − 1))` at the angle γ from `direction`.
    Studio {
        /// Radiance from straight below.
        below: Rgb,
        /// Radiance from the horizon.
        horizon: Rgb,
        /// Radiance from straight above.
        zenith: Rgb,
        /// Unit vector to the zenith.
        up: Vec3,
        /// Unit direction to the key light.
        direction: Vec3,
        /// Radiance of the key light's middle.
        key: Rgb,
        /// How narrow the key light is: 0 is everywhere, 20 some 15 degrees.
        sharpness: f32,
    },
    /// A map of all directions.
    Panorama(Arc<Panorama>),
}

/// Share of the studio's samples that go to the key light; the rest is uniform.
const KEY_SHARE: f32 = 0.75;

impl Environment {
    /// Radiance that arrives from the unit direction `d`.
    #[inline(always)]
    pub fn le(&self, d: Vec3) -> Rgb {
        match self {
            Environment::Constant(radiance) => *radiance,
            Environment::Studio { below, horizon, zenith, up, direction, key, sharpness } => {
                let height = d.dot(*up);
                let end = if height < 0.0 { below } else { zenith };
                // A square root keeps the change of tone near the horizon, as skies do.
                let t = height.abs().min(1.0).sqrt();
                let lobe = libm::expf(sharpness * (d.dot(*direction) - 1.0));
                *horizon * (1.0 - t) + *end * t + *key * lobe
            }
            Environment::Panorama(map) => map.le(d),
        }
    }

    /// True when light samples find what BSDF samples would miss; a constant environment is found as well by the BSDF
    /// alone, without shadow rays. Not `compensated`: no BSDF samples are there to find it.
    pub fn deserves_samples(&self, compensated: bool) -> bool {
        match self {
            Environment::Constant(_) => !compensated,
            Environment::Studio { .. } => true,
            Environment::Panorama(map) => map.has_density(compensated),
        }
    }

    /// A direction by importance, its density per solid angle and the radiance from there; `compensated`: see
    /// [`Panorama`]. `None` where nothing shines.
    #[inline(always)]
    pub fn sample(&self, compensated: bool, u: [f32; 2]) -> Option<(Vec3, f32, Rgb)> {
        let wi = match self {
            Environment::Constant(_) => sphere(u),
            Environment::Studio { direction, sharpness, .. } => {
                if u[0] < KEY_SHARE {
                    Frame::new(*direction).to_world(lobe([u[0] / KEY_SHARE, u[1]], *sharpness))
                } else {
                    sphere([(u[0] - KEY_SHARE) / (1.0 - KEY_SHARE), u[1]])
                }
            }
            Environment::Panorama(map) => return map.sample(compensated, u),
        };
        Some((wi, self.pdf(compensated, wi), self.le(wi)))
    }

    /// Density of [`Environment::sample`] per solid angle.
    #[inline(always)]
    pub fn pdf(&self, compensated: bool, wi: Vec3) -> f32 {
        match self {
            Environment::Constant(_) => SPHERE_PDF,
            Environment::Studio { direction, sharpness, .. } => {
                KEY_SHARE * lobe_pdf(wi.dot(*direction), *sharpness) + (1.0 - KEY_SHARE) * SPHERE_PDF
            }
            Environment::Panorama(map) => map.pdf(compensated, wi),
        }
    }

    /// True where no light comes from anywhere.
    pub fn is_black(&self) -> bool {
        match self {
            Environment::Constant(radiance) => *radiance == Rgb::ZERO,
            Environment::Studio { below, horizon, zenith, key, .. } => {
                [below, horizon, zenith, key].into_iter().all(|radiance| *radiance == Rgb::ZERO)
            }
            Environment::Panorama(map) => map.mean() == Rgb::ZERO,
        }
    }

    /// Average radiance over the sphere, for choosing among lights.
    pub fn average(&self) -> Rgb {
        match self {
            Environment::Constant(radiance) => return *radiance,
            Environment::Panorama(map) => return map.mean(),
            Environment::Studio { .. } => {}
        }
        let n = 64;
        let at = |i: usize| (i % n, i / n);
        let cell = |(i, j): (usize, usize)| {
            self.le(sphere([(i as f32 + 0.5) / n as f32, (j as f32 + 0.5) / n as f32]))
        };
        (0..n * n).map(|i| cell(at(i))).sum::<Rgb>() / (n * n) as f32
    }

    /// The same light at `scale` times the radiance; maps are scaled when they are made.
    pub fn scaled(self, scale: f32) -> Environment {
        match self {
            Environment::Panorama(map) => Environment::Panorama(map),
            Environment::Constant(radiance) => Environment::Constant(radiance * scale),
            Environment::Studio { below, horizon, zenith, up, direction, key, sharpness } => {
                Environment::Studio {
                    below: below * scale,
                    horizon: horizon * scale,
                    zenith: zenith * scale,
                    up,
                    direction,
                    key: key * scale,
                    sharpness,
                }
            }
        }
    }
}

/// A direction around z with density proportional to exp(sharpness·cos θ) (von Mises and Fisher).
#[inline(always)]
fn lobe(u: [f32; 2], sharpness: f32) -> Vec3 {
    let floor = libm::expf(-2.0 * sharpness);
    let z = (1.0 + libm::logf(u[0] + (1.0 - u[0]) * floor) / sharpness).clamp(-1.0, 1.0);
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (s, c) = sin_cos_turn(u[1]);
    Vec3::new(r * c, r * s, z)
}

/// Density of [`lobe`] per solid angle.
#[inline(always)]
fn lobe_pdf(cos: f32, sharpness: f32) -> f32 {
    let norm = TAU * (1.0 - libm::expf(-2.0 * sharpness));
    sharpness / norm * libm::expf(sharpness * (cos - 1.0))
}
