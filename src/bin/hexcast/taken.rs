//! The places of inputs and of outputs: no output may be another one, or an input.

use std::path::{Path, PathBuf};

use hexcast::{Error, Result};

use super::output_file::PendingFile;

/// Places that are taken, those of inputs first.
pub(crate) struct Taken {
    places: Vec<PathBuf>,
    n_inputs: usize,
}

impl Taken {
    /// By inputs.
    pub(crate) fn by(inputs: &[&Path]) -> Taken {
        let places: Vec<PathBuf> = inputs.iter().filter_map(|input| input.canonicalize().ok()).collect();
        Taken { n_inputs: places.len(), places }
    }

    /// Takes the place that a name leads to.
    pub(crate) fn take(&mut self, path: &Path, place: PathBuf) -> Result<()> {
        let what = match self.places.iter().position(|other| *other == place) {
            Some(index) if index < self.n_inputs => "is an input too",
            Some(_) => "is written twice",
            None => {
                self.places.push(place);
                return Ok(());
            }
        };
        Err(Error::new("job-conflict", format!("{} {what}", path.display()), "give the output another name"))
    }

    /// Opens a file whose place is not taken.
    pub(crate) fn open(&mut self, path: &Path) -> Result<PendingFile> {
        let (place, file) = PendingFile::open(path)?;
        self.take(path, place)?;
        Ok(file)
    }
}
