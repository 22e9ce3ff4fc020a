//! What a fluid has of the cells of its outline, of their faces and edges.
//!
//! [`Outline`], cut cells -> [`OutlinePart`]s, one for each cell of the outline. Cost: that of the cut cells with all that is measured but surfaces; 280 bytes a cell, twice that while they are made.

use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::grid::window::CellWindow;

use super::cut_cell::{CutPart, CutWanted};
use super::measure::{CutBy, Measured, in_parts};
use crate::mesh::outline::{Outline, OutlinePart};

/// What the fluid has of nothing.
const NOTHING: OutlinePart =
    OutlinePart { fraction: 0.0, centre: [0.5; 3], areas: [0.0; 6], face_centres: [[0.5; 2]; 6], lengths: [0.0; 12] };

/// Measures what the fluid of an outline, which was found by the same surfaces, has of each of its cells.
///
/// # Errors
/// `memory` where it would take more than `max_bytes`; `cancelled`.
pub async fn parts(by: CutBy<'_>, outline: &Outline, max_bytes: u64, control: &Control) -> Result<Vec<OutlinePart>> {
    let asked = CutWanted { centroids: true, faces: true, face_centroids: true, edges: true, surfaces: false };
    let keep = |part: CutPart| of_flag(&part, outline.fluid);
    let bytes_of = |found: &Vec<(u64, OutlinePart)>| 2 * size_of_val(&found[..]);
    let window = CellWindow::all(by.lines.dims());
    let Measured { parts, .. } = in_parts((by, window), asked, max_bytes, control, (keep, bytes_of)).await?;
    let mut found = parts.into_iter().flatten().peekable();
    let of_cell = |cell: u64| {
        while found.next_if(|(other, _)| *other < cell).is_some() {}
        found.next_if(|(other, _)| *other == cell).map_or(NOTHING, |(_, part)| part)
    };
    Ok(outline.cells.iter().map(|cell| cell.cell).map(of_cell).collect())
}

fn of_flag(part: &CutPart, flag: u8) -> Vec<(u64, OutlinePart)> {
    let has = (0..part.flags.len()).filter(|&at| part.flags[at].flag == flag);
    let of = |at: usize| OutlinePart {
        fraction: part.flags[at].fraction,
        centre: part.centroids[at],
        areas: part.faces[at],
        face_centres: part.face_centroids[at],
        lengths: part.edges[at],
    };
    has.map(|at| (part.flags[at].cell, of(at))).collect()
}
