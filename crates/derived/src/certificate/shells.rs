//! Finds shells of one geometry that overlap: where two of them do, the rule `parity` calls the cells outside.
//!
//! # Theory
//! If all facets of a closed surface agree in their orientation, its winding number at a cell counts the shells around it.
//! `parity` calls a cell outside if that number is even. That is right for 0, as in a cavity, whose shell is turned inwards.
//! For 2 it is wrong: both shells are turned the same way, because parts were put into one another without uniting them, or
//! because the shell of a cavity is turned the wrong way. `nonzero` calls such a cell inside.
//!
//! # Practice
//! Some rows of rays are cast on the host, which finds overlaps as large as the distance between the rows. Only where one is
//! found is the orientation of the facets checked: facets that do not agree can give any winding number.
//! Cost: one pass over the boxes of all facets.

use std::collections::BTreeMap;
use std::ops::Range;

use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::rays::Rays;
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::cpu::{Window, over_windows, rays_through};
use hexcast_core::stages::crossings::{Crossings, Passage};

pub mod lone;
pub mod numbers;
pub mod own_cells;

/// Rows of rays that are looked at, at most.
const N_ROWS: u64 = 32;

/// A geometry with cells in two or more of its shells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Overlap {
    /// Its position.
    pub position: u16,
    /// Its cells of winding number 2 or more, either way, among those looked at.
    pub n_cells: u64,
}

/// The rays of a box that are looked at and pass some cells of it: the first cell, and the end, exclusive.
fn looked_at(rays: &Rays, cells: [[u32; 3]; 2]) -> Vec<Window> {
    let [across, down] = rays_through(rays, cells);
    let n_rows = u64::from(rays.counts[1]);
    let n_looked = n_rows.min(N_ROWS);
    let row = |index: u64| ((2 * index + 1) * n_rows / (2 * n_looked)) as u32;
    (0..n_looked).map(row).filter(|row| down.contains(row)).map(|row| [across.clone(), row..row + 1]).collect()
}

/// Number of rays that are looked at.
pub fn n_rays_looked_at(rays: &Rays, cells: [[u32; 3]; 2]) -> u64 {
    looked_at(rays, cells).iter().map(|[across, _]| across.len() as u64).sum()
}

/// Finds them among the geometries of a frame, in the order of positions, in some cells of its box; `agrees` says of one whether its facets do.
pub fn overlapping_shells(cast: &Cast, agrees: &dyn Fn(usize) -> bool, cells: [[u32; 3]; 2]) -> Vec<Overlap> {
    let along = cells[0][cast.rays.axis]..cells[1][cast.rays.axis];
    let windows = looked_at(cast.rays, cells);
    let mut n_cells = BTreeMap::new();
    let with_facets = !cast.frame.ranks.are_positions();
    let in_two = |crossings: &Crossings| cells_in_two(crossings, cast.frame, &along);
    for of_window in over_windows(cast, &windows, with_facets, in_two) {
        for (position, n) in of_window {
            *n_cells.entry(position).or_insert(0) += n;
        }
    }
    let found = n_cells.into_iter().filter(|(position, _)| agrees(usize::from(*position)));
    found.map(|(position, n_cells)| Overlap { position, n_cells }).collect()
}

/// Cells of winding number 2 or more, either way, of each geometry, by position, among some of each ray.
fn cells_in_two(crossings: &Crossings, frame: &Frame, along: &Range<u32>) -> BTreeMap<u16, u64> {
    let mut n_cells = BTreeMap::new();
    crossings.for_each_passage(frame, |_, passages| {
        // winding number of each geometry, and the cell from which it holds
        let mut now: BTreeMap<u16, (i32, u32)> = BTreeMap::new();
        for &Passage { cell, position, step } in passages {
            let (winding, since) = now.entry(position).or_insert((0, cell));
            let n = cell.min(along.end).saturating_sub((*since).max(along.start));
            if winding.abs() > 1 && n > 0 {
                *n_cells.entry(position).or_insert(0) += u64::from(n);
            }
            (*winding, *since) = (*winding + step, cell);
        }
    });
    n_cells
}
