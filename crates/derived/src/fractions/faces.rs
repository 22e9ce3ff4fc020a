//! The fraction of each face of a cell that a flag has.
//!
//! # Theory
//! Rays run in the planes of the faces: m to each face, each in the middle of a strip of it, along x, or along y for faces across x. A ray is exact
//! along itself. Where one line divides a face, lengths bend at two places at most; a strip is off by 1/4 for each bend in it, as `fractions.rs` has it. So the
//! fraction is off by at most 1 / 2 m. Of a convex part of a face each strip has a length between its ends; the lengths above any one are an interval of strips,
//! which is off by less than a strip: so the fraction is off by less than 1 / m.
//!
//! A cell is listed where it is cut, and where a face of it is not of its flag alone. So both cells beside a face have the same numbers of it, and cells that are not
//! listed are of one flag with all of their faces.
//!
//! Cost: a cast of 3 m times as many rays as the mesh has; while a part is made, 8 bytes for each flag of each run of faces that are alike.

use std::ops::Range;

use super::column::{Columns, Memory};
use super::cut::Cells;
use super::fraction::Fraction;
use super::refined::Refined;
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::window::CellWindow;
use hexcast_core::input::job::Rule;
use hexcast_core::stages::inside::Kind;

/// The faces of cells across x, y and z.
pub(super) struct Faces<'a> {
    columns: [Columns<'a>; 3],
    window: CellWindow,
}

impl<'a> Faces<'a> {
    /// Sorts the facets by faces.
    pub(super) fn new(
        (frame, lines): (&Frame, &Lines),
        window: CellWindow,
        m: u32,
        rule: (Rule, &'a [Kind]),
    ) -> Faces<'a> {
        let of_axis = |axis| Columns::new(Refined::of_faces(frame, lines, m, axis, &window), rule);
        Faces { columns: [0, 1, 2].map(of_axis), window }
    }

    /// Measures the faces of cells of some planes of the window across z, which are those of one row of a part.
    pub(super) fn of_planes(&self, planes: Range<u32>, memory: &mut Memory) -> FacesOfPlanes {
        let above = planes.end..planes.end + 1;
        let own = std::slice::from_ref(&planes);
        let runs = [
            Runs::new(&self.columns[0], own, memory),
            Runs::new(&self.columns[1], own, memory),
            Runs::new(&self.columns[2], &[planes.clone(), above], memory),
        ];
        let listed = Cells::new(&self.window, planes.end - planes.start);
        let mut faces = FacesOfPlanes { runs, listed, window: self.window, first_plane: planes.start };
        faces.list_divided(planes);
        faces
    }
}

/// The faces of cells of some planes.
pub(super) struct FacesOfPlanes {
    /// Across x, y and z.
    runs: [Runs; 3],
    /// Cells that are not of one flag with all of their faces, as far as is known.
    listed: Cells,
    window: CellWindow,
    first_plane: u32,
}

impl FacesOfPlanes {
    /// Lists the cells on both sides of faces across x that have several flags.
    fn list_divided(&mut self, planes: Range<u32>) {
        let CellWindow { first, end, .. } = self.window;
        let [nx, ny] = [0, 1].map(|axis| end[axis] - first[axis]);
        for z in planes {
            for face in 0..=nx {
                for (along, flags) in self.runs[0].of_column([face, z], first[1]..first[1] + ny) {
                    if flags.len() > 1 {
                        let beside = face.saturating_sub(1)..(face + 1).min(nx);
                        along.for_each(|y| self.listed.add([y - first[1], z - self.first_plane], beside.clone()));
                    }
                }
            }
        }
    }

    /// Lists those of some cells of one flag, all of a row, that are cut, and those with a face that is not of that flag alone; returns all that are
    /// listed.
    pub(super) fn with_unlike(&mut self, of_row: [u32; 2], cells: Range<u32>, flag: u8, cut: &Cells) -> &Cells {
        let [first_x, first_y, _] = self.window.first;
        let [y, z] = [of_row[0], self.first_plane + of_row[1]];
        let along = first_x + cells.start..first_x + cells.end;
        for (axis, column) in [(1, [y, z]), (1, [y + 1, z]), (2, [y, z]), (2, [y, z + 1])] {
            for (faces, flags) in self.runs[axis].of_column(column, along.clone()) {
                if flags != [(flag, 1.0)] {
                    self.listed.add(of_row, faces.start - first_x..faces.end - first_x);
                }
            }
        }
        // across x a whole face has another flag only where a wall lies in it: at the end of these cells, or where they are cut
        let of_cut = cut.of_row(of_row, cells.clone()).flat_map(|x| [x, x + 1]);
        for face in [cells.start, cells.end].into_iter().chain(of_cut) {
            if self.runs[0].at([face, z], first_y + y) != [(flag, 1.0)] {
                self.listed.add(of_row, face.saturating_sub(1).max(cells.start)..(face + 1).min(cells.end));
            }
        }
        cut.of_row(of_row, cells).for_each(|x| self.listed.add(of_row, x..x + 1));
        &self.listed
    }

    /// The fractions of cells, with one of 0 for each flag that only a face of the cell has; and for each of them those of the six faces: below and above
    /// along x, y, z.
    pub(super) fn with_all_flags(&self, fractions: &[Fraction]) -> (Vec<Fraction>, Vec<[f32; 6]>) {
        let [first_x, first_y, _] = self.window.first;
        let (mut all, mut faces) = (Vec::with_capacity(fractions.len()), Vec::with_capacity(fractions.len()));
        let mut flags: Vec<u8> = Vec::new();
        let of_flag = |of: &[(u8, f32)], flag: u8| of.iter().find(|of| of.0 == flag).map_or(0.0, |of| of.1);
        for of_cell in fractions.chunk_by(|one, other| one.cell == other.cell) {
            let cell = of_cell[0].cell;
            let [x, y, z] = self.window.cell(cell);
            // along themselves, rays begin where the box does
            let of_faces = [
                self.runs[0].at([x, z], first_y + y),
                self.runs[0].at([x + 1, z], first_y + y),
                self.runs[1].at([y, z], first_x + x),
                self.runs[1].at([y + 1, z], first_x + x),
                self.runs[2].at([y, z], first_x + x),
                self.runs[2].at([y, z + 1], first_x + x),
            ];
            flags.clear();
            flags.extend(of_cell.iter().map(|of| of.flag).chain(of_faces.iter().copied().flatten().map(|of| of.0)));
            flags.sort_unstable();
            flags.dedup();
            for &flag in &flags {
                let own = of_cell.iter().find(|of| of.flag == flag).map_or(0.0, |of| of.fraction);
                all.push(Fraction { cell, fraction: own, flag });
                faces.push(of_faces.map(|face| of_flag(face, flag)));
            }
        }
        (all, faces)
    }
}

/// Runs of faces that are alike, column after column.
struct Runs {
    first_row: u32,
    n_across: u32,
    /// First run of each column, then the end.
    offsets: Vec<u32>,
    /// Of each run the end of its faces in the column, and of its flags.
    ends: Vec<[u32; 2]>,
    /// Flags and their fractions.
    flags: Vec<(u8, f32)>,
}

impl Runs {
    fn new(columns: &Columns, rows: &[Range<u32>], memory: &mut Memory) -> Runs {
        let (mut offsets, mut ends, mut flags) = (Vec::new(), Vec::new(), Vec::new());
        let of_whole = 1.0 / columns.whole() as f64;
        for rows in rows {
            columns.rows(rows.clone(), memory, |_, faces, sums| {
                if faces.start == 0 {
                    offsets.push(ends.len() as u32);
                }
                let some = sums.iter().filter(|sum| sum.length() > 0);
                flags.extend(some.map(|sum| (sum.flag, (sum.length() as f64 * of_whole) as f32)));
                ends.push([faces.end, flags.len() as u32]);
            });
        }
        offsets.push(ends.len() as u32);
        Runs { first_row: rows[0].start, n_across: columns.counts()[0], offsets, ends, flags }
    }

    /// The runs of a column that some faces of it are in: which of these, and their flags.
    fn of_column(
        &self,
        [column, row]: [u32; 2],
        faces: Range<u32>,
    ) -> impl Iterator<Item = (Range<u32>, &[(u8, f32)])> {
        let column = ((row - self.first_row) * self.n_across + column) as usize;
        let runs = self.offsets[column] as usize..self.offsets[column + 1] as usize;
        let first = runs.start + self.ends[runs.clone()].partition_point(|[end, _]| *end <= faces.start);
        let mut start = faces.start;
        (first..runs.end).map_while(move |run| {
            let of_run = start..self.ends[run][0].min(faces.end);
            start = of_run.end;
            let first = run.checked_sub(1).map_or(0, |before| self.ends[before][1]);
            (!of_run.is_empty()).then(|| (of_run, &self.flags[first as usize..self.ends[run][1] as usize]))
        })
    }

    /// The flags of a face.
    fn at(&self, [column, row]: [u32; 2], along: u32) -> &[(u8, f32)] {
        let column = ((row - self.first_row) * self.n_across + column) as usize;
        let of_column = self.offsets[column] as usize..self.offsets[column + 1] as usize;
        let run = of_column.start + self.ends[of_column].partition_point(|[end, _]| *end <= along);
        let start = run.checked_sub(1).map_or(0, |before| self.ends[before][1]);
        &self.flags[start as usize..self.ends[run][1] as usize]
    }
}
