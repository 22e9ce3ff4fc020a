//! Whether the disks have room for outputs, as far as their sizes are known before they are written.
//!
//! Files that will be replaced count as used: they are there until the new ones have their names.

use std::path::{Path, PathBuf};

use hexcast::{Error, Result};

/// An output whose size is known.
pub(crate) struct Planned {
    /// The name that the caller gave.
    pub(crate) path: PathBuf,
    /// The folder that it is written in.
    pub(crate) folder: PathBuf,
    pub(crate) n_bytes: u64,
}

/// Checks that every disk has room for all outputs on it, after each has said whether it can be written: whose sizes are those that are planned, or `" at least"` those. A disk that does not
/// say what is free is trusted.
///
/// # Errors
/// `io`, with the bytes needed, free and missing.
pub(crate) fn check_room(outputs: impl Iterator<Item = Result<Option<Planned>>>, least: &str) -> Result<()> {
    let outputs = outputs.collect::<Result<Vec<_>>>()?;
    let mut disks: Vec<(Disk, Vec<&Planned>)> = Vec::new();
    for output in outputs.iter().flatten() {
        let Some(disk) = disk_of(&output.folder) else { continue };
        match disks.iter_mut().find(|(other, _)| other.id == disk.id) {
            Some((_, outputs)) => outputs.push(output),
            None => disks.push((disk, vec![output])),
        }
    }
    disks.iter().try_for_each(|(disk, outputs)| check_disk(disk.n_free, outputs, least))
}

fn check_disk(n_free: u64, outputs: &[&Planned], least: &str) -> Result<()> {
    let needed = outputs.iter().fold(0u64, |sum, output| sum.saturating_add(output.n_bytes));
    let Some(missing @ 1..) = needed.checked_sub(n_free) else { return Ok(()) };
    let names: Vec<String> = outputs.iter().map(|output| output.path.display().to_string()).collect();
    let takes = if names.len() == 1 { "takes" } else { "take" };
    let message = format!(
        "{} {takes} {needed} bytes{least}, and the disk has {n_free} free: {missing} bytes are missing",
        names.join(" and ")
    );
    let hint =
        "make room, name another disk, or write .hxc, which is far smaller; `hexcast convert` makes the others from it";
    Err(Error::new("io", message, hint))
}

/// A disk, and the bytes on it that this user may fill.
struct Disk {
    id: u64,
    n_free: u64,
}

#[cfg(unix)]
fn disk_of(folder: &Path) -> Option<Disk> {
    use std::os::unix::fs::MetadataExt;
    let facts = rustix::fs::statvfs(folder).ok()?;
    // some virtual file systems have no blocks, and room all the same
    let n_free = facts.f_bavail.checked_mul(facts.f_frsize).filter(|_| facts.f_blocks > 0)?;
    Some(Disk { id: folder.metadata().ok()?.dev(), n_free })
}

#[cfg(not(unix))]
fn disk_of(_: &Path) -> Option<Disk> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn outputs_of_one_disk_are_summed() {
        let planned = |name: &str, n_bytes| Planned { path: name.into(), folder: ".".into(), n_bytes };
        let room = |all: Vec<Planned>| check_room(all.into_iter().map(|one| Ok(Some(one))), "");
        let (a, b) = (planned("a.raw", 700), planned("b.npy", 301));
        assert_eq!(check_disk(1001, &[&a, &b], ""), Ok(()));
        let error = check_disk(1000, &[&a, &b], "").unwrap_err();
        assert_eq!((error.code(), error.to_string().contains("take 1001 bytes")), ("io", true), "{error}");
        assert!(error.to_string().ends_with("the disk has 1000 free: 1 bytes are missing"), "{error}");
        assert!(room([planned("a.raw", 1)].into()).is_ok());
        #[cfg(unix)]
        assert!(room([planned("a.raw", u64::MAX), planned("b.raw", u64::MAX)].into()).is_err());
        assert!(room([Planned { folder: "no such folder".into(), ..planned("a.raw", u64::MAX) }].into()).is_ok());
    }
}
