//! Who is how fast: ray kinds × scenes × contestants, on the same recorded rays.
//!
//! ```text
//! cargo bench --bench accel -- [SCENE]... [--rounds N] [--rays N] [--only PART,PART] [--list]
//! ```
//! A scene is an OBJ or scene file, `sphere:N` (bumpy, N triangles), `hall` (0.36 M long thin triangles, seen from
//! inside), `cornell` (the box of `scenes/`, with bounce and shadow rays of depth 1 to 4) or `instanced` (one mesh
//! copied 512 times, as geometry: the library has no instances yet). Without one, all that need no file.
//!
//! # What is measured
//! Every contestant is measured against a yardstick: Embree's single-ray calls in a bare loop over prepared rays.
//! Both trace the same rays right after each other, round by round, in changing order; a ratio is the median of the
//! rounds' ratios, so that what slows the machine down slows down both. Without the feature `embree` the first
//! contestant is the yardstick. All times are CPU seconds of the one thread that traces, and conversions to
//! a contestant's own types are not counted; what it writes down of its hits is. Builds are measured in processes of
//! their own: CPU seconds and peak memory on all threads, wall seconds on one.
//!
//! Contestants from other crates get single rays, and the SIMD that they were compiled for: `RUSTFLAGS='-C
//! target-cpu=native'` gives them this machine's.
//!
//! The yardstick's own row compares it with itself: how far it is from ×1.00 is the noise. `embree medium` over the
//! yardstick is what the backend's chunks, gate and settled edges cost or gain.

mod build;
mod clock;
mod contest;
mod contestants;
mod record;
mod scenes;
mod table;

use clap::Parser;
use contest::{Contestant, Measured};

/// Measures contestants on recorded rays.
#[derive(Parser)]
pub struct Arguments {
    /// FILE.obj, SCENE.toml, sphere:N, hall, cornell or instanced
    #[arg(value_name = "SCENE", default_values = ["sphere:870000", "hall", "cornell", "instanced"])]
    scenes: Vec<String>,
    /// Alternating rounds; figures are their medians
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// Builds to take the median of
    #[arg(long, default_value_t = 1, value_parser = clap::value_parser!(u32).range(1..))]
    builds: u32,
    /// Rays of each kind, if enough hit anything
    #[arg(long, default_value_t = 1 << 18)]
    rays: usize,
    /// Contestants whose names contain one of these
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
    /// Names the contestants and ends
    #[arg(long)]
    list: bool,
    /// Builds this contestant, prints what it took, and ends (`build.rs`)
    #[arg(long, hide = true)]
    build: Option<String>,
    /// On so many threads
    #[arg(long, hide = true, default_value_t = 0)]
    threads: usize,
    /// What `cargo bench` adds
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() {
    let arguments = Arguments::parse();
    let mut contestants = contestants::all();
    if arguments.list {
        contestants.iter().for_each(|c| println!("{}", c.name));
        return;
    }
    if let Some(name) = &arguments.build {
        for contestant in contestants.iter().filter(|c| c.name == *name) {
            build::run(contestant, &scene(&arguments.scenes[0]), arguments.threads);
        }
        return;
    }
    let only = &arguments.only;
    contestants.retain(|c| only.is_empty() || only.iter().any(|part| c.name.contains(part)));
    for name in &arguments.scenes {
        measure(&scene(name), &contestants, &arguments);
    }
}

fn scene(name: &str) -> scenes::Scene {
    scenes::by_name(name).unwrap_or_else(|e| {
        eprintln!("error: {name}: {e}");
        std::process::exit(1)
    })
}

fn measure(scene: &scenes::Scene, contestants: &[Contestant], arguments: &Arguments) {
    let rays = record::record(scene, arguments.rays);
    let yardstick = contestants::yardstick().build(scene, 0);
    table::head(scene, &rays);
    for contestant in contestants {
        let measured = Measured::of(contestant, scene, &rays, &*yardstick, arguments);
        table::row(&contestant.name, &measured, &rays);
    }
    println!();
}
