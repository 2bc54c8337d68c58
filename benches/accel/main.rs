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
//! a contestant's own types are not counted; what it writes down of its hits is.
//!
//! The yardstick's own row compares it with itself: how far it is from ×1.00 is the noise. `embree medium` over the
//! yardstick is what the backend's chunks, gate and settled edges cost or gain.

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
struct Arguments {
    /// FILE.obj, SCENE.toml, sphere:N, hall, cornell or instanced
    #[arg(value_name = "SCENE", default_values = ["sphere:870000", "hall", "cornell", "instanced"])]
    scenes: Vec<String>,
    /// Alternating rounds; figures are their medians
    #[arg(long, default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..))]
    rounds: u32,
    /// Camera rays; of other kinds, there is at most one a hit
    #[arg(long, default_value_t = 1 << 18)]
    rays: usize,
    /// Contestants whose names contain one of these
    #[arg(long, value_delimiter = ',')]
    only: Vec<String>,
    /// Names the contestants and ends
    #[arg(long)]
    list: bool,
    /// What `cargo bench` adds
    #[arg(long, hide = true)]
    bench: bool,
}

fn main() {
    let arguments = Arguments::parse();
    let chosen = |name: &str| arguments.only.is_empty() || arguments.only.iter().any(|o| name.contains(&**o));
    let contestants: Vec<Contestant> =
        contestants::all().into_iter().filter(|c| arguments.list || chosen(&c.name)).collect();
    if arguments.list {
        contestants.iter().for_each(|c| println!("{}", c.name));
        return;
    }
    for name in &arguments.scenes {
        let scene = scenes::by_name(name).unwrap_or_else(|e| panic!("{name}: {e}"));
        let rays = record::record(&scene, arguments.rays);
        let mut yardstick = contestants::yardstick().build(&scene, 0);
        table::head(&scene, &rays);
        for contestant in &contestants {
            let measured = Measured::of(contestant, &scene, &rays, &mut *yardstick, arguments.rounds);
            table::row(&contestant.name, &measured, &rays);
        }
        println!();
    }
}
