//! Where the centres of cells are in the frame.
//!
//! Of equal cells the centre of cell i is the integer `i * 2^F`; of listed lines it is `round(u * 2^F)` like any other place, from a table.
//! u is counted from the centre of cell 0 in sizes of the smallest cell of the axis, so neighbouring centres are at least `2^F - 1`
//! units from each other.

use std::sync::Arc;

use crate::lines::Lines;

/// Centres of all cells of each axis, ascending from 0.
pub type Centres = Arc<[Vec<i32>; 3]>;

/// How places are counted: from the centre of cell 0, in cells of the smallest size.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Scale {
    origin: [f64; 3],
    unit: [f64; 3],
    /// From line 0 to the centre of cell 0.
    half: [f64; 3],
}

impl Scale {
    pub(crate) fn new(lines: &Lines) -> Scale {
        let (origin, unit) = (lines.origin(), lines.smallest());
        Scale { origin, unit, half: [0, 1, 2].map(|axis| 0.5 * (lines.cell_size(axis, 0) / unit[axis])) }
    }

    #[inline(always)]
    pub(crate) fn units_from_world(&self, axis: usize, world: f64) -> f64 {
        (world - self.origin[axis]) / self.unit[axis] - self.half[axis]
    }

    pub(crate) fn world_from_units(&self, axis: usize, units: f64) -> f64 {
        self.origin[axis] + (units + self.half[axis]) * self.unit[axis]
    }
}

/// The centres of listed lines; None where cells are equal.
pub(super) fn centres(lines: &Lines, scale: &Scale, fraction_bits: u32) -> Option<Centres> {
    let factor = f64::from(1u32 << fraction_bits);
    let centre = |axis: usize, cell: u32| {
        let middle = 0.5 * (lines.line(axis, cell) + lines.line(axis, cell + 1));
        libm::rint(scale.units_from_world(axis, middle) * factor) as i32
    };
    let of_axis = |axis: usize| (0..lines.dims()[axis]).map(|cell| centre(axis, cell)).collect();
    lines.is_graded().then(|| Arc::new([0, 1, 2].map(of_axis)))
}
