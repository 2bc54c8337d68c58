//! What shines from infinitely far away, and the choice between that and the lights with a place.

use super::tree::LightTree;
use super::{Directional, Environment, Light, Openings, Receiver, Sampled, Sun};
use crate::math::{Rgb, Vec3, luminance};
use std::f32::consts::PI;

/// A light at infinity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distant {
    /// The environment.
    Environment,
    /// The sun of that index.
    Sun(u32),
    /// Parallel light of that index.
    Directional(u32),
}

/// A light at infinity as the choice sees it.
#[derive(Clone, Copy, Debug)]
struct Candidate {
    light: Distant,
    /// Irradiance on a plane that faces it, in luminance.
    irradiance: f32,
    /// Where it is, and the sine of its radius; `None`: all around.
    place: Option<(Vec3, f32)>,
}

impl Candidate {
    /// About the irradiance at `to`; zero only where none can arrive.
    #[inline(always)]
    fn importance(&self, to: &Receiver) -> f32 {
        match (self.place, to.normal) {
            (Some((direction, radius)), Some(n)) => {
                self.irradiance * (direction.dot(n) + radius).clamp(0.0, 1.0)
            }
            _ => self.irradiance,
        }
    }
}

/// All lights at infinity.
#[derive(Clone, Debug)]
pub struct Distants {
    /// What rays that hit nothing see.
    pub environment: Option<Environment>,
    /// Whether light samples of the environment are compensated for BSDF samples.
    pub compensated: bool,
    /// Where a constant environment is seen from indoors.
    openings: Option<Openings>,
    /// Discs in front of the environment.
    pub suns: Vec<Sun>,
    /// Parallel light.
    pub directionals: Vec<Directional>,
    /// Those that are sampled.
    candidates: Vec<Candidate>,
}

/// Where both kinds can reach a point, each gets this share of the samples at least: a tree's importance is a bound, and
/// an average says little about an environment.
const LEAST: f32 = 0.1;

/// A direction that counts as on the horizon although a packed normal is off by 1e-4.
const SLACK: f32 = 2e-4;

impl Distants {
    pub(super) fn new(lights: &[Light], sampled: Sampled) -> Distants {
        let mut all = Distants {
            environment: None,
            compensated: !sampled.alone,
            openings: None,
            suns: Vec::new(),
            directionals: Vec::new(),
            candidates: Vec::new(),
        };
        for light in lights {
            match light {
                Light::Environment(e) => all.environment = Some(e.clone()),
                Light::Sun(s) => all.suns.push(*s),
                Light::Directional(d) => all.directionals.push(*d),
                Light::Point(_) | Light::Spot(_) | Light::Sphere(_) => {}
            }
        }
        if let Some(e) = &all.environment
            && e.deserves_samples(!sampled.alone)
        {
            let irradiance = PI * luminance(e.average());
            all.candidates.push(Candidate { light: Distant::Environment, irradiance, place: None });
        }
        for (i, sun) in all.suns.iter().enumerate() {
            let (irradiance, place) =
                (luminance(sun.irradiance()), Some((sun.direction, sun.sin_radius + SLACK)));
            all.candidates.push(Candidate { light: Distant::Sun(i as u32), irradiance, place });
        }
        for (i, light) in all.directionals.iter().enumerate().filter(|_| sampled.deltas) {
            let (irradiance, place) = (luminance(light.irradiance), Some((-light.direction, SLACK)));
            all.candidates.push(Candidate { light: Distant::Directional(i as u32), irradiance, place });
        }
        all.candidates.retain(|c| c.irradiance > 0.0);
        all
    }

    /// True where light samples would only pay if they knew where to look: BSDF samples find a constant environment as
    /// well, unless little of it is seen.
    pub fn wants_openings(&self) -> bool {
        self.compensated && matches!(self.environment, Some(Environment::Constant(l)) if luminance(l) > 0.0)
    }

    /// From now on the environment is sampled through `openings`.
    pub fn add_openings(&mut self, openings: Openings) {
        let irradiance =
            self.environment.as_ref().map_or(0.0, |e| PI * luminance(e.average()) * openings.share);
        if irradiance > 0.0 {
            self.candidates.push(Candidate { light: Distant::Environment, irradiance, place: None });
            self.openings = Some(openings);
        }
    }

    /// A direction from `p` to the environment, its density per solid angle and the radiance from there.
    #[inline(always)]
    pub fn sample_environment(&self, p: Vec3, u: [f32; 2]) -> Option<(Vec3, f32, Rgb)> {
        let environment = self.environment.as_ref()?;
        match &self.openings {
            Some(openings) => {
                let (wi, pdf) = openings.sample(p, u);
                Some((wi, pdf, environment.le(wi)))
            }
            None => environment.sample(self.compensated, u),
        }
    }

    /// True when none is sampled.
    #[inline(always)]
    pub fn is_empty(&self) -> bool {
        self.candidates.is_empty()
    }

    /// How many are sampled.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.candidates.len()
    }

    /// The only light that is sampled.
    #[inline(always)]
    pub fn only(&self) -> Option<Distant> {
        self.candidates.first().map(|c| c.light)
    }

    #[inline(always)]
    fn importance(&self, to: &Receiver) -> f32 {
        self.candidates.iter().map(|c| c.importance(to)).sum()
    }

    /// The share of samples that lights with a place get, which are in `tree`.
    #[inline(always)]
    pub fn share_of_others(&self, tree: &LightTree, to: &Receiver) -> f32 {
        if self.candidates.is_empty() { 1.0 } else { share(tree.importance(to), self.importance(to)) }
    }

    /// A light at infinity, or `None` for those in `tree`, with the probability of that, and what is left of `number`.
    #[inline(always)]
    pub fn choose(
        &self,
        tree: &LightTree,
        to: &Receiver,
        number: f64,
    ) -> Option<(Option<Distant>, f32, f64)> {
        if self.candidates.is_empty() {
            return Some((None, 1.0, number));
        }
        let sum = self.importance(to);
        let others = share(tree.importance(to), sum);
        let split = f64::from(others);
        if number < split {
            return Some((None, others, number / split));
        }
        let mut rest = (number - split) / (1.0 - split) * f64::from(sum);
        let mut last = None;
        for candidate in &self.candidates {
            let importance = candidate.importance(to);
            if importance > 0.0 {
                last = Some((Some(candidate.light), (1.0 - others) * (importance / sum), 0.0));
                if rest < f64::from(importance) {
                    break;
                }
                rest -= f64::from(importance);
            }
        }
        last
    }

    /// Probability of choosing a light at infinity.
    #[inline(always)]
    pub(super) fn chance(&self, light: Distant, tree: &LightTree, to: &Receiver) -> f32 {
        let Some(candidate) = self.candidates.iter().find(|c| c.light == light) else { return 0.0 };
        let importance = candidate.importance(to);
        if importance <= 0.0 {
            return 0.0;
        }
        let sum = self.importance(to);
        (1.0 - share(tree.importance(to), sum)) * (importance / sum)
    }

    /// See [`super::Lights::at_end`].
    #[inline(always)]
    pub fn at_end(&self, tree: &LightTree, from: &Receiver, d: Vec3, mut found: impl FnMut(Rgb, f32)) {
        if let Some(environment) = &self.environment {
            let chance = self.chance(Distant::Environment, tree, from);
            let pdf = match &self.openings {
                _ if chance <= 0.0 => 0.0,
                // The ray started a rounding away from the point that took the sample: in the same part (`openings.rs`).
                Some(openings) => chance * openings.pdf(from.p, d),
                None => chance * environment.pdf(self.compensated, d),
            };
            found(environment.le(d), pdf);
        }
        for (i, sun) in self.suns.iter().enumerate().filter(|(_, sun)| sun.contains(d)) {
            found(sun.radiance, self.chance(Distant::Sun(i as u32), tree, from) / sun.solid_angle());
        }
    }
}

/// The share of lights with a place, of importance `near`, beside those at infinity, of importance `far`.
#[inline(always)]
fn share(near: f32, far: f32) -> f32 {
    if near <= 0.0 {
        return 0.0;
    }
    if far <= 0.0 {
        return 1.0;
    }
    (near / (near + far)).clamp(LEAST, 1.0 - LEAST)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every light at infinity is chosen as often as it says when a ray meets it.
    #[test]
    fn choices_have_their_probabilities() {
        let sun = |direction, radiance| {
            Light::Sun(Sun { direction, radiance: Rgb::splat(radiance), sin_radius: 0.1 })
        };
        let lights = [sun(Vec3::Y, 100.0), sun(Vec3::X, 30.0), sun(-Vec3::Y, 500.0)];
        let all = Distants::new(&lights, Sampled { alone: false, deltas: true });
        let tree = LightTree::new(&[]);
        let n = Vec3::new(0.6, 0.8, 0.0);
        for packed in [Receiver::pack(n), Receiver::ALL_AROUND] {
            let to = Receiver::new(Vec3::ZERO, packed);
            let mut counts = [0; 3];
            for k in 0..10_000 {
                let (light, chance, _) = all.choose(&tree, &to, (f64::from(k) + 0.5) / 10_000.0).unwrap();
                let Some(Distant::Sun(i)) = light else { panic!() };
                assert_eq!(chance, all.chance(Distant::Sun(i), &tree, &to));
                counts[i as usize] += 1;
            }
            for (i, count) in counts.iter().enumerate() {
                let chance = all.chance(Distant::Sun(i as u32), &tree, &to);
                assert!((*count as f32 - 1e4 * chance).abs() < 2.0, "{count} {chance}");
            }
            assert_eq!(counts[2] == 0, packed != Receiver::ALL_AROUND, "a sun below the horizon");
        }
        assert!(share(0.0, 1.0) == 0.0 && share(1.0, 0.0) == 1.0 && share(1e-9, 1.0) == LEAST);
    }
}
