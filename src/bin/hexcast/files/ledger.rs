//! The ledger of paths: every file that the command reads or writes is entered here, and none is both, nor written twice.
//!
//! Nothing else opens a file or gives one its name: `tests/native/layering/paths_of_command.rs` reads the source of the command for that. So an option
//! that is added is checked, too. A process runs one command, and has one ledger.
//!
//! Two paths are one file if they lead to the same place without links, or, on Unix, to files with the same device and inode: so do hard
//! links, and standard input that is read from a file. An output is entered before anything is written, and looked at again when it gets
//! its name, as it may be there by then.

use std::collections::HashMap;
use std::collections::hash_map::Entry as Slot;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::{LazyLock, Mutex, MutexGuard, PoisonError};

use hexcast::files::place::{Id, check_kind, folder_of, id_of, not_a_file, target_of};
use hexcast::{Error, Result};
use tempfile::NamedTempFile;

use crate::files::{standard_streams, temporary};

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Use {
    Read,
    /// One file, or a store that other processes fill, too.
    Write,
    /// A folder that is replaced with all that is in it.
    Replace,
}

/// A path, where it leads and what for.
struct Entry {
    /// The name that the caller gave.
    path: PathBuf,
    place: PathBuf,
    id: Option<Id>,
    used: Use,
}

#[derive(Default)]
struct Ledger {
    entries: Vec<Entry>,
    by_place: HashMap<PathBuf, usize>,
    by_id: HashMap<Id, usize>,
    /// Folders that are replaced.
    folders: Vec<usize>,
}

impl Ledger {
    /// Enters a path, and returns its number.
    fn enter(&mut self, entry: Entry) -> Result<usize> {
        let of_id = entry.id.and_then(|id| self.by_id.get(&id));
        if let Some(&other) = self.by_place.get(&entry.place).or(of_id) {
            if entry.used == Use::Read && self.entries[other].used == Use::Read {
                return Ok(other);
            }
            return Err(self.conflict(&entry, other));
        }
        self.check_folders(&entry)?;
        let number = self.entries.len();
        self.by_place.insert(entry.place.clone(), number);
        if let Some(id) = entry.id {
            self.by_id.insert(id, number);
        }
        if entry.used == Use::Replace {
            self.folders.push(number);
        }
        self.entries.push(entry);
        Ok(number)
    }

    /// Refuses what lies in a folder that is replaced, and such a folder around something else.
    fn check_folders(&self, entry: &Entry) -> Result<()> {
        let is_in = |inner: &Entry, folder: &Entry| inner.place.starts_with(&folder.place);
        let around = self.folders.iter().map(|&number| &self.entries[number]).find(|folder| is_in(entry, folder));
        if let Some(folder) = around {
            return Err(inside(entry, folder));
        }
        let within = self.entries.iter().find(|other| entry.used == Use::Replace && is_in(other, entry));
        within.map_or(Ok(()), |inner| Err(inside(inner, entry)))
    }

    fn conflict(&self, entry: &Entry, number: usize) -> Error {
        let other = &self.entries[number];
        let what = if [entry.used, other.used].contains(&Use::Read) { "is an input too" } else { "is written twice" };
        // the output is the one to rename
        let path = if entry.used == Use::Read { &other.path } else { &entry.path };
        Error::new("job-conflict", format!("{} {what}", path.display()), "give the output another name")
    }

    /// Refuses to give an output its name where something else that is used has it by now.
    fn check_again(&self, number: usize) -> Result<()> {
        let entry = &self.entries[number];
        let id = entry.place.metadata().ok().as_ref().and_then(id_of);
        match id.and_then(|id| self.by_id.get(&id)) {
            Some(&other) if other != number => Err(self.conflict(entry, other)),
            _ => Ok(()),
        }
    }

    /// Notes which file an output is now.
    fn note(&mut self, number: usize) {
        let entry = &mut self.entries[number];
        let old = std::mem::replace(&mut entry.id, entry.place.metadata().ok().as_ref().and_then(id_of));
        let new = entry.id;
        // the system may give the number of the file that was replaced to another
        if let Some(Slot::Occupied(slot)) = old.map(|id| self.by_id.entry(id))
            && *slot.get() == number
        {
            slot.remove();
        }
        if let Some(id) = new {
            self.by_id.insert(id, number);
        }
    }
}

fn inside(inner: &Entry, folder: &Entry) -> Error {
    let [inner_name, folder_name] = [inner, folder].map(|of| of.path.display());
    let what = if inner.used == Use::Read { "an input" } else { "an output" };
    let message =
        format!("{inner_name}, {what}, lies in {folder_name}, a folder that is replaced with all that is in it");
    Error::new("job-conflict", message, "write the folder elsewhere")
}

/// That of this process, which begins with where its standard output goes, if that is a file.
static LEDGER: LazyLock<Mutex<Ledger>> = LazyLock::new(|| {
    let mut ledger = Ledger::default();
    if let Some(id) = standard_streams::output_file().as_ref().and_then(id_of) {
        let name = PathBuf::from("standard output");
        ledger.by_id.insert(id, 0);
        ledger.entries.push(Entry { path: name.clone(), place: name, id: Some(id), used: Use::Write });
    }
    Mutex::new(ledger)
});

fn ledger() -> MutexGuard<'static, Ledger> {
    // every change leaves it whole
    LEDGER.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Where a path leads, without links as far as it is there.
fn place_of(path: &Path) -> PathBuf {
    if is_elsewhere(path) {
        return path.into();
    }
    let absolute = std::path::absolute(path).unwrap_or_else(|_| path.into());
    // the nearest folder that is there, and what is to be made in it
    let from = |there: &Path| Some(there.canonicalize().ok()?.join(absolute.strip_prefix(there).ok()?));
    absolute.ancestors().find_map(from).unwrap_or_else(|| absolute.clone())
}

/// Whether a path is that of standard input or output, or of a bucket.
fn is_elsewhere(path: &Path) -> bool {
    standard_streams::is_standard(path) || path.to_string_lossy().contains("://")
}

/// Enters an input, before it is opened or where others open it.
///
/// # Errors
/// `job-conflict` where it is an output.
pub(crate) fn reads(path: &Path) -> Result<()> {
    let metadata =
        if standard_streams::is_standard(path) { standard_streams::input_file() } else { path.metadata().ok() };
    // pipes and devices are not overwritten
    let id = metadata.filter(|metadata| metadata.is_file() || metadata.is_dir()).as_ref().and_then(id_of);
    let place = if standard_streams::is_standard(path) { "standard input".into() } else { place_of(path) };
    ledger().enter(Entry { path: path.into(), place, id, used: Use::Read }).map(|_| ())
}

/// Opens a file, or a pipe or device, to read it.
///
/// # Errors
/// Those of [`reads`] and of [`hexcast::files::open_file`].
pub(crate) fn open(path: &Path) -> Result<File> {
    reads(path)?;
    hexcast::files::open_file(path)
}

/// The right to write one file or folder.
#[derive(Debug)]
pub(crate) struct Output {
    /// The name that the caller gave.
    pub(crate) path: PathBuf,
    /// What it leads to; [`standard_streams::NAME`] where that is standard output.
    pub(crate) target: PathBuf,
    number: usize,
}

impl Output {
    /// Enters a file to be written; a link at the end of the path stays, and what it leads to is written.
    ///
    /// # Errors
    /// `job-conflict` where it is an input or another output; `io` where no file can have this name.
    pub(crate) fn file(path: &Path) -> Result<Output> {
        if is_elsewhere(path) {
            return Output::enter(path, path.into(), Use::Write);
        }
        if path.is_dir() {
            return Err(Error::new("io", format!("{} is a folder", path.display()), "name a file in it"));
        }
        check_kind(path)?;
        Output::enter(path, target_of(path)?, Use::Write)
    }

    /// Enters a file of several that `path` stands for.
    ///
    /// # Errors
    /// `job-conflict` where it is an input or another output.
    pub(crate) fn file_of(path: &Path, target: PathBuf) -> Result<Output> {
        Output::enter(path, target, Use::Write)
    }

    /// Enters a folder that is replaced as a whole.
    ///
    /// # Errors
    /// `job-conflict` where it is an output, or has an input or another output in it.
    pub(crate) fn folder(path: &Path, target: PathBuf) -> Result<Output> {
        Output::enter(path, target, Use::Replace)
    }

    fn enter(path: &Path, target: PathBuf, used: Use) -> Result<Output> {
        let id = target.metadata().ok().as_ref().and_then(id_of);
        let entry = Entry { path: path.into(), place: place_of(&target), id, used };
        let number = ledger().enter(entry)?;
        Ok(Output { path: path.into(), target, number })
    }

    /// Whether it goes to standard output.
    pub(crate) fn is_standard(&self) -> bool {
        standard_streams::is_standard(&self.path)
    }

    /// A temporary file beside it; for standard output where the system has such files.
    pub(crate) fn temporary_file(&self) -> std::io::Result<NamedTempFile> {
        if self.is_standard() {
            return NamedTempFile::new_in(std::env::temp_dir());
        }
        temporary::file_for(&self.target, folder_of(&self.target))
    }

    /// Opens the file itself, to go on with what it holds.
    ///
    /// # Errors
    /// `io` where it is no file, or cannot be opened.
    pub(crate) fn open_kept(&self) -> Result<File> {
        // a pipe would swallow the columns, and a link may lead to a file of somebody else
        if self.path.symlink_metadata().is_ok_and(|metadata| !metadata.is_file()) {
            return Err(not_a_file(&self.path));
        }
        let opened = File::options().read(true).write(true).create(true).truncate(false).open(&self.target);
        let file = opened.map_err(|error| {
            let message = format!("{}, the file to resume from, cannot be opened: {error}", self.path.display());
            Error::new("io", message, "move what has this name, or name another output")
        })?;
        ledger().note(self.number);
        Ok(file)
    }

    /// Gives a temporary file its name.
    ///
    /// # Errors
    /// `io`; `job-conflict` where something else that is used has the name by now.
    pub(crate) fn put_file(&self, temporary: NamedTempFile) -> Result<()> {
        self.put(|target| temporary.persist(target).map(|_| ()).map_err(|error| error.error))
    }

    /// Gives a file or folder in a temporary folder its name.
    ///
    /// # Errors
    /// `io`; `job-conflict` where something else that is used has the name by now.
    pub(crate) fn put_path(&self, from: &Path) -> Result<()> {
        self.put(|target| {
            std::fs::create_dir_all(folder_of(target))?;
            std::fs::rename(from, target)
        })
    }

    fn put(&self, give: impl FnOnce(&Path) -> std::io::Result<()>) -> Result<()> {
        let mut ledger = ledger();
        ledger.check_again(self.number)?;
        give(&self.target).map_err(|error| Error::io(format!("writing {}", self.path.display()), error))?;
        ledger.note(self.number);
        Ok(())
    }
}

#[cfg(all(test, unix))]
mod tests;
