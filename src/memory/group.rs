//! What the control groups of this process leave it, in both versions of the kernel's interface.

use std::path::Path;

/// The least that is left in this process' group and those around it.
pub(super) fn left() -> Option<u64> {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    read("/proc/self/cgroup").and_then(|groups| left_in(&groups, &read))
}

/// Where a version of the interface keeps its figures.
struct Version {
    root: &'static str,
    limit: &'static str,
    usage: &'static str,
    /// In `memory.stat`: pages of files, which the kernel gives back before anybody is killed.
    files: &'static str,
}

const SECOND: Version =
    Version { root: "/sys/fs/cgroup", limit: "memory.max", usage: "memory.current", files: "file " };
const FIRST: Version = Version {
    root: "/sys/fs/cgroup/memory",
    limit: "memory.limit_in_bytes",
    usage: "memory.usage_in_bytes",
    files: "total_cache ",
};

/// As [`left`], from the text of `/proc/self/cgroup`; a group without a limit says nothing.
fn left_in(groups: &str, read: &dyn Fn(&str) -> Option<String>) -> Option<u64> {
    let mut least = None;
    for line in groups.lines() {
        let mut fields = line.splitn(3, ':').skip(1);
        let (Some(controllers), Some(path)) = (fields.next(), fields.next()) else { continue };
        let version = match controllers {
            "" => SECOND,
            some if some.split(',').any(|c| c == "memory") => FIRST,
            _ => continue,
        };
        for folder in Path::new(path).ancestors() {
            let folder = format!("{}{}", version.root, folder.display().to_string().trim_end_matches('/'));
            let text = |file: &str| read(&format!("{folder}/{file}"));
            let number = |file: &str| text(file)?.trim().parse::<u64>().ok();
            let (Some(limit), Some(usage)) = (number(version.limit), number(version.usage)) else { continue };
            let stat = text("memory.stat").unwrap_or_default();
            let files = stat.lines().find_map(|line| line.strip_prefix(version.files)?.trim().parse().ok());
            let left = limit.saturating_sub(usage.saturating_sub(files.unwrap_or(0)));
            least = Some(least.map_or(left, |l: u64| l.min(left)));
        }
    }
    least
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_tightest_control_group_counts() {
        let files: &[(&str, &str)] = &[
            ("/sys/fs/cgroup/memory.max", "max\n"),
            ("/sys/fs/cgroup/memory.current", "9\n"),
            ("/sys/fs/cgroup/a/memory.max", "1000\n"),
            ("/sys/fs/cgroup/a/memory.current", "700\n"),
            ("/sys/fs/cgroup/a/memory.stat", "anon 400\nfile 300\nfile_mapped 7\n"),
            ("/sys/fs/cgroup/a/b/memory.max", "900\n"),
            ("/sys/fs/cgroup/a/b/memory.current", "100\n"),
            ("/sys/fs/cgroup/memory/c/memory.limit_in_bytes", "500\n"),
            ("/sys/fs/cgroup/memory/c/memory.usage_in_bytes", "501\n"),
        ];
        let read =
            |path: &str| files.iter().find(|(name, _)| *name == path).map(|(_, text)| text.to_string());
        assert_eq!(left_in("0::/a/b\n", &read), Some(600));
        assert_eq!(left_in("0::/\n", &read), None);
        assert_eq!(left_in("5:cpu,memory:/c\n1:cpu:/a\n", &read), Some(0));
        assert_eq!(left_in("nonsense\n\n", &read), None);
    }
}
