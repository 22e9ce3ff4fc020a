//! Reads input files: in chunks, hashed at the same time, several files in parallel.

use std::fs::File;
use std::io::{Cursor, Read};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use hexcast::column_file::{self, is_column_file};
use hexcast::control::{CancelToken, Control};
use hexcast::files::open_file;
use hexcast::geometry::Facet;
use hexcast::job::{ByteSize, Job};
use hexcast::mesh::Mesh;
use hexcast::pipeline::prepare;
use hexcast::read::Format;
use hexcast::sources::Source;
use hexcast::{Error, Result};
use indicatif::ProgressBar;
use rayon::prelude::*;

use super::file_store::FileStore;
use super::progress::Progress;
use super::standard;

const CHUNK_BYTES: usize = 1 << 20;

/// Reads the file of every geometry of a job, in their order.
pub(crate) fn read_job_files(job: &Job, token: &CancelToken, progress: Progress) -> Result<Vec<Source>> {
    let files: Vec<&str> = job.geometries.iter().map(|geometry| geometry.file.as_str()).collect();
    read_files(&files, job.max_memory, token, progress)
}

/// Reads files, in their order; the first that fails decides the error. Those that are not on disk take at most `max_memory`.
pub(crate) fn read_files(
    files: &[&str],
    max_memory: Option<ByteSize>,
    token: &CancelToken,
    progress: Progress,
) -> Result<Vec<Source>> {
    let room = Room { max: max_memory, held: AtomicU64::new(0) };
    let total = files.iter().filter_map(|file| std::fs::metadata(file).ok()).map(|metadata| metadata.len()).sum();
    let bar = progress.bytes("read", Some(total));
    let sources: Vec<Result<Source>> = files.par_iter().map(|file| read_file(file, &room, token, &bar)).collect();
    bar.finish_and_clear();
    sources.into_iter().collect()
}

/// Solids by their names.
pub(crate) type NamedSolids = Vec<(String, Vec<Facet>)>;

/// The solids of a file that is no STL, or a packed one, and its format; None of an STL.
pub(crate) fn solids_beside_stl(
    file: &str,
    max_memory: Option<ByteSize>,
    token: &CancelToken,
) -> Result<Option<(&'static str, NamedSolids)>> {
    let sources = read_files(&[file], max_memory, token, Progress::new(true))?;
    let Some(contents) = sources.into_iter().next().map(|source| source.contents) else { return Ok(None) };
    let mut start = [0; 2];
    let read = open_file(Path::new(file))?.read_exact(&mut start);
    let is_packed = read.is_ok() && start == [0x1f, 0x8b];
    let format = match contents.format {
        Format::StlAscii | Format::StlBinary if !is_packed => return Ok(None),
        _ if is_packed => Format::Gzip,
        format => format,
    };
    let solids = contents.solids.into_iter().map(|solid| (solid.name, solid.facets.to_vec()));
    Ok(Some((format.name(), solids.collect())))
}

/// The lines of the whole box of a job.
pub(crate) fn lines_of_box(job: &Job, token: &CancelToken) -> Result<[Vec<f64>; 3]> {
    let whole = prepare(job, read_job_files(job, token, Progress::new(true))?)?.whole;
    Ok([0, 1, 2].map(|axis| whole.list(axis)))
}

fn read_file(file: &str, room: &Room, token: &CancelToken, bar: &ProgressBar) -> Result<Source> {
    let (input, n_bytes) = open(file, room, token)?;
    let mut control = Control::default();
    control.cancel = token.clone();
    Source::read(file, n_bytes, &mut bar.wrap_read(input), &control)
}

/// The memory for inputs that are not files on disk.
struct Room {
    max: Option<ByteSize>,
    /// Bytes held, of all inputs together.
    held: AtomicU64,
}

impl Room {
    /// Makes room for more bytes of an input of which so many have come; the facets in them take almost as much again.
    fn take(&self, more: u64, n_come: u64) -> Result<()> {
        let held = self.held.fetch_add(2 * more, Ordering::Relaxed) + 2 * more;
        let Some(max) = self.max.filter(|max| held > max.0) else { return Ok(()) };
        let message = format!(
            "it is not a file on disk, so it is held in memory, with its facets: after {n_come} bytes nothing is left of the {max} \
             that are allowed"
        );
        Err(Error::new("memory", message, "allow more with --max-memory, or save it to a file and name that"))
    }
}

/// Opens a file and returns its length; what has no length, such as a pipe, is read to memory first.
fn open(file: &str, room: &Room, token: &CancelToken) -> Result<(Box<dyn Read + Send>, u64)> {
    let failed = |error| Error::io(format!("reading {file}"), error);
    let mut input: Box<dyn Read + Send> = if standard::is_standard(Path::new(file)) {
        Box::new(standard::input()?)
    } else {
        let input = open_file(Path::new(file))?;
        let metadata = input.metadata().map_err(failed)?;
        if metadata.is_file() {
            return Ok((Box::new(input), metadata.len()));
        }
        Box::new(input)
    };
    let mut bytes = Vec::new();
    while Read::take(&mut input, CHUNK_BYTES as u64).read_to_end(&mut bytes).map_err(failed)? > 0 {
        if token.is_cancelled() {
            return Err(Error::Cancelled);
        }
        room.take(CHUNK_BYTES as u64, bytes.len() as u64).map_err(|error| error.at(file))?;
    }
    let n_bytes = bytes.len() as u64;
    Ok((Box::new(Cursor::new(bytes)), n_bytes))
}

/// Whether this is a column file, or standard input has one; false for what is not a file or cannot be read.
pub(crate) fn is_columns(path: &Path) -> bool {
    if standard::is_standard(path) {
        return standard::first_bytes().is_ok_and(|start| is_column_file(&start));
    }
    let mut start = [0; 8];
    let is_read = File::open(path).and_then(|mut file| {
        let is_file = file.metadata()?.is_file();
        if is_file { file.read_exact(&mut start) } else { Ok(()) }
    });
    is_read.is_ok() && is_column_file(&start)
}

/// Refuses an input that is not there, or that is a file and no column file; nothing is known yet of standard input.
///
/// # Errors
/// `io`; `columns-corrupt`.
pub(crate) fn check_columns(path: &Path) -> Result<()> {
    if standard::is_standard(path) {
        return Ok(());
    }
    open_file(path)?;
    if path.is_file() && !is_columns(path) {
        let message = format!("{} is not a column file", path.display());
        let hint = "mesh it first: hexcast mesh PART.stl -o MESH.hxc, and name MESH.hxc here";
        return Err(Error::new("columns-corrupt", message, hint));
    }
    Ok(())
}

/// Opens a column file without reading it; what has no length, such as a pipe, is read to memory. Both take at most
/// `max_bytes`.
pub(crate) fn open_columns(path: &Path, max_bytes: u64, control: &Control) -> Result<Mesh> {
    let name = path.display();
    if standard::is_standard(path) {
        return column_file::read(&mut standard::input()?, max_bytes, control)
            .map_err(|error| error.at("standard input"));
    }
    let mut file = open_file(path)?;
    let metadata = file.metadata().map_err(|error| Error::io(format!("reading {name}"), error))?;
    let opened = if metadata.is_file() {
        column_file::open(Arc::new(FileStore::new(file)), metadata.len(), max_bytes, control)
    } else {
        column_file::read(&mut file, max_bytes, control)
    };
    opened.map_err(|error| error.at(name))
}
