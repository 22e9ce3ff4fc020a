//! The outline of a fluid: the flags at the corners of cut cells, and the crossings of their edges with its surface.
//!
//! Snapped facets, lines, the flag of the fluid -> [`Outline`]. Crossings are those of `edges.rs`, swept along each edge from its low end: where the strongest
//! geometry changes to or from the fluid, there is a crossing. Ends and crossings are found by what is on the edge alone, so all cells at it find the same.
//!
//! Cost: that of the cut cells with edges; 168 bytes a cell.

use super::cells::State;
use super::cut_cell::CutCellsJob;
use super::edges::{Crossing, Insides, at_corners, crossings, ends_of};
use super::measure::{CutBy, Measure, PLANES, ROUND};
use super::pieces::{Piece, Pieces};
use crate::mesh::outline::{Outline, OutlineCell};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::parallel::*;
use hexcast_core::grid::window::CellWindow;

/// Finds the outline of the cells of a flag in a box; `wall_of` names the wall of a facet.
///
/// # Errors
/// `memory` where it would take more than `max_bytes`; `cancelled`.
pub async fn outline(
    by: CutBy<'_>,
    (fluid, walls): (u8, Vec<String>),
    wall_of: &(dyn Fn(u32) -> u32 + Sync),
    max_bytes: u64,
    control: &Control,
) -> Result<Outline> {
    let measure = Measure::new(by, CellWindow::all(by.lines.dims()), CutCellsJob::default());
    let n_parts = measure.grid.n_planes().div_ceil(PLANES);
    let sweep = Sweep { measure: &measure, fluid, wall_of };
    let mut cells = Vec::new();
    for start in (0..n_parts).step_by(ROUND) {
        control.rest().await?;
        let end = (start + ROUND as u32).min(n_parts);
        let found: Vec<Vec<OutlineCell>> =
            on_all_cores(|| map_within(start..end, |pieces: &mut Pieces, part| sweep.part(part, pieces)));
        let n_found: usize = found.iter().map(Vec::len).sum();
        let n_bytes = ((cells.len() + n_found) * size_of::<OutlineCell>()) as u64;
        if n_bytes > max_bytes {
            let message = format!(
                "the outline of {} cut cells or more takes {n_bytes} bytes: {max_bytes} are left of the memory allowed",
                cells.len() + n_found
            );
            let hint = "allow more with max_memory (--max-memory), or use larger cells";
            return Err(Error::new("memory", message, hint));
        }
        found.into_iter().for_each(|found| cells.extend(found));
    }
    Ok(Outline { fluid, cells, walls, parts: Vec::new() })
}

/// A change along an edge.
struct Change {
    at: f64,
    rank: u8,
    sign: i8,
    facet: u32,
}

struct Sweep<'a> {
    measure: &'a Measure<'a>,
    fluid: u8,
    wall_of: &'a (dyn Fn(u32) -> u32 + Sync),
}

impl Sweep<'_> {
    fn part(&self, part: u32, pieces: &mut Pieces) -> Vec<OutlineCell> {
        let Measure { by, grid, firsts, facets, .. } = self.measure;
        let CellWindow { end: [nx, ny, nz], .. } = grid.window;
        let planes = part * PLANES..((part + 1) * PLANES).min(nz);
        let of_part = firsts[part as usize] as usize..firsts[part as usize + 1] as usize;
        pieces.find(grid, &facets[of_part], planes.clone());
        let mut state = State::new(Insides { rule: by.rule, kinds: by.kinds });
        let mut found = Vec::new();
        for row in 0..planes.len() as u32 * ny {
            let of_row = pieces.of_row(row as usize);
            for of_cell in of_row.chunk_by(|one, other| one.cell() == other.cell()) {
                if let Some(x) = of_cell[0].cell().checked_sub(1) {
                    let index = u64::from(x) + u64::from(nx) * u64::from(planes.start * ny + row);
                    found.push(self.cell(index, (pieces, of_cell), &state));
                }
                for piece in of_cell {
                    crossings(pieces, piece, |crossing| {
                        if crossing.edge == 0 {
                            state.pass(piece.rank(), crossing.sign);
                        }
                    });
                }
            }
            if !of_row.is_empty() {
                state.begin();
            }
        }
        found
    }

    fn flag(&self, rank: Option<u8>) -> u8 {
        rank.map_or(0, |rank| self.measure.by.frame.ranks.flag_of_rank[usize::from(rank)])
    }

    /// The outline in a cell, given the state at its low corner.
    fn cell(&self, cell: u64, (pieces, of_cell): (&Pieces, &[Piece]), state: &State) -> OutlineCell {
        let mut changes = [const { Vec::new() }; 12];
        let mut windings = Vec::new();
        for of_rank in of_cell.chunk_by(|one, other| one.rank() == other.rank()) {
            let (rank, mut losses) = (of_rank[0].rank(), [0; 12]);
            for piece in of_rank {
                crossings(pieces, piece, |Crossing { edge, sign, at }| {
                    losses[usize::from(edge)] += i32::from(sign);
                    changes[usize::from(edge)].push(Change { at, rank, sign, facet: piece.facet() });
                });
            }
            windings.push((rank, at_corners(state.winding(rank), &losses)));
        }
        let at_corner =
            |corner: usize| -> Vec<(u8, i32)> { windings.iter().map(|(rank, of)| (*rank, of[corner])).collect() };
        let corners = std::array::from_fn(|corner| self.flag(state.winner_with(&at_corner(corner))));
        let mut found = OutlineCell { cell, corners, crossings: [f64::NAN; 12], walls: [0; 12], is_thin: false };
        for (edge, changes) in changes.iter_mut().enumerate().filter(|(_, changes)| !changes.is_empty()) {
            let [low, high] = ends_of(edge);
            let mut passed = at_corner(low);
            changes.sort_unstable_by(|one, other| {
                one.at.total_cmp(&other.at).then((one.rank, one.sign, one.facet).cmp(&(
                    other.rank,
                    other.sign,
                    other.facet,
                )))
            });
            // where the fluid begins or ends, and by which facet
            let (mut places, mut is_fluid): (Vec<(f64, u32)>, bool) = (Vec::new(), corners[low] == self.fluid);
            let begins = is_fluid;
            for &Change { at, rank, sign, facet } in changes.iter() {
                passed.iter_mut().filter(|(of, _)| *of == rank).for_each(|(_, winding)| *winding -= i32::from(sign));
                let is_behind = self.flag(state.winner_with(&passed)) == self.fluid;
                // two surfaces at one place: what is between has no length
                let is_nothing = places.last().is_some_and(|(last, _)| *last == at);
                match is_behind != is_fluid {
                    true if is_nothing => _ = places.pop(),
                    true => places.push((at, facet)),
                    false => {}
                }
                is_fluid = is_behind;
            }
            found.is_thin |= places.len() > 1;
            if begins != (corners[high] == self.fluid) {
                // every second stretch is that of the low end
                let ends = places.iter().map(|(at, _)| *at);
                let length: f64 = ends.enumerate().map(|(index, at)| if index % 2 == 0 { at } else { -at }).sum();
                found.crossings[edge] = length.clamp(0.0, 1.0);
                found.walls[edge] = places.last().map_or(0, |(_, facet)| (self.wall_of)(*facet));
            }
        }
        found
    }
}
