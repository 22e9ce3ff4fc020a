//! Flags: the property flag of every cell of a box, expanded from columns where they are consumed.
//!
//! Columns, a box of cells -> `flags[x + nx * (y + ny * z)]`, u8, x fastest, counted from the box's first cell (Eq. 20).
//! Along x a run is contiguous in memory: filled. Along y and z the runs are first sorted by the row or plane in which they
//! begin; then each row or plane is a copy of the one before with a few flags changed. Both run at the speed of memory.
//! Where one flag is in use, [`expand_bits`] takes a bit a cell: an eighth of the memory and time.
//! Cost: O(cells of the box) time; 8 bytes a run of the box besides the output.

use std::ops::Range;

use crate::base::error::Result;
use crate::base::parallel::*;
use crate::cells::columns::{Columns, run_cell, run_flag, spans};

mod packing;

pub use packing::row_bytes;
use packing::{Bits, Bytes, Packing};

/// Bytes that one core takes at a time.
const ROWS_BYTES: usize = 1 << 16;

/// Cells from `start` to `end` (exclusive) on x, y and z.
pub type CellBox = [Range<u32>; 3];

/// Number of cells of a box.
pub fn n_cells(cells: &CellBox) -> usize {
    cells.iter().map(|range| range.len()).product()
}

/// Splits a box, in the order of its cells, in slabs of whole z planes of at most `max_cells`, or of whole rows along x where one
/// plane is already larger; at least one row each.
pub fn slabs_of_box(cells: &CellBox, max_cells: usize) -> impl Iterator<Item = CellBox> + use<> {
    let [x, y, z] = cells.clone();
    let (row, max) = (x.len().max(1), max_cells);
    let rows = (max / row).clamp(1, y.len().max(1));
    // a slab is either all rows of some planes or some rows of one plane
    let planes = if rows >= y.len() { (max / (row * rows)).clamp(1, z.len().max(1)) } else { 1 };
    let parts = |range: Range<u32>, step: usize| {
        let end = range.end;
        range.step_by(step).map(move |start| start..start.saturating_add(step as u32).min(end))
    };
    parts(z, planes).flat_map(move |z| {
        let x = x.clone();
        parts(y.clone(), rows).map(move |y| [x.clone(), y, z.clone()])
    })
}

/// Expands the flags of a box into `out`, a byte a cell, x fastest.
///
/// # Errors
/// `io` where the columns are in a store that fails.
///
/// # Panics
/// If `out` does not have the box's number of cells or the box reaches past the columns: a bug of the caller.
pub fn expand(columns: &Columns, cells: &CellBox, out: &mut [u8]) -> Result<()> {
    expand_as::<Bytes<false>>(columns, cells, out)
}

/// Expands the flags of a box into memory that is all 0, as [`expand`] does into any: what is background needs no writing.
///
/// Where `out` is not 0 and the flag is, what comes out may be either.
///
/// # Errors
/// Those of [`expand`].
///
/// # Panics
/// As [`expand`].
pub fn expand_into_zeros(columns: &Columns, cells: &CellBox, out: &mut [u8]) -> Result<()> {
    expand_as::<Bytes<true>>(columns, cells, out)
}

/// Expands the flags of a box into `out`, a bit a cell, 1 where the flag is not 0; each row along x takes [`row_bytes`]
/// bytes, its first cell in the lowest bit of the first. What `out` held is overwritten.
///
/// # Errors
/// `io` where the columns are in a store that fails.
///
/// # Panics
/// If `out` does not have [`row_bytes`] for each row of the box or the box reaches past the columns: a bug of the caller.
pub fn expand_bits(columns: &Columns, cells: &CellBox, out: &mut [u8]) -> Result<()> {
    expand_as::<Bits>(columns, cells, out)
}

/// Expands the flags of a box to a vector, a byte a cell, x fastest.
///
/// # Errors
/// Those of [`expand`].
pub fn flags_of_box(columns: &Columns, cells: &CellBox) -> Result<Vec<u8>> {
    let mut out = vec![0; n_cells(cells)];
    expand_into_zeros(columns, cells, &mut out)?;
    Ok(out)
}

/// Expands the flags of a box to a vector, a bit a cell as [`expand_bits`] has them.
///
/// # Errors
/// Those of [`expand_bits`].
pub fn bits_of_box(columns: &Columns, cells: &CellBox) -> Result<Vec<u8>> {
    let mut out = vec![0; n_bytes_of_bits(cells)];
    expand_bits(columns, cells, &mut out)?;
    Ok(out)
}

/// Number of bytes of a box, a bit a cell.
pub fn n_bytes_of_bits(cells: &CellBox) -> usize {
    row_bytes(cells[0].len() as u32) as usize * cells[1].len() * cells[2].len()
}

fn expand_as<P: Packing>(columns: &Columns, cells: &CellBox, out: &mut [u8]) -> Result<()> {
    let [nx, ny, nz] = [0, 1, 2].map(|axis| cells[axis].len());
    let row = P::n_bytes(P::row(nx));
    assert_eq!(out.len(), row * ny * nz, "one slot a cell");
    assert!((0..3).all(|axis| cells[axis].end <= columns.dims()[axis]), "box {cells:?} reaches past the columns");
    if out.is_empty() {
        return Ok(());
    }
    match columns.rays.axis {
        0 => {
            // some rows a task, so that their rays are found together
            let rows = ROWS_BYTES.div_ceil(row).min(ny);
            out.par_chunks_mut(row * ny).zip(cells[2].clone().into_par_iter()).try_for_each(|(plane, z)| {
                plane.par_chunks_mut(row * rows).enumerate().try_for_each(|(task, out)| {
                    fill_rows::<P>(columns, [cells[1].start + (task * rows) as u32, z], &cells[0], out)
                })
            })
        }
        1 => out.par_chunks_mut(row * ny).zip(cells[2].clone().into_par_iter()).try_for_each(|(plane, z)| {
            fill_cross_sections::<P>(columns, [cells[0].clone(), z..z + 1], &cells[1], plane)
        }),
        _ => {
            // one thick slab a core: each slab reads every ray
            let planes = nz.div_ceil(current_num_threads());
            out.par_chunks_mut(row * ny * planes).enumerate().try_for_each(|(slab, out)| {
                let start = cells[2].start + (slab * planes) as u32;
                let along = start..(start + planes as u32).min(cells[2].end);
                fill_cross_sections::<P>(columns, [cells[0].clone(), cells[1].clone()], &along, out)
            })
        }
    }
}

/// Fills rows with cells of consecutive rays, from ray (i, j) on.
fn fill_rows<P: Packing>(columns: &Columns, [i, j]: [u32; 2], along: &Range<u32>, out: &mut [u8]) -> Result<()> {
    let first = u64::from(i) + u64::from(columns.rays.counts[0]) * u64::from(j);
    let mut rows = out.chunks_exact_mut(P::n_bytes(P::row(along.len())));
    columns.for_rays(first..first + rows.len() as u64, |runs| {
        if let Some(row) = rows.next() {
            fill_row::<P>(runs, along, row);
        }
    })
}

/// Fills a row with cells of one ray.
fn fill_row<P: Packing>(runs: &[u32], along: &Range<u32>, out: &mut [u8]) {
    P::begin(out);
    spans(runs, along, |from, to, flag| {
        P::fill(out, (from - along.start) as usize, (to - along.start) as usize, flag);
    });
}

/// Fills cross-sections of a box, one for each cell along the rays, each a changed copy of the one before.
fn fill_cross_sections<P: Packing>(
    columns: &Columns,
    across: [Range<u32>; 2],
    along: &Range<u32>,
    out: &mut [u8],
) -> Result<()> {
    let row_slots = P::row(across[0].len());
    let n_bytes = P::n_bytes(row_slots * across[1].len());
    let mut changes: Vec<(u32, u32)> = Vec::new();
    let mut ends = vec![0u32; along.len() + 1];
    P::begin(&mut out[..n_bytes]);
    for (index, j) in across[1].clone().enumerate() {
        let mut slot = index * row_slots;
        let row = u64::from(across[0].start) + u64::from(columns.rays.counts[0]) * u64::from(j);
        columns.for_rays(row..row + across[0].len() as u64, |runs| {
            let first = runs.partition_point(|&run| run_cell(run) <= along.start);
            P::put(out, slot, if first == 0 { 0 } else { run_flag(runs[first - 1]) });
            for &run in runs[first..].iter().take_while(|&&run| run_cell(run) < along.end) {
                changes.push((slot as u32, run));
                ends[(run_cell(run) - along.start) as usize] += 1;
            }
            slot += 1;
        })?;
    }
    let changes = sorted_by_cell(&changes, &mut ends, along.start);
    for index in 1..along.len() {
        let (before, now) = out.split_at_mut(index * n_bytes);
        now[..n_bytes].copy_from_slice(&before[(index - 1) * n_bytes..]);
        for &(slot, flag) in &changes[ends[index - 1] as usize..ends[index] as usize] {
            P::put(now, slot as usize, flag);
        }
    }
    Ok(())
}

/// Sorts changes by the cell in which they begin; `ends` holds counts a cell and receives the end of each.
fn sorted_by_cell(changes: &[(u32, u32)], ends: &mut [u32], first_cell: u32) -> Vec<(u32, u8)> {
    let mut next = 0;
    for end in ends.iter_mut() {
        next += std::mem::replace(end, next);
    }
    let mut sorted = vec![(0, 0); changes.len()];
    for &(slot, run) in changes {
        let next = &mut ends[(run_cell(run) - first_cell) as usize];
        sorted[*next as usize] = (slot, run_flag(run));
        *next += 1;
    }
    sorted
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::cells::columns::{Band, run};
    use crate::grid::rays::Rays;

    /// Columns with arbitrary runs of up to three flags.
    fn columns(axis: usize, dims: [u32; 3]) -> Columns {
        let rays = Rays::new(axis, dims);
        let mut band = Band::default();
        for ray in 0..rays.n_rays() as u32 {
            let mut cell = ray * 7 % 5;
            let mut flag = 0;
            while cell < rays.depth {
                flag = (flag + 1) % 3;
                band.runs.push(run(cell, flag));
                cell += 1 + (ray * 13 + cell * 5) % 4;
            }
            band.ends.push(band.runs.len() as u32);
        }
        Columns::new(rays, vec![band]).unwrap()
    }

    /// The bits of up to eight flags, the first the lowest.
    fn byte_of(flags: &[u8]) -> u8 {
        flags.iter().enumerate().map(|(bit, &flag)| u8::from(flag != 0) << bit).sum()
    }

    #[test]
    fn any_box_along_any_axis_equals_cell_by_cell_lookup() {
        let dims = [37, 7, 11];
        let boxes = [
            [0..37, 0..7, 0..11],
            [2..3, 0..7, 0..11],
            [0..9, 3..5, 4..11],
            [8..9, 6..7, 10..11],
            [1..8, 2..2, 0..3],
            [5..37, 1..6, 2..9],
            [0..16, 0..7, 3..4],
        ];
        for axis in 0..3 {
            let columns = columns(axis, dims);
            for cells in &boxes {
                let mut expected = Vec::new();
                for z in cells[2].clone() {
                    for y in cells[1].clone() {
                        expected.extend(cells[0].clone().map(|x| columns.flag([x, y, z]).unwrap()));
                    }
                }
                assert_eq!(flags_of_box(&columns, cells).unwrap(), expected, "axis {axis}, box {cells:?}");
                let mut flags = vec![0xa5; expected.len()];
                expand(&columns, cells, &mut flags).unwrap();
                assert_eq!(flags, expected, "axis {axis}, box {cells:?}");
                let rows = expected.chunks(cells[0].len());
                let packed: Vec<u8> = rows.flat_map(|row| row.chunks(8).map(byte_of)).collect();
                // what was there before does not matter
                let mut bits = vec![0xa5; n_bytes_of_bits(cells)];
                expand_bits(&columns, cells, &mut bits).unwrap();
                assert_eq!(bits, packed, "axis {axis}, box {cells:?}");
            }
        }
    }
}
