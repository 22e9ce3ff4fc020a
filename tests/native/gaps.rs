//! Closed gaps, against the definition cell by cell; holes of every width; the command line.

use hexcast::columns::{run_cell, run_flag};
use hexcast::control::Control;
use hexcast::gaps::{Gaps, close};
use hexcast_core::cells::flags::expand;

use super::compare::assert_same;
use super::leak::Grid;
use super::soups::Random;

/// Flag of closed gaps.
const FLAG: u8 = 9;

/// The flags with gaps closed, by a mesh with rays along an axis.
fn closed(grid: &Grid, width: u32, axis: usize) -> (Vec<u8>, Gaps) {
    let mesh = grid.mesh(axis);
    let (columns, gaps) = close(mesh.columns(), mesh.lines(), (width, FLAG), 1 << 30, &Control::default()).unwrap();
    for ray in 0..columns.rays().n_rays() {
        let runs = columns.ray(ray).unwrap();
        let is_sound = |pair: &[u32]| run_cell(pair[0]) < run_cell(pair[1]) && run_flag(pair[0]) != run_flag(pair[1]);
        assert!(runs.windows(2).all(is_sound) && runs.first().is_none_or(|&run| run_flag(run) != 0), "{runs:x?}");
    }
    assert_eq!(columns.cells_per_flag()[usize::from(FLAG)], gaps.cells);
    let mut flags = vec![0; grid.flags.len()];
    expand(&columns, &grid.dims.map(|n| 0..n), &mut flags).unwrap();
    (flags, gaps)
}

/// The definition: fewer than `width` background cells in a row, with a flagged cell at both ends.
fn is_gap(grid: &Grid, cell: [u32; 3], width: u32) -> bool {
    let is_flagged = |cell: [u32; 3]| grid.flags[grid.index(cell)] != 0;
    !is_flagged(cell)
        && (0..3).any(|axis| {
            let at = |along: u32| [0, 1, 2].map(|other| if other == axis { along } else { cell[other] });
            let below = (0..cell[axis]).rev().find(|&along| is_flagged(at(along)));
            let above = (cell[axis]..grid.dims[axis]).find(|&along| is_flagged(at(along)));
            below.zip(above).is_some_and(|(below, above)| above - below - 1 < width)
        })
}

/// A wall of flag 1 across an axis, in a box of 30 x 30 x 12 cells with the axis last.
fn wall(axis: usize, is_hole: impl Fn(f64, f64) -> bool) -> Grid {
    let mut dims = [30; 3];
    dims[axis] = 12;
    let mut grid = Grid::filled(dims, 0);
    let across = [[1, 2], [0, 2], [0, 1]][axis];
    for i in 0..30 {
        for j in 0..30 {
            if is_hole(f64::from(i) + 0.5, f64::from(j) + 0.5) {
                continue;
            }
            let mut low = [4; 3];
            (low[across[0]], low[across[1]]) = (i, j);
            let mut high = low.map(|at| at + 1);
            high[axis] = 6;
            grid.set(low, high, 1);
        }
    }
    grid
}

#[test]
fn gaps_are_those_of_the_definition_whatever_the_ray_axis() {
    let mut random = Random::new(2718);
    let mut n_gaps = 0;
    for number in 0..120 {
        let dims = [0; 3].map(|_| 1 + random.below(12) as u32);
        let mut grid = Grid::filled(dims, 0);
        let flagged = 3 + random.below(60);
        for flag in &mut grid.flags {
            *flag = if random.below(100) < flagged { random.one_of(&[1, 2, FLAG]) } else { 0 };
        }
        // cells that had the flag before are not counted
        let width = 2 + random.below(6) as u32;
        grid.flags.iter_mut().for_each(|flag| *flag = if *flag == FLAG { 3 } else { *flag });
        let expected: Vec<u8> = (0..grid.flags.len() as u32)
            .map(|index| {
                let cell = [index % dims[0], index / dims[0] % dims[1], index / (dims[0] * dims[1])];
                if is_gap(&grid, cell, width) { FLAG } else { grid.flags[index as usize] }
            })
            .collect();
        let of_first = closed(&grid, width, 0).1;
        for axis in 0..3 {
            let (flags, gaps) = closed(&grid, width, axis);
            assert_same(&format!("grid {number} of seed 2718, rays along {axis}"), &expected, &flags, dims);
            assert_eq!(gaps, of_first, "grid {number}, rays along {axis}");
        }
        assert_eq!(of_first.largest.iter().map(|gap| gap.cells).sum::<u64>() == of_first.cells, of_first.gaps <= 100);
        n_gaps += of_first.gaps;
    }
    assert!(n_gaps > 500, "{n_gaps} gaps");
}

#[test]
fn holes_narrower_than_the_width_are_closed_and_no_wider() {
    let mut random = Random::new(100);
    let (mut n_closed, mut n_kept) = (0, 0);
    for number in 0..100 {
        let width = 2 + random.below(8) as u32;
        // every width around it
        let sides =
            [width - 2 + (number % 5).max(3 - width.min(3)), width - 1 + random.below(9) as u32].map(|n| n.max(1));
        let sides = if number % 2 == 0 { sides } else { [sides[1], sides[0]] };
        let low = [0, 1].map(|side| 1 + random.below(u64::from(28 - sides[side])) as u32);
        let is_inside = |at: f64, side: usize| at > f64::from(low[side]) && at < f64::from(low[side] + sides[side]);
        let grid = wall(number as usize % 3, |i, j| is_inside(i, 0) && is_inside(j, 1));
        let name = format!("hole {number} of seed 100: {sides:?} cells, closed below {width}");
        let (flags, gaps) = closed(&grid, width, random.below(3) as usize);
        if sides[0].min(sides[1]) < width {
            // all cells of the hole, in the two layers of the wall
            assert_eq!((gaps.cells, gaps.gaps), (u64::from(2 * sides[0] * sides[1]), 1), "{name}");
            n_closed += 1;
        } else {
            assert_eq!(gaps.cells, 0, "{name}");
            assert_same(&name, &grid.flags, &flags, grid.dims);
            n_kept += 1;
        }
    }
    assert!(n_closed > 20 && n_kept > 20, "{n_closed} closed, {n_kept} kept");
}

#[test]
fn round_holes_keep_their_middle_if_they_are_as_wide() {
    for diameter in 2..20u32 {
        let radius = f64::from(diameter) / 2.0;
        let centre = 14.0 + radius % 1.0;
        let grid = wall(2, |i, j| (i - centre).hypot(j - centre) < radius);
        let hole = grid.flags.iter().filter(|flag| **flag == 0).count();
        for width in 2..20 {
            let (_, gaps) = closed(&grid, width, 1);
            let outside = 30 * 30 * 10;
            if diameter < width {
                assert_eq!(gaps.cells, hole as u64 - outside, "diameter {diameter}, width {width}");
            } else {
                assert!(gaps.cells < hole as u64 - outside, "diameter {diameter}, width {width}");
            }
        }
    }
}

#[test]
fn gaps_are_where_the_report_says() {
    let mut grid = Grid::filled([12, 9, 8], 5);
    grid.set([2, 3, 4], [4, 5, 6], 0);
    grid.set([9, 1, 1], [10, 2, 7], 0);
    // open at the boundary: no gap along x, but one along the others
    grid.set([11, 8, 0], [12, 9, 8], 0);
    for axis in 0..3 {
        let (_, gaps) = closed(&grid, 3, axis);
        assert_eq!((gaps.width, gaps.flag, gaps.cells, gaps.gaps), (3, FLAG, 14, 2));
        let found: Vec<_> = gaps.largest.iter().map(|gap| (gap.cells, gap.bounds)).collect();
        // cells of 1 x 2 x 0.5 from (-1, 0, 10)
        let [first, second] = [[[1.0, 6.0, 12.0], [3.0, 10.0, 13.0]], [[8.0, 2.0, 10.5], [9.0, 4.0, 13.5]]];
        assert_eq!(found, [(8, first), (6, second)]);
    }
}

#[test]
fn too_little_memory_is_said() {
    let mesh = Grid::filled([5; 3], 0).mesh(0);
    let error = close(mesh.columns(), mesh.lines(), (3, FLAG), 100, &Control::default()).unwrap_err();
    assert_eq!(error.code(), "memory");
    assert!(!error.hint().is_empty());
}
