//! Cut cells as polyhedra: the whole cells of a fluid, and what of the others lies in it, cut flat; a closed mesh that has all of the fluid.
//!
//! Lines, whole cells, [`Outline`] -> [`Polyhedra`].
//!
//! # Theory
//! The surface goes straight from crossing to crossing on the faces of cells, over the place where it bends sharply, and within a cell over flat polygons between these segments, or between
//! them and its corner there (`cell.rs`). Crossings, bends and corners are exact; what is between them is not: a smooth surface is off by the square of the cell's size. A point is one of a
//! line, of a face or of a cell of the mesh, and both cells of a face have the same ones, so the mesh is closed by construction; each cell is checked nevertheless.
//!
//! *Crossings near a corner* of the mesh, within [`SNAP`] of the edge, lie in the corner: faces and bodies of nothing vanish.
//!
//! *Small bodies*, below [`LEAST`] of their cell, are joined with what is behind their largest face, and so on while the whole is small (`join.rs`): no part of the fluid is lost.
//!
//! *Wrong shapes*: where a cell with bends is wrong (`quality.rs`), its surface is flat there. What mends wrong cells is looked for in their surroundings alone.
//!
//! *What is thinner than a cell*, where an edge is crossed several times, has no room between corners: such an edge is crossed once or not at all, and a cell without a corner in the fluid has none of it. These cells are counted.
//!
//! Cost: O(cells) time, once or twice, and for the surroundings of wrong cells up to some hundred times; some 150 bytes a cell of the fluid, 13 a cell of the box.

mod build;
pub(in crate::cut_cells) mod cell;
mod closed;
mod join;
mod merge;
pub(in crate::cut_cells) mod planar;
mod quality;
#[cfg(test)]
mod tests;

use crate::mesh::outline::Outline;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::grid::lines::Lines;

pub use build::SNAP;
use build::{Build, Flat, Near};
pub use closed::{Behind, Counts, Face, Polyhedra};
pub use join::LEAST;
use join::{Trial, Ways};

/// Times that the surroundings of wrong cells are made at most to find out which bends make cells wrong.
const ROUNDS: usize = 5;

impl Polyhedra {
    /// The polyhedra of a fluid: `is_whole` says of each cell of the box whether all of it is fluid, x fastest; what it says of those of the outline does not count.
    ///
    /// # Errors
    /// `export-too-large` where there are more than 2^31 - 1 faces, points or corners; `cut-open` where a cell is not closed, which is an error of hexcast; `cancelled`.
    pub async fn new(lines: &Lines, outline: &Outline, is_whole: &[bool], control: &Control) -> Result<Polyhedra> {
        let mut flat = Flat::default();
        let whole = async |flat: &Flat, ways: &Ways| {
            Build::new(lines, outline, is_whole, flat, None)?.made(ways, control).await
        };
        let first = whole(&flat, &Ways::new()).await?;
        let n_wrong = first.cells.len();
        if n_wrong == 0 {
            first.found.check_closed()?;
            return Ok(first.found);
        }
        let near = Near::new(&first.cells, lines.dims());
        drop(first);
        let mut rounds = 0..ROUNDS;
        let ways = loop {
            let mut build = Build::new(lines, outline, is_whole, &flat, Some(&near))?;
            build.add_all(control).await?;
            let Trial { cells, ways, .. } = build.joined(control).await?;
            // where bends make cells wrong the surface is flat
            let more = build.bent(cells);
            if more.is_empty() || rounds.next().is_none() {
                break ways;
            }
            flat.extend(more);
        };
        let mut last = whole(&flat, &ways).await?;
        if last.cells.len() > n_wrong {
            // what was found near wrong cells made others wrong further off
            last = whole(&Flat::default(), &Ways::new()).await?;
        }
        last.found.check_closed()?;
        Ok(last.found)
    }
}
