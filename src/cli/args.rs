//! The words of the command line, and the scene keys that they stand for.

use super::cache::CacheArgs;
use super::console::{Console, Verbosity};
use super::machine;
use super::memory::MemoryArgs;
use super::progress::Style;
use super::render::threads;
use super::secure::SecureArgs;
use clap::{ArgAction, Args, Parser, Subcommand};
use drt::error::{Error, Result};
use drt::load::Override;
use std::path::PathBuf;

/// Turns a mesh into a physically correct picture.
///
/// `drt bunny.obj` renders bunny.png: the camera frames the mesh, a default sky lights it, and what brings no
/// material is clay. A scene file (TOML) sets all of that and more. Light is computed by path tracing in linear
/// radiance; nothing is clamped, denoised or tone-mapped unless asked for, and the same input gives the same bytes on
/// any number of threads.
#[derive(Parser)]
#[command(
    name = "drt",
    disable_version_flag = true,
    args_conflicts_with_subcommands = true,
    max_term_width = 110,
    override_usage = "drt [OPTIONS] <MESH|SCENE.toml>\n       drt <COMMAND>"
)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Option<Command>,
    #[command(flatten)]
    pub render: RenderArgs,
    /// Print the versions of drt and Embree, the backends and instruction sets
    #[arg(short = 'V', long)]
    pub version: bool,
}

/// What drt can do.
#[derive(Subcommand)]
pub enum Command {
    /// Render a picture (the word may be left out: `drt bunny.obj`)
    Render(Box<RenderArgs>),
    /// Say what is in a mesh or scene file and what is wrong with it, by file and line
    Check(super::check::CheckArgs),
    /// Say how far a picture is from a reference: MSE, relMSE, PSNR, FLIP
    Compare(super::compare::CompareArgs),
    /// Draw how fast rules of integration converge: error against the number of samples
    Converge(Box<super::converge::ConvergeArgs>),
    /// Send the same rays through every backend and instruction set, and judge each disagreement in f64
    DiffBackends(super::diff::DiffArgs),
}

/// The flags that every study has.
#[derive(Args)]
pub struct StudyArgs {
    /// Set any key of the scene file, e.g. film.filter=gaussian; repeat for several
    #[arg(long, value_name = "KEY=VALUE", action = ArgAction::Append)]
    pub set: Vec<String>,

    /// Threads, 1 to 1024 (all by default); nothing but what was timed depends on it
    #[arg(long, value_name = "N", allow_negative_numbers = true)]
    pub threads: Option<String>,

    #[command(flatten)]
    pub files: SecureArgs,

    /// Show progress on stderr: auto (a bar in a terminal), plain, json, none
    #[arg(long, value_name = "STYLE")]
    pub progress: Option<String>,

    /// Say nothing but errors, and print no table
    #[arg(short, long)]
    pub quiet: bool,
}

impl StudyArgs {
    /// How many threads are asked for.
    pub fn threads(&self) -> Result<usize> {
        self.threads.as_deref().map_or_else(|| Ok(machine::threads()), threads)
    }

    /// How progress is shown.
    pub fn style(&self) -> Result<Style> {
        let style = self.progress.as_deref().map_or(Ok(Style::Auto), Style::from_name)?;
        Ok(if self.quiet { Style::None } else { style })
    }

    /// What is said.
    pub fn console(&self) -> Console {
        Console { verbosity: if self.quiet { Verbosity::Quiet } else { Verbosity::Normal } }
    }
}

/// The flags of `drt render`.
#[derive(Args)]
pub struct RenderArgs {
    /// A mesh (.obj, .ply, .stl, .gltf, .glb; also in .gz and .zst; `-` is standard input) or a scene file (.toml)
    #[arg(value_name = "MESH|SCENE.toml")]
    pub input: Option<PathBuf>,

    /// Write the picture here; repeat for several formats
    ///
    /// The extension is the format: .exr (linear float, layers, settings), .png and .jpg (8-bit sRGB), .hdr, .pfm. `-`
    /// writes a PNG to standard output. Without -o: INPUT's name with .png, in the current folder.
    #[arg(short, long, value_name = "FILE")]
    pub output: Vec<PathBuf>,

    #[command(flatten)]
    pub opening: super::input::InputArgs,

    /// Samples a pixel, 1 to 1048576 (64 by default); twice the samples take the noise down by √2
    #[arg(long, value_name = "N", help_heading = "Picture", allow_negative_numbers = true)]
    pub spp: Option<String>,

    /// Width and height in pixels, e.g. 1920x1080
    #[arg(long, value_name = "WxH", help_heading = "Picture", allow_hyphen_values = true)]
    pub size: Option<String>,

    /// Render only this part; its pixels are those of the whole picture, bit for bit
    #[arg(long, value_name = "X,Y,W,H", help_heading = "Picture", allow_hyphen_values = true)]
    pub crop: Option<String>,

    /// Seed of all random choices, 0 to 2^64-1 (0 by default)
    #[arg(long, value_name = "N", help_heading = "Picture", allow_negative_numbers = true)]
    pub seed: Option<String>,

    /// Scattering events at most, 0 to 65535 (16 by default): 0 shows emitted light only, 1 adds direct light
    #[arg(long, value_name = "N", help_heading = "Picture", allow_negative_numbers = true)]
    pub max_depth: Option<String>,

    /// Paths into which a sample splits at its first hit, 1 to 64 (by default 8 below a sky or by one square lamp, but 1 up
    /// to 16 samples; else 2; 1 with a lens or motion)
    #[arg(long, value_name = "N", help_heading = "Picture", allow_negative_numbers = true)]
    pub split: Option<String>,

    /// What is computed: path, distribution, direct, ao, normals
    #[arg(long, value_name = "NAME", help_heading = "Picture")]
    pub integrator: Option<String>,

    /// Where the sample points come from: sobol, halton, stratified, random
    #[arg(long, value_name = "NAME", help_heading = "Picture")]
    pub sampler: Option<String>,

    /// Layers of the first hit, into .exr outputs: depth,normal,albedo,position,uv,ids
    #[arg(long, value_name = "LIST", help_heading = "Picture")]
    pub aov: Option<String>,

    /// Scale samples down whose brightest channel exceeds this radiance: no fireflies, and a picture that is too dark
    #[arg(long, value_name = "RADIANCE", help_heading = "Picture", allow_negative_numbers = true)]
    pub clamp: Option<String>,

    /// Set any key of the scene file, e.g. film.filter=gaussian; repeat for several
    #[arg(long, value_name = "KEY=VALUE", help_heading = "Picture", action = ArgAction::Append)]
    pub set: Vec<String>,

    /// Exposure in stops, for 8-bit outputs only
    #[arg(long, value_name = "EV", help_heading = "Picture", allow_negative_numbers = true)]
    pub exposure: Option<String>,

    /// Tone curve, for 8-bit outputs only (none by default)
    #[arg(long, value_name = "NAME", help_heading = "Picture")]
    pub tone_map: Option<String>,

    /// The axis that points up: y (default), z, x, -y, -z, -x
    #[arg(long, value_name = "AXIS", help_heading = "View of a mesh", allow_hyphen_values = true)]
    pub up: Option<String>,

    /// Where the camera stands: three-quarter (default), front, back, left, right, top, bottom, iso
    #[arg(long, value_name = "NAME", help_heading = "View of a mesh")]
    pub view: Option<String>,

    /// Put a ground under the mesh
    #[arg(long, help_heading = "View of a mesh")]
    pub ground: bool,

    /// The light from all around: studio (default for a mesh), white, overcast, none, or a picture (.exr, .hdr)
    #[arg(long, value_name = "NAME|FILE", help_heading = "View of a mesh")]
    pub sky: Option<String>,

    /// Focus the lens (camera.aperture) on what the middle of this pixel sees
    #[arg(long, value_name = "X,Y", help_heading = "View of a mesh", allow_hyphen_values = true)]
    pub focus: Option<String>,

    #[command(flatten)]
    pub series: super::render::SeriesArgs,

    /// Threads, 1 to 1024 (all by default); the picture does not depend on it
    #[arg(long, value_name = "N", help_heading = "Machine", allow_negative_numbers = true)]
    pub threads: Option<String>,

    /// Who intersects rays and triangles: embree, bvh
    #[arg(long, value_name = "NAME", help_heading = "Machine")]
    pub backend: Option<String>,

    /// Pin the instruction set: sse2, avx2, avx512 (the machine's best by default)
    #[arg(long, value_name = "NAME", help_heading = "Machine")]
    pub isa: Option<String>,

    /// What all textures together may take in memory, e.g. 512M, 4G (the default); others are left out with a warning
    #[arg(long, value_name = "SIZE", help_heading = "Machine", allow_hyphen_values = true)]
    pub max_texture_bytes: Option<String>,

    #[command(flatten)]
    pub checkpoint: super::checkpoint::CheckpointArgs,
    #[command(flatten)]
    pub memory: MemoryArgs,
    #[command(flatten)]
    pub cache: CacheArgs,

    #[command(flatten)]
    pub files: SecureArgs,

    /// Write what was counted and timed as JSON; `-`: to standard output
    #[arg(long, value_name = "FILE", help_heading = "Messages")]
    pub stats: Option<PathBuf>,

    /// Show progress on stderr: auto (a bar in a terminal), plain, json, none
    #[arg(long, value_name = "STYLE", help_heading = "Messages")]
    pub progress: Option<String>,

    /// Make a skipped face, a missing texture or material an error
    #[arg(long, help_heading = "Messages")]
    pub strict: bool,

    /// Say nothing but errors
    #[arg(short, long, help_heading = "Messages", conflicts_with = "verbose")]
    pub quiet: bool,

    /// Say what is being done, and how long it took
    #[arg(short, long, help_heading = "Messages")]
    pub verbose: bool,
}

impl RenderArgs {
    /// The scene keys that the flags stand for. `--set` comes last, so that it can refine what a flag began:
    /// `--integrator ao --set render.integrator.distance=2`.
    pub fn overrides(&self) -> Result<Vec<Override>> {
        let mut all: Vec<Override> = Vec::new();
        let numbers = [
            ("--spp", "render.spp", &self.spp),
            ("--seed", "render.seed", &self.seed),
            ("--max-depth", "render.max_depth", &self.max_depth),
            ("--clamp", "film.clamp", &self.clamp),
            ("--split", "render.split", &self.split),
        ];
        for (flag, key, word) in numbers {
            if let Some(word) = word {
                all.push(Override::flag(flag, key, word)?);
            }
        }
        let names = [
            ("--integrator", "render.integrator", &self.integrator),
            ("--sampler", "render.sampler", &self.sampler),
            ("--backend", "render.backend", &self.backend),
        ];
        for (flag, key, name) in names {
            all.extend(name.as_ref().map(|name| Override::name(flag, key, name)));
        }
        if let Some(size) = &self.size {
            all.push(self::size(size)?);
        }
        if let Some(crop) = &self.crop {
            let words: Vec<&str> = crop.split(',').collect();
            if words.len() != 4 {
                return Err(form("--crop", crop, "X,Y,WIDTH,HEIGHT, e.g. 100,50,64,64"));
            }
            all.push(Override::list("--crop", "film.crop", words));
        }
        if let Some(aov) = &self.aov {
            all.push(Override::list("--aov", "film.aov", aov.split(',')));
        }
        all.extend(self.memory.overrides()?);
        for text in &self.set {
            all.push(Override::parse(text)?);
        }
        Ok(all)
    }
}

/// `--size WxH` as the key it stands for.
pub fn size(word: &str) -> Result<Override> {
    let words: Vec<&str> = word.split(['x', 'X', '×']).collect();
    if words.len() != 2 {
        return Err(form("--size", word, "WIDTHxHEIGHT, e.g. 1920x1080"));
    }
    Ok(Override::list("--size", "film.size", words))
}

/// A number of bytes: a whole number, or a number with K, M, G or T (powers of 1024; KB, KiB and so on as well).
pub fn bytes(flag: &str, word: &str) -> Result<u64> {
    let upper = word.trim().to_uppercase();
    let short = upper.strip_suffix("IB").or_else(|| upper.strip_suffix('B')).unwrap_or(&upper);
    let (number, power) = match short.char_indices().last() {
        Some((end, unit)) if unit.is_ascii_alphabetic() => (short[..end].trim(), "KMGT".find(unit)),
        _ => (short.trim(), Some(usize::MAX)),
    };
    let factor = power.map(|power| 1024f64.powi(power.wrapping_add(1) as i32));
    let bytes = factor.zip(number.parse::<f64>().ok()).map(|(factor, number)| number * factor);
    match bytes {
        Some(bytes) if (0.0..=1e18).contains(&bytes) => Ok(bytes as u64),
        _ => Err(form(flag, word, "a number of bytes, e.g. 512M or 4G")),
    }
}

fn form(flag: &str, word: &str, form: &str) -> Error {
    Error::usage(format!("{flag} {word}: not of the form {form}"))
}
