//! All lights of a scene, chosen by power.

use super::{Environment, Light, Point};
use crate::math::distribution::AliasTable;
use crate::math::ray::{Ray, leave};
use crate::math::{Rgb, Vec2, Vec3, luminance, warp};
use crate::shape::{Mesh, Surface};
use std::f64::consts::PI;
use std::sync::Arc;

/// What a material emits.
#[derive(Clone, Copy, Debug)]
pub struct Emission {
    /// Radiance, the same in all directions.
    pub radiance: Rgb,
    /// True: from both sides; false: from the side `ng` points to.
    pub two_sided: bool,
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
    Environment,
}

/// All lights of a scene, ready to be sampled.
#[derive(Clone, Debug)]
pub struct Lights {
    meshes: Vec<Arc<Mesh>>,
    emissions: Vec<Emission>,
    /// The environment that rays meet which hit nothing.
    pub environment: Option<Environment>,
    points: Vec<Point>,
    entries: Vec<Entry>,
    table: AliasTable,
    /// By entry, for points and the environment: the probability of being chosen.
    chance: Vec<f32>,
    /// By material: density per area with which [`Lights::sample`] chooses a point of such a triangle. The
    /// triangle's power is its area times a constant of the material, so the area cancels.
    density: Vec<f32>,
    environment_chance: f32,
}

impl Lights {
    /// Collects the emissive triangles of `meshes` (`emissions` by material id) and the other lights.
    /// `sample_all`: give samples also to an environment that BSDF sampling finds as well.
    /// `radius`: of a sphere around the scene, in metres, to weigh the environment against the rest.
    pub fn new(
        meshes: &[Arc<Mesh>],
        emissions: Vec<Emission>,
        others: &[Light],
        radius: f32,
        sample_all: bool,
    ) -> Lights {
        let mut lights = Lights {
            meshes: meshes.to_vec(),
            environment: others.iter().find_map(|l| match l {
                Light::Environment(e) => Some(*e),
                Light::Point(_) => None,
            }),
            points: others
                .iter()
                .filter_map(|l| if let Light::Point(p) = l { Some(*p) } else { None })
                .collect(),
            density: vec![0.0; emissions.len()],
            emissions,
            entries: Vec::new(),
            table: AliasTable::default(),
            chance: Vec::new(),
            environment_chance: 0.0,
        };
        let mut powers = Vec::new();
        lights.collect_triangles(&mut powers);
        for (i, point) in lights.points.iter().enumerate() {
            lights.entries.push(Entry::Point(i as u32));
            powers.push(4.0 * PI * f64::from(luminance(point.intensity)));
        }
        if let Some(environment) = lights.environment.filter(|e| sample_all || e.deserves_samples()) {
            let disk = PI * f64::from(radius.max(1e-3)).powi(2);
            lights.entries.push(Entry::Environment);
            powers.push(4.0 * PI * disk * f64::from(luminance(environment.average())));
        }
        lights.weigh(&powers);
        lights
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
        if emission.two_sided || surface.ng.dot(wo) > 0.0 { emission.radiance } else { Rgb::ZERO }
    }

    /// Density per solid angle with which [`Lights::sample`] would have chosen the point that a ray met at
    /// distance `t` on an emissive triangle of `material`.
    #[inline(always)]
    pub fn pdf_of_hit(&self, material: u32, surface: &Surface, wo: Vec3, t: f32) -> f32 {
        self.density[material as usize] * t * t / surface.ng.dot(wo).abs()
    }

    /// Density per solid angle with which [`Lights::sample`] would have chosen the environment's direction `d`.
    #[inline(always)]
    pub fn pdf_of_miss(&self, d: Vec3) -> f32 {
        match &self.environment {
            Some(environment) if self.environment_chance > 0.0 => {
                self.environment_chance * environment.pdf(d)
            }
            _ => 0.0,
        }
    }

    /// One light and one direction to it. `choice`: 32 uniform bits; `u`: where on the light.
    #[inline(always)]
    pub fn sample(&self, from: &Surface, choice: u32, u: [f32; 2]) -> Option<LightSample> {
        let entry = self.table.sample(choice)?;
        match self.entries[entry] {
            Entry::Triangle { mesh, triangle } => self.sample_triangle(from, mesh, triangle, u),
            Entry::Point(i) => sample_point(from, &self.points[i as usize], self.chance[entry]),
            Entry::Environment => self.sample_environment(from, u),
        }
    }

    #[inline(always)]
    fn sample_triangle(&self, from: &Surface, mesh: u32, triangle: u32, u: [f32; 2]) -> Option<LightSample> {
        let mesh = &self.meshes[mesh as usize];
        let material = mesh.materials.get(triangle as usize);
        let [b1, b2] = warp::triangle(u);
        let light = emitter_point(mesh, triangle, b1, b2);
        let to = light.p - from.p;
        let distance_squared = to.length_squared();
        if distance_squared <= 0.0 {
            return None;
        }
        let wi = to * (1.0 / distance_squared.sqrt());
        let radiance = self.emitted(material, &light, -wi);
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

/// A point on an emitter; texture coordinates and shading normals play no part in emission.
#[inline(always)]
fn emitter_point(mesh: &Mesh, triangle: u32, u: f32, v: f32) -> Surface {
    let mut surface = Surface::new(mesh, triangle, u, v);
    surface.uv = Vec2::ZERO;
    surface
}
