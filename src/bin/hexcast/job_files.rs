//! Files that say what to mesh: jobs, and lists of lines.

use std::io::Read;
use std::path::Path;

use hexcast::files::open_file;
use hexcast::job::{Job, LinesJob};
use hexcast::{Error, Result};

/// Reads lists of lines.
pub(crate) fn read_lines(path: &Path) -> Result<LinesJob> {
    let text = read_text(path)?;
    serde_json::from_str(&text).map_err(|error| {
        let message = format!("{}: {error}", path.display());
        Error::new(
            "job-syntax",
            message,
            "write three lists of numbers: {\"x\": [0, 1, 3], \"y\": [...], \"z\": [...]}",
        )
    })
}

/// Most bytes of a job file: 255 geometries take a ten-thousandth of it.
const MAX_JOB_BYTES: u64 = 64 << 20;

/// Reads a job file or lists of lines as text.
fn read_text(path: &Path) -> Result<String> {
    let name = path.display();
    let mut bytes = Vec::new();
    let read = open_file(path)?.take(MAX_JOB_BYTES + 1).read_to_end(&mut bytes);
    read.map_err(|error| Error::io(format!("reading {name}"), error))?;
    if bytes.len() as u64 > MAX_JOB_BYTES {
        let message = format!("{name}: more than {MAX_JOB_BYTES} bytes, which no job file has");
        return Err(Error::new("job-syntax", message, "name a job file, TOML or JSON"));
    }
    String::from_utf8(bytes).map_err(|error| {
        let message = format!("{name}: byte {} is not UTF-8 text", error.utf8_error().valid_up_to());
        Error::new("job-syntax", message, "name a job file, TOML or JSON")
    })
}

/// Reads a job file and makes its file names relative to the current folder.
pub(crate) fn read_job(path: &Path) -> Result<Job> {
    let (name, text) = (path.display(), read_text(path)?);
    let is_json = path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
    let read = if is_json { Job::from_json(&text) } else { Job::from_toml(&text) };
    let mut job = read.map_err(|error| error.at(name))?;
    let folder = path.parent().unwrap_or(Path::new(""));
    for geometry in &mut job.geometries {
        // a join with an absolute path is that path
        geometry.file = folder.join(&geometry.file).to_string_lossy().into_owned();
    }
    Ok(job)
}
