//! What the machine has: memory left, threads, and what a render will take of them.

use drt::error::{Error, Result};
use drt::scene::Settings;
use std::fs;

/// Bytes a triangle of the largest acceleration structure: Embree's robust one with its copies.
const STRUCTURE_BYTES: u64 = 100;
/// Bytes a pixel: f64 sums, developed channels, the encoder's copies.
const PIXEL_BYTES: u64 = 32 + 12 + 24;
/// Bytes a pixel with layers: their sums and channels.
const LAYER_BYTES: u64 = 112 + 56;

/// Bytes that building and rendering will take on top of the scene.
pub fn prediction(triangles: u64, settings: &Settings) -> u64 {
    let pixels = u64::from(settings.size[0]) * u64::from(settings.size[1]);
    let per_pixel = PIXEL_BYTES + if settings.aovs.is_empty() { 0 } else { LAYER_BYTES };
    triangles * STRUCTURE_BYTES + pixels * per_pixel
}

/// Refuses what cannot fit, before it is begun.
///
/// # Errors
/// Less memory left than needed.
pub fn check_memory(needed: u64) -> Result<()> {
    match memory_left() {
        Some((left, limit)) if needed > left => Err(Error::new(format!(
            "not enough memory: about {} are needed, {} are left ({limit})",
            megabytes(needed),
            megabytes(left)
        ))
        .advise("take a smaller --size, fewer layers, or a machine with more memory")),
        _ => Ok(()),
    }
}

/// `1234567` as `2 MB`, rounded up.
pub fn megabytes(bytes: u64) -> String {
    format!("{} MB", bytes.div_ceil(1_000_000))
}

/// The tightest of the process's, the group's and the machine's limits, and its name.
fn memory_left() -> Option<(u64, &'static str)> {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let address_space = rustix::process::getrlimit(rustix::process::Resource::As).current;
    let process = address_space.map(|limit| limit.saturating_sub(kilobytes(&status, "VmSize:").unwrap_or(0)));
    let machine = fs::read_to_string("/proc/meminfo").ok().and_then(|m| kilobytes(&m, "MemAvailable:"));
    let limits = [
        (process, "limit of the process"),
        (group_left(), "limit of the control group"),
        (machine, "free memory"),
    ];
    limits.into_iter().filter_map(|(left, name)| left.map(|left| (left, name))).min_by_key(|(left, _)| *left)
}

/// What the control group (version 2) still allows. File pages can be given back, so they do not count.
fn group_left() -> Option<u64> {
    let group = fs::read_to_string("/proc/self/cgroup").ok()?;
    let path = group.lines().find_map(|line| line.strip_prefix("0::"))?;
    let read = |name: &str| fs::read_to_string(format!("/sys/fs/cgroup{path}/{name}")).ok();
    let limit: u64 = read("memory.max")?.trim().parse().ok()?;
    let used: u64 = read("memory.current")?.trim().parse().ok()?;
    let pages = read("memory.stat")
        .and_then(|s| {
            s.lines().find_map(|line| line.strip_prefix("file ")).and_then(|n| n.trim().parse().ok())
        })
        .unwrap_or(0);
    Some(limit.saturating_sub(used.saturating_sub(pages)))
}

/// The largest resident set so far, in bytes.
pub fn peak_memory() -> Option<u64> {
    kilobytes(&fs::read_to_string("/proc/self/status").ok()?, "VmHWM:")
}

/// A line `name   1234 kB` of `text`, in bytes.
fn kilobytes(text: &str, name: &str) -> Option<u64> {
    let rest = text.lines().find_map(|line| line.strip_prefix(name))?;
    rest.split_whitespace().next()?.parse::<u64>().ok()?.checked_mul(1024)
}

/// CPU seconds of all threads so far.
pub fn cpu_seconds() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    time.tv_sec as f64 + time.tv_nsec as f64 * 1e-9
}

/// Threads that the machine runs at once.
pub fn threads() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}
