//! `drt render`: check, load, build, render, write; what can be refused is refused before the first ray.

mod series;

pub use series::SeriesArgs;

use super::Failure;
use super::args::RenderArgs;
use super::console::{Console, Verbosity, summary};
use super::machine;
use super::paths;
use super::progress::{Phase, Style, duration};
use super::signals::Signals;
use super::stats::{Clock, Report};
use drt::accel::Intersector;
use drt::error::{Error, Findings, Result, Severity, show_path, unknown_word_advice};
use drt::load::auto::{Up, View};
use drt::load::sky::SkySource;
use drt::load::{self, Loaded};
use drt::math::isa::Isa;
use drt::output::{self, ToneMap};
use drt::render::{self, Hooks, Progress, RenderStats, Rendering};
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
    style: Style,
    console: Console,
}

/// Runs the subcommand.
pub fn run(args: RenderArgs) -> Result<(), Failure> {
    let clock = Clock::start();
    let job = Job::new(args)?;
    let signals = Signals::listen()?;
    paths::check(&job.outputs, job.args.stats.as_deref())?;
    paths::check_inputs(&job.outputs, job.args.stats.as_deref(), [job.input.as_path()].into_iter())?;
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
        let series = Series::new(&args.series, &args.output, &input)?;
        let one = || paths::outputs(&args.output, &input);
        Ok(Job {
            outputs: series.as_ref().map_or_else(one, Series::first_outputs),
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
        let mut loaded = self.load(signals).map_err(|e| ended_early("loading", e))?;
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
        let needed = machine::prediction(scene.triangles(), settings);
        console.detail(&format!("building and rendering take about {}", machine::megabytes(needed)));
        machine::check_memory(needed)?;

        let phase = Phase::begin(self.style, "build");
        let progress = |p| {
            if let Progress::Build(share) = p {
                phase.show_share(share)
            }
        };
        let hooks = Hooks { progress: &progress, stop: &|| signals.stop() };
        let mut accel =
            render::build(scene, settings, self.isa, &hooks).map_err(|e| ended_early("building", e))?;
        drop(phase);
        let seconds = clock.end("build");
        console.detail(&format!(
            "built {} ({}, {}) in {}",
            settings.backend.name(),
            accel.isa(),
            machine::megabytes(accel.bytes() as u64),
            duration(seconds)
        ));

        if let Some(pixel) = self.focus {
            let distance = render::focus(scene, settings, &*accel, pixel)?;
            console.detail(&format!("focused at {distance} m"));
            loaded.scene.camera.focus_distance = distance;
        }
        if let Some(series) = &self.series {
            return self.render_series(series, &mut loaded, &mut *accel, signals, clock);
        }
        let (scene, settings) = (&loaded.scene, &loaded.settings);
        let phase = Phase::begin(self.style, "render");
        let progress = |p| {
            if let Progress::Render(done, total) = p {
                phase.show(done, total)
            }
        };
        let hooks = Hooks { progress: &progress, stop: &|| signals.stop() };
        let rendering = render::render(scene, settings, &*accel, self.isa, &hooks)?;
        drop(phase);
        let seconds = clock.end("render");
        let rays = rendering.stats.camera_rays + rendering.stats.bounce_rays + rendering.stats.shadow_rays;
        console.detail(&format!("traced {rays} rays in {}", duration(seconds)));
        if rendering.stats.camera_rays == 0 {
            // Not one sample: an empty picture would be a lie.
            let nothing = Error::new("nothing was rendered");
            return if rendering.complete {
                Err(nothing.into())
            } else {
                Err(ended_early("rendering", nothing))
            };
        }

        for path in &self.outputs {
            output::write(path, &rendering.image, &self.display)?;
        }
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

    fn load(&self, signals: &Signals) -> Result<Loaded> {
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
                progress: &progress,
            },
        )
    }

    /// Says what was found; with `--strict`, a warning is an error.
    fn judge(&self, loaded: &Loaded) -> Result<()> {
        let findings = &loaded.findings;
        let inputs = loaded.files.iter().map(PathBuf::as_path);
        let outputs = self.series.as_ref().map_or_else(|| self.outputs.clone(), Series::all_outputs);
        paths::check_inputs(&outputs, self.args.stats.as_deref(), inputs)?;
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
        let pixels = u64::from(rendering.image.width) * u64::from(rendering.image.height);
        let done = rendering.stats.camera_rays as f64 / pixels.max(1) as f64;
        let message =
            format!("stopped by {name} after about {done:.1} of {spp} samples a pixel; those are in {names}");
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
