//! `drt compare A B`: how far two pictures are apart.

use super::Failure;
use super::console::write_stdout;
use super::signals::Signals;
use clap::Args;
use drt::compare::{self, Comparison, flip::Kind};
use drt::error::Result;
use drt::load::picture::{self, Encoding};
use drt::output;
use serde_json::json;
use std::path::PathBuf;

/// The flags of `drt compare`.
#[derive(Args)]
pub struct CompareArgs {
    /// The picture (.exr, .png, .jpg, .hdr, .pfm)
    pub a: PathBuf,

    /// The reference that it is compared with
    pub b: PathBuf,

    /// Write the figures as JSON to standard output
    #[arg(long)]
    pub json: bool,

    /// Write the absolute difference as a picture; an .exr also gets FLIP of every pixel as the layer flip.Y
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,
}

/// Compares, prints the figures, writes the difference.
///
/// # Errors
/// A picture that cannot be read or written, or two that cannot be compared; a signal.
pub fn run(args: &CompareArgs) -> Result<(), Failure> {
    if let Some(path) = &args.output {
        output::check_path(path)?;
    }
    let signals = Signals::listen()?;
    signals.nothing_to_lose("comparing");
    let (a, b) = (picture::read(&args.a)?, picture::read(&args.b)?);
    // A picture made for a display has no range beyond it: one of them is enough to compare as a display would show.
    let both_linear = a.encoding == Encoding::Linear && b.encoding == Encoding::Linear;
    let kind = if both_linear { Kind::Hdr } else { Kind::Ldr };
    let comparison = compare::compare(&a.image, &b.image, kind).map_err(|e| e.at(&args.a))?;
    if let Some((signal, name)) = signals.received() {
        let message = format!("stopped by {name} while comparing; nothing was written");
        return Err(Failure::Stopped { signal, message });
    }

    if let Some(path) = &args.output {
        let difference = compare::difference(&a.image, &b.image, &comparison);
        output::write(path, &difference, &output::Options::default())?;
    }
    // With `-o -` standard output carries the picture.
    match &args.output {
        Some(path) if path.as_os_str() == "-" && !args.json => Ok(()),
        _ => Ok(write_stdout(&if args.json { as_json(&comparison) } else { as_text(&comparison) })?),
    }
}

fn as_json(c: &Comparison) -> String {
    let figures = json!({
        "width": c.width, "height": c.height,
        "mse": c.mse, "relmse": c.rel_mse, "psnr": c.psnr, "max": c.max, "mean": c.mean,
        "flip": c.flip, "flip_kind": c.flip_kind.name(),
    });
    format!("{figures}\n")
}

fn as_text(c: &Comparison) -> String {
    let psnr = c.psnr.map_or("identical".to_string(), |psnr| format!("{psnr:.3} dB"));
    format!(
        "{width}x{height} pixels, linear R, G, B\n\
         MSE      {mse:.6e}\n\
         relMSE   {rel_mse:.6e}   mean of (a - b)^2 / (b^2 + 0.01)\n\
         PSNR     {psnr}   peak 1\n\
         max      {max:.6e}   largest |a - b|\n\
         mean     {mean:.6e}   mean |a - b|\n\
         FLIP     {flip:.6}   {kind}, 67 pixels per degree; 0 is the same, 1 the greatest difference\n",
        width = c.width,
        height = c.height,
        mse = c.mse,
        rel_mse = c.rel_mse,
        max = c.max,
        mean = c.mean,
        flip = c.flip,
        kind = c.flip_kind.name(),
    )
}
