//! What a study of a scene varies, and the rules that it compares: one line a rule.

use crate::error::{Result, lookup};
use crate::film::PixelRule;
use crate::film::rule::Grid;
use crate::quadrature::hemisphere::{Cells, HemisphereRule, Measure};
use crate::sampler::SamplerKind;
use crate::scene::{Directions, IntegratorKind, LightSampling, Settings};

/// A rule of a scene: what it does to the settings for N samples.
pub struct PictureRule {
    /// Its name, as in `--rules`.
    pub name: &'static str,
    /// One line about it, with the notes' equation.
    pub meaning: &'static str,
    /// False where the seed changes nothing.
    pub is_random: bool,
    /// Asks for N samples by this rule.
    pub set: fn(&mut Settings, u32),
}

/// What a study of a scene varies.
pub struct Subject {
    /// Its name, as in `--vary`.
    pub name: &'static str,
    /// What is estimated, for captions.
    pub meaning: &'static str,
    /// Where the camera rays go, for captions.
    pub points: &'static str,
    /// What N counts.
    pub samples: &'static str,
    /// The rules that are compared.
    pub rules: &'static [PictureRule],
    /// True when pixels are seen at their centres alone.
    pub is_of_centres: bool,
    /// `max_depth` where nobody asks for one; `None`: the scene's.
    pub max_depth: Option<&'static str>,
    /// Makes settings with their samples a pixel those of the reference.
    pub(super) reference: fn(&mut Settings),
}

const fn rule(
    name: &'static str,
    meaning: &'static str,
    is_random: bool,
    set: fn(&mut Settings, u32),
) -> PictureRule {
    PictureRule { name, meaning, is_random, set }
}

/// N directions at the first hit, seen from the centres of the pixels, and one direction at every deeper hit.
fn directions(s: &mut Settings, rule: HemisphereRule, n: u32) {
    let directions = Directions::new(&[Cells::of(n), Cells::of(1)]).unwrap_or(Directions::USUAL);
    s.integrator = IntegratorKind::Distribution { rule, directions };
    centres(s, 1);
}

/// `spp` samples through the centre of every pixel.
fn centres(s: &mut Settings, spp: u32) {
    s.rule = PixelRule::Uniform(Grid { cells: [1, 1], per_cell: spp });
    s.spp = spp;
}

fn importance(s: &mut Settings, lights: LightSampling, n: u32) {
    s.lights = lights;
    directions(s, HemisphereRule::Importance, n);
}

const ANGLES: Measure = Measure::Angles;

/// How the directions over a surface are chosen (13.5–13.8).
static HEMISPHERE: Subject = Subject {
    name: "hemisphere",
    meaning: "light over the hemisphere at the pixels' centres",
    points: "through each pixel's centre",
    samples: "directions at the first hit N",
    rules: &[
        rule("uniform", "a grid of midpoints in theta and phi (18)", false, |s, n| {
            directions(s, HemisphereRule::Uniform, n);
        }),
        rule("uniform-corner", "the grid of left edges (16)-(18)", false, |s, n| {
            directions(s, HemisphereRule::UniformCorner, n);
        }),
        rule("random", "independent random angles (10)", true, |s, n| {
            directions(s, HemisphereRule::Random { measure: ANGLES }, n);
        }),
        rule("stratified", "a random direction in each of N cells (13.6)", true, |s, n| {
            directions(s, HemisphereRule::Stratified { measure: ANGLES, per_cell: 1 }, n);
        }),
        rule("nonuniform", "N cells of equal projected solid angle (19)", false, |s, n| {
            directions(s, HemisphereRule::Nonuniform { per_cell: 0 }, n);
        }),
        rule("nonuniform-random", "a random direction in each of those (13.7)", true, |s, n| {
            directions(s, HemisphereRule::Nonuniform { per_cell: 1 }, n);
        }),
        rule("importance-bsdf", "the BSDF's density (20)", true, |s, n| {
            importance(s, LightSampling::Bsdf, n);
        }),
        rule("importance-light", "the lights' density (20)", true, |s, n| {
            importance(s, LightSampling::Light, n);
        }),
        rule("importance", "both densities, multiple importance sampling", true, |s, n| {
            importance(s, LightSampling::Mis, n);
        }),
        rule("sobol", "scrambled Sobol angles", true, |s, n| {
            directions(s, HemisphereRule::Sobol { measure: ANGLES }, n);
        }),
    ],
    is_of_centres: true,
    max_depth: Some("1"),
    reference: |s| {
        (s.integrator, s.sampler, s.lights) = (IntegratorKind::Path, SamplerKind::Sobol, LightSampling::Mis);
        centres(s, s.spp);
    },
};

/// N points of the grid rule `rule` in each pixel; what else a sample needs is random.
fn points(s: &mut Settings, rule: PixelRule, n: u32) {
    // Wider than high where it cannot be square.
    let Cells { theta: rows, phi: columns } = Cells::of(n);
    s.rule = rule.over(Grid { cells: [columns, rows], per_cell: 0 });
    (s.sampler, s.spp) = (SamplerKind::Random, n);
}

const CELL: Grid = Grid { cells: [1, 1], per_cell: 0 };

/// How the points of a pixel are chosen (13.4): N of them in each.
static PIXEL: Subject = Subject {
    name: "pixel",
    meaning: "light over the pixel",
    points: "a pixel",
    samples: "points of a pixel N",
    rules: &[
        rule("uniform", "a grid of midpoints (14)", true, |s, n| points(s, PixelRule::Uniform(CELL), n)),
        rule("uniform-corner", "the grid of left edges (12)-(14)", true, |s, n| {
            points(s, PixelRule::UniformCorner(CELL), n);
        }),
        rule("random", "independent random points (11)", true, |s, n| points(s, PixelRule::Random, n)),
        rule("stratified", "a random point in each of N cells (13.6)", true, |s, n| {
            points(s, PixelRule::Stratified(CELL), n);
            s.sampler = SamplerKind::Stratified;
        }),
        rule("nonuniform", "N cells of equal weight under the filter (19)", true, |s, n| {
            points(s, PixelRule::Nonuniform(CELL), n);
        }),
        rule("importance", "random points drawn from the filter (20)", true, |s, n| {
            points(s, PixelRule::Importance, n);
        }),
        rule("sobol", "scrambled Sobol points drawn from the filter", true, |s, n| {
            points(s, PixelRule::Sampler, n);
            s.sampler = SamplerKind::Sobol;
        }),
    ],
    is_of_centres: false,
    max_depth: None,
    reference: |s| (s.rule, s.sampler) = (PixelRule::Sampler, SamplerKind::Sobol),
};

impl Subject {
    /// Name, meaning, value; the default first.
    pub const TABLE: &'static [(&'static str, &'static str, &'static Subject)] = &[
        (
            "hemisphere",
            "N directions at what each pixel's centre sees, by every rule of the hemisphere",
            &HEMISPHERE,
        ),
        ("pixel", "N points of each pixel, by every rule of the pixel", &PIXEL),
    ];

    /// The subject of that name.
    ///
    /// # Errors
    /// An unknown name.
    pub fn from_name(word: &str) -> Result<&'static Subject> {
        lookup("subject", word, Self::TABLE)
    }
}
