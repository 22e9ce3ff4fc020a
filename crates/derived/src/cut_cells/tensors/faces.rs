//! How the permittivity of a cell changes from face to face, on the inner sides of its faces.

use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::parallel::*;
use hexcast_core::base::sort::sort_by_key;
use hexcast_core::grid::frame::{Frame, normal};
use hexcast_core::grid::window::CellWindow;

use super::smoothed::{OfFlags, Tensor, mean_of};
use crate::cut_cells::cut_cell::{CutPart, CutWanted};
use crate::cut_cells::measure::{CutBy, in_parts};

/// Two mirrors are a turn, which leaves facets facing out. In the first the faces below along x and y are above, in the second those along y and z.
const MIRRORS: [[bool; 3]; 2] = [[true, true, false], [false, true, true]];
/// Differences below this part of the contrast are rounding.
const ROUNDING: f64 = 1e-9;
/// What has less of a cell than this has nothing: sums are rounded.
const NOTHING: f64 = 1e-12;

/// What a face says of the permittivity: its mean there less that of the cell, by the largest contrast in the cell; and whether all flags have of the face what they have of the cell.
#[derive(Clone, Copy, Default)]
pub(super) struct OfFace {
    mean: f64,
    is_flat: bool,
}

/// A cell with several flags.
pub(super) struct Rise {
    pub(super) cell: u64,
    /// What lies outside metal.
    pub(super) parts: Vec<(f64, Tensor)>,
    pub(super) has_metal: bool,
    /// Whether these are of more than one permittivity.
    pub(super) is_mixed: bool,
    pub(super) is_sampled: bool,
    /// Below and above along x, then y, then z.
    faces: [OfFace; 6],
}

impl Rise {
    /// Those of a part.
    pub(super) fn of_part<'a>(part: &'a CutPart, eps: &'a OfFlags) -> impl Iterator<Item = Rise> + 'a {
        let mut first = 0;
        part.flags.chunk_by(|one, other| one.cell == other.cell).filter_map(move |of_cell| {
            let entries = first..first + of_cell.len();
            first = entries.end;
            // where one flag has all, that of the point says it
            if of_cell.iter().filter(|of| of.fraction > NOTHING).count() < 2 {
                return None;
            }
            let outside = |at: &usize| Some((part.flags[*at].fraction, eps[usize::from(part.flags[*at].flag)]?));
            let parts: Vec<(f64, Tensor)> = entries.clone().filter_map(|at| outside(&at)).collect();
            let has_metal = of_cell.iter().any(|of| of.fraction > NOTHING && eps[usize::from(of.flag)].is_none());
            let parts_of_faces = entries.filter(|at| outside(at).is_some()).map(|at| part.faces[at]);
            let (cell, is_sampled) = (of_cell[0].cell, of_cell[0].is_sampled);
            let mut rise =
                Rise { cell, parts: Vec::new(), has_metal, is_mixed: false, is_sampled, faces: Default::default() };
            rise.compare(&parts, parts_of_faces);
            rise.parts = parts.into_iter().filter(|(part, _)| *part > NOTHING).collect();
            Some(rise)
        })
    }

    /// Compares the faces of a cell with it, with what each substance has of both.
    fn compare(&mut self, parts: &[(f64, Tensor)], of_faces: impl Iterator<Item = [f64; 6]>) {
        let total: f64 = parts.iter().map(|(part, _)| part).sum();
        if total <= 0.0 {
            return;
        }
        let mut held = parts.iter().filter(|(part, _)| *part > NOTHING);
        let Some((_, first)) = held.next() else { return };
        self.is_mixed = held.any(|(_, of)| of != first);
        let against_mean = |values: &[f64]| {
            let mean = parts.iter().zip(values).map(|((part, _), value)| part * value).sum::<f64>() / total;
            let off: Vec<f64> = values.iter().map(|value| value - mean).collect();
            let held = off.iter().zip(parts).filter(|(_, (part, _))| *part > NOTHING);
            (held.map(|(off, _)| off.abs()).fold(0.0, f64::max), off, mean)
        };
        let numbers: Vec<f64> = parts.iter().map(|(_, of)| mean_of(of)).collect();
        let (mut contrast, mut off, mean) = against_mean(&numbers);
        if contrast < ROUNDING * mean {
            // crystals that are turned differ in nothing else
            let order = |of: &Tensor| parts.iter().position(|(_, other)| other == of).unwrap_or(0) as f64;
            (contrast, off, _) = against_mean(&parts.iter().map(|(_, of)| order(of)).collect::<Vec<f64>>());
        }
        let mut faces = [OfFace { mean: 0.0, is_flat: true }; 6];
        for (((part, _), off), of_faces) in parts.iter().zip(off).zip(of_faces) {
            for (face, fraction) in faces.iter_mut().zip(of_faces) {
                if contrast > 0.0 {
                    face.mean += fraction * off / contrast;
                }
                face.is_flat &= (fraction - part).abs() < ROUNDING;
            }
        }
        self.faces = faces;
    }

    /// The direction in which the permittivity rises, of length 1; None where it does not. `below` replaces the faces below.
    pub(super) fn normal(&self, below: Option<[OfFace; 3]>, size: [f64; 3]) -> Option<[f64; 3]> {
        let below = below.unwrap_or([0, 1, 2].map(|axis| self.faces[2 * axis]));
        let above = [0, 1, 2].map(|axis| self.faces[2 * axis + 1]);
        let change = [0, 1, 2].map(|axis| above[axis].mean - below[axis].mean);
        if change.iter().any(|of| of.abs() > ROUNDING) {
            let smallest = size.into_iter().fold(f64::INFINITY, f64::min);
            let rise = [0, 1, 2].map(|axis| change[axis] * (smallest / size[axis]));
            let length = rise.iter().map(|of| of * of).sum::<f64>().sqrt();
            return Some(rise.map(|of| of / length));
        }
        // a layer between the faces across one axis is the same along the others
        let is_flat = |axis: &usize| below[*axis].is_flat && above[*axis].is_flat;
        let mut across = (0..3).filter(|axis| !is_flat(axis));
        let (Some(axis), None) = (across.next(), across.next()) else { return None };
        Some([0, 1, 2].map(|of| f64::from(u8::from(of == axis))))
    }
}

/// The faces below cells from their inner sides, by index, ascending, where facets lie in faces.
pub(super) struct Below(Vec<(u64, [OfFace; 3])>);

/// Faces across the axes of a mirror, seen in it.
type Seen = Vec<(u64, [OfFace; 3])>;

impl Below {
    /// Those of a window.
    ///
    /// # Errors
    /// `memory`; `cancelled`.
    pub(super) async fn new(
        by: CutBy<'_>,
        window: CellWindow,
        eps: &OfFlags,
        (max_bytes, control): (u64, &Control),
    ) -> Result<Below> {
        let mut found: Seen = Vec::new();
        if !lies_in_faces(by.frame) {
            return Ok(Below(found));
        }
        for (nth, mirrors) in MIRRORS.into_iter().enumerate() {
            let frame = by.frame.clone().mirrored(mirrors);
            let turned = |one: [u32; 3], other: [u32; 3]| {
                [0, 1, 2].map(|axis| if mirrors[axis] { frame.dims[axis] - other[axis] } else { one[axis] })
            };
            let there =
                CellWindow { first: turned(window.first, window.end), end: turned(window.end, window.first), halo: 0 };
            let dims = window.dims();
            let index = |cell: u64| {
                let there = there.cell(cell);
                let place = |axis: usize| if mirrors[axis] { dims[axis] - 1 - there[axis] } else { there[axis] };
                window.index([0, 1, 2].map(|axis| place(axis) + window.first[axis]))
            };
            let above = |rise: Rise| (index(rise.cell), [1, 3, 5].map(|face| rise.faces[face]));
            let keep = |part: CutPart| Rise::of_part(&part, eps).map(above).collect::<Seen>();
            let left = max_bytes.saturating_sub(2 * size_of_val(&found[..]) as u64);
            let asked = CutWanted { faces: true, ..CutWanted::default() };
            let bytes_of = |seen: &Seen| 2 * size_of_val(&seen[..]);
            let seen = in_parts((CutBy { frame: &frame, ..by }, there), asked, left, control, (keep, bytes_of)).await?;
            let mut seen: Seen = seen.parts.into_iter().flatten().collect();
            no_room(2 * (size_of_val(&found[..]) + size_of_val(&seen[..])) as u64, max_bytes)?;
            sort_by_key(&mut seen, |(index, _)| *index);
            match nth {
                0 => found = seen,
                _ => add_last(&mut found, &seen),
            }
            control.rest().await?;
        }
        Ok(Below(found))
    }

    /// Those of a cell; None where no facet lies in a face, or it is not cut.
    pub(super) fn get(&self, cell: u64) -> Option<[OfFace; 3]> {
        self.0.binary_search_by_key(&cell, |(index, _)| *index).ok().map(|at| self.0[at].1)
    }

    pub(super) fn n_bytes(&self) -> u64 {
        size_of_val(&self.0[..]) as u64
    }
}

/// Gives cells the faces along z that the last mirror has, of those that both have.
fn add_last(found: &mut Seen, last: &[(u64, [OfFace; 3])]) {
    let mut last = last.iter().peekable();
    found.retain_mut(|(index, faces)| {
        while last.next_if(|(other, _)| other < index).is_some() {}
        let Some((_, of_last)) = last.next_if(|(other, _)| other == index) else { return false };
        faces[2] = of_last[2];
        true
    });
}

/// The error of too many points for the memory.
fn no_room(needed: u64, max_bytes: u64) -> Result<()> {
    if needed <= max_bytes {
        return Ok(());
    }
    let message = format!("smoothed permittivity takes {needed} bytes: {max_bytes} are left of the memory allowed");
    Err(Error::new("memory", message, "allow more with max_memory (--max-memory), or use larger cells"))
}

/// Whether a facet lies in a plane of faces.
fn lies_in_faces(frame: &Frame) -> bool {
    let faces = [0, 1, 2].map(|axis| (0..=frame.dims[axis]).map(|line| frame.face(axis, line)).collect::<Vec<i32>>());
    frame.facets.par_iter().any(|facet| {
        let [a, b, c] = facet;
        let lies_in =
            |axis: usize| a[axis] == b[axis] && a[axis] == c[axis] && faces[axis].binary_search(&a[axis]).is_ok();
        (0..3).any(lies_in) && normal(facet) != [0; 3]
    })
}
