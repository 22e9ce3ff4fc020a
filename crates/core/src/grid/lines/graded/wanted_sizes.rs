//! The sizes of cells that geometries want along an axis, and where.
//!
//! A cell that a geometry's box reaches into, however little, is no larger than the geometry's `max_size`, nor than its length divided by
//! `min_cells`. Between two fixed lines that holds for all cells, unless the box ends within the smallest cell of one of the lines: then it
//! reaches into the cell at that line alone, and only this one has a largest size. So it does not matter which lines the ends of the box
//! got, or whether they got any.
//!
//! Cells are counted where the lines are known: of a box whose ends are off their lines, cells that are small enough may be one too few
//! within it. Then it wants one more ([`Wanted::count_more`]).

use super::sizes::Interval;
use crate::input::geometry::Sizing;

/// What a geometry wants along an axis.
#[derive(Debug, Clone, Copy)]
pub(super) struct Wanted {
    /// The ends of its box, within the domain.
    pub(super) ends: [f64; 2],
    max_size: Option<f64>,
    min_cells: Option<u32>,
    /// Cells into which its length is divided, at least: `min_cells`, and more where some of them are not within the box.
    n_cells: u32,
}

impl Wanted {
    pub(super) fn new(ends: [f64; 2], Sizing { max_size, min_cells, .. }: Sizing) -> Wanted {
        // across a plane there are no cells
        let min_cells = min_cells.filter(|_| ends[0] < ends[1]);
        Wanted { ends, max_size, min_cells, n_cells: min_cells.unwrap_or(0) }
    }

    /// The largest size of a cell that the box reaches into.
    pub(super) fn size(&self) -> f64 {
        let [low, high] = self.ends;
        let of_cells = self.min_cells.map(|_| (high - low) / f64::from(self.n_cells));
        self.max_size.into_iter().chain(of_cells).fold(f64::INFINITY, f64::min)
    }

    /// Wants one more cell where fewer than it wants lie within the box; whether it does.
    pub(super) fn count_more(&mut self, lines: &[f64]) -> bool {
        let [low, high] = self.ends;
        let within = lines.partition_point(|line| *line <= high) - lines.partition_point(|line| *line < low);
        let is_less = self.min_cells.is_some_and(|n| (within as u64) < u64::from(n) + 1);
        self.n_cells = self.n_cells.saturating_add(is_less.into());
        is_less
    }

    /// Limits the cells between two lines, none of which is below the smallest size.
    fn limit(&self, interval: &mut Interval, [from, to]: [f64; 2], least: f64) {
        let ([low, high], size) = (self.ends, self.size());
        // the cell at a line may be smaller by rounding
        let is_one = |length: f64| length < least * (1.0 - 1e-6);
        if low >= to || high <= from {
        } else if is_one(high - from) {
            interval.limit_outer(0, size);
        } else if is_one(to - low) {
            interval.limit_outer(1, size);
        } else {
            interval.limit(size);
        }
    }
}

/// The cells between two lines, as large as the largest size of all and the geometries allow.
pub(super) fn interval(wanted: &[Wanted], two: [f64; 2], most: f64, least: f64) -> Interval {
    let mut interval = Interval::new(two[1] - two[0], most);
    wanted.iter().for_each(|wanted| wanted.limit(&mut interval, two, least));
    interval
}
