//! The frame of the rays within cells.

use std::sync::Arc;

use crate::frame::{Frame, Places, Scale, moved};
use crate::lines::Lines;
use crate::rays::Rays;

/// A frame in which cells are m times as many along each axis, of the same facets.
pub(super) struct Refined {
    pub(super) frame: Frame,
    pub(super) m: u32,
    /// Lines across x in units, where cells differ in size.
    lines: Option<Vec<f64>>,
    /// Line 0 and the size of a cell along x in units, where all are equal.
    first: f64,
    size: f64,
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
            return Refined { frame, m, lines: None, first: -0.5 * sizes[0], size: sizes[1] };
        }
        let (scale, factor) = (Scale::new(lines), f64::from(1u32 << frame.fraction_bits));
        let units = |axis: usize, world: f64| scale.units_from_world(axis, world) * factor;
        let centre = |axis: usize, index: u32| {
            let fraction = (f64::from(index % m) + 0.5) / f64::from(m);
            libm::rint(units(axis, lines.at(axis, f64::from(index / m) + fraction))) as i32
        };
        let centres = [0, 1, 2].map(|axis| (0..dims[axis]).map(|index| centre(axis, index)).collect());
        let faces = frame.centres.as_ref().map_or_else(Default::default, |places| places.faces.clone());
        let frame = Frame { centres: Some(Arc::new(Places { centres, faces })), dims, ..frame.clone() };
        let list = lines.list(0).into_iter().map(|line| units(0, line)).collect();
        Refined { frame, m, lines: Some(list), first: 0.0, size: 1.0 }
    }

    /// Rays along x: their rows are those of the cells, in order.
    pub(super) fn rays(&self) -> Rays {
        Rays::new(0, self.frame.dims)
    }

    /// The cell of the mesh along x that holds a place, and the fraction of it before the place; None behind the last.
    pub(super) fn cell(&self, at: f64) -> Option<(u32, f64)> {
        let n = self.frame.dims[0] / self.m;
        match &self.lines {
            None => {
                let cells = (at - self.first) / self.size;
                let cell = cells.floor();
                if cell < 0.0 { Some((0, 0.0)) } else { (cell < n.into()).then_some((cell as u32, cells - cell)) }
            }
            Some(lines) => {
                let above = lines.partition_point(|&line| line <= at);
                match above {
                    0 => Some((0, 0.0)),
                    _ if above == lines.len() => None,
                    _ => Some((above as u32 - 1, (at - lines[above - 1]) / (lines[above] - lines[above - 1]))),
                }
            }
        }
    }
}
