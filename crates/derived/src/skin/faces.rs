//! Faces between cells of different flags, as spans, and the rectangles that equal spans form.
//!
//! A level, a row of rays -> [`RowFaces`]. A row holds the rays of one index j on the second axis across. Three kinds of
//! faces belong to it: those where runs end (across the ray axis; spans lie along the row), those between neighbouring
//! rays of the row (spans lie along the rays), and those between it and the row before (likewise, already joined over
//! the row). A [`Sweep`] joins the spans of the first two kinds over the rows.
//!
//! Cost: O(runs of the row) for spans along the rays; the spans along the row are sorted, O(n log n).

use std::ops::Range;

use crate::mesh::level::Level;
use hexcast_core::cells::columns::{flag_at, run_cell, run_flag, spans};

/// Neighbouring faces of one flag, in one plane, of one row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct FaceSpan {
    /// Mesh line of the plane.
    pub(super) plane: u32,
    /// First cell.
    pub(super) start: u32,
    /// End of the cells (exclusive).
    pub(super) end: u32,
    /// Flag of the cells that the faces belong to.
    pub(super) flag: u8,
}

/// A rectangle: equal spans of consecutive rows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Quad {
    pub(super) span: FaceSpan,
    /// First row, and end of the rows (exclusive).
    pub(super) rows: [u32; 2],
}

/// Joins equal spans of consecutive rows.
#[derive(Debug, Default)]
pub(super) struct Sweep {
    /// Spans of the last row, and the row in which each began.
    open: Vec<(FaceSpan, u32)>,
    next: Vec<(FaceSpan, u32)>,
    /// Rectangles that a later row ended.
    pub(super) quads: Vec<Quad>,
}

impl Sweep {
    /// Takes the spans of the next row, ascending by plane and start.
    pub(super) fn push(&mut self, row: u32, spans: &[FaceSpan]) {
        let key = |span: &FaceSpan| (span.plane, span.start);
        let mut open = self.open.iter().peekable();
        let close = |&(span, first): &(FaceSpan, u32)| Quad { span, rows: [first, row] };
        for span in spans {
            let mut first = row;
            while let Some(last) = open.next_if(|(last, _)| key(last) <= key(span)) {
                if last.0 == *span {
                    first = last.1;
                } else {
                    self.quads.push(close(last));
                }
            }
            self.next.push((*span, first));
        }
        self.quads.extend(open.map(close));
        std::mem::swap(&mut self.open, &mut self.next);
        self.next.clear();
    }
}

/// The faces of one row of rays; of every pair the faces that look down their axis, then those that look up.
#[derive(Debug, Default)]
pub(super) struct RowFaces {
    /// Spans across the ray axis, then across the first axis across the rays, each ascending by plane and start.
    pub(super) spans: [[Vec<FaceSpan>; 2]; 2],
    /// Rectangles between the row before and this one.
    pub(super) between: [Vec<Quad>; 2],
    /// Number of faces.
    pub(super) n_faces: u64,
}

/// Finds the faces of a row; the row after the last has none but those between.
pub(super) fn row_faces(level: &Level, row: u32) -> RowFaces {
    let (now, before) = (level.row(row), row.checked_sub(1).map_or(Vec::new(), |row| level.row(row)));
    let mut faces = RowFaces { spans: [ends(level, &now), sides(level, &now)], ..RowFaces::default() };
    faces.n_faces = faces.spans.iter().flatten().flatten().map(|span| u64::from(span.end - span.start)).sum();
    let mut sweeps: [Sweep; 2] = Default::default();
    let mut spans: [Vec<FaceSpan>; 2] = Default::default();
    for (index, ray) in level.across[0].clone().enumerate() {
        let pair = [&before, &now].map(|rays| rays.get(index).copied().unwrap_or(&[]));
        facing(pair, &level.along, |side, start, end, flag| {
            spans[side].push(FaceSpan { plane: row, start, end, flag });
            faces.n_faces += u64::from(end - start);
        });
        for side in 0..2 {
            sweeps[side].push(ray, &spans[side]);
            spans[side].clear();
        }
    }
    faces.between = sweeps.map(|mut sweep| {
        sweep.push(level.across[0].end, &[]);
        sweep.quads
    });
    faces
}

/// Spans of faces between neighbouring rays of a row.
fn sides(level: &Level, rays: &[&[u32]]) -> [Vec<FaceSpan>; 2] {
    let mut spans: [Vec<FaceSpan>; 2] = Default::default();
    if rays.is_empty() {
        return spans;
    }
    for index in 0..=rays.len() {
        let left = if index == 0 { &[][..] } else { rays[index - 1] };
        let right = rays.get(index).copied().unwrap_or(&[]);
        let plane = level.across[0].start + index as u32;
        facing([left, right], &level.along, |side, start, end, flag| {
            spans[side].push(FaceSpan { plane, start, end, flag });
        });
    }
    spans
}

/// Finds the faces between the lower and the upper of two rays as spans along them: `found(side, start, end, flag)`
/// with side 0 for faces of the upper ray, which look down, and 1 for those of the lower, which look up.
fn facing(pair: [&[u32]; 2], along: &Range<u32>, mut found: impl FnMut(usize, u32, u32, u8)) {
    if pair[0] == pair[1] {
        return;
    }
    // by side: the upper ray first
    let rays = [pair[1], pair[0]];
    let mut at = along.start;
    let mut next = rays.map(|runs| runs.partition_point(|&run| run_cell(run) <= at));
    let mut flags = rays.map(|runs| flag_at(runs, at));
    let mut open = [(0u8, at); 2];
    loop {
        for side in 0..2 {
            let flag = if flags[0] == flags[1] { 0 } else { flags[side] };
            let (last, start) = open[side];
            if flag != last {
                if last != 0 {
                    found(side, start, at, last);
                }
                open[side] = (flag, at);
            }
        }
        if at == along.end {
            return;
        }
        let cell = |side: usize| rays[side].get(next[side]).map_or(along.end, |&run| run_cell(run));
        let cells = [cell(0), cell(1)];
        at = cells[0].min(cells[1]).min(along.end);
        if at == along.end {
            flags = [0; 2];
            continue;
        }
        for side in 0..2 {
            if cells[side] == at {
                flags[side] = run_flag(rays[side][next[side]]);
                next[side] += 1;
            }
        }
    }
}

/// Spans of faces where the runs of a row begin (these look down) and end (these look up).
fn ends(level: &Level, rays: &[&[u32]]) -> [Vec<FaceSpan>; 2] {
    // plane, ray and flag in the order they sort by; a plane takes 18 bits
    let face = |plane: u32, ray: u32, flag: u8| u64::from(plane) << 40 | u64::from(ray) << 8 | u64::from(flag);
    let mut faces: [Vec<u64>; 2] = Default::default();
    for (&runs, ray) in rays.iter().zip(level.across[0].clone()) {
        spans(runs, &level.along, |start, end, flag| {
            if flag != 0 {
                faces[0].push(face(start, ray, flag));
                faces[1].push(face(end, ray, flag));
            }
        });
    }
    faces.map(|mut faces| {
        faces.sort_unstable();
        let mut spans: Vec<FaceSpan> = Vec::new();
        for face in faces {
            let (plane, ray, flag) = ((face >> 40) as u32, (face >> 8) as u32, face as u8);
            match spans.last_mut() {
                Some(last) if (last.plane, last.end, last.flag) == (plane, ray, flag) => last.end += 1,
                _ => spans.push(FaceSpan { plane, start: ray, end: ray + 1, flag }),
            }
        }
        spans
    })
}
