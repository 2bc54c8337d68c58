//! All lights of a scene: one is chosen by what it can mean to the point that is lit, then a direction to it.
//!
//! Lights with a place (emissive triangles, points, spots, spheres) are in a [`LightTree`]; what is infinitely far away is
//! in a short list ([`distant`](super::distant)). Every choice has a probability that can be asked for from the other end,
//! when a ray meets a light by itself.

mod collect;
mod instanced;

use super::distant::{Distant, Distants};
use super::patch::{self, Patch};
use super::single::{sample_directional, sample_point, sample_sphere, sample_spot};
use super::tree::LightTree;
use super::{Emission, Light, LightSample, Openings, Point, Receiver, Sphere, Spot, Sun, reach};
use crate::math::{Rgb, Vec3};
use crate::shape::{Instances, Mesh, Surface};
use instanced::Lamp;
use std::sync::Arc;

/// A light with a place, by its index in the list of its kind.
#[derive(Clone, Copy, Debug)]
enum Emitter {
    Patch { patch: u32, material: u32 },
    Lamp { lamp: u32, triangle: u32, material: u32 },
    Point(u32),
    Spot(u32),
    Sphere(u32),
}

/// Which lights [`Lights::sample`] chooses from, besides those that always deserve it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sampled {
    /// No BSDF samples find lights: environments are sampled as they are, and wherever light comes from.
    pub alone: bool,
    /// Also points, spots and parallel light. False: [`Lights::deltas`] gives them, each for itself.
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

/// The emitters of a mesh's triangles, from the first emissive one to the last.
#[derive(Clone, Debug, Default)]
struct Owners {
    first: u32,
    emitters: Vec<u32>,
}

/// In [`Owners::emitters`]: none.
const NONE: u32 = u32::MAX;

/// All lights of a scene, ready to be sampled.
#[derive(Clone, Debug)]
pub struct Lights {
    emissions: Vec<Emission>,
    patches: Vec<Patch>,
    /// By patch: its mesh and first triangle.
    sources: Vec<[u32; 2]>,
    meshes: Vec<Arc<Mesh>>,
    /// By mesh, then by instance.
    owners: Vec<Owners>,
    /// Instances that shine.
    lamps: Vec<Lamp>,
    /// True when instances shine of which no light samples are taken.
    pub has_unsampled: bool,
    points: Vec<Point>,
    spots: Vec<Spot>,
    /// The spherical lamps, which rays meet besides the meshes.
    pub spheres: Vec<Sphere>,
    /// By spherical lamp.
    sphere_emitter: Vec<u32>,
    distant: Distants,
    emitters: Vec<Emitter>,
    tree: LightTree,
}

impl Lights {
    /// Collects the emissive triangles of `meshes` and of `instances` on their way while the shutter is open (`emissions`
    /// by material id), and the other lights.
    pub fn new(
        meshes: &[Arc<Mesh>],
        (instances, shutter): (&Instances, [f64; 2]),
        emissions: Vec<Emission>,
        others: &[Light],
        sampled: Sampled,
    ) -> Lights {
        let mut lights = Lights {
            emissions,
            patches: Vec::new(),
            sources: Vec::new(),
            meshes: meshes.to_vec(),
            owners: Vec::new(),
            lamps: Vec::new(),
            has_unsampled: false,
            points: Vec::new(),
            spots: Vec::new(),
            spheres: Vec::new(),
            sphere_emitter: Vec::new(),
            distant: Distants::new(others, sampled),
            emitters: Vec::new(),
            tree: LightTree::default(),
        };
        for light in others {
            match light {
                Light::Point(p) => lights.points.push(*p),
                Light::Spot(s) => lights.spots.push(*s),
                Light::Sphere(s) => lights.spheres.push(*s),
                Light::Environment(_) | Light::Sun(_) | Light::Directional(_) => {}
            }
        }
        let mut bounds = Vec::new();
        for (i, mesh) in meshes.iter().enumerate() {
            let owners = lights.collect_patches(i as u32, mesh, &mut bounds);
            lights.owners.push(owners);
        }
        lights.collect_lamps(instances, shutter, instanced::MOST, &mut bounds);
        lights.collect_others(sampled.deltas, &mut bounds);
        lights.tree = LightTree::new(&bounds);
        lights
    }

    /// True when there is nothing to sample.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.emitters.is_empty() && self.distant.is_empty()
    }

    /// True when it would help to know where the sky is seen from.
    pub fn wants_openings(&self) -> bool {
        self.distant.wants_openings()
    }

    /// From now on the sky gets light samples, through `openings`.
    pub fn add_openings(&mut self, openings: Openings) {
        self.distant.add_openings(openings);
    }

    /// True when [`Lights::sample`] chooses between lights, so that its choice needs a number and the receiver's normal.
    #[inline(always)]
    pub fn has_choice(&self) -> bool {
        self.emitters.len() + self.distant.len() > 1
    }

    /// The receiver at `surface`, with its normal packed for rays to carry. Light can come from the side of `wo` alone,
    /// or from `all_around`.
    #[inline(always)]
    pub fn receiver(&self, surface: &Surface, wo: Vec3, all_around: bool) -> (Receiver, u32) {
        let packed = if all_around || !self.has_choice() {
            Receiver::ALL_AROUND
        } else {
            Receiver::pack(surface.ng * 1.0f32.copysign(surface.ng.dot(wo)))
        };
        (Receiver::new(surface.p, packed), packed)
    }

    /// The patch that is all there is to sample, and its emission, where that is the same all over.
    #[inline(always)]
    pub(crate) fn only_patch(&self) -> Option<(&Patch, &Emission)> {
        match self.emitters.as_slice() {
            [Emitter::Patch { patch, material }] if self.distant.is_empty() => {
                let emission = self.emissions.get(*material as usize).filter(|e| !e.varies())?;
                Some((self.patches.get(*patch as usize)?, emission))
            }
            _ => None,
        }
    }

    /// Whether surfaces of that material emit.
    #[inline(always)]
    pub fn emits(&self, material: u32) -> bool {
        self.emissions[material as usize].radiance != Rgb::ZERO
    }

    /// Radiance that the triangle hit at `surface` sends back along `wo`.
    #[inline(always)]
    pub fn emitted(&self, material: u32, surface: &Surface, wo: Vec3) -> Rgb {
        let emission = &self.emissions[material as usize];
        if emission.two_sided || surface.ng.dot(wo) > 0.0 { emission.at(surface.uv) } else { Rgb::ZERO }
    }

    /// True when light samples are taken of the shining triangles of a hit's mesh or instance.
    #[inline(always)]
    pub fn samples(&self, mesh: u32) -> bool {
        (mesh as usize) < self.owners.len()
    }

    /// Density per solid angle with which [`Lights::sample`] would have chosen, at `from` and at `time`, the point `surface`
    /// that a ray met at distance `t` on a triangle of a mesh or instance.
    #[inline(always)]
    pub fn pdf_of_hit(
        &self,
        from: &Receiver,
        [mesh, triangle]: [u32; 2],
        surface: &Surface,
        wo: Vec3,
        t: f32,
        time: f32,
    ) -> f32 {
        let Some(owners) = self.owners.get(mesh as usize) else { return 0.0 };
        let Some(&emitter) = owners.emitters.get(triangle.wrapping_sub(owners.first) as usize) else {
            return 0.0;
        };
        match self.emitters.get(emitter as usize) {
            Some(Emitter::Patch { patch, .. }) => {
                let pdf = self.patches[*patch as usize].pdf(from.p, t * t, surface.ng.dot(wo).abs());
                self.chance(emitter, from) * pdf
            }
            Some(Emitter::Lamp { lamp, triangle, .. }) => {
                let cos = surface.ng.dot(wo).abs();
                self.chance(emitter, from) * self.pdf_of_lamp([*lamp, *triangle], from.p, time, t * t, cos)
            }
            _ => 0.0,
        }
    }

    /// Probability of choosing an emitter.
    #[inline(always)]
    fn chance(&self, emitter: u32, from: &Receiver) -> f32 {
        if !self.has_choice() {
            return 1.0;
        }
        self.distant.share_of_others(&self.tree, from) * self.tree.probability(emitter, from)
    }

    /// Tells `found` the radiance of everything at the end of a ray from `o` along `d` that meets no mesh, each with the
    /// density per solid angle with which [`Lights::sample`] would have chosen that direction; `normal` is the packed one
    /// of where the ray started.
    #[inline(always)]
    pub fn at_end(&self, end: End, o: Vec3, d: Vec3, normal: u32, mut found: impl FnMut(Rgb, f32)) {
        match end {
            End::Sky => self.distant.at_end(&self.tree, &Receiver::new(o, normal), d, found),
            End::Sphere(i) => {
                let sphere = &self.spheres[i as usize];
                let pdf = sphere.pdf(o);
                // Seen from inside it is black.
                if pdf > 0.0 {
                    let chance = self.chance(self.sphere_emitter[i as usize], &Receiver::new(o, normal));
                    found(sphere.radiance, chance * pdf);
                }
            }
        }
    }

    /// Every light that no ray can meet: points, spots and parallel light, as the notes' 13.7 hints at them (no grid of
    /// directions finds one).
    #[inline]
    pub fn deltas<'a>(&'a self, from: &'a Surface) -> impl Iterator<Item = LightSample> + 'a {
        let points = self.points.iter().filter_map(|p| sample_point(from, p.position, 1.0, |_| p.intensity));
        let spots = self.spots.iter().filter_map(|s| sample_spot(from, s, 1.0));
        points.chain(spots).chain(self.distant.directionals.iter().map(|d| sample_directional(from, d, 1.0)))
    }

    /// One light and one direction to it from `surface`, whose receiver is `from`. `choice`: 32 uniform bits; `time`: 0 as
    /// the shutter opens, 1 as it closes; `u`: where on the light.
    #[inline(always)]
    pub fn sample(
        &self,
        surface: &Surface,
        from: &Receiver,
        choice: u32,
        time: f32,
        u: [f32; 2],
    ) -> Option<LightSample> {
        let (emitter, chance) = if self.has_choice() {
            // The hash fills the digits that 32 bits leave open: a tree has as many as its depth of choices to make.
            let below = f64::from(choice.wrapping_mul(0x9e37_79b9)) / 4_294_967_296.0;
            let number = (f64::from(choice) + below) / 4_294_967_296.0;
            match self.distant.choose(&self.tree, from, number)? {
                (None, share, rest) => {
                    let (emitter, chance) = self.tree.sample(from, rest)?;
                    (emitter, share * chance)
                }
                (Some(distant), chance, _) => return self.sample_distant(surface, distant, chance, u),
            }
        } else if let Some(distant) = self.distant.only() {
            return self.sample_distant(surface, distant, 1.0, u);
        } else {
            (0, 1.0)
        };
        match *self.emitters.get(emitter as usize)? {
            Emitter::Patch { patch, material } => self.sample_patch(surface, patch, material, chance, u),
            Emitter::Lamp { lamp, triangle, material } => {
                self.sample_lamp(surface, [lamp, triangle, material], chance, time, u)
            }
            Emitter::Point(i) => {
                let point = &self.points[i as usize];
                sample_point(surface, point.position, chance, |_| point.intensity)
            }
            Emitter::Spot(i) => sample_spot(surface, &self.spots[i as usize], chance),
            Emitter::Sphere(i) => sample_sphere(surface, &self.spheres[i as usize], chance, u),
        }
    }

    #[inline(always)]
    fn sample_patch(
        &self,
        from: &Surface,
        index: u32,
        material: u32,
        chance: f32,
        u: [f32; 2],
    ) -> Option<LightSample> {
        let patch = &self.patches[index as usize];
        let point = patch.sample(from.p, u);
        let emission = &self.emissions[material as usize];
        let mut radiance = emission.radiance;
        if emission.varies() {
            let [mesh, triangle] = self.sources[index as usize];
            radiance = emission.there(self.meshes[mesh as usize].uv_at(triangle as usize, point.p));
        }
        patch::light_sample(from, &point, (radiance, emission.two_sided), patch.sampled_area(), chance)
    }

    #[inline(always)]
    fn sample_distant(
        &self,
        from: &Surface,
        light: Distant,
        chance: f32,
        u: [f32; 2],
    ) -> Option<LightSample> {
        let (wi, pdf, radiance) = match light {
            Distant::Directional(i) => {
                return Some(sample_directional(from, &self.distant.directionals[i as usize], chance));
            }
            Distant::Sun(i) => {
                let sun: &Sun = &self.distant.suns[i as usize];
                (sun.sample(u), 1.0 / sun.solid_angle(), sun.radiance)
            }
            Distant::Environment => self.distant.sample_environment(from.p, u)?,
        };
        let pdf = pdf * chance;
        if !(pdf > 0.0 && pdf.is_finite()) {
            return None;
        }
        Some(LightSample { wi, radiance_over_pdf: radiance / pdf, pdf, shadow: reach::to_infinity(from, wi) })
    }
}
