//! The paper's optimum: the largest uniform cell size that puts all end points on mesh lines.
//!
//! End points of an axis, a largest size, a tolerance -> the size s. With d_i the distances of the end points from the
//! first, allowed is every `s <= s_max` with `|d_i / s - round(d_i / s)| <= tolerance` for all i. The number of cells of
//! Eq. 1-3 is least where s is largest, under the paper's two restrictions. The paper gives no algorithm; AEG Mesher [30]
//! minimises the distance of each ratio to an integer. Here both are done, one after the other:
//!
//! 1. The largest allowed size decides which line is whose, m_i = round(d_i / s), and so the number of cells. The sizes that
//!    an end point allows are intervals, `d_i / (m + tolerance) ..= d_i / (m - tolerance)`: from s_max downwards, as long as
//!    an end point does not allow s, s jumps to the top of the next lower interval of the one that needs the largest jump. No size between is
//!    allowed, so the first size that all end points allow is the largest of all.
//! 2. Within the tolerance nearer is still better: of the sizes d_i / m_i, which put one end point exactly on its line, and the size of step 1,
//!    the one with the least greatest residual `|d_i / s - m_i|` is taken, if it is not above s_max. So a common divisor is
//!    met exactly, and the number of cells stays.
//!
//! Degenerate: a geometry thinner than the tolerance would have both faces on one line and no cell, so s is also at most
//! `thickness / (1 - 2 tolerance)`, which keeps its faces on different lines for tolerances under a quarter. End points
//! nearer than the rounding of the files to either end of the domain are that end. Cost: O(end points) a jump, at most one
//! jump an interval, O(end points^2) for step 2.

use crate::grid::domain::Domain;

/// How far below the largest possible size the search goes before it gives up.
const SMALLEST_SHARE: f64 = 1.0 / 256.0;

/// Lengths along one axis that the cell size has to suit, in the unit of the files.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Intervals {
    /// Distances of the end points from the domain's minimum: ascending, positive, the last is the domain's extent.
    pub(crate) distances: Vec<f64>,
    /// Extent of the thinnest geometry that lies in the domain and is not flat; infinite without one.
    pub(crate) thinnest: f64,
}

impl Intervals {
    /// Takes the end points of a domain along an axis, without those that only rounding keeps off its ends.
    pub(crate) fn new(domain: &Domain, axis: usize) -> Intervals {
        let (low, high) = (domain.low[axis], domain.high[axis]);
        let rounding = domain.file_rounding(axis);
        let inner = domain.end_points[axis].iter().filter(|&&end| end - low > rounding && high - end > rounding);
        let distances = inner.map(|end| end - low).chain([high - low]).collect();
        let within = domain.boxes.iter().filter(|[first, last]| {
            first[axis] >= low - rounding && last[axis] <= high + rounding && last[axis] - first[axis] > rounding
        });
        let thinnest = within.map(|[first, last]| last[axis] - first[axis]).fold(f64::INFINITY, f64::min);
        Intervals { distances, thinnest }
    }

    /// The sizes that are searched: least and greatest.
    pub(crate) fn searched(&self, s_max: f64, tolerance: f64) -> [f64; 2] {
        let extent = self.distances.iter().copied().fold(0.0, f64::max);
        let greatest = s_max.min(extent).min(self.thinnest / (1.0 - 2.0 * tolerance));
        [greatest * SMALLEST_SHARE, greatest]
    }

    /// Finds the optimal size of at most `s_max`; None if no size of [`Intervals::searched`] is allowed.
    pub(crate) fn optimal_cell_size(&self, s_max: f64, tolerance: f64) -> Option<f64> {
        let [least, greatest] = self.searched(s_max, tolerance);
        let mut size = greatest;
        while size >= least {
            let allowed = self.distances.iter().map(|distance| largest_allowed(*distance, size, tolerance));
            let next = allowed.fold(size, f64::min);
            if next == size {
                return Some(self.settled(size, greatest));
            }
            size = next;
        }
        None
    }

    /// Of the sizes that leave every end point its line, the one that brings the farthest off nearest.
    fn settled(&self, size: f64, greatest: f64) -> f64 {
        let numbered: Vec<(f64, f64)> = self.distances.iter().map(|d| (*d, (d / size).round())).collect();
        let residual = |s: f64| numbered.iter().map(|(d, m)| (d / s - m).abs()).fold(0.0, f64::max);
        let mut best = (residual(size), size);
        for (distance, line) in numbered.iter().rev().filter(|(_, line)| *line >= 1.0) {
            let candidate = distance / line;
            let off = residual(candidate);
            if candidate <= greatest && off < best.0 {
                best = (off, candidate);
            }
        }
        best.1
    }
}

/// The largest size of at most `size` that one end point allows.
fn largest_allowed(distance: f64, size: f64, tolerance: f64) -> f64 {
    let ratio = distance / size;
    // a few ulps of forgiveness, so that the size computed below satisfies its own test
    if (ratio - ratio.round()).abs() <= tolerance + 4.0 * f64::EPSILON * ratio {
        return size;
    }
    distance / (ratio.floor() + 1.0 - tolerance)
}

#[cfg(test)]
mod tests;
