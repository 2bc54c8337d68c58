//! What every vertex may look at, prepared once a picture.

use super::explore::explore;
use crate::accel::Intersector;
use crate::bsdf::Material;
use crate::camera::Camera;
use crate::error::Result;
use crate::film::PixelPoints;
use crate::film::filter::FilterSampler;
use crate::light::{Emission, Lights, Sampled};
use crate::quadrature::hemisphere::HemisphereRule;
use crate::sampler::{Key, Sampler, SamplerKind, Splits, scatter};
use crate::scene::{IntegratorKind, LightSampling, Scene, Settings};
use crate::shape::{Instances, Mesh};
use std::sync::Arc;

/// The scene and the tables of one picture.
#[derive(Debug)]
pub struct Context<'a> {
    /// The meshes at rest that hits name.
    pub meshes: &'a [Arc<Mesh>],
    /// The instances that hits name after them.
    pub instances: &'a Instances,
    /// When the shutter opens and closes.
    pub shutter: [f64; 2],
    /// True when the picture depends on the samples' times.
    pub moves: bool,
    /// The materials that faces name.
    pub materials: &'a [Material],
    /// All lights.
    pub lights: Lights,
    /// The camera.
    pub camera: Camera,
    /// Places in the pixel.
    pub pixel: PixelPoints,
    /// Draws numbers.
    pub sampler: Sampler,
    /// Draws independent numbers, for the rules that ask for them.
    pub random: Sampler,
    /// Which number is used for what.
    pub dimensions: Dimensions,
    /// Into how many paths samples split at their first hit, unless that is a mirror or clear glass; of path tracing.
    ///
    /// A camera ray and what it hits are then paid once for several paths (Arvo and Kirk 1990), whose numbers come from one
    /// well-distributed set: on the Cornell box two paths take 57 % of the error away and cost 66 % more time. What a sample
    /// decides before it splits (pixel, lens, time) gains nothing.
    pub splits: Splits,
    /// True when each path of a sample that splits takes a light sample of its own.
    pub splits_light_samples: bool,
    /// True when vertices take light samples.
    pub samples_lights: bool,
    /// True when a BSDF of the scene chooses between lobes.
    pub has_lobes: bool,
    /// True when a material of the scene is a mixture of others.
    pub has_mixes: bool,
    /// True when a material of the scene changes over its surface.
    pub has_maps: bool,
    /// True when a surface of the scene has holes.
    pub has_cutouts: bool,
    /// What the brightest channel of a sample is clamped to; infinite where nothing is.
    pub brightest: f64,
    /// Width and height of the full picture.
    pub size: [u32; 2],
}

impl<'a> Context<'a> {
    /// Prepares `scene` for a picture as `settings` say.
    ///
    /// # Errors
    /// A camera that cannot be, or a grid of pixel points without a weight.
    pub fn new(scene: &'a Scene, settings: &Settings) -> Result<Context<'a>> {
        let emission = |m: &Material| Emission {
            radiance: m.emission,
            two_sided: m.two_sided,
            texture: m.maps.as_ref().and_then(|maps| maps.emission.clone()).map(Box::new),
            opacity: m.maps.as_ref().and_then(|maps| maps.opacity.clone()).map(Box::new),
        };
        let lights = Lights::new(
            &scene.meshes,
            (&scene.instances, scene.camera.shutter),
            scene.materials.iter().map(emission).collect(),
            &scene.lights,
            Sampled {
                alone: settings.lights == LightSampling::Light,
                deltas: !matches!(settings.integrator, IntegratorKind::Distribution { .. }),
            },
        );
        let camera = Camera::new(&scene.camera, scene.origin)?;
        // A picture can give a model lobes that its constants have not.
        let changes = |m: &Material| m.maps.as_ref().is_some_and(|maps| !maps.parameters.is_empty());
        let has_lobes = scene.materials.iter().any(|m| m.bsdf.has_lobes() || changes(m));
        let has_cutouts =
            scene.materials.iter().any(|m| m.maps.as_ref().is_some_and(|maps| maps.opacity.is_some()));
        let lit = match settings.integrator {
            IntegratorKind::Path | IntegratorKind::Direct => true,
            IntegratorKind::Distribution { rule, .. } => rule == HemisphereRule::Importance,
            IntegratorKind::Ao { .. } | IntegratorKind::Normals => false,
        };
        let mut cx = Context {
            meshes: &scene.meshes,
            instances: &scene.instances,
            shutter: scene.camera.shutter,
            moves: scene.moves(),
            materials: &scene.materials,
            dimensions: Dimensions::new(camera.has_lens(), scene.moves(), has_lobes, None),
            lights,
            splits: settings.splits(scene),
            splits_light_samples: false,
            camera,
            pixel: PixelPoints::new(settings.rule, FilterSampler::new(settings.filter))?,
            sampler: Sampler::new(settings.sampler, settings.seed, settings.spp),
            random: Sampler::new(SamplerKind::Random, settings.seed, settings.spp),
            samples_lights: false,
            has_lobes,
            has_mixes: scene.materials.iter().any(|m| m.mix.is_some()),
            has_maps: scene.materials.iter().any(|m| m.maps.is_some()),
            has_cutouts,
            brightest: settings.clamp.map_or(f64::INFINITY, f64::from),
            size: settings.size,
        };
        cx.plan_light_samples(lit);
        Ok(cx)
    }

    /// Decides all that depends on which lights there are to sample; `lit`: whether vertices sample any.
    fn plan_light_samples(&mut self, lit: bool) {
        self.samples_lights = lit && !self.lights.is_empty();
        // One lamp is sampled so well that the first hit's shadows are the least of a picture's errors.
        self.splits_light_samples = self.lights.only_patch().is_none();
        let choice = self.samples_lights.then(|| self.lights.has_choice());
        self.dimensions = Dimensions::new(self.camera.has_lens(), self.moves, self.has_lobes, choice);
    }

    /// Looks where the sky is seen from, and takes light samples of it from now on, where that is worth it: a constant
    /// sky indoors. Not where something moves or is an instance.
    pub fn look_out(
        &mut self,
        settings: &Settings,
        accel: &dyn Intersector,
        stop: &(dyn Fn() -> bool + Sync),
    ) {
        let traced = matches!(settings.integrator, IntegratorKind::Path | IntegratorKind::Direct);
        let stands = !self.moves && self.instances.places.is_empty();
        if !(traced && stands && settings.lights == LightSampling::Mis && self.lights.wants_openings()) {
            return;
        }
        if let Some(openings) = explore(self, accel, stop) {
            self.lights.add_openings(openings);
            self.plan_light_samples(true);
        }
    }

    /// Where branch `branch` of a sample takes its numbers from: each of those from 1 has its own, 0 those of the sample.
    #[inline(always)]
    pub fn branched(&self, key: Key, branch: u32) -> Key {
        if branch == 0 { key } else { self.sampler.node(key, self.splits.number(key.index, branch)) }
    }

    /// The material that scatters where a ray meets `material`: of a mixture the part that a number of the sample
    /// chooses, the same for every part of the program that asks.
    #[inline(always)]
    pub fn part(&self, material: u32, key: Key, depth: u32, branch: u32) -> u32 {
        let mut part = material;
        // Parts come before what they are mixed to, so this ends.
        while self.has_mixes
            && let Some(mix) = self.materials[part as usize].mix
        {
            let place = scatter(part ^ scatter(branch ^ scatter(depth)));
            let second = self.sampler.d1(key, Dimensions::MIX | (place >> 3)) < mix.amount;
            part = mix.parts[usize::from(second)];
        }
        part
    }

    /// False on the black side of a one-sided material; `outside`: on the side that `ng` points to.
    #[inline(always)]
    pub fn scatters(&self, material: u32, outside: bool) -> bool {
        outside || self.materials[material as usize].two_sided
    }
}

/// Which dimension of a sample decides what. Only decisions that the picture can need get one of the first
/// dimensions, which are the best distributed.
#[derive(Clone, Copy, Debug)]
pub struct Dimensions {
    /// One: when the sample is taken, where something moves.
    pub time: u32,
    first: u32,
    stride: u32,
    lobes: u32,
}

/// The dimensions of one vertex.
#[derive(Clone, Copy, Debug)]
pub struct VertexDimensions {
    /// Two: the scattered direction.
    pub bsdf: u32,
    /// One: which lobe.
    pub lobe: u32,
    /// Two: the place on the light.
    pub light: u32,
    /// One: which light.
    pub choice: u32,
    /// One: whether the path goes on.
    pub roulette: u32,
}

impl Dimensions {
    /// Two: the place in the pixel.
    pub const PIXEL: u32 = 0;
    /// Two: the place on the lens.
    pub const LENS: u32 = 2;
    /// Roulette's dimensions begin here, out of the way of the others.
    const ROULETTE: u32 = 1 << 20;
    /// Whether a hit of a surface with holes counts: one a triangle and place on the path, scattered over 30 bits.
    pub const CUTOUT: u32 = 1 << 30;
    /// Whose part of a mixture is met; the place among them is hashed.
    const MIX: u32 = 1 << 29;

    /// `lights`: whether they are sampled, and then whether there is a choice among them.
    fn new(lens: bool, moves: bool, lobes: bool, lights: Option<bool>) -> Dimensions {
        let lobes = u32::from(lobes);
        let lights = lights.map_or(0, |choice| 2 + u32::from(choice));
        let time = if lens { 4 } else { 2 };
        Dimensions { time, first: time + u32::from(moves), stride: 2 + lobes + lights, lobes }
    }

    /// The dimensions of the vertex that is reached after `depth` scattering events.
    #[inline(always)]
    pub fn at(&self, depth: u32) -> VertexDimensions {
        let base = self.first + self.stride * depth;
        let light = base + 2 + self.lobes;
        VertexDimensions {
            bsdf: base,
            lobe: base + 2,
            light,
            choice: light + 2,
            roulette: Self::ROULETTE + depth,
        }
    }
}
