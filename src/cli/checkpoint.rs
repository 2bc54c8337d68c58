//! `--checkpoint`, `--every`, `--resume`: where a render's progress is kept, and what it goes on from.

use super::console::Console;
use clap::Args;
use drt::checkpoint::{self, Checkpoint};
use drt::error::{Error, Result, show_path};
use drt::render::{self, Keep};
use drt::scene::{Scene, Settings};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::time::Duration;

/// The flags.
#[derive(Args)]
pub struct CheckpointArgs {
    /// Keep the progress in this file, so that --resume can go on after an interruption
    ///
    /// The file belongs to this scene and these settings, and stays when the picture is finished, so that it can get
    /// more samples. Without --resume an earlier checkpoint there is replaced.
    #[arg(long, value_name = "FILE", help_heading = "Interruptions")]
    pub checkpoint: Option<PathBuf>,

    /// Time between two saves of the checkpoint, 10ms to 1000h, e.g. 30s, 5m, 2h (60s by default)
    #[arg(long, value_name = "TIME", help_heading = "Interruptions", allow_hyphen_values = true)]
    pub every: Option<String>,

    /// Go on from the checkpoint, with the bytes of a render that was never stopped; begin where there is none
    ///
    /// With a larger --spp than before: more samples for the same picture. Without --checkpoint the file is the first
    /// output's name with .checkpoint. A series goes on with the pictures that are not there yet.
    #[arg(long, help_heading = "Interruptions")]
    pub resume: bool,
}

/// Where progress is kept, checked.
pub struct Kept {
    /// The checkpoint.
    pub file: PathBuf,
    every: Duration,
    resume: bool,
    /// What is there to go on from.
    from: Option<Checkpoint>,
    /// What was said last, so that it is not said every minute.
    said: Mutex<String>,
}

impl Kept {
    /// What the words say; `None` where nothing is to be kept, and for a series, whose finished pictures are its progress.
    pub fn new(args: &CheckpointArgs, outputs: &[PathBuf], is_series: bool) -> Result<Option<Kept>> {
        if is_series {
            return if args.checkpoint.is_none() && args.every.is_none() {
                Ok(None)
            } else {
                Err(Error::usage("--checkpoint and --every are for one picture")
                    .advise("a series goes on with --resume alone, with the pictures that are not there yet"))
            };
        }
        let every = args.every.as_deref().map_or(Ok(Duration::from_secs(60)), time)?;
        let file = match (&args.checkpoint, args.resume) {
            (Some(file), _) => file.clone(),
            (None, true) => beside(outputs)?,
            (None, false) if args.every.is_some() => {
                return Err(Error::usage("--every: nothing is kept").advise("add --checkpoint FILE"));
            }
            (None, false) => return Ok(None),
        };
        Ok(Some(Kept { file, every, resume: args.resume, from: None, said: Mutex::default() }))
    }

    /// Opens what there is, before any other work.
    ///
    /// # Errors
    /// No checkpoint, a damaged one, or a place where none can be written.
    pub fn open(&mut self, console: Console) -> Result<()> {
        checkpoint::check_path(&self.file)?;
        let Some(found) = Checkpoint::open(&self.file)? else { return Ok(()) };
        if self.resume {
            self.from = Some(found);
        } else {
            let (file, (_, most)) = (show_path(&self.file), found.header().samples);
            console.say(&format!(
                "warning: {file} has {most} samples a pixel of an earlier run, which will be replaced; --resume goes on from them"
            ));
        }
        Ok(())
    }

    /// Refuses a checkpoint of other settings, and says how far it is.
    pub fn adopt(&self, scene: &Scene, settings: &mut Settings, console: Console) -> Result<()> {
        let Some(from) = &self.from else { return Ok(()) };
        render::adopt(from, scene, settings)?;
        let (least, most) = from.header().samples;
        let range = if least == most { least.to_string() } else { format!("{least} to {most}") };
        console.say(&format!("{}: has {range} of {} samples a pixel", show_path(&self.file), settings.spp));
        Ok(())
    }

    /// Hands what the render needs to `work`.
    pub fn keep<R>(&self, console: Console, work: impl FnOnce(&Keep<'_>) -> R) -> R {
        let trouble = |e: &Error| {
            let text = format!("warning: {e}; the render goes on, and the checkpoint is tried again later");
            if let Ok(mut said) = self.said.lock()
                && *said != text
            {
                console.say(&text);
                *said = text;
            }
        };
        work(&Keep { file: &self.file, every: self.every, from: self.from.as_ref(), trouble: &trouble })
    }
}

/// The first output's name with `.checkpoint`.
fn beside(outputs: &[PathBuf]) -> Result<PathBuf> {
    let name = |path: &PathBuf| {
        let is_device = path.as_os_str() == "-" || path.starts_with("/dev") || path.starts_with("/proc");
        (!is_device).then(|| {
            let mut name = path.clone().into_os_string();
            name.push(".checkpoint");
            PathBuf::from(name)
        })
    };
    outputs.iter().find_map(name).ok_or_else(|| {
        Error::usage("--resume: the output has no name to find its checkpoint by")
            .advise("add --checkpoint FILE")
    })
}

/// A time as `90`, `90s`, `1.5m`, `500ms`, `2h`.
fn time(word: &str) -> Result<Duration> {
    const UNITS: [(&str, f64); 5] = [("ms", 1e-3), ("min", 60.0), ("s", 1.0), ("m", 60.0), ("h", 3600.0)];
    let unit = UNITS.iter().find_map(|(unit, seconds)| Some((word.strip_suffix(unit)?, *seconds)));
    let (number, unit) = unit.unwrap_or((word, 1.0));
    let seconds = number.trim().parse::<f64>().ok().map(|number| number * unit);
    match seconds {
        Some(seconds) if (0.01..=3.6e6).contains(&seconds) => Ok(Duration::from_secs_f64(seconds)),
        _ => Err(Error::usage(format!(
            "--every: must be a time from 10ms to 1000h, e.g. 60s, 5m or 2h, not \"{word}\""
        ))),
    }
}

/// Where else a run may write: all of it is checked against its inputs.
pub fn file_of(kept: Option<&Kept>) -> Option<&Path> {
    kept.map(|kept| kept.file.as_path())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_units() {
        for (word, seconds) in
            [("60", 60.0), ("60s", 60.0), ("1.5m", 90.0), ("2 min", 120.0), ("500ms", 0.5), ("2h", 7200.0)]
        {
            assert_eq!(time(word).unwrap().as_secs_f64(), seconds, "{word}");
        }
        for word in ["", "s", "0", "-1s", "nan", "inf", "1e9h", "9ms", "1d", "1 0s"] {
            assert!(time(word).unwrap_err().message.contains("--every"), "{word}");
        }
    }
}
