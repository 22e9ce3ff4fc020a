//! What the machine allows this process: the memory that it may still take. Natively only.
//!
//! Files of the system -> bytes. The least of what the system has without swapping, and of what every control group around the process
//! leaves: that of a container, of a job of Slurm, of a service. A group allows its limit less what it holds; cached pages of files that
//! were not used lately are free to go, and do not count.
//!
//! Version 2 of control groups: `memory.max`, `memory.high`, `memory.current`; version 1: `memory.limit_in_bytes`, `memory.usage_in_bytes`. A group has no
//! more than those around it, so all of them are asked, as far as they are visible. Where they are says `/proc/self/mountinfo`: a container may see its
//! own group as the root, or be shown only a part of the hierarchy.
//!
//! Our own reader of some files: `cgroups-rs` is made to manage groups, and `sysinfo` asks the root of a hierarchy only. The number of threads
//! needs none: rayon takes [`std::thread::available_parallelism`], which knows the quotas of control groups.

use std::path::{Path, PathBuf};

/// Bytes that this process may still take without swapping; None where the system does not say.
pub fn available_bytes() -> Option<u64> {
    available_bytes_in(Path::new("/"))
}

/// The same of a system whose files lie in a folder.
pub fn available_bytes_in(root: &Path) -> Option<u64> {
    let of_system = value(&root.join("proc/meminfo"), "MemAvailable:").map(|kilobytes| kilobytes << 10);
    [of_system, least_of_groups(root, left_in)].into_iter().flatten().min()
}

/// The least that a control group around this process lets all of its processes hold; None where none has a limit.
pub fn group_limit_bytes() -> Option<u64> {
    group_limit_bytes_in(Path::new("/"))
}

/// The same of a system whose files lie in a folder.
pub fn group_limit_bytes_in(root: &Path) -> Option<u64> {
    // version 1 says that there is none with a number of nearly 2^63
    least_of_groups(root, limit_of).filter(|limit| *limit < 1 << 62)
}

/// Bytes of memory that the system has; None where it does not say.
pub fn total_bytes() -> Option<u64> {
    value(Path::new("/proc/meminfo"), "MemTotal:").map(|kilobytes| kilobytes << 10)
}

/// What the files of a version of control groups are called.
struct Names {
    limits: &'static [&'static str],
    used: &'static str,
    /// Key of `memory.stat` of pages that are free to go.
    free_to_go: &'static str,
}

const VERSION_2: Names =
    Names { limits: &["memory.max", "memory.high"], used: "memory.current", free_to_go: "inactive_file" };
const VERSION_1: Names =
    Names { limits: &["memory.limit_in_bytes"], used: "memory.usage_in_bytes", free_to_go: "total_inactive_file" };

/// What a group allows, or what of that it leaves; None where it has no limit.
type OfGroup = fn(&Path, &Names) -> Option<u64>;

/// The least of the control groups of this process; None where none has a limit.
fn least_of_groups(root: &Path, of_group: OfGroup) -> Option<u64> {
    let groups = std::fs::read_to_string(root.join("proc/self/cgroup")).ok()?;
    let mounts = std::fs::read_to_string(root.join("proc/self/mountinfo")).ok()?;
    let mounts: Vec<Mount> = mounts.lines().filter_map(Mount::read).collect();
    let of_line = |line: &str| {
        let mut fields = line.splitn(3, ':').skip(1);
        let (controllers, path) = (fields.next()?, fields.next()?);
        let is_memory = controllers.split(',').any(|controller| controller == "memory");
        let is_version_2 = controllers.is_empty();
        let mount = mounts.iter().find(|mount| mount.is_version_2 == is_version_2)?;
        let names = if is_version_2 { &VERSION_2 } else { &VERSION_1 };
        (is_version_2 || is_memory).then(|| mount.least(root, path, (names, of_group))).flatten()
    };
    groups.lines().filter_map(of_line).min()
}

/// A hierarchy of control groups, as far as it is visible.
struct Mount {
    is_version_2: bool,
    /// The group that is visible at the point.
    group: String,
    point: String,
}

impl Mount {
    /// Reads a line of `mountinfo`; None where it is another file system.
    fn read(line: &str) -> Option<Mount> {
        let (place, kind) = line.split_once(" - ")?;
        let mut kind = kind.split(' ');
        let is_version_2 = match kind.next()? {
            "cgroup2" => true,
            "cgroup" if kind.nth(1)?.split(',').any(|option| option == "memory") => false,
            _ => return None,
        };
        let mut place = place.split(' ').skip(3).map(|field| field.replace("\\040", " "));
        Some(Mount { is_version_2, group: place.next()?, point: place.next()? })
    }

    /// The least of a group and those around it.
    fn least(&self, root: &Path, path: &str, (names, of_group): (&Names, OfGroup)) -> Option<u64> {
        // a container may be told the name of its group outside, where it sees none
        let below = Path::new(path).strip_prefix(&self.group).unwrap_or(Path::new(""));
        let point = root.join(self.point.trim_start_matches('/'));
        let folder: PathBuf = point.join(below.strip_prefix("/").unwrap_or(below));
        let groups = folder.ancestors().take_while(|folder| folder.starts_with(&point));
        groups.filter_map(|folder| of_group(folder, names)).min()
    }
}

/// Bytes that one group allows; None where it has no limit.
fn limit_of(folder: &Path, names: &Names) -> Option<u64> {
    names.limits.iter().filter_map(|name| value(&folder.join(name), "")).min()
}

/// Bytes that one group leaves; None where it has no limit.
fn left_in(folder: &Path, names: &Names) -> Option<u64> {
    let limit = limit_of(folder, names)?;
    let used = value(&folder.join(names.used), "").unwrap_or(0);
    let free_to_go = value(&folder.join("memory.stat"), names.free_to_go).unwrap_or(0);
    Some(limit.saturating_sub(used.saturating_sub(free_to_go)))
}

/// The number behind a word at the beginning of a line of a file.
fn value(file: &Path, word: &str) -> Option<u64> {
    let text = std::fs::read_to_string(file).ok()?;
    let rest = text
        .lines()
        .find_map(|line| line.strip_prefix(word).filter(|rest| word.is_empty() || rest.starts_with(' ')))?;
    rest.split_ascii_whitespace().next()?.parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    const GIB: u64 = 1 << 30;

    /// A folder with the files of a system, by their names.
    fn system(files: &[(&str, &str)]) -> tempfile::TempDir {
        let root = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let path = root.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        root
    }

    const MEMINFO: (&str, &str) = ("proc/meminfo", "MemTotal: 33554432 kB\nMemAvailable:   16777216 kB\n");
    const MOUNT_2: &str = "30 24 0:26 / /sys/fs/cgroup rw,nosuid shared:9 - cgroup2 cgroup2 rw,nsdelegate\n";

    #[test]
    fn without_groups_it_is_what_the_system_has() {
        assert_eq!(available_bytes_in(system(&[MEMINFO]).path()), Some(16 * GIB));
        assert_eq!(available_bytes_in(system(&[]).path()), None);
        let unlimited = [
            MEMINFO,
            ("proc/self/cgroup", "0::/user.slice\n"),
            ("proc/self/mountinfo", MOUNT_2),
            ("sys/fs/cgroup/user.slice/memory.max", "max\n"),
            ("sys/fs/cgroup/user.slice/memory.current", "5000\n"),
        ];
        assert_eq!(available_bytes_in(system(&unlimited).path()), Some(16 * GIB));
        assert_eq!(group_limit_bytes_in(system(&unlimited).path()), None);
    }

    #[test]
    fn of_version_2_every_group_around_counts_less_what_it_holds() {
        let files = [
            MEMINFO,
            ("proc/self/cgroup", "0::/pods/pod 1/one\n"),
            ("proc/self/mountinfo", MOUNT_2),
            ("sys/fs/cgroup/pods/pod 1/one/memory.max", "4294967296\n"),
            ("sys/fs/cgroup/pods/pod 1/one/memory.current", "1073741824\n"),
            ("sys/fs/cgroup/pods/pod 1/one/memory.stat", "inactive_file_x 7\ninactive_file 73741824\nactive_file 9\n"),
            ("sys/fs/cgroup/pods/pod 1/memory.max", "max\n"),
            ("sys/fs/cgroup/pods/memory.max", "8589934592\n"),
            ("sys/fs/cgroup/pods/memory.current", "3221225472\n"),
        ];
        let root = system(&files);
        assert_eq!(available_bytes_in(root.path()), Some(4 * GIB - 1_000_000_000));
        assert_eq!(group_limit_bytes_in(root.path()), Some(4 * GIB));
        std::fs::write(root.path().join("sys/fs/cgroup/pods/memory.current"), "7516192768").unwrap();
        assert_eq!(available_bytes_in(root.path()), Some(GIB));
        std::fs::write(root.path().join("sys/fs/cgroup/pods/memory.high"), "7516192769").unwrap();
        assert_eq!(available_bytes_in(root.path()), Some(1));
        std::fs::write(root.path().join("sys/fs/cgroup/pods/memory.current"), "9516192768").unwrap();
        assert_eq!(available_bytes_in(root.path()), Some(0));
    }

    #[test]
    fn of_version_1_a_container_sees_its_own_group_at_the_mount() {
        let mounts = "41 36 0:30 /docker/4f /sys/fs/cgroup/cpu rw - cgroup cgroup rw,cpu,cpuacct\n\
                      42 36 0:31 /docker/4f /sys/fs/cgroup/memory ro master:14 - cgroup cgroup rw,memory\n";
        let files = [
            MEMINFO,
            ("proc/self/cgroup", "11:memory:/docker/4f\n4:cpu,cpuacct:/docker/4f\n0::/\n"),
            ("proc/self/mountinfo", mounts),
            ("sys/fs/cgroup/memory/memory.limit_in_bytes", "314572800\n"),
            ("sys/fs/cgroup/memory/memory.usage_in_bytes", "14572800\n"),
            ("sys/fs/cgroup/memory/memory.stat", "inactive_file 1\ntotal_inactive_file 4572800\n"),
        ];
        let root = system(&files);
        assert_eq!(available_bytes_in(root.path()), Some(304_572_800));
        // a group within, as Slurm makes for a step; and one that is named as outside, where it is not visible
        std::fs::write(root.path().join("proc/self/cgroup"), "11:memory:/docker/4f/step_0\n").unwrap();
        std::fs::create_dir(root.path().join("sys/fs/cgroup/memory/step_0")).unwrap();
        std::fs::write(root.path().join("sys/fs/cgroup/memory/step_0/memory.limit_in_bytes"), "9000000").unwrap();
        assert_eq!(available_bytes_in(root.path()), Some(9_000_000));
        std::fs::write(root.path().join("proc/self/cgroup"), "11:memory:/kubepods/x\n").unwrap();
        assert_eq!(available_bytes_in(root.path()), Some(304_572_800));
        // no limit is a number of 2^63 less a page
        std::fs::write(root.path().join("sys/fs/cgroup/memory/memory.limit_in_bytes"), "9223372036854771712").unwrap();
        assert_eq!(available_bytes_in(root.path()), Some(16 * GIB));
        assert_eq!(group_limit_bytes_in(root.path()), None);
    }
}
