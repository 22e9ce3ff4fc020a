//! Where the centres of cells are in the frame.
//!
//! Of equal cells the centre of cell i is the integer `i * 2^F`; of listed lines it is `round(u * 2^F)` like any other place, from a table.
//! u is counted from the centre of cell 0 in sizes of the smallest cell of the axis, so neighbouring centres are at least `2^F - 1`
//! units from each other.

use std::sync::Arc;

use super::Frame;
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

impl Frame {
    /// Whether cells differ in size.
    pub fn is_graded(&self) -> bool {
        self.centres.is_some()
    }

    /// Centre of a cell along an axis, in units.
    #[inline(always)]
    pub fn centre(&self, axis: usize, cell: u32) -> i32 {
        match &self.centres {
            None => (cell << self.fraction_bits) as i32,
            Some(centres) => centres[axis][cell as usize],
        }
    }

    /// Size of the cells along an axis on average, in units.
    pub(crate) fn mean_cell(&self, axis: usize) -> f64 {
        let unit = f64::from(1u32 << self.fraction_bits);
        match self.centres.as_ref().map(|centres| &centres[axis]) {
            Some(centres) if centres.len() > 1 => f64::from(centres[centres.len() - 1]) / (centres.len() - 1) as f64,
            _ => unit,
        }
    }

    /// Number of cells of an axis whose centres lie below a place, or at it if `with_at`.
    #[inline(always)]
    pub(crate) fn n_below(&self, axis: usize, place: i32, with_at: bool) -> u32 {
        let place = i64::from(place) + i64::from(with_at);
        match &self.centres {
            None => {
                let cells = (place + (1 << self.fraction_bits) - 1) >> self.fraction_bits;
                cells.clamp(0, self.dims[axis].into()) as u32
            }
            Some(centres) => centres[axis].partition_point(|&centre| i64::from(centre) < place) as u32,
        }
    }

    /// The centres of some cells, counted from that of the first.
    pub(super) fn centres_of(&self, [first, end]: [[u32; 3]; 2]) -> Option<Centres> {
        let centres = self.centres.as_ref()?;
        let of_axis = |axis: usize| {
            let some = &centres[axis][first[axis] as usize..end[axis] as usize];
            some.iter().map(|centre| centre - some[0]).collect()
        };
        Some(Arc::new([0, 1, 2].map(of_axis)))
    }
}
