//! How much memory there still is: what the machine, the control group, the process' own limits and the user allow.
//!
//! A process that takes more than the machine has is killed without a word, so whatever may be large is asked for here
//! before it is begun. What is free decides whether work is refused; it never changes a picture.

mod group;
mod room;

pub use room::{HEADROOM, OutOfMemory, probe, reserve};

use crate::error::Error;
use std::fs;
use std::sync::atomic::{AtomicU64, Ordering};

/// What is left under the tightest limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Left {
    /// Bytes.
    pub bytes: u64,
    /// Whose limit it is.
    pub limit: Limit,
}

/// A limit on memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Limit {
    /// The user's, in bytes: [`limit_process`].
    Stated(u64),
    /// Of the address space (`ulimit -v`).
    AddressSpace,
    /// Of the control group or one around it: a container, a batch system.
    Group,
    /// What the machine has free.
    Machine,
}

impl std::fmt::Display for Limit {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Limit::Stated(bytes) => write!(f, "--max-memory of {}", megabytes(*bytes)),
            Limit::AddressSpace => write!(f, "the process' limit, ulimit -v"),
            Limit::Group => write!(f, "the control group's limit"),
            Limit::Machine => write!(f, "free memory"),
        }
    }
}

/// The user's limit; all ones: none.
static STATED: AtomicU64 = AtomicU64::new(u64::MAX);

/// From now on the whole process is to have at most so many bytes resident. As `ulimit` does it, this holds for
/// everything that runs in the process; unlike it, nothing is killed: what would not fit is refused.
pub fn limit_process(bytes: u64) {
    STATED.store(bytes, Ordering::Relaxed);
}

/// What is left under the tightest limit; `None` where the system tells none.
pub fn left() -> Option<Left> {
    let status = fs::read_to_string("/proc/self/status").unwrap_or_default();
    let of_status = |name| kilobytes(&status, name).unwrap_or(0);
    let stated = Some(STATED.load(Ordering::Relaxed)).filter(|bytes| *bytes < u64::MAX);
    let address_space = rustix::process::getrlimit(rustix::process::Resource::As).current;
    let machine = fs::read_to_string("/proc/meminfo").ok().and_then(|text| kilobytes(&text, "MemAvailable:"));
    let left = [
        stated.map(|all| (all.saturating_sub(of_status("VmRSS:")), Limit::Stated(all))),
        address_space.map(|all| (all.saturating_sub(of_status("VmSize:")), Limit::AddressSpace)),
        group::left().map(|bytes| (bytes, Limit::Group)),
        machine.map(|bytes| (bytes, Limit::Machine)),
    ];
    let left = left.into_iter().flatten().map(|(bytes, limit)| Left { bytes, limit });
    left.min_by_key(|left| left.bytes)
}

/// The largest resident set so far, in bytes.
pub fn peak() -> Option<u64> {
    kilobytes(&fs::read_to_string("/proc/self/status").ok()?, "VmHWM:")
}

/// A line `name   1234 kB` of `text`, in bytes.
fn kilobytes(text: &str, name: &str) -> Option<u64> {
    let rest = text.lines().find_map(|line| line.strip_prefix(name))?;
    rest.split_whitespace().next()?.parse::<u64>().ok()?.checked_mul(1024)
}

/// `1234567` as `2 MB`, rounded up.
pub fn megabytes(bytes: u64) -> String {
    format!("{} MB", bytes.div_ceil(1_000_000))
}

/// The error of work that does not fit; `what` it needs in words, and `advice`.
pub fn refused(needed: u64, what: &str, left: Left, advice: impl Into<String>) -> Error {
    let (needed, bytes, limit) = (megabytes(needed), megabytes(left.bytes), left.limit);
    Error::new(format!("not enough memory: about {needed} are needed ({what}), {bytes} are left ({limit})"))
        .advise(advice)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_read_as_the_kernel_writes_it() {
        let text = "MemTotal:       24600000 kB\nMemFree:         100 kB\nMemAvailable:   22000000 kB\n";
        assert_eq!(kilobytes(text, "MemAvailable:"), Some(22_000_000 * 1024));
        assert_eq!(kilobytes("MemTotal: 1 kB\n", "MemAvailable:"), None);
        assert_eq!(kilobytes("MemAvailable: many kB\n", "MemAvailable:"), None);
        #[cfg(target_os = "linux")]
        assert!(left().is_some_and(|left| left.bytes > 0) && peak() > Some(1 << 16));
    }

    #[test]
    fn a_refusal_says_what_is_needed_and_what_there_is() {
        let left = Left { bytes: 99_000_001, limit: Limit::Stated(500_000_000) };
        assert_eq!(
            refused(1_234_000_000, "a film", left, "be modest").to_string(),
            "not enough memory: about 1234 MB are needed (a film), 100 MB are left (--max-memory of 500 MB); be modest"
        );
    }
}
