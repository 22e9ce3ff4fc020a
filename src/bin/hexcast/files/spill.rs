//! The file for columns that do not fit in memory, or that shall outlive an interrupted run.

use std::fs::File;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use hexcast::column_file::may_continue;
use hexcast::job::RunJob;
use hexcast::pipeline::SpillTarget;
use hexcast::{Error, Result};

use crate::files::{ledger::Output, output_file::with_ending, standard_streams, temporary};
use crate::options::job_options::as_text;
use crate::screen::terminal;
use hexcast::files::FileStore;

/// Where columns go that exceed the memory allowed.
#[derive(clap::Args)]
#[command(next_help_heading = "Memory")]
pub(crate) struct SpillArguments {
    /// Folder for a temporary file that columns spill to when they exceed the memory allowed. The file has no name and
    /// disappears when the program ends
    #[arg(long, value_name = "DIR", conflicts_with = "resume")]
    spill: Option<PathBuf>,
    /// Keep finished columns in OUT.partial, beside the first output OUT, until all is written. After Ctrl-C or a failure the
    /// same command continues from them. Columns that exceed the memory allowed are also read from this file
    #[arg(long, requires = "outputs")]
    resume: bool,
}

/// A file that columns spill to, and its name if it outlives a failure.
pub(crate) struct SpillFile {
    pub(crate) target: SpillTarget,
    resumable: Option<(PathBuf, Arc<FileStore>)>,
}

impl SpillArguments {
    /// Puts the options into a job file.
    pub(crate) fn put(&self, run: &mut RunJob) -> Result<()> {
        run.resume = self.resume;
        run.spill = self.spill.as_deref().map(as_text).transpose()?;
        Ok(())
    }

    /// The error with the name of the file to resume from, where it is about that.
    pub(crate) fn at_file(&self, error: Error, outputs: &[PathBuf]) -> Error {
        let output = outputs.first().filter(|_| self.resume && error.code() == "columns-other");
        match output.map(|output| with_ending(output, ".partial")) {
            Some(path) => error.at(path.display()),
            None => error,
        }
    }

    /// Opens the file that the arguments ask for.
    pub(crate) fn open(&self, outputs: &[PathBuf]) -> Result<SpillFile> {
        if let Some(folder) = &self.spill {
            let file = temporary::unnamed(folder).map_err(|error| {
                let message = format!("no temporary file can be made in {}: {error}", folder.display());
                Error::new("io", message, "make sure that the folder exists and is yours")
            })?;
            let target = SpillTarget::Temporary(Arc::new(FileStore::new(file)));
            return Ok(SpillFile { target, resumable: None });
        }
        match outputs.first().filter(|_| self.resume) {
            Some(output) if standard_streams::is_standard(output) => {
                let message = "--resume is given and the first output is -: there is no folder for OUT.partial";
                Err(Error::new("job-conflict", message, "name a file as the first output"))
            }
            Some(output) => open_resumable(&with_ending(output, ".partial")),
            None => Ok(SpillFile { target: SpillTarget::None, resumable: None }),
        }
    }
}

fn open_resumable(path: &Path) -> Result<SpillFile> {
    let name = path.display();
    let file = Output::file_of(path, path.to_path_buf())?.open_kept()?;
    if file.try_lock().is_err() {
        let message = format!("{name} is in use by another run");
        return Err(Error::new("io", message, "wait for it, or name another output"));
    }
    check_is_ours(&file).map_err(|error| error.at(name))?;
    let store = Arc::new(FileStore::new(file));
    let target = SpillTarget::Resumable(store.clone());
    Ok(SpillFile { target, resumable: Some((path.to_path_buf(), store)) })
}

/// Refuses a file that does not begin as kept columns do, however short it is; nobody else would have made an empty one.
fn check_is_ours(file: &File) -> Result<()> {
    let failed = |error| Error::io("reading the columns of the interrupted run", error);
    let mut start = Vec::new();
    file.take(8).read_to_end(&mut start).map_err(failed)?;
    if may_continue(&start) {
        return Ok(());
    }
    let n_bytes = file.metadata().map_err(failed)?.len();
    let message = format!(
        "the file exists but is not a hexcast file: it has {n_bytes} bytes and does not begin like a column file"
    );
    Err(Error::new("job-conflict", message, "move the file away, or name another output"))
}

impl SpillFile {
    /// Removes the file when all is written.
    pub(crate) fn remove(self) {
        if let Some((path, _)) = &self.resumable {
            // a file that cannot be removed is refused, or resumed from, next time
            let _ = std::fs::remove_file(path);
        }
    }

    /// After an error, says how to continue if the file holds columns of this job.
    pub(crate) fn keep_after(self, error: &Error) {
        let Some((path, store)) = &self.resumable else { return };
        if matches!(error.code(), "job-conflict" | "columns-other") {
            return;
        }
        let n_bytes = store.n_bytes();
        if n_bytes > 0 {
            let name = path.display();
            let text = "the same command continues from there";
            terminal::complain(&format!("kept: finished columns are in {name} ({n_bytes} bytes); {text}"));
        } else {
            self.remove();
        }
    }
}
