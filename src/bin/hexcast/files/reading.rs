//! Reads input files: in chunks, hashed at the same time, several files in parallel.

use std::io::{Cursor, Read};
use std::path::Path;
use std::sync::Arc;

use hexcast::column_file::{self, is_column_file};
use hexcast::control::{CancelToken, Control};
use hexcast::geometry::Facet;
use hexcast::job::{ByteSize, Job};
use hexcast::memory::{Held, Memory};
use hexcast::mesh::Mesh;
use hexcast::pipeline::prepare;
use hexcast::read::Format;
use hexcast::sources::Source;
use hexcast::{Error, Result};
use indicatif::ProgressBar;
use rayon::prelude::*;

use crate::files::{ledger, standard_streams};
use crate::screen::{memory, progress::Progress};
use hexcast::files::{FileAt, FileStore, Fineness, format_of_cad, read_cad};

const CHUNK_BYTES: usize = 1 << 20;

/// Reads the file of every geometry of a job, in their order.
pub(crate) fn read_job_files(job: &Job, token: &CancelToken, progress: Progress) -> Result<Vec<Source>> {
    read_finer_job_files(job, 1.0, token, progress)
}

/// The same for cells that are so many times smaller in places than those of the job.
pub(crate) fn read_finer_job_files(
    job: &Job,
    finer: f64,
    token: &CancelToken,
    progress: Progress,
) -> Result<Vec<Source>> {
    let entry = |index: usize| (&job.geometries[index].file[..], Fineness::of_job(job, index, finer));
    let files: Vec<(&str, Fineness)> = (0..job.geometries.len()).map(entry).collect();
    read(&files, (job.max_memory, true), token, progress)
}

/// Reads files, in their order; the first that fails decides the error. They take at most `max_memory`.
pub(crate) fn read_files(
    files: &[&str],
    max_memory: Option<ByteSize>,
    token: &CancelToken,
    progress: Progress,
) -> Result<Vec<Source>> {
    let files: Vec<(&str, Fineness)> = files.iter().map(|file| (*file, Fineness::default())).collect();
    read(&files, (max_memory, false), token, progress)
}

/// The same, where facets may stay in their files.
fn read(
    files: &[(&str, Fineness)],
    (max_memory, may_stay): (Option<ByteSize>, bool),
    token: &CancelToken,
    progress: Progress,
) -> Result<Vec<Source>> {
    let max = max_memory.map_or(u64::MAX, |size| size.0);
    let mut control = Control::default();
    control.cancel = token.clone();
    control.memory = Memory::beside_program(max, memory::program_bytes(false));
    let total = files.iter().filter_map(|(file, _)| std::fs::metadata(file).ok()).map(|metadata| metadata.len()).sum();
    let bar = progress.bytes("read", Some(total));
    let sources: Vec<Result<Source>> = files.par_iter().map(|file| read_file(file, may_stay, &control, &bar)).collect();
    bar.finish_and_clear();
    sources.into_iter().collect()
}

/// Solids by their names.
pub(crate) type NamedSolids = Vec<(String, Vec<Facet>)>;

/// The solids of the file of a geometry of a job that is no STL, or a packed one, and its format; None of an STL.
pub(crate) fn solids_beside_stl(
    job: &Job,
    geometry: usize,
    token: &CancelToken,
) -> Result<Option<(&'static str, NamedSolids)>> {
    let file = &job.geometries[geometry].file[..];
    let fineness = Fineness::of_job(job, geometry, 1.0);
    let sources = read(&[(file, fineness)], (job.max_memory, false), token, Progress::new(true))?;
    let Some(contents) = sources.into_iter().next().map(|source| source.contents) else { return Ok(None) };
    let mut start = [0; 2];
    let read = ledger::open(Path::new(file))?.read_exact(&mut start);
    let is_packed = read.is_ok() && start == [0x1f, 0x8b];
    let format = match contents.format {
        Format::StlAscii | Format::StlBinary if !is_packed => return Ok(None),
        _ if is_packed => Format::Gzip,
        format => format,
    };
    let solids = contents.solids.into_iter().map(|solid| Ok((solid.name, solid.facets.in_memory("this")?.to_vec())));
    Ok(Some((format.name(), solids.collect::<Result<_>>()?)))
}

/// The lines of the whole box of a job.
pub(crate) fn lines_of_box(job: &Job, token: &CancelToken) -> Result<[Vec<f64>; 3]> {
    let whole = prepare(job, read_job_files(job, token, Progress::new(true))?)?.whole;
    Ok([0, 1, 2].map(|axis| whole.list(axis)))
}

fn read_file(
    (file, fineness): &(&str, Fineness),
    may_stay: bool,
    control: &Control,
    bar: &ProgressBar,
) -> Result<Source> {
    // held until its facets are read
    let mut room = Held::of(&control.memory);
    let Input { input, n_bytes, again, cad } = open(file, &mut room, control)?;
    let mut input = bar.wrap_read(input);
    if let Some(format) = cad {
        return read_cad((file, format), &mut input, fineness, control);
    }
    match again.filter(|_| may_stay) {
        Some(again) => Source::read_again(*file, n_bytes, (&mut input, Arc::new(again)), control),
        None => Source::read(*file, n_bytes, &mut input, control),
    }
}

/// Makes room for twice the bytes of an input that has no length; while they are moved, both are there.
fn make_room(bytes: &mut Vec<u8>, room: &mut Held) -> Result<()> {
    let (old, more) = (bytes.capacity(), bytes.len().max(CHUNK_BYTES));
    let n_new = (bytes.len() + more) as u64;
    let what = format!(
        "{} bytes of it have come; it is not a file on disk and is held in memory: its next bytes",
        bytes.len()
    );
    room.grow(n_new, &what)?;
    bytes
        .try_reserve_exact(more)
        .map_err(|error| Error::new("memory", format!("{what}: {error}"), "save it to a file and name that"))?;
    room.shrink(old as u64);
    Ok(())
}

/// What is read as a file.
struct Input {
    input: Box<dyn Read + Send>,
    n_bytes: u64,
    /// The same once more, of a file on disk.
    again: Option<FileAt>,
    /// Its format, of a file of CAD on disk.
    cad: Option<Format>,
}

/// Opens a file; what has no length, such as a pipe, is read to memory first.
fn open(file: &str, room: &mut Held, control: &Control) -> Result<Input> {
    let failed = |error| Error::io(format!("reading {file}"), error);
    let mut input: Box<dyn Read + Send> = if standard_streams::is_standard(Path::new(file)) {
        Box::new(standard_streams::input()?)
    } else {
        let mut input = ledger::open(Path::new(file))?;
        let metadata = input.metadata().map_err(failed)?;
        if metadata.is_file() {
            let cad = format_of_cad(&mut input).map_err(failed)?;
            let again = Some(FileAt::new(input.try_clone().map_err(failed)?));
            return Ok(Input { input: Box::new(input), n_bytes: metadata.len(), again, cad });
        }
        Box::new(input)
    };
    let (mut bytes, mut chunk) = (Vec::new(), Vec::new());
    while Read::take(&mut input, CHUNK_BYTES as u64).read_to_end(&mut chunk).map_err(failed)? > 0 {
        control.check()?;
        if bytes.len() + chunk.len() > bytes.capacity() {
            make_room(&mut bytes, room).map_err(|error| error.at(file))?;
        }
        bytes.append(&mut chunk);
    }
    let n_bytes = bytes.len() as u64;
    Ok(Input { input: Box::new(Cursor::new(bytes)), n_bytes, again: None, cad: None })
}

/// Whether this is a column file, or standard input has one; false for what is not a file or cannot be read.
pub(crate) fn is_columns(path: &Path) -> bool {
    if standard_streams::is_standard(path) {
        return standard_streams::first_bytes().is_ok_and(|start| is_column_file(&start));
    }
    let mut start = [0; 8];
    let is_read = ledger::open(path).is_ok_and(|mut file| {
        let is_file = file.metadata().is_ok_and(|metadata| metadata.is_file());
        is_file && file.read_exact(&mut start).is_ok()
    });
    is_read && is_column_file(&start)
}

/// Refuses an input that is not there, or that is a file and no column file; nothing is known yet of standard input.
///
/// # Errors
/// `io`; `columns-corrupt`.
pub(crate) fn check_columns(path: &Path) -> Result<()> {
    if standard_streams::is_standard(path) {
        return ledger::reads(path);
    }
    ledger::open(path)?;
    if path.is_file() && !is_columns(path) {
        let message = format!("{} is not a column file", path.display());
        let hint = "mesh it first: hexcast mesh PART.stl -o MESH.hxc, and name MESH.hxc here";
        return Err(Error::new("columns-corrupt", message, hint));
    }
    Ok(())
}

/// Opens a column file without reading it; what has no length, such as a pipe, is read to memory. Both take at most
/// `max_bytes`.
pub(crate) fn open_columns(path: &Path, max_bytes: u64) -> Result<Mesh> {
    let name = path.display();
    if standard_streams::is_standard(path) {
        return column_file::read(&mut standard_streams::input()?, max_bytes)
            .map_err(|error| error.at("standard input"));
    }
    let mut file = ledger::open(path)?;
    let metadata = file.metadata().map_err(|error| Error::io(format!("reading {name}"), error))?;
    let opened = if metadata.is_file() {
        column_file::open(Arc::new(FileStore::new(file)), metadata.len(), max_bytes)
    } else {
        column_file::read(&mut file, max_bytes)
    };
    opened.map_err(|error| error.at(name))
}
