//! What of the edges and faces of cells lies outside metal: the data of conformal finite-difference solvers of Maxwell's equations.
//!
//! Snapped facets, flags that are metal -> [`Conformal`].
//!
//! # Theory
//! Dey and Mittra (1997) keep the scheme of Yee, and give Faraday's law for a face the lengths of its edges and the area that are outside metal. With both of them exact a
//! wall is second order wherever it lies. Lengths and areas are those of the cut cells of this group, so all cells at an edge or face have the same number.
//!
//! *Ties.* Metal holds its surface: an edge or a face that lies in a wall has none outside. Cut cells take what lies in a plane between cells for what is infinitesimally below it,
//! so they see one side of such a wall. Seen in mirrors across two axes they see another: of four the least counts, and any edge has its
//! four sides in these (`mirrors.rs`). Where no facet lies along a line of the mesh all four are the same, and one is made.
//!
//! *Sheets*, metal without thickness, are faces of no area with edges of no length, as those of a staggered grid.
//!
//! *Stability.* The step is bounded by areas that are small beside their edges (`step.rs`). A face keeps a part of its longest edge as its area, and takes what it lacks from
//! the face behind that edge: so areas add up to what they did, and the scheme stays second order, which it does not where areas are made larger alone (`stable.rs`).
//!
//! Source: Dey and Mittra (1997); Benkler, Chavannes and Kuster (2006) bound the step by ratios; to take from neighbours, and to compute the bound, is ours.
//! Cost: that of the cut cells with faces and edges, up to four times; some 900 bytes for each edge that is cut. Lists are put in order and searched by one core.
//!
//! Out of scope: metal thinner than a cell that is no sheet. Its edges are as long as they are, but the field on both sides of it is one.

mod mirrors;
mod places;
mod stable;
mod step;

use std::sync::Arc;

use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::cells::columns::Columns;
use hexcast_core::cells::flags::CellBox;
use hexcast_core::grid::window::CellWindow;

use super::measure::CutBy;
use crate::staggered::SheetFace;
use mirrors::outside_of_all;
pub use places::PARTS;
use places::{Cells, Grid, Outside};

/// How many cells around a window have a say in its numbers: a face takes from that beside it, which others take from.
pub const REACH: u32 = 2;

/// The fractions of edges and faces that lie outside metal.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Conformal {
    /// Those of each component, in the order of [`PARTS`].
    pub parts: Vec<Fractions>,
    /// The cell that the first edges and faces are those of, counted in the box: 0 but for windows.
    pub origin: [u32; 3],
    /// What they are, counted.
    pub counts: Counts,
    /// The largest stable step, as a part of that of the same lines without metal.
    pub dt_factor: f64,
}

/// Edges and faces, counted: those on the last line along an axis only where that is the last of the box, so that those of windows add up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Counts {
    /// Edges of which a part lies in metal.
    pub cut_edges: u64,
    /// Faces of which a part lies in metal.
    pub cut_faces: u64,
    /// Faces that are larger than what lies outside metal, for stability.
    pub enlarged_faces: u64,
    /// Those of which no face beside them had all that they lacked.
    pub unbalanced_faces: u64,
    /// Cells whose faces rays measure, as a surface passes through itself there.
    pub sampled_cells: u64,
}

/// The fractions of a component.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Fractions {
    /// Such as "Lx".
    pub name: &'static str,
    dims: [u32; 3],
    /// Those of cells that are cut, by index, x fastest.
    cut: Outside,
    /// All others are those of a cell beside them, which has one flag.
    cells: Arc<Cells>,
    /// The first of these cells.
    first: [u32; 3],
}

impl Fractions {
    /// Number of edges or faces on each axis.
    pub fn dims(&self) -> [u32; 3] {
        self.dims
    }

    /// The fractions of a box of edges or faces, x fastest.
    ///
    /// # Errors
    /// `io` where the cells are in a store that fails.
    pub fn fractions(&self, some: &CellBox) -> Result<Vec<f64>> {
        let mut fractions = self.cells.fractions(self.first, some)?;
        let grid = Grid::new(self.dims);
        let [nx, ny] = [0, 1].map(|axis| some[axis].len());
        for &(index, fraction) in self.cut.of_planes(&grid, some[2].clone()) {
            let place = grid.place(index);
            if (0..3).all(|axis| some[axis].contains(&place[axis])) {
                let [x, y, z] = [0, 1, 2].map(|axis| (place[axis] - some[axis].start) as usize);
                fractions[x + nx * (y + ny * z)] = fraction;
            }
        }
        Ok(fractions)
    }
}

/// What is metal, and how it is kept stable.
pub struct Metal<'a> {
    /// By flag.
    pub is_metal: &'a [bool; 256],
    /// Faces of sheets, counted from the first of the cells that are measured.
    pub sheets: &'a [SheetFace],
    /// The least area of a face, as a part of the fraction of its longest edge; 0 leaves areas as they are.
    pub stable: f64,
}

/// Measures the edges and faces of a window by the cells `near` it: [`REACH`] more along each axis, as far as the box goes. `codes` has the rank + 1 of all these.
///
/// # Errors
/// `memory` where they would take more than `max_bytes`; `cancelled`.
pub async fn conformal(
    by: CutBy<'_>,
    (window, near): ([[u32; 3]; 2], [[u32; 3]; 2]),
    metal: Metal<'_>,
    codes: Columns,
    (max_bytes, control): (u64, &Control),
) -> Result<Conformal> {
    let [first, end] = near;
    let within = CellWindow { first, end, halo: 0 };
    let cells = Arc::new(Cells::new(codes, &by.frame.ranks.flag_of_rank, metal.is_metal));
    let (mut outside, sampled_cells) =
        outside_of_all(by, (within, window), (metal.is_metal, &cells), (max_bytes, control)).await?;
    let dims = within.dims();
    close_sheets(&mut outside, metal.sheets, metal.is_metal, dims);
    let mut counts = Counts { sampled_cells, ..Counts::default() };
    let changed = stable::enlarged(&mut outside, dims, metal.stable);
    control.rest().await?;
    let dt_factor = step::factor(&outside, by.lines, near, control).await?;
    let start = [0, 1, 2].map(|axis| window[0][axis] - first[axis]);
    let n = [0, 1, 2].map(|axis| window[1][axis] - window[0][axis]);
    // those on the last line are counted by the window behind
    let is_last = [0, 1, 2].map(|axis| window[1][axis] == by.frame.dims[axis]);
    let counted = |part: usize| [0, 1, 2].map(|axis| n[axis] + u32::from(PARTS[part].1[axis] && is_last[axis]));
    for (part, all) in changed.iter().enumerate() {
        let grid = Grid::of_part(dims, 3 + part);
        let is_counted = |index: &&(u64, bool)| grid.within(index.0, start, counted(3 + part)).is_some();
        for (_, is_balanced) in all.iter().filter(is_counted) {
            counts.enlarged_faces += 1;
            counts.unbalanced_faces += u64::from(!is_balanced);
        }
    }
    let mut parts = Vec::with_capacity(PARTS.len());
    for (part, outside) in outside.into_iter().enumerate() {
        let (name, is_moved) = PARTS[part];
        let of_window = [0, 1, 2].map(|axis| n[axis] + u32::from(is_moved[axis]));
        let cut = outside.cut((Grid::of_part(dims, part), start), Grid::new(of_window));
        let grid = Grid::new(of_window);
        let is_cut = |&&(index, fraction): &&(u64, f64)| {
            fraction > 0.0 && fraction < 1.0 && grid.within(index, [0; 3], counted(part)).is_some()
        };
        let n_cut = cut.all().iter().filter(is_cut).count() as u64;
        *(if part < 3 { &mut counts.cut_edges } else { &mut counts.cut_faces }) += n_cut;
        parts.push(Fractions { name, dims: of_window, cut, cells: cells.clone(), first: start });
    }
    Ok(Conformal { parts, origin: window[0], counts, dt_factor })
}

/// Gives faces of sheets of metal no area, and their edges no length.
fn close_sheets(outside: &mut [Outside; 6], sheets: &[SheetFace], is_metal: &[bool; 256], dims: [u32; 3]) {
    let mut closed = [const { Vec::new() }; 6];
    for sheet in sheets.iter().filter(|sheet| is_metal[usize::from(sheet.flag)]) {
        let axis = usize::from(sheet.axis);
        closed[3 + axis].push((Grid::of_part(dims, 3 + axis).index(sheet.face), 0.0));
        for (along, edge) in places::edges_of_face(axis, sheet.face) {
            closed[along].push((Grid::of_part(dims, along).index(edge), 0.0));
        }
    }
    outside.iter_mut().zip(closed).for_each(|(outside, closed)| outside.lower(closed));
}
