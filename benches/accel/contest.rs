//! One contestant against the yardstick: built, then traced in alternating rounds.

use crate::Arguments;
use crate::build;
use crate::clock::seconds;
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
    /// Takes `rays` over in its own form, traces them once and keeps the answers. Returns the seconds that the
    /// tracing took ([`timed`]) and how many rays hit something.
    fn trace(&self, rays: &RaySet) -> (f64, usize);

    /// Bytes of the structure.
    fn bytes(&self) -> usize;
}

/// CPU seconds of this thread.
pub fn timed(work: impl FnOnce()) -> f64 {
    let start = seconds(ClockId::ThreadCPUTime);
    work();
    seconds(ClockId::ThreadCPUTime) - start
}

/// What is known of a contestant after all rounds.
pub struct Measured {
    /// A build on all threads.
    pub build: build::Cost,
    /// A build on one.
    pub build_one: build::Cost,
    /// The structure's MiB.
    pub mib: f64,
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
        yardstick: &dyn Tracer,
        arguments: &Arguments,
    ) -> Measured {
        let build = build::measure(contestant, &scene.name, 0, arguments.builds);
        let build_one = build::measure(contestant, &scene.name, 1, arguments.builds);
        let built = contestant.build(scene, 0);
        let mib = built.bytes() as f64 / (1 << 20) as f64;
        let mut series = vec![Vec::new(); rays.len()];
        let mut speeds = vec![Speed::default(); rays.len()];
        for round in 0..arguments.rounds {
            for (i, set) in rays.iter().enumerate() {
                let (mine, other);
                if round % 2 == 0 {
                    other = yardstick.trace(set);
                    mine = built.trace(set);
                } else {
                    mine = built.trace(set);
                    other = yardstick.trace(set);
                }
                series[i].push((set.len() as f64 * 1e-6 / mine.0, other.0 / mine.0));
                (speeds[i].hits, speeds[i].expected) = (mine.1, other.1);
            }
        }
        for (speed, series) in speeds.iter_mut().zip(&series) {
            speed.mrays = median(series.iter().map(|s| s.0));
            speed.ratio = median(series.iter().map(|s| s.1));
        }
        Measured { build, build_one, mib, speeds }
    }
}

/// The middle one.
pub fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    let middle = values.len() / 2;
    if values.len() % 2 == 1 { values[middle] } else { 0.5 * (values[middle - 1] + values[middle]) }
}
