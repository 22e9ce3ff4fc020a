//! A Zarr store as output: a folder of its own, put in place at the end, or a store that several processes fill.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use hexcast::Result;
use hexcast::control::Control;
use hexcast::mesh::Mesh;
use hexcast::write::Options;
use hexcast::write::zarr::{self, Place};

use crate::files::{
    ledger::Output,
    output_file::OutputFile,
    place_of_store::{self, is_s3},
    store::Shared,
    zarr_folder::{ZarrFolder, check_replaceable},
};
use crate::screen::progress::Progress;

/// A store being written.
pub(crate) enum ZarrOutput {
    /// The whole mesh, in a temporary folder until all is written.
    Whole(ZarrFolder),
    /// A part of a mesh, or a whole one in a bucket, where nothing can be renamed: shards get their names one by one.
    Shared { path: PathBuf, store: Arc<Shared> },
}

impl ZarrOutput {
    /// Opens it.
    pub(crate) fn open(path: &Path, is_part: bool) -> Result<ZarrOutput> {
        if !is_part && !is_s3(path) {
            return Ok(ZarrOutput::Whole(ZarrFolder::open(path)?));
        }
        let target = if is_s3(path) { path.to_path_buf() } else { check_replaceable(path)? };
        let output = Output::file_of(path, target)?;
        let store = Arc::new(Shared::new(place_of_store::open(&output.target)?));
        Ok(ZarrOutput::Shared { path: path.into(), store })
    }

    /// Writes the mesh, which lies in the store where `place` says.
    pub(crate) fn write(
        &mut self,
        mesh: &Mesh,
        place: &Place,
        options: &Options,
        control: &Control,
        progress: Progress,
    ) -> Result<OutputFile> {
        match self {
            ZarrOutput::Whole(folder) => folder.write(mesh, options, control, progress),
            ZarrOutput::Shared { path, store } => {
                let bar = progress.bytes("write", Some(mesh.n_cells()));
                let advance = |n_cells| bar.inc(n_cells);
                let written =
                    zarr::write_part(mesh, place, options, &|key, value| store.set(key, value), control, advance);
                bar.finish_and_clear();
                written.map_err(|error| error.at(path.display()))?;
                Ok(OutputFile { path: path.clone(), n_bytes: store.n_bytes() })
            }
        }
    }

    /// Puts a folder in its place.
    pub(crate) fn finish(self) -> Result<()> {
        match self {
            ZarrOutput::Whole(folder) => folder.finish(),
            ZarrOutput::Shared { .. } => Ok(()),
        }
    }
}
