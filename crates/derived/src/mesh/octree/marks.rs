//! Which cells are halved for what is asked for: at surfaces, and in boxes.

use super::cells::unite;
use hexcast_core::base::error::Result;
use hexcast_core::cells::columns::{Columns, for_differing, run_cell, run_flag};
use hexcast_core::cells::flags::CellBox;

/// The rows of the children of a row among the planes and rows around them.
const OWN: [[usize; 2]; 4] = [[1, 1], [1, 2], [2, 1], [2, 2]];
/// Pairs of these that touch.
const WITHIN: [[[usize; 2]; 2]; 4] = [[[1, 1], [1, 2]], [[2, 1], [2, 2]], [[1, 1], [2, 1]], [[1, 2], [2, 2]]];
/// Each of these with those that touch it and are of other cells.
const BESIDE: [[[usize; 2]; 2]; 8] = [
    [[1, 1], [1, 0]],
    [[1, 2], [1, 3]],
    [[2, 1], [2, 0]],
    [[2, 2], [2, 3]],
    [[1, 1], [0, 1]],
    [[1, 2], [0, 2]],
    [[2, 1], [3, 1]],
    [[2, 2], [3, 2]],
];

/// Which cells are halved.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Wanted {
    /// Of each flag the level of the cells at its surfaces, which are those of the mesh of that level; a surface between two flags has the finer one.
    pub level_of_flag: [u8; 256],
    /// Boxes of cells of level 0, in which all cells are of this level or finer.
    pub boxes: Vec<(CellBox, u8)>,
}

impl Wanted {
    /// All surfaces get cells of this level.
    pub fn surfaces(level: u8) -> Wanted {
        let mut level_of_flag = [level; 256];
        level_of_flag[0] = 0;
        Wanted { level_of_flag, boxes: Vec::new() }
    }
}

/// What is asked for of a level, whose cells are found as those of which a child touches a surface.
pub(super) struct Marks<'a> {
    /// Of the children.
    columns: &'a Columns,
    wanted: &'a Wanted,
    /// That of the children.
    level: u8,
    /// Whether there are surfaces that get cells of this level.
    has_surfaces: bool,
}

/// The rows of children that decide about the cells of a plane: from the plane before to that behind.
pub(super) struct OfPlane<'a> {
    marks: &'a Marks<'a>,
    /// The runs of all rows of each plane, and where those of each row end; none outside the box.
    planes: [Option<(Vec<u32>, Vec<u32>)>; 4],
}

impl Marks<'_> {
    pub(super) fn new<'a>(columns: &'a Columns, wanted: &'a Wanted, level: u8) -> Marks<'a> {
        let has_surfaces = wanted.level_of_flag.contains(&level);
        Marks { columns, wanted, level, has_surfaces }
    }

    /// Reads what decides about the cells of a plane.
    ///
    /// # Errors
    /// `io` where the columns are in a store that fails.
    pub(super) fn plane(&self, z: u32) -> Result<OfPlane<'_>> {
        let [_, ny, nz] = self.columns.dims();
        let mut planes = [const { None }; 4];
        for (index, plane) in planes.iter_mut().enumerate().filter(|_| self.has_surfaces) {
            let Some(at) = (2 * z + index as u32).checked_sub(1).filter(|at| *at < nz) else { continue };
            let (mut runs, mut ends) = (Vec::new(), Vec::with_capacity(ny as usize));
            let first = u64::from(ny) * u64::from(at);
            self.columns.for_rays(first..first + u64::from(ny), |of_row| {
                runs.extend_from_slice(of_row);
                ends.push(runs.len() as u32);
            })?;
            *plane = Some((runs, ends));
        }
        Ok(OfPlane { marks: self, planes })
    }
}

impl OfPlane<'_> {
    /// Finds the cells of a row that are halved, as runs that are sorted and do not touch; `found` is empty.
    pub(super) fn add(&mut self, [y, z]: [u32; 2], found: &mut Vec<[u32; 2]>) {
        let Marks { wanted, level, has_surfaces, .. } = *self.marks;
        if has_surfaces {
            self.add_surfaces(y, found);
        }
        // cells of level 0 in one of this level
        let shift = u32::from(level) - 1;
        for (of, _) in wanted.boxes.iter().filter(|(_, finest)| *finest >= level) {
            if of[1].contains(&(y >> shift)) && of[2].contains(&(z >> shift)) {
                unite(found, &mut 0, [of[0].start << shift, of[0].end << shift]);
            }
        }
    }

    fn add_surfaces(&self, y: u32, found: &mut Vec<[u32; 2]>) {
        let Marks { wanted, level, columns, .. } = self.marks;
        let nx = columns.dims()[0];
        let is_asked = |[one, other]: [u8; 2]| {
            one != other
                && wanted.level_of_flag[usize::from(one)].max(wanted.level_of_flag[usize::from(other)]) == *level
        };
        let row = |[plane, row]: [usize; 2]| self.row(plane, y, row as u32);
        let own = OWN.map(|at| row(at).unwrap_or_default());
        let mut all = [&[][..]; 12];
        let mut n = 0;
        for runs in own.into_iter().chain(BESIDE.into_iter().filter_map(|pair| row(pair[1]))) {
            all[n] = runs;
            n += 1;
        }
        if add_shifted(&all[..n], nx, is_asked, found) {
            return;
        }
        for runs in own {
            let (mut before, mut at) = (0, 0);
            for &run in runs {
                let (cell, flag) = (run_cell(run), run_flag(run));
                if cell > 0 && is_asked([before, flag]) {
                    unite(found, &mut at, [(cell - 1) / 2, cell / 2 + 1]);
                }
                before = flag;
            }
        }
        for pair in WITHIN.into_iter().chain(BESIDE) {
            let [Some(one), Some(other)] = pair.map(row) else { continue };
            let mut at = 0;
            for_differing(one, other, nx, |cells, flags| {
                if is_asked(flags) {
                    unite(found, &mut at, [cells.start / 2, cells.end.div_ceil(2)]);
                }
            });
        }
    }

    /// The runs of a row of children: of the two of a cell, and before and behind them.
    fn row(&self, plane: usize, y: u32, row: u32) -> Option<&[u32]> {
        let (runs, ends) = self.planes[plane].as_ref()?;
        let at = (2 * y + row).checked_sub(1)? as usize;
        let end = *ends.get(at)?;
        let start = at.checked_sub(1).map_or(0, |before| ends[before]);
        Some(&runs[start as usize..end as usize])
    }
}

/// Adds the cells with a child at a surface where all rows, the first four of which are those of the children, have the same runs, shifted by less than a run; false, and nothing, where
/// they have not. Between the least and the greatest start of a run there is a surface in each cell, as each row touches another of these.
fn add_shifted(rows: &[&[u32]], nx: u32, is_asked: impl Fn([u8; 2]) -> bool, found: &mut Vec<[u32; 2]>) -> bool {
    let n_runs = rows[0].len();
    if rows.iter().any(|runs| runs.len() != n_runs) {
        return false;
    }
    let (mut last_flag, mut last_end, mut place) = (0, 0, 0);
    for at in 0..n_runs {
        let first = rows[0][at];
        // of runs with one flag the packed ones have the order of their cells
        let (mut low, mut high, mut differ) = (first, first, 0);
        for runs in &rows[1..4] {
            (low, high, differ) = (low.min(runs[at]), high.max(runs[at]), differ | (runs[at] ^ first));
        }
        let own = [run_cell(low).saturating_sub(1), (run_cell(high) + 1).min(nx)];
        for runs in &rows[4..] {
            (low, high, differ) = (low.min(runs[at]), high.max(runs[at]), differ | (runs[at] ^ first));
        }
        let ([start, end], flag) = ([low, high].map(run_cell), run_flag(first));
        if run_flag(differ) != 0 || start < last_end || start == 0 && end > 0 {
            found.clear();
            return false;
        }
        if end > 0 && is_asked([last_flag, flag]) {
            unite(found, &mut place, [start.min(own[0]) / 2, end.max(own[1]).div_ceil(2)]);
        }
        (last_flag, last_end) = (flag, end);
    }
    true
}
