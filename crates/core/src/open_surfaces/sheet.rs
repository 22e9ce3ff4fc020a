//! Sheets: the cells along the surface of a geometry, which a thin wall has even where it holds no centre of a cell.
//!
//! # Theory
//! A geometry has the cells whose centres lie inside of it. [`Fill`] may add those along its surface:
//!
//! - `conservative`: every cell whose closed box the surface touches (`touched`). A surface on the face between two cells touches
//!   both.
//! - `separating`: every cell that the surface crosses on one of three segments, from face to face through its centre along each
//!   axis. A step from a cell to its face neighbour goes along the half of such a segment of each; where the surface crosses the
//!   step one of both is in the sheet. So no path of face neighbours outside of the sheet crosses the surface. These crossings are
//!   those of the rays of three axes, with the same rule for ties, half a cell on: a ray crosses in the cell whose centre is nearest.
//!
//! # Practice
//! All of it is in whole numbers, so that the cells are the same whoever meshes and along whatever axis.
//! Degenerate cases: the surface need not be closed, and may have no thickness. Parts outside of the domain have no cell.
//! Cost: `separating` three casts and 8 bytes a crossing; `conservative` 44 bytes a facet, and a few intervals for each.

use std::ops::Range;

use crate::base::parallel::*;
use crate::cells::columns::{Band, run};
use crate::grid::frame::{Frame, SnappedFacet};
use crate::grid::rays::Rays;
use crate::input::geometry::Fill;
use crate::stages::axis_crossings::{
    AxisCasts, AxisCrossings, Words, bit_of_axis, grouped, of_planes, place_of, plane_of, row_of,
};

mod touched;

use touched::Touched;

/// The cells along a surface.
pub(crate) struct Sheet {
    rays: Rays,
    cells: Cells,
}

enum Cells {
    /// Facets, each with the rows of rays of the cells that it touches.
    Touched { facets: Vec<(Range<u32>, SnappedFacet)>, frame: Box<Frame> },
    /// Cells as crossings of the mesh's rays.
    Crossed(Words),
}

impl Sheet {
    /// The rays that decide the sheet of some facets of a frame.
    ///
    /// With faces in the place of centres, a crossing in cell i is above the face below it and below the next; so its first face above is
    /// i + 1. There is one face more than cells, which tells those beyond the domain, and 0 those before.
    pub(crate) fn casts(facets: &[SnappedFacet], fill: Fill, frame: &Frame) -> Vec<AxisCasts> {
        let cast = |axis: usize| AxisCasts {
            frame: frame.with_facets(facets.to_vec()).around_faces([0, 1, 2].map(|other| other == axis)),
            axes: vec![(axis, false)],
        };
        if fill == Fill::Separating { [0, 1, 2].map(cast).into() } else { Vec::new() }
    }

    /// The sheet of some facets of a frame, by what [`Sheet::casts`] asked for.
    pub(crate) fn new(
        facets: &[SnappedFacet],
        fill: Fill,
        crossings: Vec<AxisCrossings>,
        frame: &Frame,
        rays: &Rays,
    ) -> Sheet {
        let cells = if fill == Fill::Conservative {
            let with_rows = |facet: &SnappedFacet| {
                let rows = Touched::new(facet, frame, rays)?.cells[1].clone();
                Some((*rows.start() as u32..*rows.end() as u32 + 1, *facet))
            };
            let facets = facets.par_iter().filter_map(with_rows).collect();
            Cells::Touched { facets, frame: Box::new(frame.with_facets(Vec::new())) }
        } else {
            let of_axis = |(axis, crossings): (usize, AxisCrossings)| {
                let bit = bit_of_axis(axis, rays);
                let is_within = |word: &u64| (1..=u64::from(frame.dims[axis])).contains(&(word >> bit & 0x3_ffff));
                crossings.words.into_iter().filter(is_within).map(|word| word - (1 << bit)).collect::<Words>()
            };
            Cells::Crossed(grouped(&crossings.into_iter().enumerate().map(of_axis).collect::<Vec<_>>()))
        };
        Sheet { rays: *rays, cells }
    }

    /// Bytes that it holds.
    pub(crate) fn n_bytes(&self) -> u64 {
        match &self.cells {
            Cells::Touched { facets, .. } => size_of_val(facets.as_slice()) as u64,
            Cells::Crossed(words) => 8 * words.capacity() as u64,
        }
    }

    /// Its cells on the rays of some rows, with the flag 1.
    pub(crate) fn rows(&self, planes: Range<u32>) -> Band {
        let n_across = u64::from(self.rays.counts[0]);
        // ray of the band, first cell, first cell after
        let mut intervals: Vec<(u64, u32, u32)> = Vec::new();
        match &self.cells {
            Cells::Crossed(words) => intervals.extend(of_planes(words, &planes).iter().map(|&word| {
                let plane = plane_of(word) - planes.start;
                (u64::from(plane) * n_across + u64::from(place_of(word)), row_of(word), row_of(word) + 1)
            })),
            Cells::Touched { facets, frame } => {
                let passing = facets.iter().filter(|(rows, _)| rows.start < planes.end && rows.end > planes.start);
                for (rows, facet) in passing {
                    let Some(touched) = Touched::new(facet, frame, &self.rays) else { continue };
                    for j in rows.start.max(planes.start)..rows.end.min(planes.end) {
                        for i in touched.cells[0].clone() {
                            let [first, last] = touched.of_ray(i, j.into());
                            if first <= last {
                                let ray = u64::from(j - planes.start) * n_across + i as u64;
                                intervals.push((ray, first as u32, last as u32 + 1));
                            }
                        }
                    }
                }
            }
        }
        intervals.sort_unstable();
        self.united(&intervals, &planes)
    }

    /// Runs of intervals in order.
    fn united(&self, intervals: &[(u64, u32, u32)], planes: &Range<u32>) -> Band {
        let n_across = u64::from(self.rays.counts[0]);
        let n_rays = u64::from(planes.end - planes.start) * n_across;
        let mut band = Band { first_ray: u64::from(planes.start) * n_across, ..Band::default() };
        let mut rest = intervals;
        for ray in 0..n_rays {
            let n = rest.iter().take_while(|interval| interval.0 == ray).count();
            let (own, others) = rest.split_at(n);
            rest = others;
            let mut own = own.iter().map(|&(_, start, end)| (start, end)).peekable();
            while let Some((start, mut end)) = own.next() {
                while let Some((_, next)) = own.next_if(|next| next.0 <= end) {
                    end = end.max(next);
                }
                band.runs.push(run(start, 1));
                if end < self.rays.depth {
                    band.runs.push(run(end, 0));
                }
            }
            band.ends.push(band.runs.len() as u32);
        }
        band
    }
}
