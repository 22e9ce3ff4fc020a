//! Partial cells: which fraction of a cell each flag has, where a surface cuts it.
//!
//! Frame, rays along x, m -> [`Fractions`]. A cell has m x m rays along x, each in the middle of a square of its face. Where a ray changes from
//! flag to flag is known exactly, and is rounded to 2^-24 of a cell. So a flag has the mean of m x m lengths for its fraction.
//!
//! # Theory
//! Under one square, a ray in its middle has the exact volume where the surface is a plane that ends neither at the near nor at the far face of the cell
//! there. A plane ends along two lines, each over at most 2 m - 1 of the m x m squares, and in a square the middle is off by at most
//! half of its volume. So the fraction of a flag in a cell that one plane cuts is off by less than 1 / m, and on average by far less.
//! Fractions of a cell are multiples of 2^-24 / m^2 before they are rounded to f32, and their sum is 1 exactly.
//!
//! A change from flag to flag adds to one cell, and to all cells behind it. These sums are kept sparsely, column after column, so that cells
//! that no surface cuts cost nothing (`fractions/column.rs`).
//!
//! Cost: a cast of m x m times as many rays as the mesh has along x; 16 bytes for each flag of each cell that is cut.

use crate::control::Control;
use crate::error::{Error, Result};
use crate::frame::Frame;
use crate::inside::Kind;
use crate::job::{FractionsJob, Rule};
use crate::lattice::{Lattice, lattice};
use crate::lines::Lines;
use crate::parallel::*;

mod column;
mod fraction;
mod refined;

use column::Columns;
pub use fraction::Fraction;
use refined::Refined;

/// The fractions of flags in all cells that have more than one.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Fractions {
    /// m: a cell has m x m rays.
    pub rays: u32,
    /// Number of cells of the box on x, y, z.
    pub dims: [u32; 3],
    /// The fractions, in the order of cells, then of flags. Those of a cell add up to 1.
    pub fractions: Vec<Fraction>,
    /// Volume of each flag, 0 to 255, in the box: that of whole cells and of fractions.
    pub volumes: Vec<f64>,
}

/// Bytes that the entries of a flag of a cell take while they are collected.
const BYTES: u64 = 2 * size_of::<Fraction>() as u64;

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
    let (mut fractions, mut volumes) = (Vec::new(), vec![0.0; 256]);
    let starts: Vec<u32> = rows.clone().step_by(ROUND).collect();
    for start in starts {
        control.check()?;
        let end = (start + ROUND as u32).min(rows.end);
        let found: Vec<_> = (start..end).into_par_iter().map(|row| columns.of_rows(&lattice, row)).collect();
        let n = fractions.len() + found.iter().map(|(some, _)| some.len()).sum::<usize>();
        if n as u64 * BYTES > max_bytes {
            let message = format!(
                "{n} fractions of cells or more take {} bytes: {max_bytes} are left of the memory allowed",
                n as u64 * BYTES
            );
            let hint = "allow more with max_memory (--max-memory), or use larger cells";
            return Err(Error::new("memory", message, hint));
        }
        for (some, of_rows) in found {
            fractions.extend_from_slice(&some);
            volumes.iter_mut().zip(of_rows).for_each(|(sum, more)| *sum += more);
        }
    }
    Ok(Fractions { rays: job.rays, dims: lines.dims(), fractions, volumes })
}

/// Rays of rows of cells that go together, about.
const ROWS: u32 = 1 << 13;
/// Bin rows of a round, after which cancel is looked at.
const ROUND: usize = 64;
