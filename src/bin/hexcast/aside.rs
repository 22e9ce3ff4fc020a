//! Files for columns that do not fit in memory, or that shall outlive an interrupted run.

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use hexcast::pipeline::Aside;
use hexcast::{Error, Result};

use super::file_store::FileStore;
use super::output_file::with_ending;

/// Where columns go besides memory.
#[derive(clap::Args)]
#[command(next_help_heading = "Memory")]
pub(crate) struct AsideArguments {
    /// Folder for a temporary file that takes the columns when they outgrow the memory allowed; it has no name there and
    /// is gone with the program
    #[arg(long, value_name = "DIR", conflicts_with = "resume")]
    spill: Option<PathBuf>,
    /// Keep finished columns in OUT.partial, beside the first output, until all is written: the same command goes on from
    /// them after Ctrl-C or a failure. They are also read from there when they outgrow the memory allowed
    #[arg(long, requires = "outputs")]
    resume: bool,
}

/// A file that columns go to, and what becomes of it.
pub(crate) struct AsideFile {
    pub(crate) aside: Aside,
    /// A file to be kept unless all goes well.
    kept: Option<(PathBuf, Arc<FileStore>)>,
}

impl AsideArguments {
    /// Opens the file that the arguments ask for.
    pub(crate) fn open(&self, outputs: &[PathBuf]) -> Result<AsideFile> {
        if let Some(folder) = &self.spill {
            let file = tempfile::tempfile_in(folder).map_err(|error| {
                let message = format!("no temporary file can be made in {}: {error}", folder.display());
                Error::new("io", message, "make sure that the folder exists and is yours")
            })?;
            return Ok(AsideFile { aside: Aside::Spill(Arc::new(FileStore::new(file))), kept: None });
        }
        match outputs.first().filter(|_| self.resume) {
            Some(output) => keep(&with_ending(output, ".partial")),
            None => Ok(AsideFile { aside: Aside::Nowhere, kept: None }),
        }
    }
}

fn keep(path: &Path) -> Result<AsideFile> {
    let name = path.display();
    let failed = |error| {
        let message = format!("{name}, which would keep the columns, cannot be opened: {error}");
        Error::new("io", message, "move what has this name, or name another output")
    };
    let options = File::options().read(true).write(true).create(true).truncate(false).open(path);
    let file = options.map_err(failed)?;
    if file.try_lock().is_err() {
        return Err(Error::new(
            "io",
            format!("{name} is in use by another run"),
            "wait for it, or name another output",
        ));
    }
    let store = Arc::new(FileStore::new(file));
    Ok(AsideFile { aside: Aside::Keep(store.clone()), kept: Some((path.to_path_buf(), store)) })
}

impl AsideFile {
    /// Removes a kept file when all is written.
    pub(crate) fn done(self) {
        if let Some((path, _)) = &self.kept {
            // a file that cannot be removed is refused, or taken up, next time
            let _ = std::fs::remove_file(path);
        }
    }

    /// Says how to go on after an error, if columns were kept for this job.
    pub(crate) fn failed(self, error: &Error) {
        let Some((path, store)) = &self.kept else { return };
        if error.code() == "job-conflict" {
            return;
        }
        let n_bytes = store.n_bytes();
        if n_bytes > 0 {
            let name = path.display();
            eprintln!("kept: finished columns are in {name} ({n_bytes} bytes); the same command goes on from there");
        } else {
            let _ = std::fs::remove_file(path);
        }
    }
}
