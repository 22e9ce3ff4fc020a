//! Files of CAD: STEP and IGES become triangles by Open CASCADE, in a process of Python that can be ended at any time.
//!
//! A file, its unit and how far triangles may be from its surfaces -> a [`Source`] with the name, length and hash of the file, and a solid
//! a body. `cad.py` does it; it needs `cadquery-ocp`, which is OCP: Open CASCADE as a Python package of one file a machine, on all systems. Gmsh
//! was tried first: the triangles that it gives for files of other programs do not meet in whole surfaces, whichever release does it.

use std::fs::File;
use std::io::{self, Read, Seek};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::Duration;

use hexcast_core::base::checksum::FileHash;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::length::Length;
use hexcast_core::base::memory::Held;
use hexcast_core::input::job::{DEFAULT_CELLS, Job};
use hexcast_core::input::read::{Conversion, Format, MILLIMETRE, UNITS, cad_format};
use hexcast_core::input::sources::Source;
use serde::Deserialize;

const SCRIPT: &str = include_str!("cad.py");
/// Triangles may be so many cells away from the surface.
const SHARE: f64 = 0.1;
/// Bytes that tell a file of CAD from others.
const HEAD: u64 = 400;
/// How long a wait for the program lasts until it is asked whether to go on.
const WAIT: Duration = Duration::from_millis(20);
const CHUNK_BYTES: u64 = 1 << 20;
/// The program has no Open CASCADE.
const NO_CASCADE: i32 = 3;
/// Open CASCADE cannot read the file.
const NOT_READ: i32 = 4;

/// The Python that the caller has.
static PYTHON: OnceLock<PathBuf> = OnceLock::new();

/// Chooses the Python that converts files of CAD, once for the process, unless the environment variable `HEXCAST_PYTHON` names one; by default
/// it is `python3` or `python`, whichever has Open CASCADE.
pub fn use_python(program: PathBuf) {
    // the first is that of the process
    let _ = PYTHON.set(program);
}

/// How fine the triangles of files of CAD are, and their unit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fineness {
    deviation: Deviation,
    /// The unit of what is read: its name in a 3MF, and its name here.
    unit: (&'static str, &'static str),
}

/// Largest distance of triangles from surfaces.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Deviation {
    Length(f64),
    /// As a share of the longest side of the box around the bodies.
    OfLongest(f64),
}

impl Default for Fineness {
    /// For 128 cells along the longest axis, in mm.
    fn default() -> Fineness {
        Fineness { deviation: Deviation::OfLongest(SHARE / f64::from(DEFAULT_CELLS)), unit: MILLIMETRE }
    }
}

impl Fineness {
    /// Triangles at most so far from the surfaces, in mm, which is the unit of what is read.
    ///
    /// # Errors
    /// `job-value` where that is not above 0, or not finite.
    pub fn within(deviation: f64) -> Result<Fineness> {
        if deviation > 0.0 && deviation.is_finite() {
            return Ok(Fineness { deviation: Deviation::Length(deviation), ..Fineness::default() });
        }
        Err(Error::new("job-value", format!("deviation is {deviation}"), "give a length above 0, in mm"))
    }

    /// That of the cells of a geometry of a job, which are `finer` times finer in places: a tenth of the smallest, if the job does not say.
    #[doc(hidden)]
    pub fn of_job(job: &Job, geometry: usize, finer: f64) -> Fineness {
        let wanted = job.unit.as_deref().and_then(Length::of_name);
        let unit = UNITS.into_iter().find(|(_, unit)| wanted.is_some() && Length::of_name(unit) == wanted);
        let scale = job.geometries.get(geometry).and_then(|entry| entry.scale);
        let scale = scale.map_or(1.0, |scale| scale.each().map(f64::abs).into_iter().fold(0.0, f64::max));
        let deviation = match (job.deviation, smallest_cell(job, geometry)) {
            (Some(length), _) => Deviation::Length(length),
            (None, Cell::Length(length)) => Deviation::Length(SHARE * length / (scale * finer)),
            (None, Cell::OfLongest(share)) => Deviation::OfLongest(SHARE * share / finer),
        };
        Fineness { deviation, unit: unit.unwrap_or(MILLIMETRE) }
    }
}

/// The smallest cell of a job.
enum Cell {
    Length(f64),
    /// As a share of the longest side of the box around all geometries.
    OfLongest(f64),
}

fn smallest_cell(job: &Job, geometry: usize) -> Cell {
    let least = |lengths: &mut dyn Iterator<Item = f64>| Cell::Length(lengths.fold(f64::INFINITY, f64::min));
    // the sizes of graded lines follow from the surfaces: the largest that one may have
    let own = job.geometries.get(geometry).and_then(|entry| entry.max_size);
    let counts = job.dims.unwrap_or([job.cells.unwrap_or(DEFAULT_CELLS); 3]).map(f64::from);
    if let Some(lines) = &job.lines {
        return least(
            &mut [&lines.x, &lines.y, &lines.z].into_iter().flat_map(|list| list.windows(2).map(|of| of[1] - of[0])),
        );
    }
    if let Some(graded) = &job.graded {
        return least(&mut graded.max_size.each().into_iter().chain(own));
    }
    match (job.cell_size, job.max_cell_size, job.domain) {
        (Some(sizes), ..) => least(&mut sizes.each().into_iter()),
        (_, Some(size), _) => Cell::Length(size),
        (.., Some([x0, y0, z0, x1, y1, z1])) => {
            let extent = [x1 - x0, y1 - y0, z1 - z0];
            match job.dims {
                Some(_) => least(&mut (0..3).map(|axis| extent[axis] / counts[axis])),
                None => Cell::Length(extent.into_iter().fold(0.0, f64::max) / counts[0]),
            }
        }
        // of a box whose sides are not known: no side is longer, and no axis has more cells
        _ => Cell::OfLongest(1.0 / counts.into_iter().fold(1.0, f64::max)),
    }
}

/// The first line that the program writes.
#[derive(Deserialize)]
struct Head {
    deviation: f64,
    bodies: u64,
    program: String,
}

/// Which format of CAD a file has, by its first line; it is read from its start again.
///
/// # Errors
/// Those of the system.
#[doc(hidden)]
pub fn format_of_cad(input: &mut File) -> io::Result<Option<Format>> {
    let mut head = Vec::new();
    Read::take(&mut *input, HEAD).read_to_end(&mut head)?;
    input.rewind()?;
    Ok(cad_format(&head))
}

/// Reads a file of CAD of a format; `file` is its path, and `input` is at its start.
///
/// # Errors
/// `cad-program` where no program converts it; `file-syntax` where Open CASCADE cannot read it; `stl-empty` where it has no surface; `memory`;
/// `io`; `cancelled`.
#[doc(hidden)]
pub fn read_cad(
    (file, format): (&str, Format),
    input: &mut dyn Read,
    fineness: &Fineness,
    control: &Control,
) -> Result<Source> {
    let failed = |error| Error::io(format!("reading {file}"), error);
    let (mut hash, mut n_bytes, mut chunk) = (FileHash::default(), 0, Vec::new());
    while Read::take(&mut *input, CHUNK_BYTES).read_to_end(&mut chunk).map_err(failed)? > 0 {
        control.check()?;
        hash.update(&chunk);
        n_bytes += chunk.len() as u64;
        chunk.clear();
    }
    let place = Path::new(file).canonicalize().map_err(failed)?;
    let made = convert(&place, format, fineness, control).map_err(|error| error.at(file))?;
    let split = made.iter().position(|byte| *byte == b'\n').unwrap_or(made.len());
    let (head, mut surface) = (&made[..split], &made[made.len().min(split + 1)..]);
    let head: Head = serde_json::from_slice(head).map_err(|error| {
        Error::new("cad-program", format!("{file}: what the program wrote is not readable: {error}"), HINT)
    })?;
    if head.bodies == 0 {
        let hint = "export the bodies themselves, and not references to files; drawings and wires have no surface";
        return Err(Error::new("stl-empty", format!("{file} has no surface"), hint));
    }
    let mut source = Source::read(file, surface.len() as u64, &mut surface, control)?;
    source.blake3 = Some(hash.finish());
    (source.contents.format, source.contents.n_bytes) = (format, n_bytes);
    source.contents.conversion = Some(Conversion::new(head.deviation, head.program));
    Ok(source)
}

const HINT: &str = "install Open CASCADE for Python: pip install cadquery-ocp-novtk; HEXCAST_PYTHON names the Python that has it. Or drop the file on hexcast's page and save it as 3MF, \
                    call readCad of the npm package, or export STL, 3MF or GLB";

/// Runs the first Python that can convert the file; returns what it wrote.
fn convert(file: &Path, format: Format, fineness: &Fineness, control: &Control) -> Result<Vec<u8>> {
    let chosen = std::env::var_os("HEXCAST_PYTHON").map(PathBuf::from).or_else(|| PYTHON.get().cloned());
    let programs = chosen.map_or_else(|| vec!["python3".into(), "python".into()], |program| vec![program]);
    let mut tried = Vec::new();
    for program in programs {
        let (written, said, code) = match run(&program, file, format, fineness, control) {
            Ok(done) => done,
            Err(Failed::Start(error)) => {
                tried.push(format!("{}: {error}", program.display()));
                continue;
            }
            Err(Failed::Run(error)) => return Err(error),
        };
        match code {
            Some(0) => return Ok(written),
            Some(NO_CASCADE) => tried.push(format!("{}: {}", program.display(), said.trim())),
            Some(NOT_READ) => {
                let hint = "open it in the program of CAD and export it again, as STEP AP214 or AP242, or as STL";
                return Err(Error::new(
                    "file-syntax",
                    format!("Open CASCADE cannot read this {} file", format.name()),
                    hint,
                ));
            }
            _ => {
                let last = said.lines().rfind(|line| !line.trim().is_empty()).unwrap_or("it was ended");
                let message = format!("Open CASCADE failed, in {}: {last}", program.display());
                return Err(Error::new("cad-program", message, "export it in parts, or as STL, 3MF or GLB"));
            }
        }
    }
    let message = format!("this is {}, and nothing here converts it ({})", format.name(), tried.join("; "));
    Err(Error::new("cad-program", message, HINT))
}

enum Failed {
    /// The program does not start.
    Start(io::Error),
    Run(Error),
}

impl From<Error> for Failed {
    fn from(error: Error) -> Failed {
        Failed::Run(error)
    }
}

/// Ends a program where it is dropped.
struct Running(Child);

impl Drop for Running {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

/// Runs a program; returns what it wrote, what it said, and its exit code.
fn run(
    program: &Path,
    file: &Path,
    format: Format,
    Fineness { deviation, unit: (in_3mf, unit) }: &Fineness,
    control: &Control,
) -> std::result::Result<(Vec<u8>, String, Option<i32>), Failed> {
    let kind = if format == Format::Step { "step" } else { "iges" };
    let (length, share) = match deviation {
        Deviation::Length(length) => (*length, 0.0),
        Deviation::OfLongest(share) => (0.0, *share),
    };
    // so many of a unit are a thousand times so many metres: the unit in mm
    let mm = Length::of_name(unit).map_or(1.0, |length| length.metres(1e3));
    let mut command = Command::new(program);
    command.args(["-c", SCRIPT]).arg(file).args([
        kind,
        &mm.to_string(),
        in_3mf,
        &length.to_string(),
        &share.to_string(),
    ]);
    let piped = command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut running = Running(piped.spawn().map_err(Failed::Start)?);
    let (output, words) = (running.0.stdout.take(), running.0.stderr.take());
    let chunks = chunks_of(output);
    let said = std::thread::spawn(move || {
        let mut text = Vec::new();
        // what cannot be read is not said
        let _ = words.map(|mut words| words.read_to_end(&mut text));
        String::from_utf8_lossy(&text).into_owned()
    });
    let mut room = Held::of(&control.memory);
    let mut written = Vec::new();
    loop {
        control.check()?;
        match chunks.recv_timeout(WAIT) {
            Ok(chunk) => {
                let chunk = chunk.map_err(|error| Error::io("reading what the program writes", error))?;
                room.grow(chunk.len() as u64, "the triangles of a file of CAD, as 3MF")?;
                written.extend(chunk);
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
    }
    let status = running.0.wait().map_err(|error| Error::io("waiting for the program", error))?;
    Ok((written, said.join().unwrap_or_default(), status.code()))
}

/// What a program writes, piece by piece, from a thread of its own.
fn chunks_of(output: Option<impl Read + Send + 'static>) -> Receiver<io::Result<Vec<u8>>> {
    let (send, chunks) = sync_channel(2);
    std::thread::spawn(move || {
        let Some(mut output) = output else { return };
        loop {
            let mut chunk = Vec::new();
            let read = Read::take(&mut output, CHUNK_BYTES).read_to_end(&mut chunk);
            let goes_on = matches!(read, Ok(1..));
            let is_sent = matches!(read, Ok(0)) || send.send(read.map(|_| chunk)).is_ok();
            if !goes_on || !is_sent {
                return;
            }
        }
    });
    chunks
}
