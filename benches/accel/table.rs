//! The table of a scene, as Markdown.

use crate::contest::Measured;
use crate::record::RaySet;
use crate::scenes::Scene;

/// Contestants whose share of hits differs from the yardstick's by more than this answer another question.
const AGREEMENT: f64 = 1e-3;

/// The scene, its rays, and the columns' names.
pub fn head(scene: &Scene, rays: &[RaySet]) {
    println!("## {}: {} triangles in {} meshes", scene.name, scene.triangles(), scene.meshes.len());
    let counts: Vec<String> = rays.iter().map(|set| format!("{} {}", set.name, set.len())).collect();
    println!("Rays: {}.\n", counts.join(", "));
    print!("| {:20} | CPU s | 1 thr s |   MiB |  peak |", "Mrays/s × yardstick");
    rays.iter().for_each(|set| print!(" {:>12} |", set.name));
    print!("   mean |\n|---|--:|--:|--:|--:|");
    rays.iter().for_each(|_| print!("--:|"));
    println!("--:|");
}

/// A contestant's row, and warnings where it disagrees with the yardstick.
pub fn row(name: &str, measured: &Measured, rays: &[RaySet]) {
    let Measured { build, build_one, mib, speeds } = measured;
    let (cpu, wall, peak) = (build.cpu, build_one.wall, build.peak_mib);
    print!("| {name:20} | {cpu:5.2} | {wall:7.2} | {mib:5.0} | {peak:5.0} |");
    speeds.iter().for_each(|s| print!(" {:6.2} ×{:4.2} |", s.mrays, s.ratio));
    // Geometric: twice as fast here and half as fast there is as fast.
    let mean = (speeds.iter().map(|s| s.ratio.ln()).sum::<f64>() / speeds.len() as f64).exp();
    println!(" ×{mean:5.2} |");
    for (speed, set) in speeds.iter().zip(rays) {
        let difference = speed.hits.abs_diff(speed.expected);
        if difference as f64 > AGREEMENT * set.len() as f64 {
            println!(
                "\nwarning: {name}, {}: {} hits, but the yardstick has {}\n",
                set.name, speed.hits, speed.expected
            );
        }
    }
}
