//! A Zarr folder as output: made under another name beside the target, and put in place at the end.

use std::path::{Path, PathBuf};

use hexcast::control::Control;
use hexcast::files::WrittenFolder;
use hexcast::files::place::{folder_of, refused, target_of};
use hexcast::mesh::Mesh;
use hexcast::write::{Format, Options, zarr};
use hexcast::{Error, Result};

use crate::files::{ledger::Output, output_file::OutputFile, temporary};
use crate::screen::progress::Progress;

/// A temporary folder; nothing is left where this is dropped before [`ZarrFolder::finish`].
pub(crate) struct ZarrFolder {
    /// The name that the caller gave.
    pub(crate) path: PathBuf,
    output: Output,
    temporary: temporary::Folder,
    /// What was written.
    written: Option<WrittenFolder>,
}

/// Whether the name of an output asks for a Zarr folder.
pub(crate) fn is_zarr(path: &Path) -> bool {
    Format::of_name(&path.to_string_lossy()) == Ok(Format::Zarr)
}

/// Refuses a path that is neither free nor a Zarr folder; returns it without the links at its end.
pub(crate) fn check_replaceable(path: &Path) -> Result<PathBuf> {
    // another process may have begun the store a moment ago
    let is_ours = |entry: std::io::Result<std::fs::DirEntry>| {
        entry.is_ok_and(|entry| entry.file_name().to_string_lossy().starts_with(temporary::PREFIX))
    };
    let is_begun = || std::fs::read_dir(path).is_ok_and(|mut entries| entries.all(is_ours));
    if path.exists() && !path.join("zarr.json").is_file() && !is_begun() {
        return Err(Error::new("io", format!("{} exists and is not a Zarr folder", path.display()), "name another"));
    }
    target_of(path)
}

impl ZarrFolder {
    /// Makes a temporary folder beside `path`, which is free or a Zarr folder.
    pub(crate) fn open(path: &Path) -> Result<ZarrFolder> {
        let output = Output::folder(path, check_replaceable(path)?)?;
        let parent = folder_of(&output.target);
        let temporary = temporary::Folder::beside(&output.target, parent);
        let temporary = temporary.map_err(|error| refused(path, parent, &error))?;
        Ok(ZarrFolder { path: path.to_path_buf(), output, temporary, written: None })
    }

    /// Writes the mesh.
    pub(crate) fn write(
        &mut self,
        mesh: &Mesh,
        options: &Options,
        control: &Control,
        progress: Progress,
    ) -> Result<OutputFile> {
        let bar = progress.bytes("write", Some(mesh.n_cells()));
        let written = self.put(|set| zarr::write(mesh, options, set, control, |n_cells| bar.inc(n_cells)));
        bar.finish_and_clear();
        written
    }

    /// Writes what `write` sets.
    pub(crate) fn put(&mut self, write: impl FnOnce(&zarr::Set) -> Result<()>) -> Result<OutputFile> {
        let folder = WrittenFolder::new(self.inner());
        write(&|key, value| folder.put(key, value)).map_err(|error| error.at(self.path.display()))?;
        let n_bytes = folder.n_bytes();
        self.written = Some(folder);
        Ok(OutputFile { path: self.path.clone(), n_bytes })
    }

    /// Puts the folder in its place, if all that was written to it is there; one that was there goes only now.
    pub(crate) fn finish(self) -> Result<()> {
        if let Some(folder) = &self.written {
            folder.verify().map_err(|error| error.at(self.path.display()))?;
        }
        let failed = |error| Error::io(format!("writing {}", self.path.display()), error);
        self.temporary.take_old(&self.output.target).map_err(failed)?;
        self.output.put_path(&self.inner())
    }

    /// The new folder: inside the temporary one, which only its owner may open.
    fn inner(&self) -> PathBuf {
        self.temporary.path("new")
    }
}
