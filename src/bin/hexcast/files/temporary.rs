//! Temporary files and folders beside an output: their names, who owns them, and what killed runs have left.
//!
//! The name is `.hexcast-OUT-XXXXXX.part`, with six random letters. The owner holds a lock: of the file itself, or of the file
//! `lock` in the folder. The system releases it however the owner ends. A process id in the name would not do: ids are used
//! again, and say nothing about processes of other machines and containers that share the folder.

#[cfg(unix)]
use std::fs::Permissions;
use std::fs::{File, TryLockError};
use std::io;
use std::path::{Path, PathBuf};

use hexcast::files::place::folder_of;
use tempfile::{NamedTempFile, TempDir};

/// Letters that make a name unique.
const N_RANDOM: usize = 6;
/// Longest part of the name of an output in that of a temporary file; a name has at most 255 bytes.
const MAX_NAME_CHARS: usize = 50;
/// What the names of temporary files and folders begin with.
pub(crate) const PREFIX: &str = ".hexcast-";
const ENDING: &str = ".part";
/// The folder inside a temporary folder that holds what had the output's name, until the new one has it.
const OLD: &str = "old";

/// Makes a temporary file beside an output, after removing those that killed runs have left.
pub(crate) fn file_for(output: &Path, folder: &Path) -> io::Result<NamedTempFile> {
    remove_orphans(output, folder);
    loop {
        let prefix = prefix_of(output);
        let mut builder = tempfile::Builder::new();
        builder.prefix(&prefix).rand_bytes(N_RANDOM).suffix(ENDING);
        // as any new file, not only for its owner
        #[cfg(unix)]
        builder.permissions(<Permissions as std::os::unix::fs::PermissionsExt>::from_mode(0o666));
        let file = builder.tempfile_in(folder)?;
        if is_mine(file.as_file()) && file.path().exists() {
            return Ok(file);
        }
    }
}

/// A temporary folder, owned as long as it is held; it is removed with all that is in it where this is dropped.
pub(crate) struct Folder {
    folder: TempDir,
    _lock: File,
}

impl Folder {
    /// Makes one beside an output, after removing those that killed runs have left.
    pub(crate) fn beside(output: &Path, folder: &Path) -> io::Result<Folder> {
        remove_orphans(output, folder);
        loop {
            let prefix = prefix_of(output);
            let folder =
                tempfile::Builder::new().prefix(&prefix).rand_bytes(N_RANDOM).suffix(ENDING).tempdir_in(folder)?;
            // another run may take a folder for an orphan between its making and its lock
            match lock_file(folder.path()) {
                Ok(lock) if is_mine(&lock) && folder.path().join("lock").exists() => {
                    return Ok(Folder { folder, _lock: lock });
                }
                Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
                _ => {}
            }
        }
    }

    /// The path of a name in it.
    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The same, with the folders that it needs.
    pub(crate) fn place(&self, name: &str) -> io::Result<PathBuf> {
        let place = self.path(name);
        std::fs::create_dir_all(folder_of(&place))?;
        Ok(place)
    }

    /// Makes a file in it.
    pub(crate) fn create(&self, name: &str) -> io::Result<File> {
        File::create(self.place(name)?)
    }

    /// Moves what has the name of the output into it, if anything has.
    pub(crate) fn take_old(&self, output: &Path) -> io::Result<()> {
        if output.exists() { std::fs::rename(output, self.path(OLD)) } else { Ok(()) }
    }
}

/// A file without a name, which disappears when the program ends.
pub(crate) fn unnamed(folder: &Path) -> io::Result<File> {
    tempfile::tempfile_in(folder)
}

fn prefix_of(output: &Path) -> String {
    let name = output.file_name().unwrap_or_default().to_string_lossy();
    format!("{PREFIX}{}-", name.chars().take(MAX_NAME_CHARS).collect::<String>())
}

/// Takes the lock; also true on file systems without locks, where no run can take a file of another for an orphan.
fn is_mine(file: &File) -> bool {
    !matches!(file.try_lock(), Err(TryLockError::WouldBlock))
}

fn lock_file(folder: &Path) -> io::Result<File> {
    File::options().write(true).create(true).truncate(false).open(folder.join("lock"))
}

/// Removes the temporary files and folders of an output that nobody owns. What cannot be removed stays.
fn remove_orphans(output: &Path, folder: &Path) {
    let prefix = prefix_of(output);
    let Ok(entries) = std::fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        let random = name.strip_prefix(&prefix).and_then(|rest| rest.strip_suffix(ENDING));
        let is_named = random.is_some_and(|random| {
            random.len() == N_RANDOM && random.bytes().all(|letter| letter.is_ascii_alphanumeric())
        });
        // neither is true of a link
        let Ok(kind) = entry.file_type() else { continue };
        let path = entry.path();
        if is_named && kind.is_file() {
            remove_orphan_file(&path);
        } else if is_named && kind.is_dir() {
            remove_orphan_folder(&path, output);
        }
    }
}

fn remove_orphan_file(path: &Path) {
    let Ok(file) = File::options().write(true).open(path) else { return };
    if file.try_lock().is_ok() {
        let _ = std::fs::remove_file(path);
    }
}

fn remove_orphan_folder(path: &Path, output: &Path) {
    let Ok(lock) = lock_file(path) else { return };
    if lock.try_lock().is_err() {
        return;
    }
    // the run was killed after it moved the old folder away and before the new one was in its place
    let old = path.join(OLD);
    if old.exists() && !output.exists() && std::fs::rename(&old, output).is_err() {
        return;
    }
    let _ = std::fs::remove_dir_all(path);
}
