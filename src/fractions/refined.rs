//! The frame of the rays within cells.

use std::sync::Arc;

use crate::frame::{Frame, Scale, moved};
use crate::lines::Lines;
use crate::rays::Rays;

/// Bits of a length within a cell.
const BITS: u32 = 24;
/// The length of a cell.
pub(super) const WHOLE: i64 = 1 << BITS;
/// Bits of a place within a cell: it may be at its end.
pub(super) const PLACE_BITS: u32 = BITS + 1;

/// A frame in which cells are m times as many along each axis, of the same facets.
pub(super) struct Refined {
    pub(super) frame: Frame,
    pub(super) m: u32,
    /// Lines across x in units, where cells differ in size.
    lines: Option<Vec<f64>>,
    /// Line 0 in units and cells a unit along x, where all are equal.
    first: f64,
    per_size: f64,
}

impl Refined {
    pub(super) fn new(frame: &Frame, lines: &Lines, m: u32) -> Refined {
        let dims = frame.dims.map(|n| m * n);
        if !frame.is_graded() {
            let bits = frame.fraction_bits - m.trailing_zeros();
            // from the first centre within a cell to that of the cell
            let by = ((1i32 << frame.fraction_bits) - (1 << bits)) / 2;
            let facets = frame.facets.iter().map(|facet| moved(facet, [by; 3])).collect();
            let (rank_of_facet, ranks) = (frame.rank_of_facet.clone(), frame.ranks.clone());
            let frame = Frame { fraction_bits: bits, centres: None, dims, facets, rank_of_facet, ranks };
            let sizes = [bits, bits + m.trailing_zeros()].map(|bits| f64::from(1u32 << bits));
            return Refined { frame, m, lines: None, first: -0.5 * sizes[0], per_size: 1.0 / sizes[1] };
        }
        let (scale, factor) = (Scale::new(lines), f64::from(1u32 << frame.fraction_bits));
        let units = |axis: usize, world: f64| scale.units_from_world(axis, world) * factor;
        let centre = |axis: usize, index: u32| {
            let fraction = (f64::from(index % m) + 0.5) / f64::from(m);
            libm::rint(units(axis, lines.at(axis, f64::from(index / m) + fraction))) as i32
        };
        let centres = [0, 1, 2].map(|axis| (0..dims[axis]).map(|index| centre(axis, index)).collect());
        let frame = Frame { centres: Some(Arc::new(centres)), dims, ..frame.clone() };
        let list = lines.list(0).into_iter().map(|line| units(0, line)).collect();
        Refined { frame, m, lines: Some(list), first: 0.0, per_size: 1.0 }
    }

    /// Rays along x: their rows are those of the cells, in order.
    pub(super) fn rays(&self) -> Rays {
        Rays::new(0, self.frame.dims)
    }

    /// `cell << 25 | length in the cell before a place` along x; cell 0 and 0 before the first cell, the number of cells behind the last.
    #[inline(always)]
    pub(super) fn place(&self, at: f64) -> u64 {
        let n = (self.frame.dims[0] / self.m) as i32;
        let (cell, fraction) = match &self.lines {
            None => {
                let cells = (at - self.first) * self.per_size;
                let cell = (cells as i32).clamp(0, n);
                (cell, (cells - f64::from(cell)).clamp(0.0, 1.0))
            }
            Some(lines) => {
                let above = lines.partition_point(|&line| line <= at);
                match above {
                    0 => (0, 0.0),
                    _ if above == lines.len() => (n, 0.0),
                    _ => (above as i32 - 1, (at - lines[above - 1]) / (lines[above] - lines[above - 1])),
                }
            }
        };
        let left = ((1.0 - fraction) * WHOLE as f64 + 0.5) as i32;
        u64::from(cell as u32) << PLACE_BITS | u64::from((WHOLE as i32 - left).min(WHOLE as i32) as u32)
    }
}
