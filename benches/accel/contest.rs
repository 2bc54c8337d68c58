//! One contestant against the yardstick: built, then traced in alternating rounds.

use crate::clock::{peak_mib, seconds};
use crate::record::RaySet;
use crate::scenes::Scene;
use rustix::time::ClockId;

/// A way to trace rays.
pub struct Contestant {
    /// Its name in the table.
    pub name: String,
    build: Box<Build>,
}

/// Builds on at most that many threads (0: all).
type Build = dyn Fn(&Scene, usize) -> Box<dyn Tracer>;

impl Contestant {
    /// A contestant that `build` makes.
    pub fn new<T: Tracer + 'static>(
        name: impl Into<String>,
        build: impl Fn(&Scene, usize) -> T + 'static,
    ) -> Self {
        Contestant {
            name: name.into(),
            build: Box::new(move |scene, threads| Box::new(build(scene, threads))),
        }
    }

    /// Builds on at most `threads` threads (0: all).
    pub fn build(&self, scene: &Scene, threads: usize) -> Box<dyn Tracer> {
        (self.build)(scene, threads)
    }
}

/// A built contestant.
pub trait Tracer {
    /// Takes rays over in its own form; not timed.
    fn load(&mut self, rays: &RaySet);

    /// Traces the loaded rays once and keeps the answers.
    fn trace(&mut self);

    /// How many of them hit something; not timed.
    fn hits(&self) -> usize;

    /// Bytes of the structure.
    fn bytes(&self) -> usize;
}

/// What is known of a contestant after all rounds.
pub struct Measured {
    /// CPU seconds of a build on all threads.
    pub build: f64,
    /// Wall seconds of a build on one.
    pub build_one: f64,
    /// The structure's MiB.
    pub mib: f64,
    /// The most that a build on one thread holds, in MiB.
    pub peak_mib: Option<f64>,
    /// One a ray set.
    pub speeds: Vec<Speed>,
}

/// One ray set.
#[derive(Clone, Copy, Default)]
pub struct Speed {
    /// Median of the rounds.
    pub mrays: f64,
    /// Median of the rounds' ratios to the yardstick.
    pub ratio: f64,
    /// How many rays hit something.
    pub hits: usize,
    /// How many did with the yardstick.
    pub expected: usize,
}

impl Measured {
    /// Builds and measures `contestant`.
    pub fn of(
        contestant: &Contestant,
        scene: &Scene,
        rays: &[RaySet],
        yardstick: &mut dyn Tracer,
        rounds: u32,
    ) -> Measured {
        let start = seconds(ClockId::ProcessCPUTime);
        drop(contestant.build(scene, 0));
        let build = seconds(ClockId::ProcessCPUTime) - start;
        let start = seconds(ClockId::Monotonic);
        let (mut built, peak_mib) = peak_mib(|| contestant.build(scene, 1));
        let build_one = seconds(ClockId::Monotonic) - start;
        let mib = built.bytes() as f64 / (1 << 20) as f64;
        let mut series = vec![Vec::new(); rays.len()];
        let mut speeds = vec![Speed::default(); rays.len()];
        for round in 0..rounds {
            for (i, set) in rays.iter().enumerate() {
                let (mine, other);
                if round % 2 == 0 {
                    other = trace(yardstick, set);
                    mine = trace(&mut *built, set);
                } else {
                    mine = trace(&mut *built, set);
                    other = trace(yardstick, set);
                }
                series[i].push((set.len() as f64 * 1e-6 / mine.0, other.0 / mine.0));
                (speeds[i].hits, speeds[i].expected) = (mine.1, other.1);
            }
        }
        for (speed, series) in speeds.iter_mut().zip(&series) {
            speed.mrays = median(series.iter().map(|s| s.0));
            speed.ratio = median(series.iter().map(|s| s.1));
        }
        Measured { build, build_one, mib, peak_mib, speeds }
    }
}

/// CPU seconds, and how many rays hit something.
fn trace(tracer: &mut dyn Tracer, set: &RaySet) -> (f64, usize) {
    tracer.load(set);
    let start = seconds(ClockId::ThreadCPUTime);
    tracer.trace();
    let seconds = seconds(ClockId::ThreadCPUTime) - start;
    (seconds, tracer.hits())
}

fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { 0.5 * (values[middle - 1] + values[middle]) }
}
