//! The solid angle of a triangle of a cap, its derivatives, and the dipole that is the triangle from afar.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

use crate::frame::{SnappedFacet, normal};

/// A triangle of a cap, in cells of the first axis.
pub(super) struct Triangle {
    snapped: SnappedFacet,
    corners: [DVec3; 3],
    low: DVec3,
    high: DVec3,
    normal: DVec3,
    pub(super) area: f64,
    centre: DVec3,
    /// Sum of the squares of its edges.
    squares: f64,
}

impl Triangle {
    /// None for one without area, which has no solid angle.
    pub(super) fn new(snapped: SnappedFacet, place: impl Fn([i32; 3]) -> DVec3) -> Option<Triangle> {
        let corners = snapped.map(place);
        let [a, b, c] = corners;
        let doubled = (b - a).cross(c - a);
        let length = doubled.length();
        let (low, high) = (a.min(b).min(c), a.max(b).max(c));
        (length > 0.0).then(|| Triangle {
            snapped,
            corners,
            low,
            high,
            normal: doubled / length,
            area: 0.5 * length,
            centre: (a + b + c) / 3.0,
            squares: a.distance_squared(b) + b.distance_squared(c) + c.distance_squared(a),
        })
    }

    /// Solid angle at a point over 4 pi, positive where the triangle turns its back on it (van Oosterom and Strackee 1983).
    pub(super) fn theta(&self, point: DVec3) -> f64 {
        let [a, b, c] = self.corners.map(|corner| corner - point);
        let [la, lb, lc] = [a.length(), b.length(), c.length()];
        let top = a.dot(b.cross(c));
        let bottom = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        libm::atan2(top, bottom) / (2.0 * PI)
    }

    /// Theta at a centre, in units of the snap, where `point` is the point beside it at which theta is computed: of another side of
    /// the triangle than the centre's, it is turned round.
    pub(super) fn theta_of_centre(&self, centre: [i64; 3], point: DVec3) -> f64 {
        let theta = self.theta(point);
        // elsewhere theta does not jump
        let is_turned =
            theta.abs() > 0.25 && self.is_behind(centre).is_some_and(|is_behind| is_behind != (theta > 0.0));
        if is_turned { -theta } else { theta }
    }

    /// Whether the triangle turns its back on a centre, which stands a little before itself, most along x, then y, then z; None for one
    /// without area.
    fn is_behind(&self, centre: [i64; 3]) -> Option<bool> {
        let normal = normal(&self.snapped);
        let towards = |axis: usize| i128::from(self.snapped[0][axis]) - i128::from(centre[axis]);
        let height: i128 = (0..3).map(|axis| normal[axis] * towards(axis)).sum();
        [height, normal[0], normal[1], normal[2]].into_iter().find(|&of| of != 0).map(|of| of > 0)
    }

    /// Change of theta a unit of length: the field of a current around the triangle (Biot and Savart), over 4 pi.
    pub(super) fn gradient(&self, point: DVec3) -> DVec3 {
        let corners = self.corners.map(|corner| corner - point);
        let lengths = corners.map(DVec3::length);
        let of_edge = |(from, to): (usize, usize)| {
            let (a, b, la, lb) = (corners[from], corners[to], lengths[from], lengths[to]);
            a.cross(b) * ((la + lb) / (la * lb * (la * lb + a.dot(b))))
        };
        [(0, 1), (1, 2), (2, 0)].map(of_edge).into_iter().fold(DVec3::ZERO, |sum, edge| sum + edge) / (4.0 * PI)
    }

    /// Theta of a dipole at its centre.
    pub(super) fn dipole(&self, point: DVec3) -> f64 {
        let q = self.centre - point;
        let square = q.length_squared();
        self.area * self.normal.dot(q) / (4.0 * PI * square * square.sqrt())
    }

    /// How far that may be off at a distance.
    pub(super) fn dipole_error(&self, distance: f64) -> f64 {
        self.area * self.squares / (48.0 * PI * distance.powi(4))
    }

    /// First and second derivative of the dipole's theta.
    pub(super) fn dipole_derivatives(&self, point: DVec3) -> (DVec3, DMat3) {
        let (n, q) = (self.normal, self.centre - point);
        let square = q.length_squared();
        let fifth = square * square * square.sqrt();
        let scale = self.area / (4.0 * PI * fifth);
        let along = n.dot(q);
        let outer = |a: DVec3, b: DVec3| DMat3::from_cols(a * b.x, a * b.y, a * b.z);
        let gradient = (q * (3.0 * along) - n * square) * scale;
        let mixed = outer(n, q) + outer(q, n) + DMat3::from_diagonal(DVec3::splat(along));
        (gradient, (outer(q, q) * (15.0 * along / square) - mixed * 3.0) * scale)
    }

    /// At most the distance from any point of a box.
    pub(super) fn distance(&self, middle: DVec3, half: DVec3) -> f64 {
        let apart = (self.low - (middle + half)).max((middle - half) - self.high).max(DVec3::ZERO);
        let across = self.normal.dot(middle - self.corners[0]).abs() - self.normal.abs().dot(half);
        apart.length().max(across)
    }
}
