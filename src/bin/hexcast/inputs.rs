//! Reading the job's files: in chunks, hashed on the way, several at once.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use hexcast::control::Control;
use hexcast::error::{Error, Result};
use hexcast::job::Job;
use hexcast::read::{Contents, Reader};
use hexcast::sources::Source;
use rayon::prelude::*;
use sha2::{Digest, Sha256};

/// Bytes read at once.
const CHUNK_BYTES: usize = 1 << 20;

/// Reads the files of all geometries of a job, in order.
pub(crate) fn sources(job: &Job, control: &Control) -> Result<Vec<Source>> {
    let read = |file: &String| {
        let (contents, sha256) = read(Path::new(file), control)?;
        Ok(Source { file: file.clone(), contents, sha256 })
    };
    job.geometries.par_iter().map(|geometry| read(&geometry.file)).collect()
}

/// Reads a file; also returns the SHA-256 of its bytes.
pub(crate) fn read(file: &Path, control: &Control) -> Result<(Contents, String)> {
    let failed = |error| Error::io(format!("reading {}", file.display()), error);
    let mut source = File::open(file).map_err(failed)?;
    let n_bytes = source.metadata().map_err(failed)?.len();
    let mut reader = Reader::new(n_bytes);
    let mut hash = Sha256::new();
    let mut chunk = vec![0; CHUNK_BYTES];
    loop {
        control.check()?;
        let n = source.read(&mut chunk).map_err(failed)?;
        if n == 0 {
            break;
        }
        let chunk = &chunk[..n];
        let (pushed, ()) = rayon::join(|| reader.push(chunk), || hash.update(chunk));
        pushed.map_err(|error| error.at(file.display()))?;
    }
    let contents = reader.finish().map_err(|error| error.at(file.display()))?;
    Ok((contents, hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()))
}
