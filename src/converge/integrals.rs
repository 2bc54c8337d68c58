//! Built-in integrals with known answers, and the rules that estimate them.
//!
//! A new integral is an entry of [`INTEGRALS`]: its name, its answer, and its rules as boxed closures.

use super::{F32, F64, Hooks, Labels, Reference, Rule, Run, Value};
use crate::error::{Error, Result, nearest};
use crate::math::Vec3;
use crate::quadrature::hemisphere::{Cells, Fan, HemisphereRule, Measure};
use crate::quadrature::{
    Density, Estimate, Exponential, Gaussian, PiecewiseLinear, Regions, importance, left_edges, midpoints,
    monte_carlo, nonuniform, nonuniform_random, numbers, stratified,
};
use crate::sampler::{Sampler, SamplerKind};
use serde_json::json;
use std::time::Instant;

/// An integral whose answer is known.
pub struct Integral {
    /// Its name on the command line.
    pub name: &'static str,
    /// The formula.
    pub meaning: &'static str,
    /// The answer.
    pub exact: f64,
    /// Relative rounding of the integrand's points: f32 directions, f64 numbers.
    rounding: f64,
    /// The rules that estimate it.
    rules: fn() -> Result<Vec<Rule<'static>>>,
}

/// D of the 1-D integrals: not 1, so that a factor D that is missing shows.
const D: f64 = 2.0;
/// The peak's place and width.
const PEAK: (f64, f64) = (1.3, 0.02);

/// Every built-in integral.
pub const INTEGRALS: &[Integral] = &[
    Integral {
        name: "smooth",
        meaning: "∫ e⁻ˣ dx over [0, 2]",
        exact: 0.864_664_716_763_387_3, // 1 − e⁻²
        rounding: F64,
        rules: || {
            let guess = PiecewiseLinear::new(&[(0.0, 1.0), (D, 0.15)])?;
            line_rules(|x| libm::exp(-x), guess, Exponential::new(D, 1.0)?)
        },
    },
    Integral {
        name: "step",
        meaning: "∫ f dx over [0, 2]: f = 1 up to x = 2/3, then 3",
        exact: 14.0 / 3.0,
        rounding: F64,
        rules: || {
            // No interval of a power of two ends at D/3: the step always lies inside one, at a third of it.
            let steps = [(0.0, 1.0), (D / 3.0, 1.0), (D / 3.0, 3.0), (D, 3.0)];
            let guess = PiecewiseLinear::new(&[(0.0, 1.0), (D, 3.0)])?;
            line_rules(|x| if x < D / 3.0 { 1.0 } else { 3.0 }, guess, PiecewiseLinear::new(&steps)?)
        },
    },
    Integral {
        name: "peak",
        meaning: "∫ exp(−½((x − 1.3)/0.02)²) dx over [0, 2]",
        exact: 0.050_132_565_492_620_01, // 0.02·√2π; what is cut off at 35 σ is less than 1e-268
        rounding: F64,
        rules: || {
            // 13.8's "Gaussian distribution centered around the point we expect": expected, so not quite there.
            let guess = Gaussian::new(D, PEAK.0 + 0.01, 3.0 * PEAK.1)?;
            let peak = |x: f64| {
                let z = (x - PEAK.0) / PEAK.1;
                libm::exp(-0.5 * z * z)
            };
            line_rules(peak, guess, Gaussian::new(D, PEAK.0, PEAK.1)?)
        },
    },
    Integral {
        name: "sky",
        meaning: "∫ eˣ cos θ dω over the hemisphere",
        // Over the unit disk below: ∫₀¹ r·∫ e^(r cos φ) dφ dr = 2π·∫ r·I₀(r) dr = 2π·I₁(1).
        exact: 3.550_999_378_424_361_6,
        rounding: F32,
        rules: || Ok(hemisphere_rules(|d| libm::exp(f64::from(d.x)))),
    },
    Integral {
        name: "lamp",
        meaning: "∫ cos θ dω over the directions to a square of side 1, 1 above, ½ aside",
        // Lambert's formula; π/0.5 times the radiance under it of a surface of reflectance ½.
        exact: 0.566_645_112_049_507_4,
        rounding: F32,
        rules: || Ok(hemisphere_rules(lamp)),
    },
];

/// Whether a direction meets the square [0, 1] × [−½, ½] at height 1.
fn lamp(d: Vec3) -> f64 {
    let (x, y) = (d.x / d.z, d.y / d.z);
    f64::from(u8::from((0.0..1.0).contains(&x) && (-0.5..0.5).contains(&y)))
}

impl Integral {
    /// The integral of that name.
    pub fn named(name: &str) -> Option<&'static Integral> {
        INTEGRALS.iter().find(|integral| integral.name == name)
    }

    /// The error for a word that is neither a file nor an integral.
    pub fn unknown(word: &str) -> Error {
        let known: Vec<&str> = INTEGRALS.iter().map(|integral| integral.name).collect();
        let list = known.join(", ");
        let advice = match nearest(word, known) {
            Some(name) => format!("did you mean \"{name}\"? (built-in integrals are {list})"),
            None => format!("built-in integrals are {list}"),
        };
        Error::new("no such file").at(word).advise(advice)
    }

    /// Its rules.
    ///
    /// # Errors
    /// None as long as the entry's densities are sound.
    pub fn rules(&self) -> Result<Vec<Rule<'static>>> {
        (self.rules)()
    }

    /// What a figure of it says.
    pub fn labels(&self) -> Labels {
        Labels {
            title: self.name.to_string(),
            subtitle: self.meaning.to_string(),
            samples: "number of evaluations N",
            settings: json!({ "integral": self.name }),
        }
    }

    /// Its answer.
    pub fn reference(&self) -> Reference {
        Reference {
            description: format!("closed form, {}", self.exact),
            value: Value::number(self.exact),
            rmse: 0.0,
            rounding: self.rounding,
        }
    }
}

/// The rules over [0, D] for `f`: `guess` is where a user would expect its values, `perfect` is f itself, scaled.
fn line_rules<F, G, P>(f: F, guess: G, perfect: P) -> Result<Vec<Rule<'static>>>
where
    F: Fn(f64) -> f64 + Copy + 'static,
    G: Density + Clone + 'static,
    P: Density + 'static,
{
    let (a, b, c) = (guess.clone(), guess.clone(), guess);
    Ok(vec![
        fixed("uniform", "midpoints of N intervals (8)", move |n| midpoints(f, D, n)),
        fixed("uniform-corner", "left ends of N intervals (12)", move |n| left_edges(f, D, n)),
        random("random", "simple Monte Carlo (10)", move |n, r| monte_carlo(f, D, n, r)),
        random("stratified", "one random point in each of N intervals (13.6)", move |n, r| {
            stratified(f, D, n, 1, r)
        }),
        fixed("nonuniform", "N regions, small where much is expected (19)", move |n| {
            Ok(nonuniform(f, &Regions::equal_shares(&a, n)?))
        }),
        random("nonuniform-random", "a random point in each of those regions (13.7)", move |n, r| {
            nonuniform_random(f, &Regions::equal_shares(&b, n)?, 1, r)
        }),
        random("importance", "points from a density that was guessed (20)", move |n, r| {
            importance(f, &c, n, r)
        }),
        random("importance-exact", "points from the integrand's own density (20)", move |n, r| {
            importance(f, &perfect, n, r)
        }),
    ])
}

/// The rules over the hemisphere for light of radiance `f`.
fn hemisphere_rules(f: fn(Vec3) -> f64) -> Vec<Rule<'static>> {
    use HemisphereRule::{Nonuniform, Random, Sobol, Stratified, Uniform, UniformCorner};
    let (angles, projected) = (Measure::Angles, Measure::Projected);
    let rule = |name, meaning, rule: HemisphereRule| {
        let run = move |n: u64, seed: u64, _: &Hooks<'_>| timed(|| hemisphere(f, rule, n, seed));
        Rule { name, meaning, is_random: !rule.is_deterministic(), run: Box::new(run) }
    };
    vec![
        rule("uniform", "a grid of midpoints in theta and phi (18)", Uniform),
        rule("uniform-corner", "the grid of left edges (16)-(18)", UniformCorner),
        rule("random", "independent random angles (10)", Random { measure: angles }),
        rule(
            "stratified",
            "a random direction in each of N cells (13.6)",
            Stratified { measure: angles, per_cell: 1 },
        ),
        rule("nonuniform", "N cells of equal projected solid angle (19)", Nonuniform { per_cell: 0 }),
        rule("nonuniform-random", "a random direction in each of those (13.7)", Nonuniform { per_cell: 1 }),
        rule("importance", "random directions of density cos θ/π (20)", Random { measure: projected }),
        rule("sobol", "scrambled Sobol angles", Sobol { measure: angles }),
    ]
}

/// Σ f(d_k)·cos θ_k·Δω_k over the N directions of `rule`.
fn hemisphere(f: fn(Vec3) -> f64, rule: HemisphereRule, n: u64, seed: u64) -> Result<Estimate> {
    let cells = u32::try_from(n).map_err(|_| Error::new(format!("{n} directions are too many")))?;
    let fan = Fan::new(rule, Cells::of(cells))?;
    let kind = if let HemisphereRule::Sobol { .. } = rule { SamplerKind::Sobol } else { SamplerKind::Random };
    // Like pixels of a picture, other N get other numbers.
    let sampler = Sampler::new(kind, seed, fan.count());
    let term = |k: u32| {
        let (d, solid_angle) = fan.direction(k, sampler.d2(sampler.key(cells, k), 0));
        f(d) * f64::from(d.z) * f64::from(solid_angle)
    };
    let value = (0..fan.count()).map(term).sum();
    Ok(Estimate { value, standard_error: None, evaluations: u64::from(fan.count()) })
}

/// A rule without random numbers.
pub fn fixed(
    name: &'static str,
    meaning: &'static str,
    rule: impl Fn(usize) -> Result<Estimate> + 'static,
) -> Rule<'static> {
    let run = move |n: u64, _seed| timed(|| rule(count(n)?));
    Rule { name, meaning, is_random: false, run: Box::new(move |n, seed, _| run(n, seed)) }
}

/// A rule with random numbers, others for every seed and N.
pub fn random(
    name: &'static str,
    meaning: &'static str,
    rule: impl Fn(usize, &mut dyn FnMut() -> f64) -> Result<Estimate> + 'static,
) -> Rule<'static> {
    let run = move |n: u64, seed| timed(|| rule(count(n)?, &mut numbers(seed, n)));
    Rule { name, meaning, is_random: true, run: Box::new(move |n, seed, _| run(n, seed)) }
}

fn count(n: u64) -> Result<usize> {
    usize::try_from(n).map_err(|_| Error::new(format!("{n} points are too many")))
}

fn timed(estimate: impl Fn() -> Result<Estimate>) -> Result<Option<Run>> {
    let begun = Instant::now();
    let estimate = estimate()?;
    Ok(Some(Run {
        value: Value::number(estimate.value),
        seconds: begun.elapsed().as_secs_f64(),
        rays: estimate.evaluations,
    }))
}
