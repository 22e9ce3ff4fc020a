//! The permittivity that stands for the cell around each point of E on a staggered grid.
//!
//! Snapped facets, the permittivity of each flag -> [`Tensors`].
//!
//! # Theory
//! The cell around a point of Ex reaches from line to line along x, and from centre to centre along y and z: it is a cell of a frame that is moved by half cells. Its fractions are those of
//! the cut cells of this group, its permittivity is that of `tensors/smoothed.rs`. The normal is the direction in which the mean permittivity
//! of such a cell rises where it is moved: for each axis what the face above has more than that below. By Gauss's theorem that is the interface in the cell, as a
//! vector, each piece of it weighted by the step of the permittivity there. So overlaps, and bodies that touch, need no rule of their own.
//!
//! *Ties.* What lies in the face below a cell belongs to that cell, and its fraction there is that of the other side. The inner side is seen in mirrors, in which this
//! face is above (`faces.rs`). Where no facet lies in a face there is one pass.
//!
//! *No normal.* A layer across an axis that lies between two faces has the normal of this axis; else what cancels has none, and the mean is taken.
//!
//! *Metal* has no permittivity. The means are those of what lies outside it; a cell within metal has 1, where E is 0.
//!
//! Source: Farjadpour et al. (2006); Kottke, Farjadpour and Johnson (2008). To take the normal from faces is ours; Meep finds it by quadrature on a sphere.
//! Cost: that of the cut cells with faces for each component, up to three times; 56 bytes a point that is cut.
//!
//! Out of scope: conductivity, permeability, and what a shell or a sheet without volume would do to fields.

mod faces;
mod smoothed;

use std::ops::Range;

use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::cells::columns::Columns;
use hexcast_core::cells::flags::{CellBox, flags_of_box};
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::window::CellWindow;

use super::cut_cell::{CutPart, CutWanted};
use super::measure::{CutBy, in_parts};
use crate::staggered::COMPONENTS;
use faces::{Below, Rise};
use smoothed::smoothed;
pub use smoothed::{OfFlags, Tensor, isotropic};

/// The smoothed permittivity at the points of E.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Tensors {
    /// Those of Ex, Ey and Ez.
    pub parts: Vec<Permittivity>,
    /// The cell that the first points are those of, counted in the box: 0 but for windows.
    pub origin: [u32; 3],
    /// What they are, counted.
    pub counts: TensorCounts,
}

/// Points, counted: those on the last line along an axis only where that is the last of the box, so that those of windows add up.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct TensorCounts {
    /// Points around which lies more than one permittivity.
    pub cut_points: u64,
    /// Those of which no normal is known, so that they have the mean.
    pub without_normal: u64,
    /// Points around which rays measure, as a surface passes through itself there.
    pub sampled_points: u64,
}

/// The permittivity at the points of a component.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Permittivity {
    /// Such as "Ex".
    pub name: &'static str,
    /// By index, x fastest, where the flag of the point does not say it.
    cut: Vec<(u64, Tensor)>,
    /// 0, or rank + 1 of the geometry.
    codes: Columns,
    of_code: Vec<Tensor>,
}

impl Permittivity {
    /// Number of points on each axis.
    pub fn dims(&self) -> [u32; 3] {
        self.codes.dims()
    }

    /// Bytes of the points that are cut.
    #[doc(hidden)]
    pub fn n_bytes(&self) -> u64 {
        size_of_val(&self.cut[..]) as u64
    }

    /// The relative permittivity of a box of points, x fastest: xx, yy, zz, yz, xz, xy of each.
    ///
    /// # Errors
    /// `io` where the flags of points are in a store that fails.
    pub fn tensors(&self, some: &CellBox) -> Result<Vec<Tensor>> {
        let codes = flags_of_box(&self.codes, some)?;
        let mut tensors: Vec<Tensor> = codes.into_iter().map(|code| self.of_code[usize::from(code)]).collect();
        let within = CellWindow::all(self.dims());
        let [nx, ny] = [0, 1].map(|axis| some[axis].len());
        let Range { start, end } = some[2];
        let [start, end] = [start, end].map(|plane| {
            let first = u64::from(plane) * u64::from(within.end[0]) * u64::from(within.end[1]);
            self.cut.partition_point(|(at, _)| *at < first)
        });
        for &(index, tensor) in &self.cut[start..end] {
            let place = within.cell(index);
            if (0..3).all(|axis| some[axis].contains(&place[axis])) {
                let [x, y, z] = [0, 1, 2].map(|axis| (place[axis] - some[axis].start) as usize);
                tensors[x + nx * (y + ny * z)] = tensor;
            }
        }
        Ok(tensors)
    }
}

impl Tensors {
    /// The points of all components; they begin at a cell.
    #[doc(hidden)]
    pub fn new(parts: Vec<Permittivity>, origin: [u32; 3], counts: TensorCounts) -> Tensors {
        Tensors { parts, origin, counts }
    }
}

/// Finds the permittivity at the points of a component, 0 to 2, that some cells of the box have. The frame of `by` is that of the cells around all points
/// ([`hexcast_core::grid::frame::Frame::around_faces`]), its lines are those of the box; `codes` has rank + 1 at these points.
///
/// # Errors
/// `memory` where they would take more than `max_bytes`; `cancelled`.
pub async fn permittivity(
    by: CutBy<'_>,
    (component, [first, end]): (usize, [[u32; 3]; 2]),
    (eps, codes): (&OfFlags, Columns),
    (max_bytes, control): (u64, &Control),
) -> Result<(Permittivity, TensorCounts)> {
    let (name, is_moved) = COMPONENTS[component];
    let box_end = by.frame.dims;
    let lines = around_points(by.lines, is_moved)?;
    let by = CutBy { lines: &lines, ..by };
    let end = [0, 1, 2].map(|axis| end[axis] + u32::from(is_moved[axis]));
    let window = CellWindow { first, end, halo: 0 };
    // those on the last line are counted by the window behind
    let is_counted = |point: [u32; 3]| {
        (0..3).all(|axis| !is_moved[axis] || end[axis] == box_end[axis] || point[axis] + 1 < end[axis] - first[axis])
    };
    let below = Below::new(by, window, eps, (max_bytes, control)).await?;
    let find = |part: CutPart| found_in(&part, (window, &lines), (eps, &below), &is_counted);
    let bytes_of = |(cut, _): &Found| 2 * size_of_val(&cut[..]);
    let left = max_bytes.saturating_sub(below.n_bytes());
    let asked = CutWanted { faces: true, ..CutWanted::default() };
    let found = in_parts((by, window), asked, left, control, (find, bytes_of)).await?;
    let (mut cut, mut counts) = (Vec::new(), TensorCounts::default());
    for (of_part, more) in found.parts {
        cut.extend(of_part);
        counts.add(more);
    }
    let of_flags = [0].iter().chain(&by.frame.ranks.flag_of_rank);
    let of_code = of_flags.map(|flag| eps[usize::from(*flag)].unwrap_or(isotropic(1.0))).collect();
    Ok((Permittivity { name, cut, codes, of_code }, counts))
}

impl TensorCounts {
    /// Adds those of other points.
    pub fn add(&mut self, more: TensorCounts) {
        self.cut_points += more.cut_points;
        self.without_normal += more.without_normal;
        self.sampled_points += more.sampled_points;
    }
}

/// Points by index, ascending, and what they are.
type Found = (Vec<(u64, Tensor)>, TensorCounts);

/// The permittivity at points around which the cells of a part lie.
fn found_in(
    part: &CutPart,
    (window, lines): (CellWindow, &Lines),
    (eps, below): (&OfFlags, &Below),
    is_counted: &impl Fn([u32; 3]) -> bool,
) -> Found {
    let (mut cut, mut counts) = (Vec::new(), TensorCounts::default());
    for rise in Rise::of_part(part, eps) {
        let point = window.cell(rise.cell);
        let counted = u64::from(is_counted(point));
        counts.sampled_points += u64::from(rise.is_sampled) * counted;
        if !rise.is_mixed {
            // of the rest, next to metal
            if rise.has_metal {
                cut.push((rise.cell, smoothed(&rise.parts, None)));
            }
            continue;
        }
        let cell = [0, 1, 2].map(|axis| point[axis] + window.first[axis]);
        let normal = rise.normal(below.get(rise.cell), [0, 1, 2].map(|axis| lines.cell_size(axis, cell[axis])));
        counts.cut_points += counted;
        counts.without_normal += counted * u64::from(normal.is_none());
        cut.push((rise.cell, smoothed(&rise.parts, normal)));
    }
    (cut, counts)
}

/// The lines between the cells around points: in the middles between lines along some axes. Beyond the ends they are mirror images.
///
/// # Errors
/// `job-value` where lengths are too large.
fn around_points(lines: &Lines, is_moved: [bool; 3]) -> Result<Lines> {
    let more = [0, 1, 2].map(|axis| u32::from(is_moved[axis]));
    if let Some(size) = lines.spacing() {
        let origin = [0, 1, 2].map(|axis| lines.origin()[axis] - 0.5 * f64::from(more[axis]) * size[axis]);
        return Lines::new(origin, size, [0, 1, 2].map(|axis| lines.dims()[axis] + more[axis]));
    }
    let list = |axis: usize| {
        let of_axis = lines.list(axis);
        if !is_moved[axis] {
            return of_axis;
        }
        let mut middles: Vec<f64> = of_axis.windows(2).map(|two| 0.5 * (two[0] + two[1])).collect();
        let (before, behind) =
            (2.0 * of_axis[0] - middles[0], 2.0 * of_axis[of_axis.len() - 1] - middles[middles.len() - 1]);
        middles.insert(0, before);
        middles.push(behind);
        middles
    };
    Lines::from_lists([0, 1, 2].map(list))
}
