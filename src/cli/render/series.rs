//! `--turntable` and `--frames`: many pictures of a scene that is read and built once.

use super::Job;
use crate::cli::Failure;
use crate::cli::progress::{Phase, duration};
use crate::cli::signals::Signals;
use crate::cli::stats::Clock;
use clap::Args;
use drt::accel::Intersector;
use drt::camera::CameraSpec;
use drt::error::{Error, Result, show_path};
use drt::load::{Loaded, picture};
use drt::output;
use drt::render::{self, Hooks, Progress, RenderStats, Rendering};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// More pictures than this are taken for a mistake.
const MOST: u32 = 1_000_000;

/// The flags.
#[derive(Args)]
pub struct SeriesArgs {
    /// Render N pictures from all around, the first one the ordinary view: -o frame-####.png
    ///
    /// The camera goes around the point looked at, about the up axis, counter-clockwise seen from above. Numbers begin
    /// with 0 and have as many digits as the name has #.
    #[arg(long, value_name = "N", help_heading = "Series", allow_negative_numbers = true)]
    pub turntable: Option<String>,

    /// Render the frames A to B, both included, of a scene that moves: frame f opens the shutter f/fps seconds later
    #[arg(
        long,
        value_name = "A..B",
        help_heading = "Series",
        conflicts_with = "turntable",
        allow_hyphen_values = true
    )]
    pub frames: Option<String>,
}

/// A series that is asked for.
pub struct Series {
    kind: Kind,
    first: u32,
    last: u32,
    /// The names with `####` for the number.
    patterns: Vec<PathBuf>,
    resume: bool,
}

#[derive(Clone, Copy)]
enum Kind {
    Turntable(u32),
    Frames,
}

impl Series {
    /// What the words say; `None` where one picture is asked for. `resume`: pictures that are whole already and were made
    /// with the same settings are left out. `asked`: the names after -o.
    ///
    /// # Errors
    /// Numbers that are none; names without a place for the number.
    pub fn new(args: &SeriesArgs, resume: bool, asked: &[PathBuf], input: &Path) -> Result<Option<Series>> {
        let (kind, first, last) = match (&args.turntable, &args.frames) {
            (Some(word), _) => {
                let count = word.parse().ok().filter(|n| (1..=MOST).contains(n)).ok_or_else(|| {
                    Error::usage(format!(
                        "--turntable: must be a whole number from 1 to {MOST}, not \"{word}\""
                    ))
                })?;
                (Kind::Turntable(count), 0, count - 1)
            }
            (None, Some(word)) => {
                let (first, last) = range(word)?;
                (Kind::Frames, first, last)
            }
            (None, None) => return Ok(None),
        };
        let patterns = if asked.is_empty() {
            let mut name = input.file_stem().unwrap_or("frame".as_ref()).to_os_string();
            name.push("-####.png");
            vec![name.into()]
        } else {
            asked.to_vec()
        };
        for pattern in &patterns {
            if numbered(pattern, 0).is_none() {
                return Err(Error::usage(format!(
                    "{}: the name of a series needs a place for the number",
                    show_path(pattern)
                ))
                .advise("e.g. -o frame-####.png"));
            }
        }
        Ok(Some(Series { kind, first, last, patterns, resume }))
    }

    /// The files of one picture.
    pub fn outputs(&self, number: u32) -> Vec<PathBuf> {
        self.patterns.iter().filter_map(|pattern| numbered(pattern, number)).collect()
    }

    /// All files.
    pub fn all_outputs(&self) -> Vec<PathBuf> {
        (self.first..=self.last).flat_map(|number| self.outputs(number)).collect()
    }

    /// The files of the first picture.
    pub fn first_outputs(&self) -> Vec<PathBuf> {
        self.outputs(self.first)
    }

    /// The camera of one picture.
    fn camera(&self, usual: &CameraSpec, number: u32) -> CameraSpec {
        match self.kind {
            Kind::Turntable(count) => usual.orbited(360.0 * f64::from(number) / f64::from(count)),
            Kind::Frames => {
                let later = f64::from(number) / usual.fps;
                CameraSpec { shutter: usual.shutter.map(|time| time + later), ..usual.clone() }
            }
        }
    }

    /// What a picture's settings say of its place in the series.
    fn place(&self, camera: &CameraSpec, number: u32) -> Value {
        match self.kind {
            Kind::Turntable(count) => json!({ "turntable": count, "number": number }),
            Kind::Frames => json!({ "fps": camera.fps, "shutter": camera.shutter, "number": number }),
        }
    }
}

/// `A..B`, or one number.
fn range(word: &str) -> Result<(u32, u32)> {
    let number = |text: &str| text.trim().parse().ok().filter(|n| *n <= MOST);
    let ends = word.split_once("..").unwrap_or((word, word));
    match (number(ends.0), number(ends.1.trim_start_matches('='))) {
        (Some(first), Some(last)) if first <= last => Ok((first, last)),
        _ => Err(Error::usage(format!("--frames {word}: not of the form A..B with 0 ≤ A ≤ B ≤ {MOST}"))
            .advise("e.g. --frames 0..47; both ends are rendered")),
    }
}

/// The name with the number in place of its last run of `#`, with leading zeros; `None` where it has none.
fn numbered(pattern: &Path, number: u32) -> Option<PathBuf> {
    let name = pattern.file_name()?.to_str()?;
    let end = name.rfind('#')? + 1;
    let start = name.get(..end)?.trim_end_matches('#').len();
    let width = end - start;
    Some(pattern.with_file_name(format!("{}{number:0width$}{}", name.get(..start)?, name.get(end..)?)))
}

/// True when `path` is a whole picture that was made with these settings.
fn is_done(path: &Path, settings: &Value) -> bool {
    let made = picture::read(path).ok().and_then(|p| serde_json::from_str::<Value>(&p.image.settings).ok());
    made.is_some_and(|made| made == *settings)
}

impl Job {
    /// Renders the series and says how it ended.
    pub(super) fn render_series(
        &self,
        series: &Series,
        loaded: &mut Loaded,
        accel: &mut dyn Intersector,
        signals: &Signals,
        mut clock: Clock,
    ) -> Result<(), Failure> {
        let usual = loaded.scene.camera.clone();
        let count = series.last - series.first + 1;
        let (mut made, mut stats, mut complete) = (0, RenderStats::default(), true);
        for number in series.first..=series.last {
            loaded.scene.camera = series.camera(&usual, number);
            accel.set_shutter(loaded.scene.camera.shutter);
            let outputs = series.outputs(number);
            let mut tag: Value =
                serde_json::from_str(&render::attribute(&loaded.scene, &loaded.settings, accel))
                    .unwrap_or_default();
            tag["frame"] = series.place(&loaded.scene.camera, number);
            if series.resume && outputs.iter().all(|path| is_done(path, &tag)) {
                continue;
            }
            let rendering = self.one(number - series.first + 1, count, loaded, accel, signals)?;
            clock.end("render");
            complete &= rendering.complete;
            stats = stats.plus(&rendering.stats);
            if rendering.stats.camera_rays > 0 {
                self.write_numbered(rendering, &outputs, &tag["frame"])?;
                made += 1;
            }
            clock.end("write");
            if signals.stop() {
                break;
            }
        }
        loaded.scene.camera = usual;
        self.report(loaded, accel, &stats, complete, &clock)?;
        if let Some((signal, name)) = signals.received() {
            let message = format!("stopped by {name} after {made} pictures; --resume goes on with the rest");
            return Err(Failure::Stopped { signal, message });
        }
        let names: Vec<String> = series.patterns.iter().map(|path| show_path(path)).collect();
        let whole = if made == count { String::new() } else { format!(" ({} were there)", count - made) };
        self.console.say(&format!(
            "wrote {made} pictures as {}{whole} in {}",
            names.join(", "),
            duration(clock.total())
        ));
        Ok(())
    }

    /// Renders one picture of the series, the `index`th of `count`.
    fn one(
        &self,
        index: u32,
        count: u32,
        loaded: &Loaded,
        accel: &dyn Intersector,
        signals: &Signals,
    ) -> Result<Rendering> {
        self.console.detail(&format!("picture {index} of {count}"));
        let phase = Phase::begin(self.style, "render");
        let progress = |p| {
            if let Progress::Render { done, total, share } = p {
                // The bar is that of the whole series.
                let before = u64::from(index - 1);
                let share = (before as f64 + share) / f64::from(count);
                phase.show_work(share, before * total + done, u64::from(count) * total);
            }
        };
        let hooks = Hooks { progress: &progress, stop: &|| signals.stop() };
        render::render(&loaded.scene, &loaded.settings, accel, self.isa, &hooks)
    }

    /// Writes a picture with its place in the series among its settings.
    fn write_numbered(&self, mut rendering: Rendering, outputs: &[PathBuf], place: &Value) -> Result<()> {
        if let Ok(mut settings) = serde_json::from_str::<Value>(&rendering.image.settings) {
            settings["frame"] = place.clone();
            rendering.image.settings = settings.to_string();
        }
        for path in outputs {
            output::write(path, &rendering.image, &self.display)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_go_where_the_last_run_of_hashes_is() {
        let named = |pattern: &str, number| numbered(Path::new(pattern), number);
        assert_eq!(named("a/b-####.png", 7), Some("a/b-0007.png".into()));
        assert_eq!(named("#1/x-##.exr", 123), Some("#1/x-123.exr".into()));
        assert_eq!(named("###-#.png", 4), Some("###-4.png".into()));
        assert_eq!(named("####/x.png", 4), None);
    }

    #[test]
    fn ranges_include_both_ends() {
        assert_eq!(range("0..47").unwrap(), (0, 47));
        assert_eq!(range("5").unwrap(), (5, 5));
        for wrong in ["", "..", "3..1", "-1..4", "a..b", "0..1000001", "1.5..2"] {
            assert!(range(wrong).is_err(), "{wrong}");
        }
    }
}
