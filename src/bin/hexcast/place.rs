//! The place of an output: where its path leads, through links, and whether it may be written there.

use std::path::{Path, PathBuf};

use hexcast::{Error, Result};

/// Links that the system follows in one path.
const MAX_LINKS: usize = 40;

/// The path of an output without the links at its end: a link stays, and what it leads to is written, there or not.
///
/// # Errors
/// `io` where the links form a circle, or lead to a file by the number under which a process has it open.
pub(crate) fn target_of(path: &Path) -> Result<PathBuf> {
    let mut target = path.to_path_buf();
    for _ in 0..MAX_LINKS {
        // links to what a process has open, as /dev/stdout is: another file of that name would not be what is open
        if target.starts_with("/proc") {
            return Err(if path.exists() { not_a_file(path) } else { not_in_proc(path) });
        }
        // fails for what is not a link and for what is not there
        let Ok(next) = std::fs::read_link(&target) else { return Ok(target) };
        target = folder_of(&target).join(next);
    }
    let message = format!(
        "{} cannot be written: it is a symbolic link that leads through more than {MAX_LINKS} others, or through links in a circle",
        path.display()
    );
    Err(Error::new("io", message, "name the file itself"))
}

/// The folder of a path.
pub(crate) fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Refuses what exists and is neither a file nor a folder: a pipe, a device, a socket.
///
/// # Errors
/// `io`.
pub(crate) fn check_kind(path: &Path) -> Result<()> {
    match path.metadata() {
        Ok(metadata) if !metadata.is_file() && !metadata.is_dir() => Err(not_a_file(path)),
        _ => Ok(()),
    }
}

fn not_in_proc(path: &Path) -> Error {
    let message = format!(
        "{} cannot be written: /proc has what the system says of its processes, and no other files",
        path.display()
    );
    Error::new("io", message, "name a file in another folder")
}

/// The error of a path that is taken by something else than a file.
pub(crate) fn not_a_file(path: &Path) -> Error {
    let message = format!("{} exists and is not a file: it is left as it is", path.display());
    Error::new("io", message, "move what has this name, or name another output")
}
