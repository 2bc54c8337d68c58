//! Scenes: pictures rendered by the rules of a [`Subject`], and a long run as the reference.

pub use super::subject::{PictureRule, Subject};
use super::{F32, Hooks, Labels, Plan, Reference, Rule, Run, Value};
use crate::accel::Intersector;
use crate::error::{Error, Result};
use crate::math::isa::Isa;
use crate::render::{self, Progress};
use crate::scene::{Scene, Settings};
use serde_json::json;
use std::time::Instant;

/// The largest N of a scene.
pub const MAX_N: u64 = 1 << 16;

/// A scene that is ready to be rendered again and again.
pub struct Stage<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// What all rules have in common.
    pub settings: &'a Settings,
    /// The structure that [`render::build`] made.
    pub accel: &'a dyn Intersector,
    /// Pins the instruction set.
    pub isa: Option<Isa>,
}

impl<'a> Stage<'a> {
    /// The subject's rules for this scene.
    pub fn rules(&'a self, subject: &'static Subject) -> Vec<Rule<'a>> {
        let rule = |rule: &'static PictureRule| Rule {
            name: rule.name,
            meaning: rule.meaning,
            is_random: rule.is_random,
            run: Box::new(move |n, seed, hooks: &Hooks<'_>| self.render(rule.set, n, seed, hooks)),
        };
        subject.rules.iter().map(rule).collect()
    }

    /// Renders with `seed` and N samples as `set` asks for them; `None` when it was stopped.
    fn render(
        &self,
        set: impl Fn(&mut Settings, u32),
        n: u64,
        seed: u64,
        hooks: &Hooks<'_>,
    ) -> Result<Option<Run>> {
        let n = u32::try_from(n).map_err(|_| Error::new(format!("{n} samples are too many")))?;
        let mut settings = Settings { seed, aovs: Vec::new(), ..self.settings.clone() };
        set(&mut settings, n);
        let progress = |p| {
            if let Progress::Render { share, .. } = p {
                (hooks.progress)(share)
            }
        };
        let hooks = render::Hooks { progress: &progress, stop: hooks.stop };
        let begun = Instant::now();
        let rendering = render::render(self.scene, &settings, self.accel, self.isa, &hooks)?;
        let stats = &rendering.stats;
        Ok(rendering.complete.then(|| Run {
            value: Value::picture(&rendering.image),
            seconds: begun.elapsed().as_secs_f64(),
            rays: stats.camera_rays + stats.bounce_rays + stats.shadow_rays,
        }))
    }

    /// A long run with seeds of its own: two halves, whose difference tells how far off their mean is
    /// (E[(a − b)²] = 2·Var a, and the mean's variance is half of Var a). `None` when it was stopped.
    ///
    /// # Errors
    /// As [`render::render`].
    pub fn reference(&self, subject: &Subject, plan: &Plan, hooks: &Hooks<'_>) -> Result<Option<Reference>> {
        let samples = reference_samples(plan);
        let set = |s: &mut Settings, n| {
            s.spp = n;
            (subject.reference)(s);
        };
        let seeds = [0, 1].map(|k| plan.seed.wrapping_add(plan.seeds).wrapping_add(k));
        let mut halves = Vec::new();
        for (done, seed) in [0.0, 0.5].into_iter().zip(seeds) {
            let progress = |share: f64| (hooks.progress)(done + 0.5 * share);
            let hooks = Hooks { progress: &progress, stop: hooks.stop };
            halves.extend(self.render(set, samples / 2, seed, &hooks)?);
        }
        let [a, b] = halves.as_slice() else { return Ok(None) };
        let mut used = self.settings.clone();
        set(&mut used, 0);
        Ok(Some(Reference {
            description: format!(
                "{}, {} sampler, {samples} samples {}, seeds {} and {}",
                used.integrator.name(),
                used.sampler.name(),
                subject.points,
                seeds[0],
                seeds[1]
            ),
            rmse: 0.5 * a.value.squares(&b.value)?.mse.sqrt(),
            value: a.value.mean_with(&b.value),
            rounding: F32,
        }))
    }

    /// What a figure of the scene `name` says.
    pub fn labels(&self, name: &str, subject: &Subject) -> Labels {
        let s = self.settings;
        let [_, _, w, h] = s.crop.unwrap_or([0, 0, s.size[0], s.size[1]]);
        let integrator = s.integrator.name();
        Labels {
            title: name.to_string(),
            subtitle: format!("{w} × {h} pixels, {}, max_depth {}", subject.meaning, s.max_depth),
            samples: subject.samples,
            settings: json!({
                "scene": name,
                "size": s.size,
                "crop": s.crop,
                "filter": s.filter.name(),
                "integrator": integrator,
                "vary": subject.name,
                "max_depth": s.max_depth,
                "lights": s.lights.name(),
                "roulette": s.roulette,
                "split": s.split,
                "backend": s.backend.name(),
                "isa": self.accel.isa(),
            }),
        }
    }
}

/// Sixteen times the largest N, where that is no more than takes as long as the study itself; else four times.
fn reference_samples(plan: &Plan) -> u64 {
    const ENOUGH: u64 = 2048;
    let largest = plan.numbers().last().unwrap_or(1);
    (16 * largest).min(ENOUGH).max(4 * largest)
}

/// The size whose longer side is `longest` where it was longer, with the proportions kept.
pub fn shrink(size: [u32; 2], longest: u32) -> [u32; 2] {
    let side = size[0].max(size[1]).max(1);
    if side <= longest {
        return size;
    }
    let scaled = |length: u32| (u64::from(length) * u64::from(longest) * 2 / u64::from(side)).div_ceil(2);
    size.map(|length| (scaled(length) as u32).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_shrinks_in_proportion() {
        assert_eq!(shrink([512, 512], 96), [96, 96]);
        assert_eq!(shrink([1920, 1080], 96), [96, 54]);
        assert_eq!(shrink([64, 48], 96), [64, 48]);
        assert_eq!(shrink([1, 100_000], 96), [1, 96]);
    }

    #[test]
    fn the_reference_has_more_samples_than_any_rule() {
        let samples = |max_n| reference_samples(&Plan { max_n, seeds: 1, seed: 0 });
        assert_eq!([1, 63, 64, 256, 1024, MAX_N].map(samples), [16, 256, 1024, 2048, 4096, 4 * MAX_N]);
    }
}
