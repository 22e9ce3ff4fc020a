//! Shells of one geometry that overlap, which the rule `parity` leaves outside where two of them are.
//!
//! # Theory
//! Where all facets of a closed surface agree, its winding number counts the shells around a cell. `parity` calls a cell outside if
//! that number is even: right for a cavity, which a shell turned inwards makes, of winding number 0. Of two, both shells are turned
//! alike: parts that were put into one another and not united, or a cavity turned the wrong way. `nonzero` calls it inside.
//!
//! # Practice
//! A look at some rows of rays, cast on the host: it finds what is as large as the distance between them. The facets are compared only
//! where it finds something, as facets that do not agree give any winding number.
//! Cost: one pass over the boxes of all facets.

use std::collections::BTreeMap;

use crate::cast::Cast;
use crate::cpu::{Window, over_windows, window_of_rows};
use crate::crossings::Crossings;

/// Rows of rays that are looked at, at most.
const N_ROWS: u64 = 32;

/// A geometry with cells in two or more of its shells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Overlap {
    /// Its rank.
    pub(crate) rank: u8,
    /// Its cells of winding number 2 or more, either way, among those looked at.
    pub(crate) n_cells: u64,
    /// Rays looked at.
    pub(crate) n_rays: u64,
}

/// Finds them among the geometries of a frame, in the order of their ranks; `agrees` says of one whether its facets do.
pub(crate) fn overlapping_shells(cast: &Cast, agrees: &dyn Fn(usize) -> bool) -> Vec<Overlap> {
    let [n_across, n_rows] = cast.rays.counts;
    let n_looked = u64::from(n_rows).min(N_ROWS);
    let row = |index: u64| ((2 * index + 1) * u64::from(n_rows) / (2 * n_looked)) as u32;
    let windows: Vec<Window> =
        (0..n_looked).map(|index| window_of_rows(cast.rays, row(index)..row(index) + 1)).collect();
    let mut n_cells = BTreeMap::new();
    for of_window in over_windows(cast, &windows, false, |crossings| cells_in_two(crossings, cast.rays.depth)) {
        for (rank, n) in of_window {
            *n_cells.entry(rank).or_insert(0) += n;
        }
    }
    let n_rays = n_looked * u64::from(n_across);
    n_cells
        .into_iter()
        .filter(|(rank, _)| agrees(usize::from(*rank)))
        .map(|(rank, n_cells)| Overlap { rank, n_cells, n_rays })
        .collect()
}

/// Cells of winding number 2 or more, either way, of each rank.
fn cells_in_two(crossings: &Crossings, depth: u32) -> BTreeMap<u8, u64> {
    let mut n_cells = BTreeMap::new();
    crossings.for_each_ray(|_, events| {
        // winding number of each rank, and the cell from which it holds
        let mut now: BTreeMap<u8, (i32, u32)> = BTreeMap::new();
        for event in events {
            let (cell, rank, step) = (event >> 9, (event >> 1) as u8, 1 - 2 * (event & 1) as i32);
            let (winding, since) = now.entry(rank).or_insert((0, cell));
            if winding.abs() > 1 && cell > *since {
                *n_cells.entry(rank).or_insert(0) += u64::from(cell.min(depth) - *since);
            }
            (*winding, *since) = (*winding + step, cell);
        }
    });
    n_cells
}
