//! Plates: geometries without thickness, whose facets all lie in one plane across an axis, as the faces of cells that they cover.
//!
//! A plate has no cell. Files of solvers whose conductors may be faces have its faces ([`Mesh::plates`](hexcast_derived::mesh::Mesh::plates)), which are found as
//! those of sheets of a staggered grid are: a face is one of the plate if the plate crosses the link between the centres of its two cells.
//! Where two geometries meet the higher rank wins: of two plates on a face that one; and a face between two cells of higher ranks is covered. Between a
//! cell of a higher rank and one of none the face stays: a strip on a board is not in it. Cells know flags, not ranks: where geometries of
//! several ranks have a flag, its lowest counts, so that no metal is lost.
//!
//! Cost: nothing without plates; else a cast along each axis that has some, on the CPU, and 256 bytes a face. A window with plates is meshed once more with its
//! neighbours.

use super::halo::Beyond;
use super::prepare::Prepared;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::base::finding::Finding;
use hexcast_core::cells::columns::Columns;
use hexcast_core::grid::frame::{Ends, Frame};
use hexcast_core::input::geometry::{Fill, Geometry};
use hexcast_derived::staggered::{Coded, SheetFace, crossed_faces, highest, under};

/// The faces of plates across each axis, counted from the first cell that is meshed, with rank + 1.
pub(super) struct Plates {
    across: [Vec<Coded>; 3],
    flag_of_rank: Vec<u8>,
    geometry_of_rank: Vec<usize>,
}

impl Plates {
    /// Those of the cells that are meshed; `ends` are those of each position.
    ///
    /// # Errors
    /// `cancelled`; `memory` where the faces would take more than `max_bytes`.
    pub(super) fn new(
        frame: &Frame,
        ends: &[Ends],
        prepared: &Prepared,
        (max_bytes, control): (u64, &Control),
    ) -> Result<Option<Plates>> {
        let axis_of = |position: usize| {
            let geometry = &prepared.geometries[frame.ranks.geometry_at[position]];
            let [low, high] = ends[position].filter(|_| is_plain(geometry))?;
            (0..3).find(|&axis| low[axis] == high[axis])
        };
        let axes: Vec<Option<usize>> = (0..ends.len()).map(axis_of).collect();
        if axes.iter().all(Option::is_none) {
            return Ok(None);
        }
        let cells = prepared.window.unwrap_or([[0; 3], prepared.whole.dims()]);
        let mut across = [const { Vec::new() }; 3];
        for (axis, faces) in across.iter_mut().enumerate().filter(|(axis, _)| axes.contains(&Some(*axis))) {
            let some = frame.with_some(|position| axes[position] == Some(axis));
            *faces = highest(crossed_faces((&some, cells), axis, (max_bytes / 3, control))?);
        }
        let mut geometry_of_rank = vec![0; frame.ranks.flag_of_rank.len()];
        for (&rank, &index) in frame.ranks.rank_at.iter().zip(&frame.ranks.geometry_at) {
            geometry_of_rank[usize::from(rank)] = index;
        }
        Ok(Some(Plates { across, flag_of_rank: frame.ranks.flag_of_rank.clone(), geometry_of_rank }))
    }

    /// The faces that no cells cover, counted from the first cell of the mesh, and a finding for each plate and flag that covers some of it. The columns have
    /// the neighbours of the cells that are meshed, too; `first` is the first of their cells, counted in the box.
    ///
    /// # Errors
    /// `io` where columns are in a store that fails.
    pub(super) fn uncovered(
        self,
        (columns, first): (&Columns, [u32; 3]),
        prepared: &Prepared,
        beyond: &Beyond,
    ) -> Result<(Vec<SheetFace>, Vec<Finding>)> {
        let (mut faces, mut covers) = (Vec::new(), Vec::new());
        let start = prepared.window.map_or([0; 3], |[first, _]| first);
        for (axis, found) in self.across.iter().enumerate() {
            let last = prepared.whole.dims()[axis] - 1;
            // at the ends of the box both are the same cell
            let beside = |side: u32| {
                let cell = |face: &Coded| {
                    let mut cell = [0, 1, 2].map(|of| face.0[of] + start[of]);
                    cell[axis] = (cell[axis] + side).saturating_sub(1).min(last);
                    ([0, 1, 2].map(|of| cell[of] - first[of]), 0)
                };
                under(columns, &found.iter().map(cell).collect::<Vec<Coded>>())
            };
            let both = beside(0)?.into_iter().zip(beside(1)?);
            for (&(face, code), (before, behind)) in found.iter().zip(both) {
                let rank = usize::from(code) - 1;
                if [before, behind].into_iter().all(|flag| self.lowest_rank(flag).is_some_and(|lowest| lowest > rank)) {
                    covers.extend([(rank, before), (rank, behind)]);
                } else {
                    faces.push(SheetFace::new(axis as u8, beyond.moved(face), self.flag_of_rank[rank]));
                }
            }
        }
        let geometries = &prepared.geometries;
        covers.sort_unstable();
        covers.dedup();
        let finding = |(rank, flag): (usize, u8)| {
            let cover = geometries.iter().position(|geometry| geometry.flag == flag).unwrap_or_default();
            covered(geometries, self.geometry_of_rank[rank], cover)
        };
        Ok((faces, covers.into_iter().map(finding).collect()))
    }

    fn lowest_rank(&self, flag: u8) -> Option<usize> {
        self.flag_of_rank.iter().position(|of_rank| *of_rank == flag && flag > 0)
    }
}

/// Whether a flat geometry is a plate: inverted it holds all cells, and filled it has some.
fn is_plain(geometry: &Geometry) -> bool {
    geometry.fill == Fill::Centre && !geometry.invert
}

fn covered(geometries: &[Geometry], plate: usize, cover: usize) -> Finding {
    let [Geometry { name, flag, .. }, Geometry { name: other, .. }] = [plate, cover].map(|index| &geometries[index]);
    let sentence = format!(
        "faces of the plate \"{name}\" (flag {flag}) lie within \"{other}\", which wins: files of solvers do not have them; give the plate a higher \
         priority"
    );
    let found =
        Finding::new("plate-covered", sentence).of_geometry(plate, name).and_geometry(cover, other).of_flag(*flag);
    geometries[plate].bounding_box().into_iter().fold(found, Finding::within)
}
