//! A facet as the rays see it: three edge functions and a plane, in exact integers.
//!
//! Snapped corners -> [`Projected`]. With X, Y across the rays and Z along them, corners ordered so that
//! `D = twice the projected area > 0`:
//!
//! - edge e: `E_e(P) = A_e (P_x - X_e) + B_e (P_y - Y_e)`, `A_e = -(Y_n - Y_e)`, `B_e = X_n - X_e` (the orientation of
//!   Eq. 16-18). A ray is inside the facet iff for all edges E > 0, or E = 0 and (A < 0, or A = 0 and B < 0): the ray
//!   stands for P - (e1, e2), e1 >> e2 > 0, so each edge belongs to exactly one of the two facets that share it.
//! - stored is `q_e(i, j) = (E_e - [0 if a tie counts as inside, else 1]) >> F` at ray (i, j); the test is `q_e >= 0`, and q
//!   changes by exactly A_e and B_e from ray to ray, since rays step by 2^F. Where cells differ in size, rays step by the distances of
//!   their centres, F is 0 there, and q changes by A_e and B_e a unit.
//! - plane: `Z(P) = Z_0 + (h_x (P_x - X_0) + h_y (P_y - Y_0)) / D` (Eq. 19).
//!
//! Degenerate case: D = 0 (the facet is parallel to the rays or collapsed) is never hit: None.
//! Widths in bits, sign included, with coordinates that span 26 bits: A, B 27; E, D, h 53; the plane's numerator 80. A test below computes
//! them; `docs/widths.md` lists what proves the widths of the kernels.
//! Twin: `shaders/shared/facet.wgsl`.

use crate::grid::frame::{Frame, SnappedFacet};
use crate::grid::rays::Rays;

/// Edge functions, plane and extent of a facet seen along the rays.
#[derive(Debug, Clone, Copy)]
pub struct Projected {
    /// q of each edge at the first ray of `rays`.
    pub q: [i64; 3],
    /// Step of q from ray to ray along the first axis across, or a unit where cells differ in size.
    pub a: [i64; 3],
    /// The same along the second axis across.
    pub b: [i64; 3],
    /// First and last ray, inclusive, of the facet's box on the two axes across, clipped to the domain.
    pub rays: [[u32; 2]; 2],
    /// Twice the projected area, positive.
    pub area: i64,
    /// Change of the height numerator over a step of one unit along each axis across.
    pub slope: [i64; 2],
    /// Numerator of the height over D at the first ray of `rays`, in units: `Z = height / D`.
    pub height: i128,
    /// Whether a centre exactly on the facet counts as above the crossing.
    pub tie_is_above: bool,
    /// Whether rays leave the body here: the facet's normal points along the rays.
    pub exits: bool,
}

impl Projected {
    /// Projects a facet, or returns None if no ray of the domain can hit it.
    pub fn new(facet: &SnappedFacet, frame: &Frame, rays: &Rays) -> Option<Projected> {
        let mut corners = [[0; 3]; 3];
        for corner in 0..3 {
            let [x, y, z] = rays.project(facet[corner]);
            corners[corner] = [x.into(), y.into(), z.into()];
        }
        let area = twice_area(&corners);
        if area == 0 {
            return None;
        }
        if area < 0 {
            corners.swap(1, 2);
        }
        // (x, z, y) is an odd permutation of the axes, so along y the orientation reads the other way round
        let exits = (area > 0) != (rays.axis == 1);
        let [across, down] = rays_under(facet, frame, rays)?;
        let origin = [frame.centre(rays.across[0], across[0]), frame.centre(rays.across[1], down[0])].map(i64::from);
        let mut projected = Projected {
            q: [0; 3],
            a: [0; 3],
            b: [0; 3],
            rays: [across, down],
            area: area.abs(),
            slope: slope(&corners),
            height: 0,
            tie_is_above: false,
            exits,
        };
        // rays that are not equally far from each other are counted in units
        let step_bits = if frame.is_graded() { 0 } else { frame.fraction_bits };
        projected.set_edges(&corners, origin, step_bits);
        projected.set_plane(&corners, origin, rays.axis);
        Some(projected)
    }

    /// Numerator of the height over D, in units, at a ray.
    pub fn height_at(&self, ray: [u32; 2], frame: &Frame, rays: &Rays) -> i128 {
        let from_first = |side: usize| {
            let centre = |ray: u32| i128::from(frame.centre(rays.across[side], ray));
            i128::from(self.slope[side]) * (centre(ray[side]) - centre(self.rays[side][0]))
        };
        self.height + from_first(0) + from_first(1)
    }

    #[inline(always)]
    fn set_edges(&mut self, corners: &[[i64; 3]; 3], origin: [i64; 2], step_bits: u32) {
        for edge in 0..3 {
            let [x, y, _] = corners[edge];
            let [next_x, next_y, _] = corners[(edge + 1) % 3];
            let (a, b) = (y - next_y, next_x - x);
            let tie_is_inside = a < 0 || (a == 0 && b < 0);
            let value = a * (origin[0] - x) + b * (origin[1] - y);
            self.q[edge] = (value - i64::from(!tie_is_inside)) >> step_bits;
            self.a[edge] = a;
            self.b[edge] = b;
        }
    }

    #[inline(always)]
    fn set_plane(&mut self, corners: &[[i64; 3]; 3], origin: [i64; 2], axis: usize) {
        let [x, y, z] = corners[0];
        let (x, y, z) = (i128::from(x), i128::from(y), i128::from(z));
        let (slope_x, slope_y) = (i128::from(self.slope[0]), i128::from(self.slope[1]));
        self.height =
            z * i128::from(self.area) + slope_x * (i128::from(origin[0]) - x) + slope_y * (i128::from(origin[1]) - y);
        // The centre stands for P - (e1, e2, e3), e1 >> e2 >> e3 along x, y, z. Relative to the plane it sits at
        // -e_axis + (slope . e_across) / D: the largest epsilon with a non-zero factor decides.
        self.tie_is_above = match axis {
            0 => false,
            1 => self.slope[0] > 0,
            _ => self.slope[0] > 0 || (self.slope[0] == 0 && self.slope[1] > 0),
        };
    }
}

/// Twice the area of a facet seen along its third coordinate, positive counter-clockwise.
#[inline(always)]
pub(crate) fn twice_area(corners: &[[i64; 3]; 3]) -> i64 {
    let [[x0, y0, _], [x1, y1, _], [x2, y2, _]] = *corners;
    (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
}

/// Change of its height times that area, over a unit along the first and the second.
#[inline(always)]
pub(crate) fn slope(corners: &[[i64; 3]; 3]) -> [i64; 2] {
    let [[x0, y0, z0], [x1, y1, z1], [x2, y2, z2]] = *corners;
    [(z1 - z0) * (y2 - y0) - (z2 - z0) * (y1 - y0), (x1 - x0) * (z2 - z0) - (x2 - x0) * (z1 - z0)]
}

/// First and last ray, inclusive, whose centres lie within the box of a facet along both axes across, clipped to the domain; None if there
/// is no such ray.
#[inline(always)]
pub fn rays_under(facet: &SnappedFacet, frame: &Frame, rays: &Rays) -> Option<[[u32; 2]; 2]> {
    let mut under = [[0; 2]; 2];
    for side in 0..2 {
        let axis = rays.across[side];
        let [a, b, c] = [facet[0][axis], facet[1][axis], facet[2][axis]];
        let first = frame.n_below(axis, a.min(b).min(c), false);
        let end = frame.n_below(axis, a.max(b).max(c), true);
        if first >= end {
            return None;
        }
        under[side] = [first, end - 1];
    }
    Some(under)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::frame::{MIN_FRACTION_BITS, Ranks, SPAN_BITS};

    fn frame(dims: [u32; 3]) -> Frame {
        let (facets, position_of_facet) = (Vec::new(), Vec::new());
        Frame { fraction_bits: 2, centres: None, dims, facets, position_of_facet, ranks: Ranks::of_one() }
    }

    #[test]
    fn a_facet_parallel_to_the_rays_is_never_hit() {
        let frame = frame([8; 3]);
        let upright = [[0, 0, 0], [8, 8, 0], [8, 8, 16]];
        assert!(Projected::new(&upright, &frame, &Rays::new(2, frame.dims)).is_none());
        assert!(Projected::new(&upright, &frame, &Rays::new(0, frame.dims)).is_some());
    }

    #[test]
    fn a_facet_between_rays_is_dropped() {
        let frame = frame([8; 3]);
        let small = [[1, 1, 0], [3, 1, 0], [1, 3, 0]];
        assert!(Projected::new(&small, &frame, &Rays::new(2, frame.dims)).is_none());
    }

    #[test]
    fn the_same_normal_exits_along_every_axis() {
        // corners counter-clockwise seen from (1, 1, 1): the normal points along all three axes
        let frame = frame([8; 3]);
        let facet = [[16, 0, 0], [0, 16, 0], [0, 0, 16]];
        for axis in 0..3 {
            assert!(Projected::new(&facet, &frame, &Rays::new(axis, frame.dims)).unwrap().exits, "axis {axis}");
        }
    }

    #[test]
    fn a_shared_edge_through_a_centre_has_one_owner() {
        let frame = frame([8; 3]);
        let rays = Rays::new(2, frame.dims);
        // a square cut along the diagonal that meets the ray (2, 2)
        let halves = [[[4, 4, 0], [12, 4, 0], [12, 12, 0]], [[4, 4, 0], [12, 12, 0], [4, 12, 0]]];
        let owners = halves.iter().filter(|half| {
            let p = Projected::new(half, &frame, &rays).unwrap();
            let (di, dj) = (2 - i64::from(p.rays[0][0]), 2 - i64::from(p.rays[1][0]));
            (0..3).all(|e| p.q[e] + p.a[e] * di + p.b[e] * dj >= 0)
        });
        assert_eq!(owners.count(), 1);
    }

    /// Numbers of a facet, given its nine coordinates and the two of a ray: area, slopes, height, then q, a and b of the edges.
    fn numbers(at: [i64; 11]) -> [i128; 13] {
        let corners: [[i64; 3]; 3] = std::array::from_fn(|corner| std::array::from_fn(|axis| at[3 * corner + axis]));
        let mut facet = Projected {
            q: [0; 3],
            a: [0; 3],
            b: [0; 3],
            rays: [[0; 2]; 2],
            area: twice_area(&corners),
            slope: slope(&corners),
            height: 0,
            tie_is_above: false,
            exits: false,
        };
        facet.set_edges(&corners, [at[9], at[10]], 0);
        facet.set_plane(&corners, [at[9], at[10]], 2);
        let Projected { q, a, b, area, slope, height, .. } = facet;
        let [[q0, q1, q2], [a0, a1, a2], [b0, b1, b2]] = [q, a, b].map(|of| of.map(i128::from));
        [area.into(), slope[0].into(), slope[1].into(), height, q0, q1, q2, a0, a1, a2, b0, b1, b2]
    }

    /// Bits of the widest of each kind: area, slopes, height, q, steps of q. Corners and rays are as far from each other as the frame lets them.
    ///
    /// All are affine in each coordinate, with the others fixed, so that the extremes are where every coordinate is at an end of its range.
    /// What does not fit on the way ends the test: it is compiled with checks for overflow.
    fn widest(span: i64) -> [u32; 5] {
        let mut most = [0u128; 5];
        for ends in [[0, span], [-span, 0]] {
            for choice in 0..1 << 11 {
                let at: [i64; 11] = std::array::from_fn(|of| ends[choice >> of & 1]);
                for (number, kind) in numbers(at).into_iter().zip([0, 1, 1, 2, 3, 3, 3, 4, 4, 4, 4, 4, 4]) {
                    most[kind] = most[kind].max(if number < 0 { !number } else { number } as u128);
                }
            }
        }
        most.map(|number| 129 - number.leading_zeros())
    }

    #[test]
    fn numbers_have_the_widths_that_the_head_says() {
        // two of the cells that the frame counts hold no corner, but for half a unit of rounding at both ends
        let span = (1 << SPAN_BITS) - (2 << MIN_FRACTION_BITS) + 1;
        assert_eq!(widest(span), [53, 53, 80, 53, 27]);
        assert_eq!(widest(2 * span), [55, 55, 83, 55, 28]);
    }

    #[test]
    fn numbers_are_affine_in_each_coordinate() {
        // twice that of the middle is the sum of those of the ends; with no tie, q is an edge function less 1
        let span = 1 << 20;
        for choice in 0..1 << 11 {
            let at: [i64; 11] = std::array::from_fn(|of| (choice >> of & 1) * span + [3, -7, 11][of % 3]);
            for of in 0..11 {
                let [low, middle, high] = [-2, 0, 2].map(|step| {
                    let mut at = at;
                    at[of] += step * 5;
                    numbers(at)
                });
                for (index, middle) in middle.into_iter().enumerate() {
                    let off = (2 * middle - low[index] - high[index]).abs();
                    let of_ties = if (4..7).contains(&index) { 2 } else { 0 };
                    assert!(off <= of_ties, "number {index} bends by {off} along coordinate {of}");
                }
            }
        }
    }
}
