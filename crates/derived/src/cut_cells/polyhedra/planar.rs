//! Loops of points as flat polygons, and the volumes of cones over polygons.
//!
//! A loop that comes back to a point is two. A loop that is flat is one polygon; of another triangles are made from that corner on from which the one that shows least of its area along the
//! mean normal shows most.

pub(in crate::cut_cells) type Point = [f64; 3];

pub(super) fn minus(a: Point, b: Point) -> Point {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(super) fn cross(a: Point, b: Point) -> Point {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn dot(a: Point, b: Point) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The area vector of a triangle.
fn triangle(a: Point, b: Point, c: Point) -> Point {
    cross(minus(b, a), minus(c, a)).map(|of| 0.5 * of)
}

/// The volume of the cone over a polygon, whose tip is a point, and the area vector of the polygon.
pub(in crate::cut_cells) fn cone(mut polygon: impl Iterator<Item = Point>, tip: Point) -> (f64, Point) {
    let (mut volume, mut area) = (0.0, [0.0; 3]);
    let (Some(first), Some(mut before)) = (polygon.next(), polygon.next()) else { return (volume, area) };
    for corner in polygon {
        let vector = triangle(first, before, corner);
        volume += dot(vector, minus(first, tip)) / 3.0;
        (0..3).for_each(|axis| area[axis] += vector[axis]);
        before = corner;
    }
    (volume, area)
}

/// Calls `each` with the polygons of a loop, flat to a distance.
pub(in crate::cut_cells) fn split(ring: &[u32], points: &[Point], flat: f64, mut each: impl FnMut(&[u32])) {
    pinched(ring, |ring| simple(ring, points, flat, &mut each));
}

/// Calls `each` with the parts of a loop that pass each point once.
pub(super) fn pinched(ring: &[u32], mut each: impl FnMut(&[u32])) {
    let mut open: Vec<u32> = Vec::with_capacity(ring.len());
    for &point in ring {
        if let Some(at) = open.iter().position(|&other| other == point) {
            each(&open[at..]);
            open.truncate(at);
        }
        open.push(point);
    }
    each(&open);
}

/// Those of a loop that passes each point once.
fn simple(ring: &[u32], points: &[Point], flat: f64, each: &mut impl FnMut(&[u32])) {
    let n = ring.len();
    if n <= 3 {
        return each(ring);
    }
    let at = |index: usize| points[ring[index % n] as usize];
    let (_, area) = cone((0..n).map(at), at(0));
    let length = dot(area, area).sqrt();
    if length > 0.0 {
        let distance = |index: usize| dot(minus(at(index), at(0)), area).abs() / length;
        if (1..n).all(|index| distance(index) <= flat) {
            return each(ring);
        }
    }
    let least = |apex: usize| {
        let shown = (1..n - 1).map(|index| dot(triangle(at(apex), at(apex + index), at(apex + index + 1)), area));
        shown.fold(f64::INFINITY, f64::min)
    };
    let apex = (0..n).rev().max_by(|&one, &other| least(one).total_cmp(&least(other))).unwrap_or(0);
    for index in 1..n - 1 {
        each(&[ring[apex], ring[(apex + index) % n], ring[(apex + index + 1) % n]]);
    }
}
