//! Files that say what to mesh: jobs, and lists of lines.

use std::io::Read;
use std::path::Path;
use std::sync::OnceLock;

use hexcast::job::{Job, JobFile, LinesJob};
use hexcast::{Error, Result};

use crate::files::{ledger, standard_streams};

/// Reads lists of lines.
pub(crate) fn read_lines(path: &Path) -> Result<LinesJob> {
    LinesJob::from_json(&read_text(path)?).map_err(|error| error.at(path.display()))
}

/// Most bytes of a job file: 65,535 geometries take a quarter of it.
const MAX_JOB_BYTES: u64 = 64 << 20;

/// Standard input as text: it can be read once, and is asked for the job and for its options.
static STANDARD_INPUT: OnceLock<String> = OnceLock::new();

/// Keys of job files that options of the command line override.
static OVERRIDDEN: OnceLock<Vec<String>> = OnceLock::new();

/// Leaves some keys of job files unread, so that a wrong value there is none where an option overrides it.
pub(crate) fn leave_out(keys: Vec<String>) {
    // said once, before any is read
    let _ = OVERRIDDEN.set(keys);
}

/// Reads a job file or lists of lines as text.
fn read_text(path: &Path) -> Result<String> {
    if !standard_streams::is_standard(path) {
        return read_anew(path);
    }
    if let Some(text) = STANDARD_INPUT.get() {
        return Ok(text.clone());
    }
    let text = read_anew(path)?;
    Ok(STANDARD_INPUT.get_or_init(|| text).clone())
}

fn read_anew(path: &Path) -> Result<String> {
    let name = path.display();
    let mut bytes = Vec::new();
    let read = if standard_streams::is_standard(path) {
        standard_streams::input()?.take(MAX_JOB_BYTES + 1).read_to_end(&mut bytes)
    } else {
        ledger::open(path)?.take(MAX_JOB_BYTES + 1).read_to_end(&mut bytes)
    };
    read.map_err(|error| Error::io(format!("reading {name}"), error))?;
    if bytes.len() as u64 > MAX_JOB_BYTES {
        let message = format!("{name} has more than {MAX_JOB_BYTES} bytes, too many for a job file");
        return Err(Error::new("job-syntax", message, "name a job file, TOML or JSON"));
    }
    String::from_utf8(bytes).map_err(|error| {
        let message = format!("{name}: byte {} is not UTF-8 text", error.utf8_error().valid_up_to());
        Error::new("job-syntax", message, "name a job file, TOML or JSON")
    })
}

/// Whether a job file is JSON by its name.
pub(crate) fn is_json(path: &Path) -> bool {
    path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"))
}

/// Reads a job file; its names stay relative to it, and its values are not checked, those not even read that options override.
pub(crate) fn read_job_file(path: &Path) -> Result<JobFile> {
    let (name, text) = (path.display(), read_text(path)?);
    // a table of TOML begins with a name or a [
    let is_json = is_json(path) || standard_streams::is_standard(path) && text.trim_start().starts_with('{');
    let overridden: Vec<&str> = OVERRIDDEN.get().into_iter().flatten().map(String::as_str).collect();
    let read = if is_json {
        JobFile::from_json_without(&text, &overridden)
    } else {
        JobFile::from_toml_without(&text, &overridden)
    };
    read.map_err(|error| error.at(name))
}

/// Reads the job of a job file and makes its file names relative to the current folder. Its values are not checked, since options may
/// override them.
pub(crate) fn read_job(path: &Path) -> Result<Job> {
    let mut job = read_job_file(path)?.job;
    let folder = path.parent().unwrap_or(Path::new(""));
    for geometry in job.geometries.iter_mut().filter(|geometry| geometry.file != standard_streams::NAME) {
        // a join with an absolute path is that path
        geometry.file = folder.join(&geometry.file).to_string_lossy().into_owned();
    }
    Ok(job)
}
