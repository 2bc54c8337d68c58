//! CPU seconds and memory of this process.

use rustix::time::{ClockId, clock_gettime};

/// Seconds of one of the system's clocks.
pub fn seconds(clock: ClockId) -> f64 {
    let t = clock_gettime(clock);
    t.tv_sec as f64 + t.tv_nsec as f64 * 1e-9
}

/// How much a piece of work raises the process's resident memory at most, in MiB; `None` where the system does
/// not tell (Linux does: "5" in `clear_refs` sets the high-water mark back).
pub fn peak_mib<T>(work: impl FnOnce() -> T) -> (T, Option<f64>) {
    let before = status("VmRSS:");
    let reset = std::fs::write("/proc/self/clear_refs", "5").is_ok();
    let result = work();
    let peak = status("VmHWM:").zip(before).filter(|_| reset).map(|(peak, before)| (peak - before) / 1024.0);
    (result, peak)
}

/// A line of `/proc/self/status`, in KiB.
fn status(key: &str) -> Option<f64> {
    let text = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix(key))?;
    line.split_whitespace().next()?.parse().ok()
}
