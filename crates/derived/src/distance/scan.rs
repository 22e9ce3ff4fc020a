//! Distances of all points of a box within a band: each part of the surface looks at the points that it may be nearest to.
//!
//! # Theory
//! What is nearest to a point lies within a facet, within an edge, or on a corner. Within a facet: then the point is above or below the facet. Within an edge: then it is between
//! the planes across its ends, and, seen from the edge, over none of the facets there. On a corner: then it is beyond it along all edges there. So each part has a convex set of points, a
//! few half-spaces; these sets hardly overlap. A row of points meets a half-space in a stretch, so what a row has to be looked at for is found without a look at its points.
//!
//! A point takes the least of what is measured by the facets of each part that has it in its set, and the sets are a millionth of the band larger than they must be: so it has the
//! bits of the least by all facets.
//!
//! Source: characteristics (Mauch, A fast algorithm for computing the closest point and distance transform, 2000), here for any facets: open, crossing, or without an area.
//! Cost: 64 rows a part where facets and the band are of a few cells; one or two facets a point.

use std::ops::Range;

use super::facet::{Facet, cross, dot, minus};
use super::features::{Features, Place};
use super::tree::{Bounds, Tree};

/// Sets are larger by this part of the band.
const MARGIN: f64 = 1e-6;

/// The coordinates of some points along each axis.
pub(super) type Places<'a> = [&'a [f64]; 3];

/// Fills distances of points, x fastest, with at most a width.
pub(super) struct Scan<'a> {
    pub(super) tree: &'a Tree,
    pub(super) features: &'a Features,
    pub(super) width: f64,
    pub(super) places: Places<'a>,
}

/// Points whose places along a normal, from an origin, are no less than a number.
struct HalfSpace {
    normal: [f64; 3],
    per_x: f64,
    least: f64,
}

/// A part of the surface: points that may be nearest to it, and the facets there.
#[derive(Default)]
pub(super) struct Part {
    origin: [f64; 3],
    half_spaces: Vec<HalfSpace>,
    facets: Vec<u32>,
}

impl Part {
    fn begin(&mut self, origin: [f64; 3]) {
        self.origin = origin;
        self.half_spaces.clear();
        self.facets.clear();
    }

    /// Takes the points on one side of a plane through a point, and as far on the other.
    fn cut(&mut self, normal: [f64; 3], through: &[f64; 3], beyond: f64) {
        let least = dot(&normal, &minus(through, &self.origin)) - beyond * dot(&normal, &normal).sqrt();
        self.half_spaces.push(HalfSpace { normal, per_x: 1.0 / normal[0], least });
    }

    /// Where a row of points lies in all half-spaces.
    #[inline]
    fn of_row(&self, y: f64, z: f64) -> [f64; 2] {
        let (y, z) = (y - self.origin[1], z - self.origin[2]);
        let (mut low, mut high) = (f64::NEG_INFINITY, f64::INFINITY);
        for HalfSpace { normal, per_x, least } in &self.half_spaces {
            let left = least - normal[1] * y - normal[2] * z;
            if normal[0] > 0.0 {
                low = low.max(left * per_x);
            } else if normal[0] < 0.0 {
                high = high.min(left * per_x);
            } else if left > 0.0 {
                return [f64::INFINITY, f64::NEG_INFINITY];
            }
        }
        [low, high].map(|at| at + self.origin[0])
    }
}

impl Scan<'_> {
    /// The distances of all points.
    pub(super) fn distances(&self, part: &mut Part) -> Vec<f64> {
        let n = self.places.map(<[f64]>::len);
        let mut squares = vec![f64::INFINITY; n.iter().product()];
        if !squares.is_empty() {
            let ends = |at: fn(usize) -> usize| [0, 1, 2].map(|axis| self.places[axis][at(n[axis])]);
            let points = Bounds::of(&[ends(|_| 0), ends(|n| n - 1)]).widened([self.beyond(); 3]);
            self.tree.touching(&points, |facet| self.look_from(facet, &mut squares, part));
        }
        squares.iter_mut().for_each(|square| *square = square.sqrt().min(self.width));
        squares
    }

    /// The width of the band, and a little.
    fn beyond(&self) -> f64 {
        self.width * (1.0 + MARGIN)
    }

    /// Looks at the points near a facet, and near the edges and corners that are met here first.
    fn look_from(&self, index: usize, squares: &mut [f64], part: &mut Part) {
        let facet = self.tree.facet(index);
        self.look_from_face(index, facet, squares, part);
        for number in 0..3 {
            if let Some(group) = self.features.edges.begun_at(index, number) {
                self.look_from_edge(group, facet.edge(number), squares, part);
            }
            if let Some(group) = self.features.corners.begun_at(index, number) {
                self.look_from_corner(group, facet.corners[number], squares, part);
            }
        }
    }

    fn look_from_face(&self, index: usize, facet: &Facet, squares: &mut [f64], part: &mut Part) {
        let Some(normal) = facet.normal() else { return };
        let (margin, beyond) = (MARGIN * self.width, self.beyond());
        part.begin(facet.corners[0]);
        part.facets.push(index as u32);
        part.cut(normal, &facet.corners[0], beyond);
        part.cut(normal.map(|component| -component), &facet.corners[0], beyond);
        for number in 0..3 {
            part.cut(cross(&normal, &facet.along(number)), &facet.corners[number], margin);
        }
        let length = dot(&normal, &normal).sqrt();
        let widened = normal.map(|component| beyond * component.abs() / length + margin);
        self.look(&Bounds::of(&facet.corners).widened(widened), squares, part);
    }

    fn look_from_edge(&self, group: &[Place], [from, to]: [[f64; 3]; 2], squares: &mut [f64], part: &mut Part) {
        let margin = MARGIN * self.width;
        part.begin(from);
        let along = minus(&to, &from);
        part.cut(along, &from, margin);
        part.cut(along.map(|component| -component), &to, margin);
        for place in group {
            let facet = self.tree.facet(place.facet());
            part.facets.push(place.facet() as u32);
            if let Some(normal) = facet.normal() {
                part.cut(cross(&facet.along(place.number()), &normal), &from, margin);
            }
        }
        self.look(&Bounds::of(&[from, to]).widened([self.beyond(); 3]), squares, part);
    }

    fn look_from_corner(&self, group: &[Place], corner: [f64; 3], squares: &mut [f64], part: &mut Part) {
        part.begin(corner);
        for place in group {
            part.facets.push(place.facet() as u32);
            let facet = self.tree.facet(place.facet());
            // of two facets at an edge each has another end for its next corner, unless one is turned over
            for other in [1, 2].map(|more| facet.corners[(place.number() + more) % 3]) {
                part.cut(minus(&corner, &other), &corner, MARGIN * self.width);
            }
        }
        self.look(&Bounds::of(&[corner]).widened([self.beyond(); 3]), squares, part);
    }

    /// Measures the points of a part within bounds.
    fn look(&self, bounds: &Bounds, squares: &mut [f64], part: &Part) {
        let Part { facets, .. } = part;
        let [nx, ny] = [0, 1].map(|axis| self.places[axis].len());
        let [across, down, along] = [0, 1, 2].map(|axis| within(self.places[axis], bounds.along(axis)));
        let of_rows = &self.places[0][across.clone()];
        if of_rows.is_empty() {
            return;
        }
        for z in along {
            for y in down.clone() {
                let row = [self.places[1][y], self.places[2][z]];
                let stretch = within(of_rows, part.of_row(row[0], row[1]));
                let first = across.start + nx * (y + ny * z);
                for x in stretch {
                    let (point, least) = ([of_rows[x], row[0], row[1]], &mut squares[first + x]);
                    for &facet in facets {
                        *least = least.min(self.tree.facet(facet as usize).square(&point));
                    }
                }
            }
        }
    }
}

/// Which of some ascending places lie between two.
#[inline]
fn within(places: &[f64], [low, high]: [f64; 2]) -> Range<usize> {
    let first = places.partition_point(|place| *place < low);
    first..first + places[first..].partition_point(|place| *place <= high)
}
