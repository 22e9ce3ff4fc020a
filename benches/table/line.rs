//! The whole line, timed: from a file to columns, and on to flags in memory.
//!
//! Flags go to pages that the system was asked to make large, as a program that wants a gigabyte at once would ask; the
//! time of a plain vector stands beside it. What differs is the system's work on pages at first touch, not ours: flags
//! expanded again into the same pages show the difference.

use std::error::Error;
use std::fs::File;
use std::io::Read;
use std::time::Instant;

use hexcast::columns::Columns;
use hexcast::control::Control;
use hexcast::job::{GeometryJob, Job, Rule};
use hexcast::pipeline::{Engine, Prepared, prepare};
use hexcast::read::Reader;
use hexcast::sources::Source;
use hexcast_core::cells::flags::{expand, expand_bits, expand_into_zeros, flags_of_box, n_bytes_of_bits, n_cells};
use hexcast_core::grid::frame::Frame;
use hexcast_core::stages::cast::Cast;
use memmap2::{MmapMut, MmapOptions};
use rayon::prelude::*;
use serde::Serialize;

use crate::cases::Case;

/// Seconds of each part of a run.
#[derive(Debug, Clone, Copy, Serialize)]
pub(crate) struct Seconds {
    /// From the file to facets in memory.
    pub(crate) read: f64,
    /// Domain, lines and rays.
    pub(crate) lines: f64,
    /// Facets to integers.
    pub(crate) snap: f64,
    /// Lattice, intersection and mapping.
    pub(crate) columns: f64,
    /// Flags in large pages, the making of these pages included.
    pub(crate) flags: f64,
    /// Flags again in the same large pages.
    pub(crate) flags_again: f64,
    /// Flags in a plain vector, its making included.
    pub(crate) flags_in_vec: f64,
    /// Flags, a bit a cell, in large pages, the making of these pages included.
    pub(crate) bits: f64,
    /// As many bytes written once to new large pages, on all cores: what no program can do without.
    pub(crate) bytes_once: f64,
}

impl Seconds {
    /// From the file to columns.
    pub(crate) fn until_columns(&self) -> f64 {
        self.read + self.lines + self.snap + self.columns
    }

    /// From the file to flags in memory.
    pub(crate) fn until_flags(&self) -> f64 {
        self.until_columns() + self.flags
    }
}

/// One run and its result.
pub(crate) struct Run {
    pub(crate) seconds: Seconds,
    pub(crate) n_facets: usize,
    pub(crate) columns: Columns,
}

/// A model ready for the rays.
pub(crate) struct Ready {
    pub(crate) prepared: Prepared,
    pub(crate) frame: Frame,
}

/// Reads a model and makes everything before the rays; also returns the seconds to read, to make lines, and to snap.
pub(crate) fn ready(case: &Case) -> Result<(Ready, [f64; 3]), Box<dyn Error>> {
    let Case { file, cells, axis, .. } = case;
    let name = file.to_string_lossy().into_owned();
    let mut job = Job::new(vec![GeometryJob::new(&name)]);
    (job.cells, job.axis) = (Some(*cells), *axis);
    let mut clock = Instant::now();
    let mut source = File::open(file)?;
    let n_bytes = source.metadata()?.len();
    let (mut reader, mut chunk) = (Reader::new(n_bytes), vec![0; 1 << 20]);
    loop {
        match source.read(&mut chunk)? {
            0 => break,
            n => reader.push(&chunk[..n])?,
        }
    }
    let contents = reader.finish()?;
    let read = lap(&mut clock);
    let prepared = prepare(&job, vec![Source::new(name, contents, None)])?;
    let lines = lap(&mut clock);
    let frame = Frame::new(&prepared.geometries, &prepared.lines)?;
    Ok((Ready { prepared, frame }, [read, lines, lap(&mut clock)]))
}

/// Runs the whole line once.
pub(crate) fn run(case: &Case, engine: &mut Engine) -> Result<Run, Box<dyn Error>> {
    let (Ready { prepared, frame }, [read, lines, snap]) = ready(case)?;
    let mut clock = Instant::now();
    let control = Control::default();
    let cast = Cast { frame: &frame, rays: &prepared.rays, rule: Rule::Parity };
    let (columns, _) = pollster::block_on(engine.columns(&cast, &control))?;
    let seconds_of_columns = lap(&mut clock);
    let mut pages = flags(&columns)?;
    let seconds_of_flags = lap(&mut clock);
    expand(&columns, &columns.dims().map(|n| 0..n), &mut pages).expect("columns in memory");
    let flags_again = lap(&mut clock);
    drop(pages);
    let flags_in_vec = seconds_in_vec(&columns);
    let mut clock = Instant::now();
    let everything = columns.dims().map(|n| 0..n);
    let mut pages = new_pages(n_bytes_of_bits(&everything))?;
    expand_bits(&columns, &everything, &mut pages)?;
    let bits = lap(&mut clock);
    drop(pages);
    let mut clock = Instant::now();
    let mut pages = new_pages(n_cells(&everything))?;
    pages.par_chunks_mut(1 << 21).for_each(|page| page.fill(1));
    std::hint::black_box(&pages);
    let seconds = Seconds {
        read,
        lines,
        snap,
        columns: seconds_of_columns,
        flags: seconds_of_flags,
        flags_again,
        flags_in_vec,
        bits,
        bytes_once: lap(&mut clock),
    };
    Ok(Run { seconds, n_facets: frame.facets.len(), columns })
}

/// Flags of all cells in large pages, x fastest.
pub(crate) fn flags(columns: &Columns) -> Result<MmapMut, Box<dyn Error>> {
    let everything = columns.dims().map(|n| 0..n);
    let mut flags = new_pages(n_cells(&everything))?;
    expand_into_zeros(columns, &everything, &mut flags)?;
    Ok(flags)
}

/// Pages that nobody has touched, large ones if the system has any.
fn new_pages(n_bytes: usize) -> Result<MmapMut, Box<dyn Error>> {
    let pages = MmapOptions::new().len(n_bytes).map_anon()?;
    #[cfg(target_os = "linux")]
    pages.advise(memmap2::Advice::HugePage)?;
    Ok(pages)
}

fn seconds_in_vec(columns: &Columns) -> f64 {
    let start = Instant::now();
    let flags = flags_of_box(columns, &columns.dims().map(|n| 0..n)).expect("columns in memory");
    let seconds = start.elapsed().as_secs_f64();
    // the optimiser must not see that nobody reads them
    std::hint::black_box(&flags);
    seconds
}

/// Seconds since the last lap.
pub(crate) fn lap(clock: &mut Instant) -> f64 {
    let now = Instant::now();
    now.duration_since(std::mem::replace(clock, now)).as_secs_f64()
}

/// The middle one of some numbers, the upper of two; 0 of none.
pub(crate) fn median(numbers: impl Iterator<Item = f64>) -> f64 {
    let mut sorted: Vec<f64> = numbers.collect();
    sorted.sort_by(f64::total_cmp);
    sorted.get(sorted.len() / 2).copied().unwrap_or(0.0)
}
