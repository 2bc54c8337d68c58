//! `drt converge INPUT`: error against the number of samples for every rule, as a figure, CSV, JSON and a table.

mod scene;

use super::args::StudyArgs;
use super::console::{Console, write_stdout};
use super::progress::{Phase, Style, duration};
use super::render::at_flag;
use super::signals::Signals;
use super::{Failure, paths};
use clap::Args;
use drt::converge::integrals::Integral;
use drt::converge::report::{self, Encode};
use drt::converge::scene::{MAX_N, Subject};
use drt::converge::{self, Hooks, Labels, Plan, Reference, Rule, Study};
use drt::error::{Error, Result, show_path};
use drt::output;
use std::path::PathBuf;
use std::time::Instant;

/// The flags of `drt converge`.
#[derive(Args)]
pub struct ConvergeArgs {
    /// A scene file (.toml), a mesh, or a built-in integral (listed below)
    #[arg(value_name = "SCENE.toml|MESH|INTEGRAL")]
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

    /// Scattering events at most; 1 by default where the hemisphere is varied, else the scene's own
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub max_depth: Option<String>,

    #[command(flatten)]
    pub study: StudyArgs,
}

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
    let threads = args.study.threads()?;
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
        let vary = |word: &str| at_flag("--vary", Subject::from_name(word));
        let job = Job {
            plan: plan(&args, integral.is_some())?,
            subject: vary(args.vary.as_deref().unwrap_or(Subject::TABLE[0].0))?,
            outputs: outputs(&args.output)?,
            style: args.study.style()?,
            console: args.study.console(),
            signals: Signals::listen()?,
            integral,
            begun,
            args,
        };
        job.refuse_scene_flags()?;
        if let (None, Some(names)) = (integral, &job.args.rules) {
            let known: Vec<&str> = job.subject.rules.iter().map(|rule| rule.name).collect();
            at_flag("--rules", converge::check_names(names, &known))?;
        }
        paths::check_files(&job.args.output)?;
        let inputs = [Some(job.args.input.as_path()), job.args.reference.as_deref()];
        paths::check_inputs(&job.args.output, &[], inputs.into_iter().flatten())?;
        Ok(job)
    }

    /// An integral has no picture.
    fn refuse_scene_flags(&self) -> Result<()> {
        let args = &self.args;
        let flags = [
            ("--vary", args.vary.is_some()),
            ("--reference", args.reference.is_some()),
            ("--size", args.size.is_some()),
            ("--max-depth", args.max_depth.is_some()),
            ("--set", !args.study.set.is_empty()),
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
            } else if !self.args.study.quiet {
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
    let (most, usual, runs) = if is_integral { (1 << 24, 4096, 64) } else { (MAX_N, 256, 1) };
    Ok(Plan {
        max_n: whole("--max-n", args.max_n.as_deref(), 1, most, usual)?,
        seeds: whole("--seeds", args.seeds.as_deref(), 1, 65536, runs)?,
        seed: whole("--seed", args.seed.as_deref(), 0, u64::MAX, 0)?,
    })
}

/// A whole number within its range.
pub fn whole(flag: &str, word: Option<&str>, least: u64, most: u64, usual: u64) -> Result<u64> {
    let Some(word) = word else { return Ok(usual) };
    word.parse().ok().filter(|n| (least..=most).contains(n)).ok_or_else(|| {
        Error::usage(format!("{flag}: must be a whole number from {least} to {most}, not \"{word}\""))
    })
}
