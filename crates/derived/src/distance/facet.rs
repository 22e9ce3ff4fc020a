//! How far a point is from a facet.

/// Corners in world coordinates.
pub(super) type Corners = [[f64; 3]; 3];

/// Of the square of its longest edge, the least area of a facet that is no line: less is rounding.
const LEAST_AREA: f64 = 1e-12;

/// A facet, prepared for many points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Facet {
    pub(super) corners: Corners,
    normal: [f64; 3],
    /// One over the squares of the lengths of its edges; 0 of none.
    per_square: [f64; 3],
    /// One over the square of the normal's length; 0 of a line or a point.
    per_normal: f64,
}

impl Facet {
    pub(super) fn new(corners: &Corners) -> Facet {
        let [a, b, c] = corners;
        let squares = [[a, b], [b, c], [c, a]].map(|[from, to]| square_of(&minus(to, from)));
        let longest = squares.iter().fold(0.0, |most: f64, square| most.max(*square));
        let normal = cross(&minus(b, a), &minus(c, a));
        let square = square_of(&normal);
        let is_line = square.sqrt() <= LEAST_AREA * longest;
        let per = |square: f64| if square > 0.0 { 1.0 / square } else { 0.0 };
        let per_normal = if is_line { 0.0 } else { per(square) };
        Facet { corners: *corners, normal, per_square: squares.map(per), per_normal }
    }

    /// Twice its area vector; None of a line or a point.
    pub(super) fn normal(&self) -> Option<[f64; 3]> {
        (self.per_normal > 0.0).then_some(self.normal)
    }

    /// The corners of an edge.
    pub(super) fn edge(&self, number: usize) -> [[f64; 3]; 2] {
        [self.corners[number], self.corners[(number + 1) % 3]]
    }

    /// From one corner of an edge to the other.
    pub(super) fn along(&self, number: usize) -> [f64; 3] {
        let [from, to] = self.edge(number);
        minus(&to, &from)
    }

    /// The square of the distance of a point.
    #[inline]
    pub(super) fn square(&self, point: &[f64; 3]) -> f64 {
        let from = self.corners.map(|corner| minus(point, &corner));
        let edges = [0, 1, 2].map(|edge| self.along(edge));
        let side = |edge: usize| dot(&self.normal, &cross(&edges[edge], &from[edge]));
        let is_line = self.per_normal == 0.0;
        // what is nearest lies on an edge that the point is beyond, or else above the facet
        let mut least = f64::INFINITY;
        for edge in 0..3 {
            if is_line || side(edge) < 0.0 {
                least = least.min(self.of_edge(&edges[edge], edge, &from[edge]));
            }
        }
        if least < f64::INFINITY {
            return least;
        }
        let height = dot(&self.normal, &from[0]);
        height * height * self.per_normal
    }

    #[inline]
    fn of_edge(&self, along: &[f64; 3], edge: usize, from: &[f64; 3]) -> f64 {
        let part = (dot(from, along) * self.per_square[edge]).clamp(0.0, 1.0);
        let rest = [0, 1, 2].map(|axis| from[axis] - part * along[axis]);
        square_of(&rest)
    }
}

fn square_of(of: &[f64; 3]) -> f64 {
    dot(of, of)
}

pub(super) fn minus(one: &[f64; 3], other: &[f64; 3]) -> [f64; 3] {
    [one[0] - other[0], one[1] - other[1], one[2] - other[2]]
}

pub(super) fn dot(one: &[f64; 3], other: &[f64; 3]) -> f64 {
    one[0] * other[0] + one[1] * other[1] + one[2] * other[2]
}

pub(super) fn cross(one: &[f64; 3], other: &[f64; 3]) -> [f64; 3] {
    [
        one[1] * other[2] - one[2] * other[1],
        one[2] * other[0] - one[0] * other[2],
        one[0] * other[1] - one[1] * other[0],
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_edges_and_inside_are_told_apart() {
        let facet = Facet::new(&[[0.0; 3], [4.0, 0.0, 0.0], [0.0, 3.0, 0.0]]);
        let cases = [
            // above it, and in it
            ([1.0, 1.0, 2.0], 2.0),
            ([1.0, 1.0, 0.0], 0.0),
            // beyond corners
            ([-3.0, -4.0, 12.0], 13.0),
            ([7.0, 0.0, 4.0], 5.0),
            // beyond edges: y = 0, and the longest, whose middle is (2, 1.5)
            ([2.0, -3.0, 4.0], 5.0),
            ([2.6, 2.3, 0.0], 1.0),
        ];
        for (point, expected) in cases {
            assert!((facet.square(&point).sqrt() - expected).abs() < 1e-15, "{point:?}");
        }
    }

    /// A line, a needle that is thinner than rounding, and a point.
    #[test]
    fn facets_without_an_area_are_lines_or_points() {
        let line = Facet::new(&[[0.0; 3], [8.0, 0.0, 0.0], [2.0, 0.0, 0.0]]);
        assert_eq!(line.square(&[5.0, 3.0, 4.0]), 25.0);
        assert_eq!(line.square(&[11.0, 0.0, 4.0]), 25.0);
        let needle = Facet::new(&[[0.0; 3], [8.0, 0.0, 0.0], [2.0, 1e-13, 0.0]]);
        assert!((needle.square(&[5.0, 3.0, 4.0]) - 25.0).abs() < 1e-11);
        let point = Facet::new(&[[1.0, 2.0, 3.0]; 3]);
        assert_eq!(point.square(&[1.0, 5.0, 7.0]), 25.0);
    }
}
