//! What reading an OBJ costs: MB a CPU second, and a second of wall time.
//!
//! `cargo bench --bench obj -- [MEGABYTES | FILE.obj]`. Without a file, the text is made in memory: a wavy
//! grid with normals, as exporters write it. `RAYON_NUM_THREADS=1` measures one thread.

use drt::load::obj::{ReadOptions, read_from};
use rustix::time::{ClockId, clock_gettime};
use std::path::Path;

fn main() {
    // `cargo bench` adds `--bench`, and `cargo test` runs benches without arguments worth obeying.
    let input = std::env::args().skip(1).find(|a| !a.starts_with("--"));
    let input = input.unwrap_or_else(|| "64".to_string());
    let text = match input.parse::<usize>() {
        Ok(megabytes) => wavy_grid(megabytes * 1_000_000),
        Err(_) => std::fs::read(&input).expect("the file can be read"),
    };
    let megabytes = text.len() as f64 / 1e6;
    println!("{megabytes:.0} MB, {} threads", rayon::current_num_threads());
    for _ in 0..5 {
        let (cpu, wall) = (seconds(ClockId::ProcessCPUTime), seconds(ClockId::Monotonic));
        let file =
            read_from(text.as_slice(), Path::new("bench.obj"), None, &ReadOptions::default()).expect("reads");
        let (cpu, wall) = (seconds(ClockId::ProcessCPUTime) - cpu, seconds(ClockId::Monotonic) - wall);
        let triangles = file.mesh.indices.len();
        println!("{triangles} triangles: {:.0} MB/CPU-s, {:.0} MB/s", megabytes / cpu, megabytes / wall);
    }
}

fn seconds(clock: ClockId) -> f64 {
    let t = clock_gettime(clock);
    t.tv_sec as f64 + t.tv_nsec as f64 * 1e-9
}

/// About `bytes` of text: about 156 bytes a vertex with its normal and two triangles.
fn wavy_grid(bytes: usize) -> Vec<u8> {
    use std::io::Write;
    let side = ((bytes / 156) as f64).sqrt().max(2.0) as usize;
    let mut text = Vec::with_capacity(bytes + bytes / 8);
    let mut line = |arguments: std::fmt::Arguments<'_>| text.write_fmt(arguments).expect("memory takes it");
    for i in 0..side * side {
        let (x, z) = ((i % side) as f64 / side as f64, (i / side) as f64 / side as f64);
        line(format_args!("v {x:.6} {:.6} {z:.6}\n", 0.1 * (30.0 * x).sin() * (20.0 * z).cos()));
    }
    for i in 0..side * side {
        let x = (i % side) as f64 / side as f64;
        line(format_args!("vn {:.4} 1.0000 0.0000\n", -3.0 * (30.0 * x).cos()));
    }
    for i in 0..side * (side - 1) {
        if i % side + 1 < side {
            let (a, b, c, d) = (i + 1, i + 2, i + side + 1, i + side + 2);
            line(format_args!("f {a}//{a} {c}//{c} {b}//{b}\nf {b}//{b} {c}//{c} {d}//{d}\n"));
        }
    }
    text
}
