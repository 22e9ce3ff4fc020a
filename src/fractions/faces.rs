//! The fraction of each face of a cell that a flag has.
//!
//! # Theory
//! Rays run in the planes of the faces: m to each face, each in the middle of a strip of it, along x, or along y for faces across x. A ray is exact
//! along itself. Where one line divides a face, lengths bend at two places at most; a strip is off by 1/4 for each bend in it, as `fractions.rs` has it. So the
//! fraction is off by at most 1 / 2 m. Both cells beside a face have the same numbers of it.
//!
//! Cost: a cast of 3 m times as many rays as the mesh has; while a part is made, 8 bytes for each flag of each run of faces that are alike.

use std::ops::Range;

use super::column::Columns;
use super::fraction::Fraction;
use super::refined::Refined;
use crate::frame::Frame;
use crate::inside::Kind;
use crate::job::Rule;
use crate::lines::Lines;
use crate::window::CellWindow;

/// The faces of cells across x, y and z.
pub(super) struct Faces<'a> {
    columns: [Columns<'a>; 3],
    window: CellWindow,
}

impl<'a> Faces<'a> {
    /// Sorts the facets by rows of faces, so many together.
    pub(super) fn new(
        (frame, lines): (&Frame, &Lines),
        window: CellWindow,
        m: u32,
        rows: u32,
        rule: (Rule, &'a [Kind]),
    ) -> Faces<'a> {
        let of_axis = |axis| Columns::new(Refined::of_faces(frame, lines, m, axis, &window), rows, rule);
        Faces { columns: [0, 1, 2].map(of_axis), window }
    }

    /// For each fraction of cells of some planes of the window across z, that of its flag in the six faces: below and above along x, y, z. The planes are
    /// those of one row of bins.
    pub(super) fn of(&self, fractions: &[Fraction], planes: Range<u32>) -> Vec<[f32; 6]> {
        let [first_x, first_y, _] = self.window.first;
        let above = planes.end..planes.end + 1;
        let own = std::slice::from_ref(&planes);
        let runs = [
            Runs::new(&self.columns[0], own),
            Runs::new(&self.columns[1], own),
            Runs::new(&self.columns[2], &[planes.clone(), above]),
        ];
        let mut faces = Vec::with_capacity(fractions.len());
        for of_cell in fractions.chunk_by(|one, other| one.cell == other.cell) {
            let [x, y, z] = self.window.cell(of_cell[0].cell);
            // along themselves, rays begin where the box does
            let flags = [
                runs[0].at([x, z], first_y + y),
                runs[0].at([x + 1, z], first_y + y),
                runs[1].at([y, z], first_x + x),
                runs[1].at([y + 1, z], first_x + x),
                runs[2].at([y, z], first_x + x),
                runs[2].at([y, z + 1], first_x + x),
            ];
            faces.extend(of_cell.iter().map(|of| {
                flags.map(|face| face.iter().find(|(flag, _)| *flag == of.flag).map_or(0.0, |(_, fraction)| *fraction))
            }));
        }
        faces
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
    fn new(columns: &Columns, rows: &[Range<u32>]) -> Runs {
        let (mut offsets, mut ends, mut flags) = (Vec::new(), Vec::new(), Vec::new());
        let of_whole = 1.0 / columns.whole() as f64;
        for rows in rows {
            columns.rows(rows.clone(), |_, faces, sums| {
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

    /// The flags of a face.
    fn at(&self, [column, row]: [u32; 2], along: u32) -> &[(u8, f32)] {
        let column = ((row - self.first_row) * self.n_across + column) as usize;
        let of_column = self.offsets[column] as usize..self.offsets[column + 1] as usize;
        let run = of_column.start + self.ends[of_column].partition_point(|[end, _]| *end <= along);
        let start = run.checked_sub(1).map_or(0, |before| self.ends[before][1]);
        &self.flags[start as usize..self.ends[run][1] as usize]
    }
}
