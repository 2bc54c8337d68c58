//! `drt render`: check, load, build, render, write; what can be refused is refused before the first ray.

mod series;

pub use series::SeriesArgs;

use super::Failure;
use super::args::RenderArgs;
use super::checkpoint::{Kept, file_of};
use super::console::{Console, Verbosity, summary};
use super::machine;
use super::paths;
use super::progress::{Phase, Style, duration};
use super::signals::Signals;
use super::stats::{Clock, Report};
use drt::accel::Intersector;
use drt::error::{Error, Findings, Result, Severity, show_path, unknown_word_advice};
use drt::load::auto::{Up, View};
use drt::load::cache::Cache;
use drt::load::sky::SkySource;
use drt::load::{self, Loaded};
use drt::math::isa::Isa;
use drt::memory::{self, megabytes};
use drt::output::{self, ToneMap};
use drt::render::{self, Hooks, Keep, Progress, RenderStats, Rendering};
use drt::scene::Settings;
use series::Series;
use std::path::PathBuf;

/// Everything that the words say, checked.
struct Job {
    args: RenderArgs,
    input: PathBuf,
    outputs: Vec<PathBuf>,
    display: output::Options,
    isa: Option<Isa>,
    threads: usize,
    focus: Option<[u32; 2]>,
    series: Option<Series>,
    kept: Option<Kept>,
    style: Style,
    console: Console,
}

/// Runs the subcommand.
pub fn run(args: RenderArgs) -> Result<(), Failure> {
    let clock = Clock::start();
    let mut job = Job::new(args)?;
    job.args.memory.limit()?;
    let signals = Signals::listen()?;
    paths::check(&job.outputs, job.args.stats.as_deref(), file_of(job.kept.as_ref()))?;
    job.check_inputs(&job.outputs, [job.input.as_path()].into_iter())?;
    if let Some(kept) = &mut job.kept {
        kept.open(job.console)?;
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(job.threads).build();
    let pool = pool.map_err(|e| Error::new(format!("cannot start {} threads: {e}", job.threads)))?;
    pool.install(|| job.work(&signals, clock))
}

impl Job {
    fn new(args: RenderArgs) -> Result<Job> {
        let input = args.input.clone().ok_or_else(|| {
            Error::usage("no input").advise("name a mesh or a scene file (.toml); see drt --help")
        })?;
        let verbosity = match (args.quiet, args.verbose) {
            (true, _) => Verbosity::Quiet,
            (_, true) => Verbosity::Verbose,
            _ => Verbosity::Normal,
        };
        let style = args.progress.as_deref().map_or(Ok(Style::Auto), Style::from_name)?;
        let exposure = args.exposure.as_deref().map_or(Ok(0.0), exposure)?;
        let tone_map = args.tone_map.as_deref().map_or(Ok(ToneMap::default()), tone_map)?;
        let series = Series::new(&args.series, args.checkpoint.resume, &args.output, &input)?;
        let one = || paths::outputs(&args.output, &input);
        let outputs = series.as_ref().map_or_else(one, Series::first_outputs);
        Ok(Job {
            kept: Kept::new(&args.checkpoint, &outputs, series.is_some())?,
            outputs,
            series,
            display: output::Options { exposure, tone_map },
            isa: args.isa.as_deref().map(|word| at_flag("--isa", Isa::from_name(word))).transpose()?,
            threads: args.threads.as_deref().map_or_else(|| Ok(machine::threads()), threads)?,
            focus: args.focus.as_deref().map(focus).transpose()?,
            style: if verbosity == Verbosity::Quiet { Style::None } else { style },
            console: Console { verbosity },
            input,
            args,
        })
    }

    fn work(&self, signals: &Signals, mut clock: Clock) -> Result<(), Failure> {
        let console = self.console;
        let ended_early = |phase: &str, error: Error| match signals.received() {
            Some((signal, name)) => Failure::Stopped {
                signal,
                message: format!("stopped by {name} while {phase}; nothing was written"),
            },
            None => Failure::Error(error),
        };
        signals.nothing_to_lose("loading");
        let cache = self.args.cache.open()?;
        let mut loaded = self.load(cache.as_ref(), signals).map_err(|e| ended_early("loading", e))?;
        self.judge(&loaded)?;
        let seconds = clock.end("load");
        let (scene, settings) = (&loaded.scene, &loaded.settings);
        console.detail(&format!(
            "loaded {} triangles, {} vertices, {} materials in {}",
            loaded.triangles,
            scene.vertices(),
            scene.materials.len(),
            duration(seconds)
        ));
        let needed = megabytes(scene.need().of(settings));
        console.detail(&format!("building and rendering take about {needed}"));
        scene.need().check(settings, memory::left())?;
        if let Some(kept) = &self.kept {
            kept.adopt(&loaded.scene, &mut loaded.settings, console)?;
        }
        let (scene, settings) = (&loaded.scene, &loaded.settings);

        signals.nothing_to_lose("building");
        let phase = Phase::begin(self.style, "build");
        let progress = |p| {
            if let Progress::Build(share) = p {
                phase.show_share(share)
            }
        };
        let hooks = Hooks { progress: &progress, stop: &|| signals.stop() };
        let mut accel = render::build_through(cache.as_ref(), scene, settings, self.isa, &hooks)
            .map_err(|e| ended_early("building", e))?;
        drop(phase);
        let seconds = clock.end("build");
        console.detail(&format!(
            "built {} ({}, {}) in {}",
            settings.backend.name(),
            accel.isa(),
            megabytes(accel.bytes() as u64),
            duration(seconds)
        ));
        if let Some(cache) = &cache {
            self.args.cache.report(cache, console);
        }

        if let Some(pixel) = self.focus {
            let distance = render::focus(scene, settings, &*accel, pixel)?;
            console.detail(&format!("focused at {distance} m"));
            loaded.scene.camera.focus_distance = distance;
        }
        if let Some(series) = &self.series {
            return self.render_series(series, &mut loaded, &mut *accel, signals, clock);
        }
        let (scene, settings) = (&loaded.scene, &loaded.settings);
        signals.nothing_to_lose("rendering");
        let phase = Phase::begin(self.style, "render");
        let progress = |p| {
            if let Progress::Render { done, total, share } = p {
                signals.something_to_lose();
                phase.show_work(share, done, total)
            }
        };
        let hooks = Hooks { progress: &progress, stop: &|| signals.stop() };
        let render =
            |keep: Option<&Keep<'_>>| render::render_kept(scene, settings, &*accel, self.isa, &hooks, keep);
        let rendering = match &self.kept {
            Some(kept) => kept.keep(console, |keep| render(Some(keep))),
            None => render(None),
        };
        signals.something_to_lose();
        let rendering = rendering.map_err(|e| ended_early("rendering", e))?;
        drop(phase);
        let seconds = clock.end("render");
        let rays = rendering.stats.camera_rays + rendering.stats.bounce_rays + rendering.stats.shadow_rays;
        console.detail(&format!("traced {rays} rays in {}", duration(seconds)));
        if rendering.samples == 0.0 {
            // Not one sample: an empty picture would be a lie.
            let nothing = Error::new("nothing was rendered");
            return if rendering.complete {
                Err(nothing.into())
            } else {
                Err(ended_early("rendering", nothing))
            };
        }

        self.write(&rendering)?;
        clock.end("write");
        self.report(&loaded, &*accel, &rendering.stats, rendering.complete, &clock)?;
        self.conclude(&rendering, settings.spp, signals, &clock)
    }

    /// Writes what was counted, if that is asked for.
    fn report(
        &self,
        loaded: &Loaded,
        accel: &dyn Intersector,
        stats: &RenderStats,
        complete: bool,
        clock: &Clock,
    ) -> Result<()> {
        let Some(path) = &self.args.stats else { return Ok(()) };
        let report = Report {
            scene: &loaded.scene,
            settings: &loaded.settings,
            findings: &loaded.findings,
            skipped_faces: loaded.skipped_faces,
            triangles: loaded.triangles,
            threads: self.threads,
            isa: accel.isa(),
            bvh_bytes: accel.bytes(),
            stats,
            complete,
            clock,
        };
        report.write(path)
    }

    /// Writes every output, each for itself: where one cannot be written, the others are.
    fn write(&self, rendering: &Rendering) -> Result<()> {
        let mut failed = Ok(());
        let mut written = Vec::new();
        for path in &self.outputs {
            match output::write(path, &rendering.image, &self.display) {
                Ok(()) => written.push(show_path(path)),
                Err(e) => failed = failed.and(Err(e)),
            }
        }
        failed.map_err(|e| match (written.as_slice(), &self.kept) {
            ([], None) => e,
            ([], Some(_)) => e.advise("what was rendered is in the checkpoint, and --resume writes it"),
            (written, _) => e.advise(format!("{} was written", written.join(", "))),
        })
    }

    fn check_inputs<'p>(
        &self,
        outputs: &[PathBuf],
        inputs: impl Iterator<Item = &'p std::path::Path>,
    ) -> Result<()> {
        let others = [self.args.stats.as_deref(), file_of(self.kept.as_ref())];
        paths::check_inputs(outputs, &others, inputs)
    }

    fn load(&self, cache: Option<&Cache>, signals: &Signals) -> Result<Loaded> {
        let phase = Phase::begin(self.style, "load");
        let progress = |share: f64| {
            phase.show_share(share);
            !signals.stop()
        };
        let args = &self.args;
        load::scene(
            &self.input,
            load::Options {
                overrides: args.overrides()?,
                up: args.up.as_deref().map(|word| at_flag("--up", Up::from_name(word))).transpose()?,
                view: args
                    .view
                    .as_deref()
                    .map(|word| at_flag("--view", View::from_name(word)))
                    .transpose()?,
                ground: args.ground,
                sky: args
                    .sky
                    .as_deref()
                    .map(|word| at_flag("--sky", SkySource::from_word(word)))
                    .transpose()?,
                max_texture_bytes: args
                    .max_texture_bytes
                    .as_deref()
                    .map_or(Ok(load::Options::default().max_texture_bytes), |word| {
                        super::args::bytes("--max-texture-bytes", word)
                    })?,
                opening: args.opening.opening()?,
                reach: args.files.reach(&self.input)?,
                cache,
                progress: &progress,
                memory: memory::left,
            },
        )
    }

    /// Says what was found; with `--strict`, a warning is an error.
    fn judge(&self, loaded: &Loaded) -> Result<()> {
        let findings = &loaded.findings;
        let inputs = loaded.files.iter().map(PathBuf::as_path);
        let outputs = self.series.as_ref().map_or_else(|| self.outputs.clone(), Series::all_outputs);
        self.check_inputs(&outputs, inputs)?;
        if self.args.strict && findings.at_least(Severity::Warning) > 0 {
            return Err(strict_error(findings));
        }
        self.console.findings(findings);
        self.judge_layers(&loaded.settings)
    }

    /// Layers that no output can hold would be lost without a word.
    fn judge_layers(&self, settings: &Settings) -> Result<()> {
        let holds_layers = |path: &PathBuf| path.extension().is_some_and(|e| e.eq_ignore_ascii_case("exr"));
        if settings.aovs.is_empty() || self.outputs.iter().any(holds_layers) {
            return Ok(());
        }
        let lost = Error::usage("layers were asked for (film.aov), and only .exr outputs have them")
            .advise("add -o NAME.exr, or leave them out");
        if self.args.strict {
            return Err(lost);
        }
        self.console.say(&format!("warning: {lost}"));
        Ok(())
    }

    fn conclude(
        &self,
        rendering: &Rendering,
        spp: u32,
        signals: &Signals,
        clock: &Clock,
    ) -> Result<(), Failure> {
        let names: Vec<String> = self.outputs.iter().map(|path| show_path(path)).collect();
        let names = names.join(", ");
        if rendering.complete {
            self.console.say(&format!("wrote {names} in {}", duration(clock.total())));
            return Ok(());
        }
        let (signal, name) = signals.received().unwrap_or((signal_hook::consts::SIGINT, "SIGINT"));
        let done = rendering.samples;
        let mut message =
            format!("stopped by {name} after about {done:.1} of {spp} samples a pixel; those are in {names}");
        if let Some(kept) = &self.kept {
            message += &format!("; --resume goes on from {}", show_path(&kept.file));
        }
        Err(Failure::Stopped { signal, message })
    }
}

/// One line that names the first warning and how many there are.
fn strict_error(findings: &Findings) -> Error {
    let count = findings.at_least(Severity::Warning);
    let worst = findings.counts().filter(|(_, _, severity)| *severity >= Severity::Warning);
    let first = worst.map(|(kind, count, _)| summary(findings, kind, count)).next().unwrap_or_default();
    Error::new(format!("{first}; {count} warnings, and --strict allows none"))
}

/// Names the flag that an error is about.
pub fn at_flag<T>(flag: &str, result: Result<T>) -> Result<T> {
    result.map_err(|mut e| {
        e.message = format!("{flag}: {}", e.message);
        e
    })
}

/// The number behind `--threads`.
pub fn threads(word: &str) -> Result<usize> {
    let number = word.parse().ok().filter(|n| (1..=1024).contains(n));
    number.ok_or_else(|| {
        Error::usage(format!("--threads: must be a whole number from 1 to 1024, not \"{word}\""))
    })
}

fn focus(word: &str) -> Result<[u32; 2]> {
    let numbers: Vec<Option<u32>> = word.split(',').map(|w| w.trim().parse().ok()).collect();
    match numbers.as_slice() {
        [Some(x), Some(y)] => Ok([*x, *y]),
        _ => Err(Error::usage(format!("--focus {word}: not of the form X,Y, a pixel, e.g. 320,240"))),
    }
}

fn exposure(word: &str) -> Result<f32> {
    let number = word.parse().ok().filter(|x: &f32| (-64.0..=64.0).contains(x));
    number.ok_or_else(|| Error::usage(format!("--exposure: must be a number from -64 to 64, not \"{word}\"")))
}

fn tone_map(word: &str) -> Result<ToneMap> {
    ToneMap::from_name(word).ok_or_else(|| {
        let known = ToneMap::NAMES.map(|row| row.0);
        Error::usage(format!("--tone-map: unknown curve \"{word}\""))
            .advise(unknown_word_advice(word, &known))
    })
}
