//! `drt converge INPUT`: error against the number of samples for every rule, as a figure, CSV, JSON and a table.

use super::console::{Console, Verbosity, write_stdout};
use super::progress::{Phase, Style, duration};
use super::render::{at_flag, threads};
use super::signals::Signals;
use super::{Failure, machine, paths};
use clap::{ArgAction, Args};
use drt::converge::integrals::Integral;
use drt::converge::report::{self, Encode};
use drt::converge::scene::{self, Stage, Subject};
use drt::converge::{self, Hooks, Labels, Plan, Reference, Rule, Study, Value};
use drt::error::{Error, Result, one_line, show_path};
use drt::load::{self, Loaded, Override, picture};
use drt::output;
use drt::render::{self, Progress};
use std::path::{Path, PathBuf};
use std::time::Instant;

/// The flags of `drt converge`.
#[derive(Args)]
pub struct ConvergeArgs {
    /// A scene file (.toml), a mesh (.obj), or a built-in integral (listed below)
    #[arg(value_name = "SCENE.toml|MESH.obj|INTEGRAL")]
    pub input: PathBuf,

    /// Write the study here; repeat for several formats: .svg (the figure), .csv, .json
    #[arg(short, long, value_name = "FILE")]
    pub output: Vec<PathBuf>,

    /// Write the JSON to standard output, instead of the table
    #[arg(long)]
    pub json: bool,

    /// Only these rules, separated by commas
    #[arg(long, value_name = "LIST")]
    pub rules: Option<String>,

    /// What of a scene is varied (the first of the list below by default)
    #[arg(long, value_name = "NAME")]
    pub vary: Option<String>,

    /// The largest N of 1, 4, 16, …: 1 to 16777216 (4096 by default), of scenes 1 to 65536 (256 by default)
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub max_n: Option<String>,

    /// Independent runs at each N, 1 to 65536 (64 by default, of scenes 1)
    #[arg(long, value_name = "K", allow_negative_numbers = true)]
    pub seeds: Option<String>,

    /// The first run's seed, 0 to 2^64-1 (0 by default); the others' follow it
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub seed: Option<String>,

    /// The picture taken for true, instead of a long run; a scene is rendered at its size
    #[arg(long, value_name = "FILE.exr")]
    pub reference: Option<PathBuf>,

    /// Width and height of a scene's picture (by default its own, shrunk to 96 pixels at most), e.g. 64x48
    #[arg(long, value_name = "WxH", allow_hyphen_values = true)]
    pub size: Option<String>,

    /// Set any key of the scene file, e.g. render.max_depth=4; repeat for several
    #[arg(long, value_name = "KEY=VALUE", action = ArgAction::Append)]
    pub set: Vec<String>,

    /// Threads, 1 to 1024 (all by default); the errors do not depend on it
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub threads: Option<String>,

    /// Show progress on stderr: auto (a bar in a terminal), plain, json, none
    #[arg(long, value_name = "STYLE")]
    pub progress: Option<String>,

    /// Say nothing but errors, and print no table
    #[arg(short, long)]
    pub quiet: bool,
}

/// The longest side of a scene's picture, where nothing is said of its size: some 9000 pixels average the noise well.
const LONGEST_SIDE: u32 = 96;

/// Everything that the words say, checked.
struct Job {
    args: ConvergeArgs,
    outputs: Vec<(PathBuf, Encode)>,
    integral: Option<&'static Integral>,
    subject: &'static Subject,
    plan: Plan,
    style: Style,
    console: Console,
    signals: Signals,
    begun: Instant,
}

/// Runs the study and writes it.
///
/// # Errors
/// Wrong words, an input that cannot be read, an output that cannot be written; a signal.
pub fn run(args: ConvergeArgs) -> Result<(), Failure> {
    let threads = args.threads.as_deref().map_or_else(|| Ok(machine::threads()), threads)?;
    let job = Job::new(args)?;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|e| Error::new(format!("cannot start {threads} threads: {e}")))?;
    pool.install(|| job.work())
}

impl Job {
    fn new(args: ConvergeArgs) -> Result<Job> {
        let begun = Instant::now();
        let integral = args.input.to_str().and_then(Integral::named);
        if integral.is_none() && args.input.extension().is_none() && !args.input.exists() {
            return Err(Integral::unknown(&args.input.to_string_lossy()));
        }
        let style = args.progress.as_deref().map_or(Ok(Style::Auto), Style::from_name)?;
        let vary = |word: &str| at_flag("--vary", Subject::from_name(word));
        let job = Job {
            plan: plan(&args, integral.is_some())?,
            subject: vary(args.vary.as_deref().unwrap_or(Subject::TABLE[0].0))?,
            outputs: outputs(&args.output)?,
            style: if args.quiet { Style::None } else { style },
            console: Console { verbosity: if args.quiet { Verbosity::Quiet } else { Verbosity::Normal } },
            signals: Signals::listen()?,
            integral,
            begun,
            args,
        };
        job.refuse_scene_flags()?;
        paths::check_files(&job.args.output)?;
        let inputs = [Some(job.args.input.as_path()), job.args.reference.as_deref()];
        paths::check_inputs(&job.args.output, None, inputs.into_iter().flatten())?;
        Ok(job)
    }

    /// An integral has no picture.
    fn refuse_scene_flags(&self) -> Result<()> {
        let args = &self.args;
        let flags = [
            ("--vary", args.vary.is_some()),
            ("--reference", args.reference.is_some()),
            ("--size", args.size.is_some()),
            ("--set", !args.set.is_empty()),
        ];
        match (self.integral, flags.into_iter().find(|(_, is_given)| *is_given)) {
            (Some(integral), Some((flag, _))) => {
                Err(Error::usage(format!("{flag} is for scenes; {} is an integral", integral.name)))
            }
            _ => Ok(()),
        }
    }

    fn work(&self) -> Result<(), Failure> {
        let study = match self.integral {
            Some(integral) => {
                let rules = self.chosen(integral.rules()?)?;
                self.study(&rules, integral.labels(), integral.reference())?
            }
            None => self.scene()?,
        };
        self.write(&study)
    }

    fn chosen<'a>(&self, rules: Vec<Rule<'a>>) -> Result<Vec<Rule<'a>>> {
        match &self.args.rules {
            Some(names) => at_flag("--rules", converge::choose(rules, names)),
            None => Ok(rules),
        }
    }

    fn study(&self, rules: &[Rule<'_>], labels: Labels, reference: Reference) -> Result<Study> {
        let phase = Phase::begin(self.style, "study");
        let progress = |share| phase.show_share(share);
        let hooks = Hooks { progress: &progress, stop: &|| self.signals.stop() };
        converge::run(rules, &self.plan, labels, reference, &hooks)
    }

    /// Loads, builds, makes the reference and studies; a signal before the study leaves nothing to write.
    fn scene(&self) -> Result<Study, Failure> {
        let ended_early = |doing: &str, error: Error| match self.signals.received() {
            Some((signal, name)) => Failure::Stopped {
                signal,
                message: format!("stopped by {name} while {doing}; nothing was written"),
            },
            None => Failure::Error(error),
        };
        let truth = self.args.reference.as_deref().map(picture::read).transpose()?;
        let mut loaded = self.load().map_err(|e| ended_early("loading", e))?;
        self.console.findings(&loaded.findings);
        paths::check_inputs(&self.args.output, None, loaded.files.iter().map(PathBuf::as_path))?;
        self.set_size(&mut loaded, truth.as_ref());
        let (scene, settings) = (&loaded.scene, &loaded.settings);
        machine::check_memory(machine::prediction(scene.triangles(), settings))?;

        let phase = Phase::begin(self.style, "build");
        let progress = |p| {
            if let Progress::Build(share) = p {
                phase.show_share(share)
            }
        };
        let hooks = render::Hooks { progress: &progress, stop: &|| self.signals.stop() };
        let accel = render::build(scene, settings, None, &hooks).map_err(|e| ended_early("building", e))?;
        drop(phase);

        let stage = Stage { scene, settings, accel: &*accel, isa: None };
        let rules = self.chosen(stage.rules(self.subject))?;
        let name = one_line(&self.args.input.file_stem().unwrap_or_default().to_string_lossy());
        let reference = match (&self.args.reference, &truth) {
            (Some(path), Some(truth)) => Reference {
                description: show_path(Path::new(path.file_name().unwrap_or_default())),
                value: Value::picture(&truth.image),
                rmse: 0.0,
            },
            _ => self.reference(&stage).map_err(|e| ended_early("making the reference", e))?,
        };
        Ok(self.study(&rules, stage.labels(&name, self.subject), reference)?)
    }

    fn load(&self) -> Result<Loaded> {
        let phase = Phase::begin(self.style, "load");
        let progress = |share: f64| {
            phase.show_share(share);
            !self.signals.stop()
        };
        let mut overrides: Vec<Override> = Vec::new();
        if let Some(size) = &self.args.size {
            overrides.push(super::args::size(size)?);
        }
        for text in &self.args.set {
            overrides.push(Override::parse(text)?);
        }
        load::scene(&self.args.input, load::Options { overrides, progress: &progress, ..Default::default() })
    }

    /// The reference's size, or a small one, unless one is asked for.
    fn set_size(&self, loaded: &mut Loaded, truth: Option<&picture::Picture>) {
        let settings = &mut loaded.settings;
        let is_asked_for =
            self.args.size.is_some() || self.args.set.iter().any(|s| s.starts_with("film.size"));
        match truth.map(|truth| &truth.image) {
            _ if is_asked_for => {}
            Some(image) => {
                let is_whole = image.full_size == [image.width, image.height];
                let [x, y] = image.offset;
                settings.size = image.full_size;
                settings.crop = (!is_whole).then_some([x, y, image.width, image.height]);
            }
            None if settings.crop.is_none() => settings.size = scene::shrink(settings.size, LONGEST_SIDE),
            None => {}
        }
    }

    fn reference(&self, stage: &Stage<'_>) -> Result<Reference> {
        let phase = Phase::begin(self.style, "reference");
        let progress = |share| phase.show_share(share);
        let hooks = Hooks { progress: &progress, stop: &|| self.signals.stop() };
        let made = stage.reference(self.subject, &self.plan, &hooks)?;
        made.ok_or_else(|| Error::new("the reference was not finished"))
    }

    /// Writes what there is, whether or not it was stopped.
    fn write(&self, study: &Study) -> Result<(), Failure> {
        let stopped = self.signals.received().filter(|_| !study.complete);
        let is_empty = study.series.iter().all(|series| series.points.is_empty());
        let names: Vec<String> = self.args.output.iter().map(|path| show_path(path)).collect();
        let names = names.join(", ");
        if !is_empty {
            for (path, encode) in &self.outputs {
                output::write_bytes(path, encode(study)?.as_bytes())?;
            }
            if self.args.json {
                write_stdout(&report::json(study))?;
            } else if !self.args.quiet {
                write_stdout(&report::table(study))?;
            }
        }
        match stopped {
            None => {
                if !names.is_empty() {
                    let took = duration(self.begun.elapsed().as_secs_f64());
                    self.console.say(&format!("wrote {names} in {took}"));
                }
                Ok(())
            }
            Some((signal, name)) => {
                let fate = match (is_empty, names.is_empty()) {
                    (true, _) => "nothing was finished, nothing was written".to_string(),
                    (false, true) => "what was finished is in the table".to_string(),
                    (false, false) => format!("what was finished is in {names}"),
                };
                Err(Failure::Stopped { signal, message: format!("stopped by {name}; {fate}") })
            }
        }
    }
}

/// The outputs with their encoders.
fn outputs(paths: &[PathBuf]) -> Result<Vec<(PathBuf, Encode)>> {
    paths.iter().map(|path| Ok((path.clone(), report::format_of(path)?))).collect()
}

fn plan(args: &ConvergeArgs, is_integral: bool) -> Result<Plan> {
    let (most, usual, runs) = if is_integral { (1 << 24, 4096, 64) } else { (scene::MAX_N, 256, 1) };
    Ok(Plan {
        max_n: whole("--max-n", args.max_n.as_deref(), 1, most, usual)?,
        seeds: whole("--seeds", args.seeds.as_deref(), 1, 65536, runs)?,
        seed: whole("--seed", args.seed.as_deref(), 0, u64::MAX, 0)?,
    })
}

/// A whole number within its range.
fn whole(flag: &str, word: Option<&str>, least: u64, most: u64, usual: u64) -> Result<u64> {
    let Some(word) = word else { return Ok(usual) };
    word.parse().ok().filter(|n| (least..=most).contains(n)).ok_or_else(|| {
        Error::usage(format!("{flag}: must be a whole number from {least} to {most}, not \"{word}\""))
    })
}
