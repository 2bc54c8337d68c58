//! Scenes: load, build, make the reference, study.

use super::Job;
use crate::cli::progress::Phase;
use crate::cli::{Failure, args, paths};
use drt::converge::scene::{Stage, shrink};
use drt::converge::{F32, Hooks, Reference, Study, Value};
use drt::error::{Error, Result, one_line, show_path};
use drt::load::{self, Loaded, Override, picture};
use drt::memory;
use drt::render::{self, Progress};
use std::path::{Path, PathBuf};

/// The longest side of a scene's picture, where nothing is said of its size: some 9000 pixels average the noise well.
const LONGEST_SIDE: u32 = 96;

impl Job {
    /// Loads, builds, makes the reference and studies; a signal before the study leaves nothing to write.
    pub fn scene(&self) -> Result<Study, Failure> {
        let ended_early = |doing: &str, error: Error| match self.signals.received() {
            Some((signal, name)) => Failure::Stopped {
                signal,
                message: format!("stopped by {name} while {doing}; nothing was written"),
            },
            None => Failure::Error(error),
        };
        self.signals.nothing_to_lose("preparing the study");
        let truth = self.args.reference.as_deref().map(truth).transpose()?;
        let mut loaded = self.load().map_err(|e| ended_early("loading", e))?;
        self.console.findings(&loaded.findings);
        paths::check_inputs(&self.args.output, &[], loaded.files.iter().map(PathBuf::as_path))?;
        self.set_size(&mut loaded, truth.as_ref())?;
        if let Some(doubt) = truth.as_ref().and_then(|truth| self.doubt(truth, &loaded)) {
            self.console.say(&format!("warning: --reference {doubt}"));
        }
        let (scene, settings) = (&loaded.scene, &loaded.settings);
        scene.need().check(settings, memory::left())?;

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
        let reference = match truth {
            Some(truth) => truth.reference,
            None => self.reference(&stage).map_err(|e| ended_early("making the reference", e))?,
        };
        self.signals.something_to_lose();
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
            overrides.push(args::size(size)?);
        }
        // One path a sample, so that N counts paths. First, so that `--set` can say otherwise, as with the depth.
        overrides.push(Override::flag("--split", "render.split", "1")?);
        if let Some(depth) = self.args.max_depth.as_deref().or(self.subject.max_depth) {
            overrides.push(Override::flag("--max-depth", "render.max_depth", depth)?);
        }
        for text in &self.args.study.set {
            overrides.push(Override::parse(text)?);
        }
        let reach = self.args.study.files.reach(&self.args.input)?;
        let options = load::Options { overrides, reach, progress: &progress, ..Default::default() };
        load::scene(&self.args.input, options)
    }

    /// The reference's size, or a small one, unless one is asked for.
    fn set_size(&self, loaded: &mut Loaded, truth: Option<&Truth>) -> Result<()> {
        let settings = &mut loaded.settings;
        let keys =
            self.args.study.set.iter().filter_map(|set| set.split_once('=').map(|(key, _)| key.trim()));
        let is_size =
            |key: &str| key == "film" || key.starts_with("film.size") || key.starts_with("film.crop");
        let is_asked_for = self.args.size.is_some() || keys.into_iter().any(is_size);
        match truth {
            Some(truth) if !is_asked_for => (settings.size, settings.crop) = (truth.size, truth.crop),
            None if !is_asked_for && settings.crop.is_none() => {
                settings.size = shrink(settings.size, LONGEST_SIDE);
            }
            _ => {}
        }
        let shown = |size: [u32; 2], crop: Option<[u32; 4]>| crop.map_or(size, |[_, _, w, h]| [w, h]);
        let ours = shown(settings.size, settings.crop);
        match truth.map(|truth| shown(truth.size, truth.crop)) {
            Some(theirs) if theirs != ours => Err(Error::usage(format!(
                "--reference has {}x{} pixels, and the scene is rendered with {}x{}",
                theirs[0], theirs[1], ours[0], ours[1]
            ))
            .advise("leave --size and film keys to the reference, or make one of that size")),
            _ => Ok(()),
        }
    }

    /// Why a reference that drt rendered is not what the study's rules tend to.
    fn doubt(&self, truth: &Truth, loaded: &Loaded) -> Option<String> {
        let settings: serde_json::Value = serde_json::from_str(&truth.settings).ok()?;
        let depth = settings["render"]["max_depth"].as_u64()?;
        if depth != u64::from(loaded.settings.max_depth) {
            let ours = loaded.settings.max_depth;
            return Some(format!("was rendered with max_depth {depth}, and the study is with {ours}"));
        }
        let rule = &settings["film"]["rule"];
        let of_centres = rule["type"] == "uniform" && rule["grid"] == serde_json::json!([1, 1]);
        (self.subject.is_of_centres && !of_centres).then(|| {
            "shows whole pixels, and the study their centres: render it with film.rule = \
             { type = \"uniform\", grid = [1, 1], per_cell = SAMPLES }"
                .to_string()
        })
    }

    fn reference(&self, stage: &Stage<'_>) -> Result<Reference> {
        let phase = Phase::begin(self.style, "reference");
        let progress = |share| phase.show_share(share);
        let hooks = Hooks { progress: &progress, stop: &|| self.signals.stop() };
        let made = stage.reference(self.subject, &self.plan, &hooks)?;
        made.ok_or_else(|| Error::new("the reference was not finished"))
    }
}

/// The picture behind `--reference`.
struct Truth {
    reference: Reference,
    /// What the picture says of how it was rendered; empty where it says nothing.
    settings: String,
    size: [u32; 2],
    crop: Option<[u32; 4]>,
}

fn truth(path: &Path) -> Result<Truth> {
    let image = picture::read(path)?.image;
    let value = Value::picture(&image);
    if !value.is_finite() {
        return Err(Error::new("the reference has values that are not finite").at(path));
    }
    let name = Path::new(path.file_name().unwrap_or_default());
    let is_whole = image.full_size == [image.width, image.height];
    let [x, y] = image.offset;
    Ok(Truth {
        settings: image.settings.clone(),
        reference: Reference { description: show_path(name), value, rmse: 0.0, rounding: F32 },
        size: image.full_size,
        crop: (!is_whole).then_some([x, y, image.width, image.height]),
    })
}
