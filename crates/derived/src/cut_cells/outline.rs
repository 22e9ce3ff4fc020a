//! The outline of a fluid: the flags at the corners of cut cells, and the crossings of their edges with its surface.
//!
//! Snapped facets, lines, the flag of the fluid -> [`Outline`]. Crossings are those of `edges.rs`, swept along each edge from its low end: where the strongest
//! geometry changes to or from the fluid, there is a crossing. Ends and crossings are found by what is on the edge alone, so all cells at it find the same. What edges do not say of the surface, its bends on
//! faces and its corner in the cell, is found by exact areas and volumes (`outline/bends.rs`).
//!
//! Cost: that of the cut cells with edges and faces; 296 bytes a cell.

mod bends;

use super::cells::{Scene, Shares, State};
use super::cut_cell::{Asked, CutWanted};
use super::edges::{ACROSS, Crossing, Insides, at_corners, crossings, ends_of};
use super::integrals::number;
use super::measure::{CutBy, Measure, PLANES, ROUND};
use super::pieces::{Piece, Pieces};
use crate::mesh::outline::{Outline, OutlineCell};
use bends::{Places, Shape};
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
    let measure = Measure::new(by, CellWindow::all(by.lines.dims()), CutWanted::default());
    let n_parts = measure.grid.n_planes().div_ceil(PLANES);
    let lists = [0, 1, 2].map(|axis| by.lines.list(axis));
    let sweep = Sweep { measure: &measure, fluid, wall_of, lists };
    let mut cells = Vec::new();
    let mut volume = 0.0;
    for start in (0..n_parts).step_by(ROUND) {
        control.rest().await?;
        let end = (start + ROUND as u32).min(n_parts);
        let found: Vec<Part> =
            on_all_cores(|| map_within(start..end, |memory: &mut Memory, part| sweep.part(part, memory)));
        let n_found: usize = found.iter().map(|part| part.cells.len()).sum();
        let n_bytes = ((cells.len() + n_found) * size_of::<OutlineCell>()) as u64;
        if n_bytes > max_bytes {
            let message = format!(
                "the outline of {} cut cells or more takes {n_bytes} bytes: {max_bytes} are left of the memory allowed",
                cells.len() + n_found
            );
            let hint = "allow more with max_memory (--max-memory), or use larger cells";
            return Err(Error::new("memory", message, hint));
        }
        for part in found {
            volume += part.volume;
            cells.extend(part.cells);
        }
    }
    Ok(Outline::new(fluid, cells, walls, volume))
}

/// Memory that a core uses for part after part.
#[derive(Default)]
struct Memory {
    pieces: Pieces,
    shares: Shares,
}

/// What was found in some planes.
#[derive(Default)]
struct Part {
    cells: Vec<OutlineCell>,
    volume: f64,
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
    /// The lines.
    lists: [Vec<f64>; 3],
}

impl Sweep<'_> {
    fn part(&self, part: u32, Memory { pieces, shares }: &mut Memory) -> Part {
        let Measure { by, grid, firsts, facets, is_oriented, .. } = self.measure;
        let CellWindow { end: [nx, ny, nz], .. } = grid.window;
        let planes = part * PLANES..((part + 1) * PLANES).min(nz);
        let of_part = firsts[part as usize] as usize..firsts[part as usize + 1] as usize;
        pieces.find(grid, &facets[of_part], planes.clone());
        let insides = Insides { rule: by.rule, kinds: by.kinds };
        let asked = Asked { faces: true, edges: false, centroids: false };
        let scene = Scene { insides, flag_of_rank: &by.frame.ranks.flag_of_rank, is_oriented, asked };
        let mut state = State::new(insides);
        let mut found = Part::default();
        for row in 0..planes.len() as u32 * ny {
            let of_row = pieces.of_row(row as usize);
            let size = |axis: usize, cell: u32| self.lists[axis][cell as usize + 1] - self.lists[axis][cell as usize];
            let of_cells = size(1, row % ny) * size(2, planes.start + row / ny);
            // the volume of the fluid in whole cells
            let whole = |state: &State, cells: std::ops::Range<u32>| {
                let is_fluid = self.flag(state.winner(&[0; 4])) == self.fluid && !cells.is_empty();
                let length = || self.lists[0][cells.end as usize] - self.lists[0][cells.start as usize];
                if is_fluid { of_cells * length() } else { 0.0 }
            };
            let mut next = 0;
            for of_cell in of_row.chunk_by(|one, other| one.cell() == other.cell()) {
                if let Some(x) = of_cell[0].cell().checked_sub(1) {
                    let index = u64::from(x) + u64::from(nx) * u64::from(planes.start * ny + row);
                    found.volume += whole(&state, next..x);
                    next = x + 1;
                    let mut cell = self.cell(index, (pieces, of_cell), &state);
                    scene.measure(pieces, of_cell, &state, shares);
                    self.shape(&mut cell, (pieces, of_cell), shares);
                    found.volume += cell.fraction * of_cells * size(0, x);
                    found.cells.push(cell);
                }
                for piece in of_cell {
                    crossings(pieces, piece, |crossing| {
                        if crossing.edge == 0 {
                            state.pass(piece.rank(), crossing.sign);
                        }
                    });
                }
            }
            found.volume += whole(&state, next..nx);
            if !of_row.is_empty() {
                state.begin();
            }
        }
        found
    }

    /// Finds what edges do not say of the fluid in a cell.
    fn shape(&self, cell: &mut OutlineCell, (pieces, of_cell): (&Pieces, &[Piece]), shares: &Shares) {
        let mut areas = [0.0; 6];
        let flags = &shares.flags;
        if let Some(at) = flags.shares.iter().position(|share| share.flag == self.fluid) {
            cell.fraction = number(flags.shares[at].cell[0]);
            areas = flags.borders[at].faces.map(|face| number(face[0]));
        }
        let mut places = Places::default();
        for piece in of_cell {
            let (corners, sides) = (pieces.corners(piece), pieces.sides(piece));
            let mut before = sides[sides.len() - 1];
            for (corner, &behind) in corners.iter().zip(sides) {
                // corners on an edge of the cell are crossings
                if before == 0 && behind == 0 {
                    places.within.push(*corner);
                } else if before == 0 || behind == 0 {
                    let face = usize::from(before.max(behind) - 1);
                    places.on_faces.push((face, ACROSS[face / 2].map(|axis| corner[axis])));
                }
                before = behind;
            }
        }
        let Shape { bends, peak } =
            Shape::new(cell.in_fluid(self.fluid), &cell.crossings, &places, &areas, cell.fraction);
        (cell.bends, cell.peak) = (bends, peak);
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
        let mut found = OutlineCell {
            cell,
            corners,
            crossings: [f64::NAN; 12],
            walls: [0; 12],
            bends: [[f64::NAN; 2]; 6],
            peak: [f64::NAN; 3],
            is_thin: false,
            fraction: 0.0,
        };
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
