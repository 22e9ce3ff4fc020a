//! Cells that one facet crosses from side to side: what lies below it there, in closed form.
//!
//! # Theory
//! Columns of cells stand along the axis on which the facet is steepest. Where all of a column's square lies strictly within the facet's projection, which integers decide, the
//! facet crosses the column, and every cell of it that it meets, as its plane does. Let h be the height of the plane above the floor of such a cell, from which its slopes along the square
//! are p and q, 0 <= q <= p <= 1: l is the height at the lowest corner, a = l + q, b = l + p and t = l + p + q. Below it in the cell lies E(h) - E(h - 1), where E is the integral of
//! max(h, 0) over the square, by how many corners are above 0:
//!
//! none 0; t: t^3 / 6 p q; b and t: (b^2 + b t + t^2) / 6 p; all but l: (l + t) / 2 - l^3 / 6 p q; all (l + t) / 2.
//!
//! Nothing cancels, and no quotient is large: what is divided by p is at most p, and so for q. Heights are those of the corners of pieces: a whole number of units and a part.
//!
//! Only among equal cells: else slopes may be steep. Source: ours. Cost: two corners a column, and one E for each cell.

use std::ops::Range;

use super::polygon::Whole;

/// A facet over the columns along one axis.
pub(super) struct Across {
    /// That of the columns, and the two others.
    pub(super) axis: usize,
    pub(super) others: [usize; 2],
    /// Of a column's four corners, along the first of the others first, the lowest, the next two and the highest.
    order: [usize; 4],
    /// 1 by the slopes p and q.
    per_slope: [f64; 2],
    /// For each edge two factors and a sum that is positive where it leaves all of a column's square within, given the low corner of that.
    edges: [[i64; 3]; 3],
    /// Size of a cell in units.
    size: i64,
    /// Of each corner of a cell whether it is at the upper end of its column, and which of that's corners it is at.
    pub(super) corners: [[u8; 2]; 8],
}

impl Across {
    pub(super) fn new(of: &Whole, size: i64) -> Across {
        let sizes = of.normal.map(i64::abs);
        let axis = if sizes[2] >= sizes[0].max(sizes[1]) { 2 } else { usize::from(sizes[1] >= sizes[0]) };
        // the last of the others is that which changes first from cell to cell of a plane across z
        let others = [[1, 2], [0, 2], [0, 1]][axis];
        let along = |other: usize| -(of.normal[other] as f64) / of.normal[axis] as f64;
        let [first, second] = others.map(along);
        let lowest = usize::from(first < 0.0) + 2 * usize::from(second < 0.0);
        let (more, less) = if first.abs() >= second.abs() { (1, 2) } else { (2, 1) };
        let order = [lowest, lowest ^ less, lowest ^ more, lowest ^ 3];
        let per_slope = [first.abs().max(second.abs()), first.abs().min(second.abs())].map(|slope| 1.0 / slope);
        // seen along the axis, others in their order are counter-clockwise but for y
        let sign = of.normal[axis].signum() * if axis == 1 { -1 } else { 1 };
        let edges = [0, 1, 2].map(|edge| {
            let [from, to] = [edge, (edge + 1) % 3].map(|corner| others.map(|other| of.corners[corner][other]));
            let (a, b) = (-(to[1] - from[1]) * sign, (to[0] - from[0]) * sign);
            [a, b, (a.min(0) + b.min(0)) * size - a * from[0] - b * from[1]]
        });
        let end = |corner: usize, axis: usize| (corner >> axis & 1) as u8;
        let corners =
            std::array::from_fn(|corner| [end(corner, axis), end(corner, others[0]) + 2 * end(corner, others[1])]);
        Across { axis, others, order, per_slope, edges, size, corners }
    }

    /// Which of n columns, that begin at a place along the first of the others, are crossed; all at the same place along the second.
    pub(super) fn columns(&self, [first, second]: [i32; 2], n: i64) -> Range<i64> {
        let (mut start, mut end) = (0, n);
        for [a, b, sum] in self.edges {
            let (value, step) = (a * i64::from(first) + b * i64::from(second) + sum, a * self.size);
            match step.signum() {
                0 if value <= 0 => end = 0,
                0 => (),
                1 => start = start.max((-value).div_euclid(step) + 1),
                _ => end = end.min((value - 1).div_euclid(-step) + 1),
            }
        }
        start..end.max(start)
    }

    /// What the plane has of the square below heights above 0: E.
    #[inline(always)]
    pub(super) fn below(&self, heights: &[f64; 4]) -> f64 {
        let [l, a, b, t] = self.order.map(|corner| heights[corner]);
        // rounding alone makes these more than 1
        let [by_p, by_q] = self.per_slope.map(|per_slope| move |height: f64| (height * per_slope).min(1.0));
        let wedge = |height: f64| height * by_p(height) * by_q(height) / 6.0;
        if t <= 0.0 {
            0.0
        } else if b <= 0.0 {
            wedge(t)
        } else if a <= 0.0 {
            (b * by_p(b) + (b + t) * by_p(t)) / 6.0
        } else if l < 0.0 {
            0.5 * (l + t) + wedge(-l)
        } else {
            0.5 * (l + t)
        }
    }
}
