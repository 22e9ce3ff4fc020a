//! A Zarr folder as output: made under another name beside the target, and put in place at the end.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use hexcast::control::Control;
use hexcast::mesh::Mesh;
use hexcast::write::{Options, zarr};
use hexcast::{Error, Result};
use tempfile::TempDir;
use zarrs::filesystem::FilesystemStore;

use super::output_file::{OutputFile, refused};
use super::progress::Progress;

/// A temporary folder; nothing is left where this is dropped before [`ZarrFolder::finish`].
pub(crate) struct ZarrFolder {
    pub(crate) path: PathBuf,
    temporary: TempDir,
}

/// Whether the name of an output asks for a Zarr folder.
pub(crate) fn is_zarr(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("zarr"))
}

impl ZarrFolder {
    /// Makes a temporary folder beside `path`, which is free or a Zarr folder; also returns the path without links.
    pub(crate) fn open(path: &Path) -> Result<(PathBuf, ZarrFolder)> {
        let name = path.display();
        if path.exists() && !path.join("zarr.json").is_file() {
            return Err(Error::new("io", format!("{name} exists and is not a Zarr folder"), "name another"));
        }
        let parent = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let refused = |error: std::io::Error| refused(path, parent, &error);
        let temporary = tempfile::Builder::new().prefix(".hexcast-").suffix(".part").tempdir_in(parent);
        let temporary = temporary.map_err(refused)?;
        let place = parent.canonicalize().map_err(refused)?.join(path.file_name().unwrap_or_default());
        Ok((place, ZarrFolder { path: path.to_path_buf(), temporary }))
    }

    /// Writes the mesh.
    pub(crate) fn write(
        &self,
        mesh: &Mesh,
        options: &Options,
        control: &Control,
        progress: Progress,
    ) -> Result<OutputFile> {
        let failed = |error: &dyn std::fmt::Display| Error::new("io", format!("writing Zarr: {error}"), "");
        let store = FilesystemStore::new(self.inner()).map_err(|error| failed(&error))?;
        let bar = progress.bytes("write", Some(mesh.n_cells()));
        let written = zarr::write(mesh, options, Arc::new(store), control, |n_cells| bar.inc(n_cells));
        bar.finish_and_clear();
        written.map_err(|error| error.at(self.path.display()))?;
        let n_bytes = bytes_of(&self.inner()).map_err(|error| failed(&error))?;
        Ok(OutputFile { path: self.path.clone(), n_bytes })
    }

    /// Puts the folder in its place; one that was there goes only now.
    pub(crate) fn finish(self) -> Result<()> {
        let failed = |error| Error::io(format!("writing {}", self.path.display()), error);
        if self.path.exists() {
            std::fs::rename(&self.path, self.temporary.path().join("old")).map_err(failed)?;
        }
        std::fs::rename(self.inner(), &self.path).map_err(failed)
    }

    /// The new folder: inside the temporary one, which only its owner may open.
    fn inner(&self) -> PathBuf {
        self.temporary.path().join("new")
    }
}

/// Bytes of all files in a folder.
fn bytes_of(folder: &Path) -> std::io::Result<u64> {
    let mut sum = 0;
    for entry in std::fs::read_dir(folder)? {
        let entry = entry?;
        let metadata = entry.metadata()?;
        sum += if metadata.is_dir() { bytes_of(&entry.path())? } else { metadata.len() };
    }
    Ok(sum)
}
