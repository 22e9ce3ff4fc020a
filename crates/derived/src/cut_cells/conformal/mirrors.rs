//! The edges and faces of cut cells, from all sides where that matters.

use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::parallel::*;
use hexcast_core::base::sort::{sort_by, sort_by_key};
use hexcast_core::grid::frame::{Frame, SnappedFacet, normal};
use hexcast_core::grid::window::CellWindow;

use super::places::{Cells, Grid, Outside, PARTS};
use crate::cut_cells::cut_cell::{CutPart, CutWanted};
use crate::cut_cells::edges::ACROSS;
use crate::cut_cells::measure::{CutBy, in_parts};

/// Mirrors across two axes each: with none, all four sides of edges along any axis, and both of any face.
const MIRRORS: [[bool; 3]; 4] = [[false, false, false], [true, true, false], [false, true, true], [true, false, true]];
/// Bytes of an edge or a face while they are put in order.
const BYTES_OF_ONE: u64 = 2 * 16;

/// Edges and faces, by component, with their fractions outside metal.
type Listed = [Vec<(u64, f64)>; 6];

/// What lies outside metal of all edges and faces of the cut cells of a window, seen from all sides; and the number of cells that were sampled of some of them.
///
/// # Errors
/// `memory`; `cancelled`.
pub(super) async fn outside_of_all(
    by: CutBy<'_>,
    (window, counted): (CellWindow, [[u32; 3]; 2]),
    (is_metal, cells): (&[bool; 256], &Cells),
    (max_bytes, control): (u64, &Control),
) -> Result<([Outside; 6], u64)> {
    let mut seen_from_all: Listed = Default::default();
    let mut n_sampled = 0;
    let n = if lies_along_lines(by.frame) { MIRRORS.len() } else { 1 };
    for mirrors in &MIRRORS[..n] {
        let held = seen_from_all.iter().map(|of| size_of_val(&of[..]) as u64).sum::<u64>();
        let frame;
        let seen = match mirrors.contains(&true) {
            true => {
                frame = by.frame.clone().mirrored(*mirrors);
                CutBy { frame: &frame, ..by }
            }
            false => by,
        };
        let turned = |cells: [u32; 3], other: [u32; 3]| {
            [0, 1, 2].map(|axis| if mirrors[axis] { by.frame.dims[axis] - other[axis] } else { cells[axis] })
        };
        let there =
            CellWindow { first: turned(window.first, window.end), end: turned(window.end, window.first), halo: 0 };
        let list = |part: CutPart| (listed(&part, (there, *mirrors), is_metal), sampled(&part, window, counted));
        let asked = CutWanted { faces: true, edges: true, ..CutWanted::default() };
        let bytes_of = |(listed, _): &(Listed, u64)| listed.iter().map(|of| 2 * size_of_val(&of[..])).sum();
        let left = max_bytes.saturating_sub(2 * held);
        let found = in_parts((seen, there), asked, left, control, (list, bytes_of)).await?;
        let mut all: Listed = Default::default();
        for (part, of_part) in found.parts {
            n_sampled += if mirrors.contains(&true) { 0 } else { of_part };
            all.iter_mut().zip(part).for_each(|(all, of)| all.extend(of));
        }
        no_room(held + BYTES_OF_ONE * all.iter().map(|of| of.len() as u64).sum::<u64>(), max_bytes)?;
        control.rest().await?;
        for (seen, mut all) in seen_from_all.iter_mut().zip(all) {
            // all cells at one have the same
            sort_by_key(&mut all, |(index, _)| *index);
            all.dedup_by_key(|(index, _)| *index);
            seen.extend(all);
        }
    }
    let mut outside = std::array::from_fn::<_, 6, _>(|_| Outside::default());
    for (part, seen) in seen_from_all.into_iter().enumerate() {
        outside[part] = least(seen, n, (Grid::of_part(window.dims(), part), cells))?;
        control.rest().await?;
    }
    Ok((outside, n_sampled))
}

/// Of each of some edges or faces, listed once for each mirror in which a cell at it is cut, the least fraction. Where there are fewer than `n`, that of its cells counts, too: they are not cut there.
///
/// # Errors
/// `io` where the cells are in a store that fails.
fn least(mut seen: Vec<(u64, f64)>, n: usize, (grid, cells): (Grid, &Cells)) -> Result<Outside> {
    sort_by(&mut seen, |one, other| (one.0, one.1) < (other.0, other.1));
    let is_seen_by_all = |of_one: &&[(u64, f64)]| of_one.len() == n;
    let others = seen.chunk_by(|one, other| one.0 == other.0).filter(|of_one| !is_seen_by_all(of_one));
    let others: Vec<(u64, f64)> = others.filter(|of_one| of_one[0].1 > 0.0).map(|of_one| of_one[0]).collect();
    let metal = cells.are_metal(others.iter().map(|(index, _)| grid.place(*index)))?;
    let in_metal = others.iter().zip(metal).filter(|(_, is_metal)| *is_metal).map(|((index, _), _)| (*index, 0.0));
    let in_metal: Vec<(u64, f64)> = in_metal.collect();
    let mut outside = Outside::default();
    seen.dedup_by_key(|(index, _)| *index);
    outside.set(seen);
    outside.set(in_metal);
    Ok(outside)
}

/// The error of too many cells for the memory.
fn no_room(needed: u64, max_bytes: u64) -> Result<()> {
    if needed <= max_bytes {
        return Ok(());
    }
    let message =
        format!("edges and faces outside metal take {needed} bytes: {max_bytes} are left of the memory allowed");
    Err(Error::new("memory", message, "allow more with max_memory (--max-memory), or use larger cells"))
}

/// Number of cells of a part that rays measure, of some of the window.
fn sampled(part: &CutPart, window: CellWindow, [first, end]: [[u32; 3]; 2]) -> u64 {
    let cells = part.flags.chunk_by(|one, other| one.cell == other.cell).map(|of_cell| of_cell[0]);
    let is_counted = |cell: u64| {
        let place = window.cell(cell);
        (0..3).all(|axis| (first[axis]..end[axis]).contains(&(place[axis] + window.first[axis])))
    };
    cells.filter(|of| of.is_sampled && is_counted(of.cell)).count() as u64
}

/// The edges and faces of the cells of a part, with their numbers outside the mirrors.
fn listed(part: &CutPart, (window, mirrors): (CellWindow, [bool; 3]), is_metal: &[bool; 256]) -> Listed {
    let dims = window.dims();
    let grids: [Grid; 6] = std::array::from_fn(|of| Grid::of_part(dims, of));
    let mut all: Listed = Default::default();
    let mut first = 0;
    for of_cell in part.flags.chunk_by(|one, other| one.cell == other.cell) {
        let entries = first..first + of_cell.len();
        first = entries.end;
        let (mut free, mut metal) = ([0.0; 18], [0.0; 18]);
        for at in entries {
            let sums = if is_metal[usize::from(part.flags[at].flag)] { &mut metal } else { &mut free };
            sums.iter_mut().zip(part.edges[at].iter().chain(&part.faces[at])).for_each(|(sum, more)| *sum += more);
        }
        // counted from the first of the window
        let low = window.cell(of_cell[0].cell);
        let mut add = |part: usize, at: usize, ends: [u32; 3]| {
            let (_, is_on_line) = PARTS[part];
            let place = [0, 1, 2].map(|axis| {
                let place = low[axis] + ends[axis];
                if mirrors[axis] { dims[axis] - place - u32::from(!is_on_line[axis]) } else { place }
            });
            // sums of rounded fractions are exact where there is nothing of one of the two
            let outside = if free[at] == 0.0 { 0.0 } else { 1.0 - metal[at] };
            all[part].push((grids[part].index(place), outside.max(0.0)));
        };
        for edge in 0..12 {
            let mut ends = [0; 3];
            for (bit, axis) in ACROSS[edge / 4].into_iter().enumerate() {
                ends[axis] = (edge % 4) as u32 >> bit & 1;
            }
            add(edge / 4, edge, ends);
        }
        for face in 0..6 {
            let mut ends = [0; 3];
            ends[face / 2] = face as u32 % 2;
            add(3 + face / 2, 12 + face, ends);
        }
    }
    all
}

/// Whether a facet lies in a plane of mesh lines, or holds a part of one.
fn lies_along_lines(frame: &Frame) -> bool {
    let faces = [0, 1, 2].map(|axis| (0..=frame.dims[axis]).map(|line| frame.face(axis, line)).collect::<Vec<i32>>());
    frame.facets.par_iter().any(|facet| holds_a_line(facet, &faces))
}

fn holds_a_line(facet: &SnappedFacet, faces: &[Vec<i32>; 3]) -> bool {
    let across = normal(facet);
    across != [0; 3] && (0..3).any(|axis| across[axis] == 0 && is_met(facet, ACROSS[axis], faces))
}

/// Whether a facet that is seen as a stretch along an axis has a crossing of lines of the two others in it, or lies in a plane of lines.
fn is_met(facet: &SnappedFacet, [one, other]: [usize; 2], faces: &[Vec<i32>; 3]) -> bool {
    let ends = facet.map(|corner| [corner[one], corner[other]]);
    let (Some(a), Some(b)) = (ends.iter().min(), ends.iter().max()) else { return false };
    let is_line = |axis: usize, place: i32| faces[axis].binary_search(&place).is_ok();
    if a[0] == b[0] {
        return is_line(one, a[0]);
    }
    let [run, rise] = [0, 1].map(|of| i64::from(b[of]) - i64::from(a[of]));
    if rise == 0 {
        return is_line(other, a[1]);
    }
    let [start, end] =
        [faces[one].partition_point(|&line| line < a[0]), faces[one].partition_point(|&line| line <= b[0])];
    faces[one][start..end].iter().any(|&line| {
        let product = (i64::from(line) - i64::from(a[0])) * rise;
        product % run == 0 && is_line(other, (i64::from(a[1]) + product / run) as i32)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn facets_along_lines_are_found() {
        let faces = [vec![0, 8, 16], vec![0, 8, 16], vec![0, 8, 16]];
        let cases = [
            // in a plane of lines, and beside it
            ([[1, 1, 8], [5, 1, 8], [1, 5, 8]], true),
            ([[1, 1, 7], [5, 1, 7], [1, 5, 7]], false),
            // along x, over the crossing of lines at y = z = 8, and beside it
            ([[1, 4, 4], [5, 4, 4], [1, 12, 12]], true),
            ([[1, 4, 5], [5, 4, 5], [1, 12, 13]], false),
            // across all axes, and without an area
            ([[1, 8, 8], [5, 9, 10], [3, 12, 11]], false),
            ([[8, 8, 8]; 3], false),
        ];
        for (facet, expected) in cases {
            assert_eq!(holds_a_line(&facet, &faces), expected, "{facet:?}");
        }
    }
}
