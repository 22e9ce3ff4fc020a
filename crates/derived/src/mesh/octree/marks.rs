//! Which cells are halved for what is asked for: at surfaces, and in boxes.

use hexcast_core::base::error::Result;
use hexcast_core::cells::columns::{Columns, run_cell, run_flag};
use hexcast_core::cells::flags::CellBox;

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
    /// Adds the cells of a row that are halved, as runs in any order.
    pub(super) fn add(&mut self, [y, z]: [u32; 2], found: &mut Vec<[u32; 2]>) {
        let Marks { wanted, level, has_surfaces, .. } = *self.marks;
        // cells of level 0 in one of this level
        let shift = u32::from(level) - 1;
        for (of, _) in wanted.boxes.iter().filter(|(_, finest)| *finest >= level) {
            if of[1].contains(&(y >> shift)) && of[2].contains(&(z >> shift)) {
                found.push([of[0].start << shift, of[0].end << shift]);
            }
        }
        if has_surfaces {
            self.add_surfaces(y, found);
        }
    }

    fn add_surfaces(&self, y: u32, found: &mut Vec<[u32; 2]>) {
        let Marks { wanted, level, columns, .. } = self.marks;
        let nx = columns.dims()[0];
        let is_asked = |one: u8, other: u8| {
            wanted.level_of_flag[usize::from(one)].max(wanted.level_of_flag[usize::from(other)]) == *level
        };
        let rows = [0, 1, 2, 3].map(|plane| [0, 1, 2, 3].map(|row| self.row(plane, y, row)));
        for plane in [1, 2] {
            for row in [1, 2] {
                let Some(runs) = rows[plane][row] else { continue };
                let mut before = 0;
                for &run in runs {
                    let (cell, flag) = (run_cell(run), run_flag(run));
                    if cell > 0 && is_asked(before, flag) {
                        found.push([(cell - 1) / 2, cell / 2 + 1]);
                    }
                    before = flag;
                }
            }
        }
        // pairs of rows that touch, one of which at least is of children of this row
        let of_y = [0, 1, 2].into_iter().flat_map(|row| [1, 2].map(|plane| [[plane, row], [plane, row + 1]]));
        let of_z = [0, 1, 2].into_iter().flat_map(|plane| [1, 2].map(|row| [[plane, row], [plane + 1, row]]));
        for pair in of_y.chain(of_z) {
            let [Some(one), Some(other)] = pair.map(|[plane, row]| rows[plane][row]) else { continue };
            differences(one, other, nx, |start, end, flags| {
                if is_asked(flags[0], flags[1]) {
                    found.push([start / 2, end.div_ceil(2)]);
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

/// Where two rows of cells have other flags: the first cell, the end, and both flags.
fn differences(one: &[u32], other: &[u32], nx: u32, mut found: impl FnMut(u32, u32, [u8; 2])) {
    if one == other {
        return;
    }
    let (mut start, mut flags) = (0, [0; 2]);
    let mut rest = [one, other];
    while start < nx {
        let next = rest.map(|runs| runs.first().map_or(nx, |run| run_cell(*run)));
        let end = next[0].min(next[1]);
        if start < end && flags[0] != flags[1] {
            found(start, end, flags);
        }
        for side in [0, 1] {
            if let Some((&run, behind)) = rest[side].split_first().filter(|(run, _)| run_cell(**run) == end) {
                (flags[side], rest[side]) = (run_flag(run), behind);
            }
        }
        start = end;
    }
}
