//! All lights of a scene, chosen by power.

use super::{Directional, Environment, Light, Point, Sphere};
use crate::math::distribution::AliasTable;
use crate::math::ray::{Ray, leave};
use crate::math::{Rgb, Vec2, Vec3, luminance, warp};
use crate::shape::{Mesh, Surface};
use crate::texture::{Opacity, Texture};
use std::f64::consts::PI;
use std::sync::Arc;

/// What a material emits.
#[derive(Clone, Debug)]
pub struct Emission {
    /// Radiance, the same in all directions; of a picture its mean, by which lights are chosen.
    pub radiance: Rgb,
    /// True: from both sides; false: from the side `ng` points to.
    pub two_sided: bool,
    /// Radiance as a picture.
    pub texture: Option<Texture>,
    /// Where the surface is there. A ray that meets a hole goes on; a light sample must count what is there.
    pub opacity: Option<Opacity>,
}

impl Emission {
    /// Radiance at texture coordinates `uv` of a surface that is there.
    #[inline(always)]
    fn at(&self, uv: Vec2) -> Rgb {
        match &self.texture {
            None => self.radiance,
            Some(texture) => texture.rgb(uv).max(Rgb::ZERO).min(Rgb::splat(Self::LARGEST)),
        }
    }

    /// Radiance above this is cut, as the scene file does.
    const LARGEST: f32 = 1e12;
}

/// A shadow ray and what comes along it.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit direction to the light.
    pub wi: Vec3,
    /// Radiance over the density of this sample, before visibility.
    pub radiance_over_pdf: Rgb,
    /// Density of `wi` per solid angle; infinite for a delta light.
    pub pdf: f32,
    /// The segment that must be free.
    pub shadow: Ray,
}

/// Shadow rays end this share before the light, so that its own triangle does not block them. Relative, so
/// it has no unit.
const ALMOST: f32 = 1.0 - 1e-5;

#[derive(Clone, Copy, Debug)]
enum Entry {
    Triangle { mesh: u32, triangle: u32 },
    Point(u32),
    Directional(u32),
    Sphere(u32),
    Environment,
}

/// Which lights [`Lights::sample`] chooses from, besides those that always deserve it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampled {
    /// Also an environment that BSDF sampling finds as well.
    pub any_environment: bool,
    /// Also points and parallel light. False: [`Lights::deltas`] gives them, each for itself.
    pub deltas: bool,
}

/// Where a ray ends without meeting a mesh.
#[derive(Clone, Copy, Debug)]
pub enum End {
    /// It hit nothing.
    Sky,
    /// The spherical lamp of that index.
    Sphere(u32),
}

/// All lights of a scene, ready to be sampled.
#[derive(Clone, Debug)]
pub struct Lights {
    meshes: Vec<Arc<Mesh>>,
    emissions: Vec<Emission>,
    /// The environment that rays meet which hit nothing.
    pub environment: Option<Environment>,
    points: Vec<Point>,
    directionals: Vec<Directional>,
    /// The spherical lamps, which rays meet besides the meshes.
    pub spheres: Vec<Sphere>,
    entries: Vec<Entry>,
    table: AliasTable,
    /// By entry, except for triangles: the probability of being chosen.
    chance: Vec<f32>,
    /// By spherical lamp: the same.
    sphere_chance: Vec<f32>,
    /// By material: density per area with which [`Lights::sample`] chooses a point of such a triangle. The
    /// triangle's power is its area times a constant of the material, so the area cancels.
    density: Vec<f32>,
    environment_chance: f32,
}

impl Lights {
    /// Collects the emissive triangles of `meshes` (`emissions` by material id) and the other lights.
    /// `radius`: of a sphere around the scene, in metres, to weigh the environment against the rest.
    pub fn new(
        meshes: &[Arc<Mesh>],
        emissions: Vec<Emission>,
        others: &[Light],
        radius: f32,
        sampled: Sampled,
    ) -> Lights {
        let mut lights = Lights {
            meshes: meshes.to_vec(),
            environment: None,
            points: Vec::new(),
            directionals: Vec::new(),
            spheres: Vec::new(),
            sphere_chance: Vec::new(),
            density: vec![0.0; emissions.len()],
            emissions,
            entries: Vec::new(),
            table: AliasTable::default(),
            chance: Vec::new(),
            environment_chance: 0.0,
        };
        for light in others {
            match light {
                Light::Environment(e) => lights.environment = Some(*e),
                Light::Point(p) => lights.points.push(*p),
                Light::Directional(d) => lights.directionals.push(*d),
                Light::Sphere(s) => lights.spheres.push(*s),
            }
        }
        // The disk that parallel light and the sky shine on; a scene without extent has any.
        let disk = PI * if radius > 0.0 { f64::from(radius).powi(2) } else { 1.0 };
        let mut powers = Vec::new();
        lights.collect_triangles(&mut powers);
        lights.collect_others(disk, sampled.deltas, &mut powers);
        if let Some(environment) =
            lights.environment.filter(|e| sampled.any_environment || e.deserves_samples())
        {
            lights.entries.push(Entry::Environment);
            powers.push(4.0 * PI * disk * f64::from(luminance(environment.average())));
        }
        lights.weigh(&powers);
        lights
    }

    /// Adds points and parallel lights (if `deltas`) and spheres with their powers.
    fn collect_others(&mut self, disk: f64, deltas: bool, powers: &mut Vec<f64>) {
        for (i, point) in self.points.iter().enumerate().filter(|_| deltas) {
            self.entries.push(Entry::Point(i as u32));
            powers.push(4.0 * PI * f64::from(luminance(point.intensity)));
        }
        for (i, light) in self.directionals.iter().enumerate().filter(|_| deltas) {
            self.entries.push(Entry::Directional(i as u32));
            powers.push(disk * f64::from(luminance(light.irradiance)));
        }
        for (i, sphere) in self.spheres.iter().enumerate() {
            self.entries.push(Entry::Sphere(i as u32));
            powers.push(
                4.0 * PI * PI * f64::from(sphere.radius).powi(2) * f64::from(luminance(sphere.radiance)),
            );
        }
    }

    /// Adds every emissive triangle with its power π·L·A·sides.
    fn collect_triangles(&mut self, powers: &mut Vec<f64>) {
        for (m, mesh) in self.meshes.iter().enumerate() {
            for t in 0..mesh.indices.len() {
                let power_per_area = self.power_per_area(mesh.materials.get(t));
                if power_per_area > 0.0 {
                    let [a, b, c] = mesh.triangle(t).map(|p| p.as_dvec3());
                    let area = 0.5 * (b - a).cross(c - a).length();
                    if area > 0.0 {
                        self.entries.push(Entry::Triangle { mesh: m as u32, triangle: t as u32 });
                        powers.push(power_per_area * area);
                    }
                }
            }
        }
    }

    fn power_per_area(&self, material: u32) -> f64 {
        self.emissions
            .get(material as usize)
            .map_or(0.0, |e| PI * f64::from(luminance(e.radiance)) * if e.two_sided { 2.0 } else { 1.0 })
    }

    fn weigh(&mut self, powers: &[f64]) {
        let total: f64 = powers.iter().sum();
        self.table = AliasTable::new(powers);
        if self.table.is_empty() {
            return;
        }
        self.chance = powers.iter().map(|p| (p / total) as f32).collect();
        self.density =
            (0..self.emissions.len() as u32).map(|m| (self.power_per_area(m) / total) as f32).collect();
        let pairs = self.entries.iter().zip(&self.chance);
        let of_spheres = pairs.filter_map(|(e, c)| matches!(e, Entry::Sphere(_)).then_some(*c));
        self.sphere_chance = of_spheres.collect();
        if let Some(Entry::Environment) = self.entries.last() {
            self.environment_chance = self.chance.last().copied().unwrap_or(0.0);
        }
    }

    /// True when there is nothing to sample.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.table.is_empty()
    }

    /// Radiance that the triangle hit at `surface` sends back along `wo`.
    #[inline(always)]
    pub fn emitted(&self, material: u32, surface: &Surface, wo: Vec3) -> Rgb {
        let emission = &self.emissions[material as usize];
        if emission.two_sided || surface.ng.dot(wo) > 0.0 { emission.at(surface.uv) } else { Rgb::ZERO }
    }

    /// Density per solid angle with which [`Lights::sample`] would have chosen the point that a ray met at
    /// distance `t` on an emissive triangle of `material`.
    #[inline(always)]
    pub fn pdf_of_hit(&self, material: u32, surface: &Surface, wo: Vec3, t: f32) -> f32 {
        self.density[material as usize] * t * t / surface.ng.dot(wo).abs()
    }

    /// Radiance at the end of a ray from `o` along `d` that meets no mesh, and the density per solid angle with
    /// which [`Lights::sample`] would have chosen that direction.
    #[inline(always)]
    pub fn at_end(&self, end: End, o: Vec3, d: Vec3) -> (Rgb, f32) {
        match end {
            End::Sky => match &self.environment {
                Some(environment) => (environment.le(d), self.pdf_of_sky(d)),
                None => (Rgb::ZERO, 0.0),
            },
            End::Sphere(i) => {
                let sphere = &self.spheres[i as usize];
                let chance = self.sphere_chance.get(i as usize).copied().unwrap_or(0.0);
                let pdf = sphere.pdf(o);
                // Seen from inside it is black.
                if pdf > 0.0 { (sphere.radiance, chance * pdf) } else { (Rgb::ZERO, 0.0) }
            }
        }
    }

    #[inline(always)]
    fn pdf_of_sky(&self, d: Vec3) -> f32 {
        match &self.environment {
            Some(environment) if self.environment_chance > 0.0 => {
                self.environment_chance * environment.pdf(d)
            }
            _ => 0.0,
        }
    }

    /// Every light that no ray can meet: points and parallel light, as the notes' 13.7 hints at them (no grid of
    /// directions finds one).
    #[inline]
    pub fn deltas<'a>(&'a self, from: &'a Surface) -> impl Iterator<Item = LightSample> + 'a {
        let points = self.points.iter().filter_map(|p| sample_point(from, p, 1.0));
        points.chain(self.directionals.iter().map(|d| sample_directional(from, d, 1.0)))
    }

    /// One light and one direction to it. `choice`: 32 uniform bits; `u`: where on the light.
    #[inline(always)]
    pub fn sample(&self, from: &Surface, choice: u32, u: [f32; 2]) -> Option<LightSample> {
        let entry = self.table.sample(choice)?;
        match self.entries[entry] {
            Entry::Triangle { mesh, triangle } => self.sample_triangle(from, mesh, triangle, u),
            Entry::Point(i) => sample_point(from, &self.points[i as usize], self.chance[entry]),
            Entry::Directional(i) => {
                Some(sample_directional(from, &self.directionals[i as usize], self.chance[entry]))
            }
            Entry::Sphere(i) => sample_sphere(from, &self.spheres[i as usize], self.chance[entry], u),
            Entry::Environment => self.sample_environment(from, u),
        }
    }

    #[inline(always)]
    fn sample_triangle(&self, from: &Surface, mesh: u32, triangle: u32, u: [f32; 2]) -> Option<LightSample> {
        let mesh = &self.meshes[mesh as usize];
        let material = mesh.materials.get(triangle as usize);
        let [b1, b2] = warp::triangle(u);
        let mut light = Surface::faceted(mesh, triangle, b1, b2);
        let emission = &self.emissions[material as usize];
        let mut share = 1.0;
        if emission.texture.is_some() || emission.opacity.is_some() {
            let uv = mesh.uv(triangle as usize, b1, b2);
            light.uv = uv.unwrap_or(light.uv);
            share = emission.opacity.as_ref().map_or(1.0, |opacity| opacity.at(uv));
        }
        let to = light.p - from.p;
        let distance_squared = to.length_squared();
        if distance_squared <= 0.0 {
            return None;
        }
        let wi = to * (1.0 / distance_squared.sqrt());
        let radiance = self.emitted(material, &light, -wi) * share;
        let pdf = self.density[material as usize] * distance_squared / light.ng.dot(wi).abs();
        if radiance == Rgb::ZERO || !(pdf > 0.0 && pdf.is_finite()) {
            return None;
        }
        let start = leave(from.p, from.error, from.ng, wi);
        let end = leave(light.p, light.error, light.ng, -wi);
        let shadow = Ray { o: start, d: end - start, tmax: ALMOST };
        Some(LightSample { wi, radiance_over_pdf: radiance / pdf, pdf, shadow })
    }

    #[inline(always)]
    fn sample_environment(&self, from: &Surface, u: [f32; 2]) -> Option<LightSample> {
        let environment = self.environment.as_ref()?;
        let (wi, pdf) = environment.sample(u);
        let pdf = pdf * self.environment_chance;
        let start = leave(from.p, from.error, from.ng, wi);
        let shadow = Ray { o: start, d: wi, tmax: f32::INFINITY };
        Some(LightSample { wi, radiance_over_pdf: environment.le(wi) / pdf, pdf, shadow })
    }
}

/// The notes' hint in 13.7 (no grid of directions can meet a point): its own term, I/d².
#[inline(always)]
fn sample_point(from: &Surface, point: &Point, chance: f32) -> Option<LightSample> {
    let to = point.position - from.p;
    let distance_squared = to.length_squared();
    if distance_squared <= 0.0 {
        return None;
    }
    let wi = to * (1.0 / distance_squared.sqrt());
    let start = leave(from.p, from.error, from.ng, wi);
    let shadow = Ray { o: start, d: point.position - start, tmax: 1.0 };
    let radiance_over_pdf = point.intensity / (distance_squared * chance);
    Some(LightSample { wi, radiance_over_pdf, pdf: f32::INFINITY, shadow })
}

/// Parallel light: its irradiance is that of a plane facing it, so f_cos alone weighs it.
#[inline(always)]
fn sample_directional(from: &Surface, light: &Directional, chance: f32) -> LightSample {
    let wi = -light.direction;
    let shadow = Ray { o: leave(from.p, from.error, from.ng, wi), d: wi, tmax: f32::INFINITY };
    LightSample { wi, radiance_over_pdf: light.irradiance / chance, pdf: f32::INFINITY, shadow }
}

#[inline(always)]
fn sample_sphere(from: &Surface, sphere: &Sphere, chance: f32, u: [f32; 2]) -> Option<LightSample> {
    let (wi, pdf, t) = sphere.sample(from.p, u)?;
    let pdf = pdf * chance;
    let start = leave(from.p, from.error, from.ng, wi);
    let shadow = Ray { o: start, d: from.p + wi * t - start, tmax: ALMOST };
    Some(LightSample { wi, radiance_over_pdf: sphere.radiance / pdf, pdf, shadow })
}
