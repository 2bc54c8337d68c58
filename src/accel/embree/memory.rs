//! How much memory a build may take, and whether the usual layout fits.
//!
//! The compact layout keeps indices where the usual one keeps the triangles' corners, in nodes of half the width where
//! the kernels are AVX or better: about half of the memory, slower rays. Its hits at edges may be the
//! neighbour's (one word in a hundred of rays aimed at edges), so what is free decides only where a scene asks for
//! that (`render.compact = "auto"`); elsewhere a build that does not fit is refused.

use std::path::Path;

/// What the usual layout takes at the peak of its build, in bytes a triangle: 112 (low) to 119 (medium) measured on
/// meshes of 0.3 to 5 million triangles, and some for what is left out here (small scenes, the film, other programs).
const USUAL: u64 = 130;

/// True where the usual layout of `triangles` triangles would not fit into `available` bytes.
pub fn is_short(triangles: u64, available: Option<u64>) -> bool {
    available.is_some_and(|available| triangles.saturating_mul(USUAL) > available)
}

/// Bytes that this process can still get: what the kernel takes to be available, or what its control group has left
/// where that is less. `None` where the machine does not say.
pub fn available() -> Option<u64> {
    let machine = read("/proc/meminfo").and_then(|text| mem_available(&text));
    let group = read("/proc/self/cgroup").and_then(|text| group_left(&text, &|path| read(path)));
    match (machine, group) {
        (Some(machine), Some(group)) => Some(machine.min(group)),
        (machine, group) => machine.or(group),
    }
}

fn read(path: impl AsRef<Path>) -> Option<String> {
    std::fs::read_to_string(path).ok()
}

/// `MemAvailable` of `/proc/meminfo`, in bytes.
fn mem_available(meminfo: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

/// The least that is left in this process' control group and those around it, from its `/proc/self/cgroup`. Both
/// versions of the interface; a group without a limit says nothing.
fn group_left(groups: &str, read: &dyn Fn(&str) -> Option<String>) -> Option<u64> {
    let mut least = None;
    for line in groups.lines() {
        let mut fields = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (fields.next(), fields.next()) else { continue };
        let (root, limit, usage) = if controllers.is_empty() {
            ("/sys/fs/cgroup", "memory.max", "memory.current")
        } else if controllers.split(',').any(|c| c == "memory") {
            ("/sys/fs/cgroup/memory", "memory.limit_in_bytes", "memory.usage_in_bytes")
        } else {
            continue;
        };
        for folder in Path::new(path).ancestors() {
            let number = |file| {
                let name = format!("{root}{}/{file}", folder.display().to_string().trim_end_matches('/'));
                read(&name)?.trim().parse::<u64>().ok()
            };
            if let (Some(limit), Some(usage)) = (number(limit), number(usage)) {
                let left = limit.saturating_sub(usage);
                least = Some(least.map_or(left, |l: u64| l.min(left)));
            }
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_compact_layout_is_taken_when_the_usual_one_does_not_fit() {
        assert!(!is_short(1_000_000, Some(USUAL * 1_000_000)));
        assert!(is_short(1_000_000, Some(USUAL * 1_000_000 - 1)));
        assert!(is_short(u64::MAX, Some(u64::MAX - 1)));
        assert!(!is_short(u64::MAX, None) && !is_short(0, Some(0)));
    }

    #[test]
    fn memory_is_read_as_the_kernel_writes_it() {
        let text = "MemTotal:       24600000 kB\nMemFree:         100 kB\nMemAvailable:   22000000 kB\n";
        assert_eq!(mem_available(text), Some(22_000_000 * 1024));
        assert_eq!(mem_available("MemTotal: 1 kB\n"), None);
        assert_eq!(mem_available("MemAvailable: many kB\n"), None);
        #[cfg(target_os = "linux")]
        assert!(available().is_some_and(|bytes| bytes > 0));
    }

    #[test]
    fn the_tightest_control_group_counts() {
        let files: &[(&str, &str)] = &[
            ("/sys/fs/cgroup/memory.max", "max\n"),
            ("/sys/fs/cgroup/memory.current", "9\n"),
            ("/sys/fs/cgroup/a/memory.max", "1000\n"),
            ("/sys/fs/cgroup/a/memory.current", "400\n"),
            ("/sys/fs/cgroup/a/b/memory.max", "900\n"),
            ("/sys/fs/cgroup/a/b/memory.current", "100\n"),
            ("/sys/fs/cgroup/memory/c/memory.limit_in_bytes", "500\n"),
            ("/sys/fs/cgroup/memory/c/memory.usage_in_bytes", "501\n"),
        ];
        let read =
            |path: &str| files.iter().find(|(name, _)| *name == path).map(|(_, text)| text.to_string());
        assert_eq!(group_left("0::/a/b\n", &read), Some(600));
        assert_eq!(group_left("0::/\n", &read), None);
        assert_eq!(group_left("5:cpu,memory:/c\n1:cpu:/a\n", &read), Some(0));
        assert_eq!(group_left("nonsense\n\n", &read), None);
    }
}
