//! All fractions of a box: rows of cells together, on all cores.

use super::column::Columns;
use super::fraction::{Fraction, Fractions};
use super::refined::Refined;
use crate::control::Control;
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::inside::Kind;
use crate::job::{FractionsJob, Rule};
use crate::lattice::{Lattice, lattice};
use crate::lines::Lines;
use crate::parallel::*;

/// Bytes that the entry of a flag of a cell takes.
const BYTES: u64 = size_of::<Fraction>() as u64;

/// Measures the fractions. `kinds` says of each rank whether it is inverted.
///
/// # Errors
/// `memory` where the fractions would take more than `max_bytes`; `cancelled`.
pub fn fractions(
    (frame, lines): (&Frame, &Lines),
    (rule, kinds): (Rule, &[Kind]),
    job: FractionsJob,
    max_bytes: u64,
    control: &Control,
) -> Result<Fractions> {
    let refined = Refined::new(frame, lines, job.rays);
    let rays = refined.rays();
    // rows of cells that go together: some thousands of rays
    let rows_of_cells = (ROWS / rays.counts[0].max(1)).clamp(1, 16);
    let bin = [rays.counts[0], job.rays * rows_of_cells];
    let rows = 0..Lattice::n_rows(&rays, bin);
    let lattice = lattice(&refined.frame, &rays, bin, rows.clone());
    let columns = Columns { refined: &refined, lines, rule, kinds };
    let (mut parts, mut n, mut volumes) = (Vec::new(), 0, vec![0.0; 256]);
    let starts: Vec<u32> = rows.clone().step_by(ROUND).collect();
    for start in starts {
        control.check()?;
        let end = (start + ROUND as u32).min(rows.end);
        let found: Vec<_> = (start..end).into_par_iter().map(|row| columns.of_rows(&lattice, row)).collect();
        n += found.iter().map(|(some, _)| some.len()).sum::<usize>();
        if n as u64 * BYTES > max_bytes {
            let message = format!(
                "{n} fractions of cells or more take {} bytes: {max_bytes} are left of the memory allowed",
                n as u64 * BYTES
            );
            let hint = "allow more with max_memory (--max-memory), or use larger cells";
            return Err(Error::new("memory", message, hint));
        }
        for (some, of_rows) in found {
            parts.push(some);
            volumes.iter_mut().zip(of_rows).for_each(|(sum, more)| *sum += more);
        }
    }
    Ok(Fractions { rays: job.rays, dims: lines.dims(), parts, volumes })
}

/// Rays of rows of cells that go together, about.
const ROWS: u32 = 1 << 12;
/// Bin rows of a round, after which cancel is looked at.
const ROUND: usize = 64;
