//! What a build takes, measured in a process of its own: there, no memory left over from earlier builds is used
//! again, which would hide how much this one needs.

use crate::clock::{peak_mib, seconds};
use crate::contest::{Contestant, median};
use crate::scenes::Scene;
use rustix::time::ClockId;
use std::process::{Command, exit};

/// A build's cost.
pub struct Cost {
    /// CPU seconds of all threads.
    pub cpu: f64,
    /// Seconds.
    pub wall: f64,
    /// The most that it raised the process's memory by, in MiB; NaN where the system does not tell.
    pub peak_mib: f64,
}

/// Builds `builds` times on `threads` threads (0: all); medians.
pub fn measure(contestant: &Contestant, scene: &str, threads: usize, builds: u32) -> Cost {
    let costs: Vec<[f64; 3]> = (0..builds).map(|_| in_child(contestant, scene, threads)).collect();
    let [cpu, wall, peak_mib] = [0, 1, 2].map(|i| median(costs.iter().map(|cost| cost[i])));
    Cost { cpu, wall, peak_mib }
}

/// Builds in a process of its own.
fn in_child(contestant: &Contestant, scene: &str, threads: usize) -> [f64; 3] {
    let program = std::env::current_exe().expect("this program has a path");
    let threads = threads.to_string();
    let child =
        Command::new(program).args([scene, "--build", &contestant.name, "--threads", &threads]).output();
    let child = child.expect("this program runs");
    let text = String::from_utf8_lossy(&child.stdout);
    let numbers: Vec<f64> = text.split_whitespace().filter_map(|word| word.parse().ok()).collect();
    numbers.try_into().unwrap_or_else(|_| {
        eprintln!("{}: the build failed\n{}", contestant.name, String::from_utf8_lossy(&child.stderr));
        exit(1)
    })
}

/// That process: prints what [`in_child`] reads.
pub fn run(contestant: &Contestant, scene: &Scene, threads: usize) {
    let clocks = || [ClockId::ProcessCPUTime, ClockId::Monotonic].map(seconds);
    let before = clocks();
    let (built, peak_mib) = peak_mib(|| contestant.build(scene, threads));
    let after = clocks();
    println!("{} {} {}", after[0] - before[0], after[1] - before[1], peak_mib.unwrap_or(f64::NAN));
    drop(built);
}
