//! `drt diff-backends INPUT`: the same rays through everybody, and who is right where they differ.

use super::args::StudyArgs;
use super::console::{Console, write_stdout};
use super::converge::whole;
use super::progress::{Phase, Style};
use super::signals::Signals;
use super::{Failure, paths};
use clap::Args;
use drt::diff::court::Court;
use drt::diff::report::{json, table};
use drt::diff::reproducer::{Reproducer, minimal};
use drt::diff::{self, Contestant, Hooks, Report};
use drt::error::{Error, Result, show_path};
use drt::load::{self, Loaded, Override};
use drt::memory;
use drt::output;
use drt::shape::Mesh;
use serde_json::{Value, json};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Reproducers written at most.
const CASES: usize = 20;

/// Bytes a ray of each kind: seven kinds of rays of 36 bytes, twice as many while three of them are recorded, and two
/// contestants' answers of 22 bytes.
const RAY_BYTES: u64 = 7 * (36 + 2 * 22) + 3 * 36;

/// The flags of `drt diff-backends`.
#[derive(Args)]
pub struct DiffArgs {
    /// A mesh, a scene file (.toml), or a reproducer that an earlier run has written (case-N.toml)
    #[arg(value_name = "MESH|SCENE.toml|case-N.toml")]
    pub input: PathBuf,

    /// Rays of each kind, 1 to 100000000 (30000 by default)
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub rays: Option<String>,

    /// Who is asked: bvh, embree, embree-fast, each with an instruction set and a build quality if you like; several
    /// with commas (e.g. bvh,embree-avx2-low,fast), or all. The first is the one that the others are compared with
    #[arg(long, value_name = "LIST")]
    pub contestants: Option<String>,

    /// Let real disagreements of embree-fast, which is not watertight, count as failures too
    #[arg(long)]
    pub fast_counts: bool,

    /// Write the report as JSON to standard output, instead of the table
    #[arg(long)]
    pub json: bool,

    /// Write report.json and reproducers here; without it, reproducers go to INPUT's stem + -disagreements
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,

    #[command(flatten)]
    pub study: StudyArgs,
}

/// Everything that the words say, checked.
struct Job {
    args: DiffArgs,
    rays: u64,
    contestants: Vec<Contestant>,
    threads: usize,
    style: Style,
    console: Console,
    signals: Signals,
}

/// Asks, judges, prints, and writes reproducers.
///
/// # Errors
/// Wrong words, an input that cannot be read, an output that cannot be written; a real disagreement; a signal.
pub fn run(args: DiffArgs) -> Result<(), Failure> {
    let threads = args.study.threads()?;
    let job = Job {
        rays: whole("--rays", args.rays.as_deref(), 1, 100_000_000, 30_000)?,
        contestants: contestants(&args)?,
        threads,
        style: args.study.style()?,
        console: args.study.console(),
        signals: Signals::listen()?,
        args,
    };
    if let Some(folder) = &job.args.output {
        output::check_writable(&folder.join("report.json")).or_else(|_| make(folder))?;
    }
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
    let pool = pool.map_err(|e| Error::new(format!("cannot start {threads} threads: {e}")))?;
    pool.install(|| job.work())
}

fn contestants(args: &DiffArgs) -> Result<Vec<Contestant>> {
    let mut all = match &args.contestants {
        Some(list) => Contestant::named(list)?,
        None => Contestant::usual(),
    };
    all.iter_mut().for_each(|contestant| contestant.counts |= args.fast_counts);
    Ok(all)
}

/// The folder, if it can be made; it is checked before any work is done for it.
fn make(folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).map_err(|e| Error::io("create the folder", folder, &e))?;
    output::check_writable(&folder.join("report.json"))
}

impl Job {
    fn work(&self) -> Result<(), Failure> {
        let reach = self.args.study.files.reach(&self.args.input)?;
        if let Some(reproducer) = Reproducer::read(&self.args.input, &reach)? {
            let report = self.replay(&reproducer, &self.contestants)?;
            return self.conclude(&report, &reproducer.meshes, None);
        }
        self.signals.nothing_to_lose("loading");
        let mut loaded = self.load().map_err(|e| self.ended_early("loading", e))?;
        self.signals.something_to_lose();
        self.console.findings(&loaded.findings);
        let report_file = self.args.output.as_ref().map(|folder| folder.join("report.json"));
        let outputs: Vec<PathBuf> = report_file.into_iter().collect();
        paths::check_inputs(&outputs, &[], loaded.files.iter().map(PathBuf::as_path))?;
        let instances = loaded.scene.instances.places.len();
        if instances > 0 {
            self.console.say(&format!(
                "note: {instances} instances are compared as copies, where they stand when the shutter opens"
            ));
        }
        loaded.scene = diff::at_rest(loaded.scene)?;
        let (scene, settings) = (&loaded.scene, &loaded.settings);
        let needed = scene.need().of(settings) + self.rays * RAY_BYTES;
        if let Some(left) = memory::left().filter(|left| needed > left.bytes) {
            let advice = "take fewer --rays, or a machine with more memory";
            return Err(memory::refused(needed, &format!("{} rays", self.rays), left, advice).into());
        }
        let phase = Phase::begin(self.style, "diff");
        let hooks = Hooks { progress: &|share| phase.show_share(share), stop: &|| self.signals.stop() };
        let report = diff::run(scene, settings, &self.contestants, self.rays, &hooks)
            .map_err(|e| self.ended_early("comparing", e))?;
        drop(phase);
        self.conclude(&report, &scene.meshes, Some(&self.contestants))
    }

    fn replay(&self, reproducer: &Reproducer, contestants: &[Contestant]) -> Result<Report> {
        let hooks = Hooks { progress: &|_| (), stop: &|| self.signals.stop() };
        let all: Vec<&Contestant> = contestants.iter().collect();
        diff::compare::ask(&reproducer.meshes, std::slice::from_ref(&reproducer.rays), &all, &hooks)
    }

    fn load(&self) -> Result<Loaded> {
        let phase = Phase::begin(self.style, "load");
        let progress = |share: f64| {
            phase.show_share(share);
            !self.signals.stop()
        };
        let overrides =
            self.args.study.set.iter().map(|text| Override::parse(text)).collect::<Result<_>>()?;
        let reach = self.args.study.files.reach(&self.args.input)?;
        let options = load::Options { overrides, reach, progress: &progress, ..Default::default() };
        load::scene(&self.args.input, options)
    }

    fn ended_early(&self, doing: &str, error: Error) -> Failure {
        match self.signals.received() {
            Some((signal, name)) => Failure::Stopped {
                signal,
                message: format!("stopped by {name} while {doing}; nothing was finished"),
            },
            None => Failure::Error(error),
        }
    }

    /// Writes reproducers and the report, prints it, and fails if something is real. `contestants`: who may be asked
    /// again to cut cases down; a replayed case is cut down already.
    fn conclude(
        &self,
        report: &Report,
        meshes: &[Arc<Mesh>],
        contestants: Option<&[Contestant]>,
    ) -> Result<(), Failure> {
        let files = match contestants {
            Some(contestants) if !report.cases.is_empty() => self.reproduce(report, meshes, contestants)?,
            _ => Vec::new(),
        };
        let mut value = json(report);
        value["threads"] = json!(self.threads);
        value["triangles"] = json!(meshes.iter().map(|mesh| mesh.indices.len()).sum::<usize>());
        value["reproducers"] = files.iter().map(|file| Value::from(file.to_string_lossy())).collect();
        if let Some(folder) = &self.args.output {
            let text = format!("{}\n", serde_json::to_string_pretty(&value).unwrap_or_default());
            output::write_bytes(&folder.join("report.json"), text.as_bytes())?;
        }
        if self.args.json {
            write_stdout(&format!("{value}\n"))?;
        } else if !self.args.study.quiet {
            write_stdout(&table(report))?;
        }
        self.judge(report, &files)
    }

    fn judge(&self, report: &Report, files: &[PathBuf]) -> Result<(), Failure> {
        if let (false, Some((signal, name))) = (report.complete, self.signals.received()) {
            let message = format!("stopped by {name}; what was finished was reported");
            return Err(Failure::Stopped { signal, message });
        }
        let real = report.failures();
        let Some(case) = report.cases.first() else { return Ok(()) };
        let error = Error::new(format!("{real} real disagreements, the first: {}", report.sentence(case)));
        Err(Failure::Error(match files.first() {
            Some(file) => error.advise(format!("see drt diff-backends {}", show_path(file))),
            None => error,
        }))
    }

    /// Writes a reproducer for each of the first cases.
    fn reproduce(
        &self,
        report: &Report,
        meshes: &[Arc<Mesh>],
        contestants: &[Contestant],
    ) -> Result<Vec<PathBuf>> {
        let folder = self.args.output.clone().unwrap_or_else(|| {
            let stem = self.args.input.file_stem().unwrap_or_default().to_string_lossy();
            PathBuf::from(format!("{stem}-disagreements"))
        });
        make(&folder)?;
        let court = Court::new(meshes);
        let mut files = Vec::new();
        for (i, case) in report.cases.iter().take(CASES).enumerate() {
            if self.signals.stop() {
                break;
            }
            let reproducer = minimal(case, &court, meshes, contestants)?;
            files.push(reproducer.write(&folder, i + 1, &report.sentence(case))?);
        }
        Ok(files)
    }
}
