//! How a scene is rendered. Every field is a key of the scene file's `[film]` or `[render]`, and all of it
//! goes into the picture's `drt` attribute.

use super::{Directions, Scene};
use crate::accel::{Backend, Quality};
use crate::error::{Result, lookup, name_in};
use crate::film::{Aov, Filter, PixelRule};
use crate::quadrature::hemisphere::HemisphereRule;
use crate::sampler::{SamplerKind, Splits};

/// What is computed along the rays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum IntegratorKind {
    /// Path tracing: everything that light does.
    Path,
    /// Emitted and direct light only: `path` with `max_depth` at most 1.
    Direct,
    /// Ambient occlusion: the cosine-weighted share of the hemisphere that is free.
    Ao {
        /// How far an occluder counts, in metres; infinite by default.
        distance: f32,
    },
    /// The shading normal as a colour, (n+1)/2.
    Normals,
    /// The notes' distribution ray tracer (13.9): N directions at every hit, each followed.
    Distribution {
        /// How the directions are chosen.
        rule: HemisphereRule,
        /// How many, by depth.
        directions: Directions,
    },
}

/// What a pixel holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// The mean radiance over the pixel.
    Radiance,
    /// The notes' flux Φ of eq. (6) and (11): the mean times the pixel's area |Δi·Δj| on the image plane.
    Flux,
}

impl Quantity {
    /// Name, meaning, value.
    pub const TABLE: &'static [(&'static str, &'static str, Quantity)] = &[
        ("radiance", "the mean radiance over the pixel", Quantity::Radiance),
        ("flux", "the mean times the pixel's area on the image plane, (6) and (11)", Quantity::Flux),
    ];

    /// The quantity of that name.
    ///
    /// # Errors
    /// A word that is none.
    pub fn from_name(word: &str) -> Result<Self> {
        lookup("quantity", word, Self::TABLE)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        name_in(&self, Self::TABLE)
    }
}

/// Which sampling finds the lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LightSampling {
    /// Light and BSDF sampling, combined by multiple importance sampling; lights that BSDF sampling finds
    /// as well by itself (a constant environment, unless it is seen through openings) get no light samples.
    Mis,
    /// Light sampling alone; only mirrors find lights by their own direction.
    Light,
    /// BSDF sampling alone; lights that cannot be hit (points) keep their own term.
    Bsdf,
}

/// How much work goes into the acceleration structure.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BuildQuality {
    /// Chosen from the triangle count and the number of samples.
    Auto,
    /// As said.
    Fixed(Quality),
}

impl IntegratorKind {
    /// Name, meaning, value with its usual parameters.
    pub const TABLE: &'static [(&'static str, &'static str, IntegratorKind)] = &[
        ("path", "path tracing: everything that light does", IntegratorKind::Path),
        ("direct", "emitted and direct light only", IntegratorKind::Direct),
        (
            "ao",
            "ambient occlusion: the free share of the hemisphere",
            IntegratorKind::Ao { distance: f32::INFINITY },
        ),
        ("normals", "shading normals as colours", IntegratorKind::Normals),
        (
            "distribution",
            "the notes' distRtShade: N directions at every hit, by a rule of integration",
            IntegratorKind::Distribution { rule: HemisphereRule::Importance, directions: Directions::USUAL },
        ),
    ];

    /// The integrator of that name.
    pub fn from_name(word: &str) -> Result<Self> {
        lookup("integrator", word, Self::TABLE)
    }

    /// Its name.
    pub fn name(&self) -> &'static str {
        match self {
            IntegratorKind::Path => "path",
            IntegratorKind::Direct => "direct",
            IntegratorKind::Ao { .. } => "ao",
            IntegratorKind::Normals => "normals",
            IntegratorKind::Distribution { .. } => "distribution",
        }
    }
}

impl LightSampling {
    /// Name, meaning, value.
    pub const TABLE: &'static [(&'static str, &'static str, LightSampling)] = &[
        ("mis", "light and BSDF sampling combined", LightSampling::Mis),
        ("light", "light sampling alone", LightSampling::Light),
        ("bsdf", "BSDF sampling alone", LightSampling::Bsdf),
    ];

    /// The strategy of that name.
    pub fn from_name(word: &str) -> Result<Self> {
        lookup("light sampling", word, Self::TABLE)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        name_in(&self, Self::TABLE)
    }
}

/// With more samples a pixel a picture is no preview.
const PREVIEW_SPP: u32 = 16;

impl BuildQuality {
    /// Name, meaning, value.
    pub const TABLE: &'static [(&'static str, &'static str, BuildQuality)] = &[
        ("auto", "low for previews of large meshes, else medium", BuildQuality::Auto),
        ("low", "fast to build", BuildQuality::Fixed(Quality::Low)),
        ("medium", "the ordinary one", BuildQuality::Fixed(Quality::Medium)),
        ("high", "slow to build", BuildQuality::Fixed(Quality::High)),
    ];

    /// The quality of that name.
    pub fn from_name(word: &str) -> Result<Self> {
        lookup("build quality", word, Self::TABLE)
    }

    /// The quality for a picture of `samples` samples, `spp` a pixel, over `triangles`.
    ///
    /// A low-quality structure is built faster and traced more slowly, so it wins for previews of many triangles: up to 16
    /// samples a pixel, and fewer a triangle than [`Backend::low_below`] says.
    pub fn resolve(self, backend: Backend, triangles: u64, samples: u64, spp: u32) -> Quality {
        match self {
            BuildQuality::Fixed(quality) => quality,
            BuildQuality::Auto
                if spp <= PREVIEW_SPP
                    && triangles > 100_000
                    && samples / backend.low_below() < triangles / 2 =>
            {
                Quality::Low
            }
            BuildQuality::Auto => Quality::Medium,
        }
    }
}

/// Whether the acceleration structure is to be small.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Compact {
    /// No: a build that does not fit into the memory is refused.
    No,
    /// Yes.
    Yes,
    /// Where the usual layout would not fit into the memory that is free. Hits at edges may then depend on that
    /// (the picture says which layout was taken), so it is for who asks.
    Auto,
}

impl Compact {
    /// Whether to build the compact layout; `is_short` says that the usual one does not fit.
    pub fn resolve(self, is_short: impl FnOnce() -> bool) -> bool {
        match self {
            Compact::No => false,
            Compact::Yes => true,
            Compact::Auto => is_short(),
        }
    }
}

/// How a scene is rendered.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// The part of the picture that is rendered: x, y, width, height; `None`: all of it.
    pub crop: Option<[u32; 4]>,
    /// Pixel filter.
    pub filter: Filter,
    /// How the points of a pixel are chosen. A grid settles [`Settings::spp`].
    pub rule: PixelRule,
    /// What a pixel holds.
    pub quantity: Quantity,
    /// The most that the brightest channel of one sample may bring; brighter samples are scaled down to it, which takes
    /// fireflies and truth alike. `None`: nothing is clamped.
    pub clamp: Option<f32>,
    /// Layers of the first hit.
    pub aovs: Vec<Aov>,
    /// What is computed.
    pub integrator: IntegratorKind,
    /// Which sampling finds the lights.
    pub lights: LightSampling,
    /// Russian roulette, unbiased, from the third scattering on.
    pub roulette: bool,
    /// Into how many paths a sample splits at its first hit, 1 to [`Settings::MOST_SPLITS`]; `None`: chosen by
    /// [`Settings::splits`]. Of the integrators `path` and `direct`.
    pub split: Option<u32>,
    /// Samples a pixel.
    pub spp: u32,
    /// Scattering events at most.
    pub max_depth: u32,
    /// Seed of all random choices.
    pub seed: u64,
    /// Where the numbers come from.
    pub sampler: SamplerKind,
    /// Who intersects.
    pub backend: Backend,
    /// Effort of the acceleration structure.
    pub build: BuildQuality,
    /// Less memory, slower rays.
    pub compact: Compact,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            size: [640, 480],
            crop: None,
            filter: Filter::Box { radius: 0.5 },
            rule: PixelRule::Sampler,
            quantity: Quantity::Radiance,
            clamp: None,
            aovs: Vec::new(),
            integrator: IntegratorKind::Path,
            lights: LightSampling::Mis,
            roulette: true,
            split: None,
            spp: 64,
            max_depth: 16,
            seed: 0,
            sampler: SamplerKind::Sobol,
            backend: Backend::ALL[0],
            build: BuildQuality::Auto,
            compact: Compact::No,
        }
    }
}

impl Settings {
    /// The most paths into which a sample can split.
    pub const MOST_SPLITS: u32 = 64;

    /// The quality of the structure over so many triangles.
    pub fn quality(&self, triangles: u64) -> Quality {
        let samples =
            self.size.iter().fold(u64::from(self.spp), |n, side| n.saturating_mul(u64::from(*side)));
        self.build.resolve(self.backend, triangles, samples, self.spp)
    }

    /// Into how many paths samples split at their first hit.
    ///
    /// Unless it is said, into eight where next to all noise comes from behind it: below a sky or by a single lamp. Into two
    /// where pictures and the edges of lamps vary over the pixel, or points and strata are as many as samples. Into one
    /// where a lens or motion brings noise of its own: there only more samples help. Twice the paths take twice the time,
    /// and from four to eight well-distributed ones 2.2 to 2.4 times the variance away (`docs/performance.md`).
    pub fn splits(&self, scene: &Scene) -> Splits {
        let varies = || scene.materials.iter().any(|m| m.maps.is_some()) || scene.has_lamps();
        let fixed = || self.rule.grid().is_some() || self.sampler == SamplerKind::Stratified;
        match (self.integrator, self.split) {
            (IntegratorKind::Path | IntegratorKind::Direct, Some(said)) => Splits::Each(said),
            (IntegratorKind::Path | IntegratorKind::Direct, None) => {
                match scene.camera.aperture.radius > 0.0 || scene.moves() {
                    true => Splits::Each(1),
                    false if fixed() || varies() => Splits::Each(2),
                    false => Splits::Later(8),
                }
            }
            _ => Splits::Each(1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn automatic_builds_are_low_for_previews_of_large_meshes_only() {
        for (backend, at_most) in
            Backend::ALL.iter().map(|b| (*b, if *b == Backend::Bvh { 1.5 } else { 4.0 }))
        {
            let auto = |triangles, samples, spp| BuildQuality::Auto.resolve(backend, triangles, samples, spp);
            let samples = |share: f64| (share * at_most * 5e6) as u64;
            assert_eq!(auto(5_000_000, samples(0.99), 16), Quality::Low);
            assert_eq!(auto(5_000_000, samples(1.01), 16), Quality::Medium);
            assert_eq!(auto(5_000_000, samples(0.99), 17), Quality::Medium);
            // A small mesh is built in no time at all; nothing overflows.
            assert_eq!(auto(100_000, 1, 1), Quality::Medium);
            assert_eq!(auto(u64::MAX, u64::MAX, 1), Quality::Low);
            for quality in [Quality::Low, Quality::High, Quality::Medium] {
                assert_eq!(BuildQuality::Fixed(quality).resolve(backend, 5_000_000, 1_000_000, 1), quality);
            }
        }
        let settings = Settings { size: [1 << 14, 1 << 14], spp: u32::MAX, ..Settings::default() };
        assert_eq!(settings.quality(5_000_000), Quality::Medium);
        assert_eq!(Settings { size: [640, 480], spp: 4, ..settings }.quality(871_264), Quality::Low);
    }

    #[test]
    fn compact_structures_are_for_who_asks() {
        assert_eq!(Settings::default().compact, Compact::No);
        assert!(!Compact::No.resolve(|| true) && Compact::Yes.resolve(|| false));
        assert!(Compact::Auto.resolve(|| true) && !Compact::Auto.resolve(|| false));
    }
}
