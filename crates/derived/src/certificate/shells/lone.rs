//! Shells that stand alone: in the boxes of their cells no other shell has any, so that the mesh itself has their cells.
//!
//! Boxes of cells -> those that meet no other; columns, a flag, boxes -> the volume of its cells in each.
//!
//! Cost: O(n log n) for n boxes in most scenes, at most [`MOST_PAIRS`] pairs; then 10 ns a ray through a box.

use std::ops::Range;

use hexcast_core::base::error::Result;
use hexcast_core::base::parallel::*;
use hexcast_core::cells::columns::{Columns, run_cell, run_flag};
use hexcast_core::grid::lines::Lines;

/// A box of cells on x, y and z.
pub type CellBox = [Range<u32>; 3];

/// Pairs of boxes that are looked at, at most: where more boxes lie beside one another along x, none is said to stand alone.
const MOST_PAIRS: usize = 1 << 22;

/// The cells that have a place in common with a box in the world.
pub fn cells_of([low, high]: [[f64; 3]; 2], lines: &Lines) -> CellBox {
    [0, 1, 2].map(|axis| {
        let n = lines.dims()[axis];
        let cell = |place: f64| lines.position(axis, place).clamp(0.0, f64::from(n));
        // one more at both ends, as places are rounded
        (cell(low[axis]).floor() as u32).saturating_sub(1)..(cell(high[axis]).ceil() as u32 + 1).min(n)
    })
}

/// Of each box whether it has no cell in common with another.
pub fn stand_alone(boxes: &[CellBox]) -> Vec<bool> {
    let mut order: Vec<usize> = (0..boxes.len()).collect();
    order.sort_unstable_by_key(|&of| boxes[of][0].start);
    let mut is_alone = vec![true; boxes.len()];
    let mut beside: Vec<usize> = Vec::new();
    let mut n_pairs = 0;
    for &one in &order {
        let own = &boxes[one];
        beside.retain(|&other| boxes[other][0].end > own[0].start);
        n_pairs += beside.len();
        if n_pairs > MOST_PAIRS {
            return vec![false; boxes.len()];
        }
        let meets =
            |axis: usize, other: &CellBox| own[axis].start < other[axis].end && other[axis].start < own[axis].end;
        for &other in beside.iter().filter(|&&other| meets(1, &boxes[other]) && meets(2, &boxes[other])) {
            (is_alone[one], is_alone[other]) = (false, false);
        }
        beside.push(one);
    }
    is_alone
}

/// Volume of the cells of a flag in each box, of columns of all cells of these lines.
///
/// # Errors
/// `io` where the columns are in a store that fails.
pub fn volumes(columns: &Columns, flag: u8, boxes: &[CellBox], lines: &Lines) -> Result<Vec<f64>> {
    boxes.par_iter().map(|cells| volume(columns, flag, cells, lines)).collect()
}

fn volume(columns: &Columns, flag: u8, cells: &CellBox, lines: &Lines) -> Result<f64> {
    let rays = columns.rays();
    let along = &cells[rays.axis];
    let [across, down] = rays.across.map(|axis| cells[axis].clone());
    let line = |cell: u32| lines.line(rays.axis, cell);
    let mut volume = 0.0;
    for j in down {
        let first = u64::from(rays.counts[0]) * u64::from(j);
        let mut area = across.clone().map(|i| lines.cell_size(rays.across[0], i) * lines.cell_size(rays.across[1], j));
        columns.for_rays(first + u64::from(across.start)..first + u64::from(across.end), |runs| {
            let area = area.next().unwrap_or_default();
            let before = runs.partition_point(|&run| run_cell(run) <= along.start);
            for (index, &run) in runs.iter().enumerate().skip(before.saturating_sub(1)) {
                let start = run_cell(run).max(along.start);
                if start >= along.end {
                    break;
                }
                if run_flag(run) == flag {
                    let end = runs.get(index + 1).map_or(rays.depth, |&next| run_cell(next)).min(along.end);
                    volume += (line(end) - line(start)) * area;
                }
            }
        })?;
    }
    Ok(volume)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing::{pattern, pattern_flag};

    #[test]
    fn boxes_stand_alone_where_no_other_has_one_of_their_cells() {
        let mut seed = 1u64;
        let mut random = |n: u32| {
            seed = hexcast_core::input::edges::mixed(seed);
            (seed >> 33) as u32 % n
        };
        let mut counts = [0, 0];
        for _ in 0..400 {
            let n = random(12);
            let boxes: Vec<CellBox> =
                (0..n).map(|_| [0; 3].map(|_| random(20)).map(|low| low..low + 1 + low % 5)).collect();
            let in_common = |one: &CellBox, other: &CellBox| {
                (0..3).all(|axis| one[axis].clone().any(|cell| other[axis].contains(&cell)))
            };
            for (one, is_alone) in stand_alone(&boxes).into_iter().enumerate() {
                let meets = (0..boxes.len()).any(|other| other != one && in_common(&boxes[one], &boxes[other]));
                assert_eq!(is_alone, !meets, "{boxes:?}");
                counts[usize::from(meets)] += 1;
            }
        }
        assert!(counts.iter().all(|&n| n > 100), "{counts:?}");
    }

    #[test]
    fn volumes_are_those_of_the_cells_one_by_one() {
        let dims = [9, 5, 7];
        let equal = Lines::new([0.5; 3], [0.5, 0.25, 2.0], dims).unwrap();
        let list = |n: u32| (0..=n).map(|line| f64::from(line * (line + 3))).collect();
        let graded = Lines::from_lists(dims.map(list)).unwrap();
        let boxes = [[0..9, 0..5, 0..7], [2..8, 1..4, 3..4], [4..5, 0..5, 2..7], [3..4, 4..5, 6..7]];
        for (axis, lines) in [0, 1, 2].into_iter().flat_map(|axis| [(axis, &equal), (axis, &graded)]) {
            let columns = pattern(axis, dims, 3).columns;
            for (found, cells) in volumes(&columns, 2, &boxes, lines).unwrap().into_iter().zip(&boxes) {
                let [x, y, z] = cells.clone();
                let all =
                    x.flat_map(|x| y.clone().map(move |y| [x, y])).flat_map(|[x, y]| z.clone().map(move |z| [x, y, z]));
                let size = |cell: [u32; 3]| (0..3).map(|axis| lines.cell_size(axis, cell[axis])).product::<f64>();
                let expected: f64 = all.filter(|cell| pattern_flag(*cell, 3) == 2).map(size).sum();
                assert!((found - expected).abs() <= 1e-12 * expected.max(1.0), "{cells:?} along {axis}");
            }
        }
    }
}
