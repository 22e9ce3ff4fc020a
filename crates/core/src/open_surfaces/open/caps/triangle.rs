//! The solid angle of a triangle of a cap, and its gradient.

use std::f64::consts::PI;

use glam::DVec3;

use crate::grid::frame::{SnappedFacet, normal};

/// How far the points at which theta is evaluated lie before the centres, in 32nds of a unit of the snap.
pub(super) const BEFORE: [i8; 3] = [14, 9, 5];

/// A triangle of a cap, in cells of the first axis.
pub(super) struct Triangle {
    snapped: SnappedFacet,
    pub(super) corners: [DVec3; 3],
    normal: DVec3,
    pub(super) area: f64,
    /// Most distance of a point of it from its first corner.
    reach: f64,
}

impl Triangle {
    /// None for one without area, which has no solid angle.
    pub(super) fn new(snapped: SnappedFacet, place: impl Fn([i32; 3]) -> DVec3) -> Option<Triangle> {
        let corners = snapped.map(place);
        let [a, b, c] = corners;
        let doubled = (b - a).cross(c - a);
        let length = doubled.length();
        let reach = (b - a).length().max((c - a).length());
        (length > 0.0).then(|| Triangle { snapped, corners, normal: doubled / length, area: 0.5 * length, reach })
    }

    /// Solid angle at a point over 4 pi, positive where the triangle turns its back on it (van Oosterom and Strackee 1983).
    pub(super) fn theta(&self, point: DVec3) -> f64 {
        let [top, bottom] = self.top_and_bottom(point);
        libm::atan2(top, bottom) / (2.0 * PI)
    }

    /// The sides of a right-angled triangle with the angle 2 pi theta.
    #[inline]
    fn top_and_bottom(&self, point: DVec3) -> [f64; 2] {
        // an array's map is a call, here and below
        let [a, b, c] = self.corners;
        let (a, b, c) = (a - point, b - point, c - point);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let top = a.dot(b.cross(c));
        let bottom = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        [top, bottom]
    }

    /// Theta at a centre, in units of the snap, which stands a little before itself, most along x, then y, then z: that of `point`,
    /// which is [`BEFORE`] it, and 1 more or less where the triangle lies between the two. Sides are exact.
    pub(super) fn theta_of_centre(&self, centre: [i64; 3], point: DVec3) -> f64 {
        let normal = normal(&self.snapped);
        let corners: [[i128; 3]; 3] =
            self.snapped.map(|corner| [0, 1, 2].map(|axis| 32 * (i128::from(corner[axis]) - i128::from(centre[axis]))));
        let is_behind = |from: [i128; 3]| {
            let height: i128 = (0..3).map(|axis| normal[axis] * (corners[0][axis] - from[axis])).sum();
            first_sign([height, normal[0], normal[1], normal[2]])
        };
        let [before, at] = [BEFORE.map(|part| -i128::from(part)), [0; 3]].map(|from| (from, is_behind(from)));
        let theta = if before.1 { self.theta(point).abs() } else { -self.theta(point).abs() };
        // on which side of an edge the line from one to the other passes
        let passes = |k: usize| {
            let (a, b) = (corners[k], corners[(k + 1) % 3]);
            let edge = [0, 1, 2].map(|axis| a[axis] - b[axis]);
            let volume: i128 = (0..3).map(|axis| before.0[axis] * cross(a, b)[axis]).sum();
            let [x, y, z] = cross(before.0, edge);
            first_sign([volume, x, y, z])
        };
        let is_between = before.1 != at.1 && passes(0) == passes(1) && passes(1) == passes(2);
        theta + if is_between { if at.1 { 1.0 } else { -1.0 } } else { 0.0 }
    }

    /// Change of theta a unit of length: the field of a current around the triangle (Biot and Savart), over 4 pi.
    pub(super) fn gradient(&self, point: DVec3) -> DVec3 {
        let [a, b, c] = self.corners;
        let (a, b, c) = (a - point, b - point, c - point);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let of_edge =
            |a: DVec3, b: DVec3, la: f64, lb: f64| a.cross(b) * ((la + lb) / (la * lb * (la * lb + a.dot(b))));
        (of_edge(a, b, la, lb) + of_edge(b, c, lb, lc) + of_edge(c, a, lc, la)) / (4.0 * PI)
    }

    /// Whether a point is for sure more than so far away.
    #[inline]
    pub(super) fn is_beyond(&self, distance: f64, point: DVec3) -> bool {
        let least = self.reach + distance;
        self.corners[0].distance_squared(point) > least * least || self.distance(point, DVec3::ZERO) > distance
    }

    /// At most the distance from any point of a box.
    #[inline]
    pub(super) fn distance(&self, middle: DVec3, half: DVec3) -> f64 {
        let [a, b, c] = self.corners;
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        let apart = (low - (middle + half)).max((middle - half) - high).max(DVec3::ZERO);
        let across = self.normal.dot(middle - a).abs() - self.normal.abs().dot(half);
        apart.length().max(across)
    }
}

/// A sum of theta of triangles: their complex numbers are multiplied, which is several times faster than an arctangent of each.
pub(super) struct Turn {
    product: [f64; 2],
    n_whole: i32,
    /// At least the sum of all magnitudes.
    pub(super) magnitude: f64,
}

impl Turn {
    pub(super) fn new() -> Turn {
        Turn { product: [1.0, 0.0], n_whole: 0, magnitude: 0.0 }
    }

    /// Adds theta of a triangle at a point that is not on it.
    #[inline]
    pub(super) fn add(&mut self, triangle: &Triangle, point: DVec3) {
        let [top, bottom] = triangle.top_and_bottom(point);
        let size = top.abs() + bottom.abs();
        if size == 0.0 {
            return;
        }
        let [im, re] = [top / size, bottom / size];
        // atan(x) <= pi x / (1 + x)
        self.magnitude += if re > 0.0 { 0.5 * im.abs() } else { 0.5 };
        let [before_re, before_im] = self.product;
        let now = [before_re * re - before_im * im, before_re * im + before_im * re];
        let is_up = before_im >= 0.0;
        // two angles of one sign pass a half turn, where one is more than a quarter
        if is_up == (im >= 0.0) && is_up != (now[1] >= 0.0) && (before_re < 0.0 || re < 0.0) {
            self.n_whole += if is_up { 1 } else { -1 };
        }
        let far_from_one = now[0].abs() + now[1].abs() < 1e-100;
        self.product = if far_from_one { now.map(|part| part * 1e100) } else { now };
    }

    /// The sum.
    pub(super) fn theta(&self) -> f64 {
        f64::from(self.n_whole) + libm::atan2(self.product[1], self.product[0]) / (2.0 * PI)
    }
}

fn cross(a: [i128; 3], b: [i128; 3]) -> [i128; 3] {
    [0, 1, 2].map(|k| a[(k + 1) % 3] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[(k + 1) % 3])
}

/// Whether a sum is positive of which each part is far larger than those after it.
fn first_sign(parts: [i128; 4]) -> bool {
    parts.into_iter().find(|&part| part != 0).is_some_and(|part| part > 0)
}
