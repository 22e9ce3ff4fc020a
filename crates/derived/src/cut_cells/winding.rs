//! The winding number of one surface over a cell, its faces and its edges: integrals of it, and what they say of the inside.
//!
//! # Theory
//! Edges: the winding number at the upper end, and for each crossing its place times its sign. Faces: what is below the segments in which pieces
//! meet the face, and the upper edge times the height (Green). Cells: what is below the pieces, and the upper face times the height (Gauss).
//!
//! Where the winding number w has two values alone, m and m + 1, the integral of w - m is the part with m + 1: that and the rule give what is inside. One piece has two sides.
//! Several that hang together and do not pass through each other are one sheet, which divides the cell into two parts. Several that are part of one convex body, or of the rest of one, have two
//! sides as well. Otherwise (w - m) (w - m - 1), which is nowhere negative, is 0 everywhere exactly if its
//! integral is 0.

use super::cut_cell::Asked;
use super::edges::{ACROSS, Crossing, Insides, at_corners, crossings, edges_of, ends_of, upper_edge_of};
use super::integrals::*;
use super::pieces::{Piece, Pieces};

/// Integrals of (w - m) (w - m - 1) below this are rounding.
const ROUNDING: f64 = 1e-11;
/// A corner this far above a plane, in cells, is on it.
const FLAT: f64 = 1e-13;

/// A surface in a cell.
#[derive(Clone, Default)]
pub(super) struct Winding {
    pub(super) rank: u8,
    /// At the corners.
    pub(super) corners: [i32; 8],
    pub(super) crossings: Vec<Crossing>,
    n_of_edge: [u8; 12],
    /// Sums of places, and of their squares by 2, without the upper ends.
    edges: [[i64; 2]; 12],
    /// Sums below segments, without the upper edges; and how many segments there are.
    faces: [OfFace; 6],
    n_of_face: [u16; 6],
    /// Sums below pieces, without the upper face.
    cell: OfCell,
}

/// Two values of a winding number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Two {
    /// The less, counted from the number at corner 0.
    low: i32,
    /// Whether both are inside.
    are_inside: [bool; 2],
}

impl Two {
    /// The values of a rank, of which the lower is given, counted from the number at corner 0; that is given, too.
    #[inline(always)]
    pub(super) fn new((rank, first): (u8, i32), low: i32, insides: &Insides) -> Two {
        let number = first + low;
        Two { low, are_inside: [number, number + 1].map(|number| insides.holds(rank, number)) }
    }

    /// What of an integral is inside, given what the whole has of the same.
    #[inline(always)]
    pub(super) fn inside(&self, sum: i64, whole: i64) -> i64 {
        let of_upper = sum.wrapping_sub(whole.wrapping_mul(self.low.into()));
        match self.are_inside {
            [false, false] => 0,
            [false, true] => of_upper,
            [true, false] => whole - of_upper,
            [true, true] => whole,
        }
    }
}

impl Winding {
    /// Takes in the pieces of a rank; the winding number at the low corner of the cell is known.
    pub(super) fn find(&mut self, pieces: &Pieces, of_rank: &[Piece], first: i32, asked: Asked) {
        self.crossings.clear();
        (self.n_of_edge, self.edges, self.faces) = ([0; 12], [[0; 2]; 12], [[0; 3]; 6]);
        (self.n_of_face, self.cell, self.rank) = ([0; 6], [0; 4], of_rank[0].rank());
        let mut losses = [0; 12];
        for piece in of_rank {
            crossings(pieces, piece, |crossing| {
                let edge = usize::from(crossing.edge);
                losses[edge] += i32::from(crossing.sign);
                self.n_of_edge[edge] = self.n_of_edge[edge].saturating_add(1);
                let places = [crossing.at, 0.5 * crossing.at * crossing.at];
                add(&mut self.edges[edge], places, crossing.sign.into());
                self.crossings.push(crossing);
            });
            let (corners, sides) = (pieces.corners(piece), pieces.sides(piece));
            for (at, &side) in
                sides.iter().enumerate().filter(|(_, side)| if asked.faces { **side > 0 } else { **side == 6 })
            {
                let face = usize::from(side - 1);
                let next = if at + 1 == corners.len() { 0 } else { at + 1 };
                let strip = strip(face, [&corners[at], &corners[next]], piece);
                self.n_of_face[face] = self.n_of_face[face].saturating_add(1);
                add(&mut self.faces[face], below_segment(strip.from, strip.to), strip.times);
            }
            if asked.centroids {
                add(&mut self.cell, below_polygon(corners).0, 1);
            } else {
                self.cell[0] = self.cell[0].wrapping_add(fixed(below_polygon(corners).0[0]));
            }
        }
        self.corners = at_corners(first, &losses);
    }

    /// The number at a corner, counted from that at corner 0.
    #[inline(always)]
    fn above_first(&self, corner: usize) -> i32 {
        self.corners[corner].wrapping_sub(self.corners[0])
    }

    #[inline(always)]
    fn edge(&self, edge: usize) -> [i64; 2] {
        let upper = i64::from(self.above_first(ends_of(edge)[1])).wrapping_mul(WHOLE);
        let [length, moment] = self.edges[edge];
        [length.wrapping_add(upper), moment.wrapping_add(upper >> 1)]
    }

    #[inline(always)]
    fn face(&self, face: usize) -> OfFace {
        let ([length, moment], [area, first, second]) = (self.edge(upper_edge_of(face)), self.faces[face]);
        [area.wrapping_add(length), first.wrapping_add(moment), second.wrapping_add(length >> 1)]
    }

    #[inline(always)]
    fn cell(&self) -> OfCell {
        let ([area, x, y], [volume, of_x, of_y, of_z]) = (self.face(5), self.cell);
        [volume.wrapping_add(area), of_x.wrapping_add(x), of_y.wrapping_add(y), of_z.wrapping_add(area >> 1)]
    }

    /// The two values, by the corners, edges and the integral of some of the cell; None where there are more.
    #[inline(always)]
    fn two(&self, corners: &[usize], edges: &[usize], integral: i64, insides: &Insides) -> Option<Two> {
        let numbers = corners.iter().map(|&corner| self.above_first(corner));
        let (low, high) = numbers.fold((i32::MAX, i32::MIN), |(low, high), at| (low.min(at), high.max(at)));
        let is_less = low == high && integral < i64::from(low).wrapping_mul(WHOLE);
        let low = if is_less { low - 1 } else { low };
        let is_within = |at: i32| (low..=low + 1).contains(&at);
        if !is_within(high) || edges.iter().any(|&edge| self.n_of_edge[edge] > 1 && !self.stays(edge, is_within)) {
            return None;
        }
        Some(Two::new((self.rank, self.corners[0]), low, insides))
    }

    /// Whether all numbers along an edge are some of these.
    fn stays(&self, edge: usize, is_within: impl Fn(i32) -> bool) -> bool {
        let of_edge = self.crossings.iter().filter(|crossing| usize::from(crossing.edge) == edge);
        let mut of_edge: Vec<(f64, i8)> = of_edge.map(|crossing| (crossing.at, crossing.sign)).collect();
        of_edge.sort_unstable_by(|one, other| one.0.total_cmp(&other.0));
        let mut number = self.above_first(ends_of(edge)[0]);
        of_edge.chunk_by(|one, other| one.0 == other.0).all(|at_place| {
            number -= at_place.iter().map(|(_, sign)| i32::from(*sign)).sum::<i32>();
            is_within(number)
        })
    }

    /// The two values in the cell; None where there are more.
    pub(super) fn two_of_cell(&self, pieces: &Pieces, of_rank: &[Piece], insides: &Insides) -> Option<Two> {
        const ALL: [usize; 12] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11];
        let two = self.two(&ALL[..8], &ALL, self.cell()[0], insides)?;
        let is_sure = of_rank.len() == 1 || are_one_sheet(pieces, of_rank) || are_of_convex(pieces, of_rank);
        let is_two = || {
            let less = self.columns(pieces, of_rank, two);
            let more: Vec<Column> = less.iter().cloned().chain([whole_cell(-1)]).collect();
            number(of_columns(&product_of_columns(&less, &more))[0]).abs() < ROUNDING
        };
        (is_sure || is_two()).then_some(two)
    }

    /// The two values on a face; None where there are more. Nothing is left to find where it is known that the cell has two.
    pub(super) fn two_of_face(
        &self,
        (pieces, of_rank): (&Pieces, &[Piece]),
        face: usize,
        is_known: bool,
        insides: &Insides,
    ) -> Option<Two> {
        let edges = edges_of(face);
        let [a, b] = [edges[0], edges[1]].map(ends_of);
        let two = self.two(&[a[0], a[1], b[0], b[1]], &edges, self.face(face)[0], insides)?;
        let is_two = || {
            let less = self.strips(pieces, of_rank, face, two);
            let more: Vec<Strip> = less.iter().copied().chain([whole_face(-1)]).collect();
            number(of_strips(&product_of_strips(&less, &more))[0]).abs() < ROUNDING
        };
        (is_known || self.n_of_face[face] <= 1 || is_two()).then_some(two)
    }

    /// Whether the surface meets a face, or edges of it.
    pub(super) fn is_on(&self, face: usize) -> bool {
        self.n_of_face[face] > 0 || edges_of(face).iter().any(|&edge| self.n_of_edge[edge] > 0)
    }

    /// Integrals of the inside over a face.
    pub(super) fn inside_face(&self, face: usize, two: Two) -> OfFace {
        let [area, first, second] = self.face(face);
        [two.inside(area, WHOLE), two.inside(first, WHOLE / 2), two.inside(second, WHOLE / 2)]
    }

    /// Integrals of the inside over the cell.
    pub(super) fn inside_cell(&self, two: Two) -> OfCell {
        let [volume, x, y, z] = self.cell();
        let half = |sum| two.inside(sum, WHOLE / 2);
        [two.inside(volume, WHOLE), half(x), half(y), half(z)]
    }

    /// w - m over a face, m being the lower of two values, as a sum of strips.
    fn strips(&self, pieces: &Pieces, of_rank: &[Piece], face: usize, two: Two) -> Vec<Strip> {
        let upper = upper_edge_of(face);
        let of_edge = self.crossings.iter().filter(|crossing| usize::from(crossing.edge) == upper);
        let below = |crossing: &Crossing| Strip { to: [crossing.at, 1.0], ..whole_face(crossing.sign.into()) };
        let mut strips: Vec<Strip> = of_edge.map(below).collect();
        strips.push(whole_face(self.above_first(ends_of(upper)[1]) - two.low));
        for piece in of_rank {
            strips.extend(strips_of(pieces, piece, face));
        }
        strips.retain(|strip| strip.times != 0 && strip.from[0] < strip.to[0]);
        strips
    }

    /// w - m over the cell, as a sum of columns.
    fn columns(&self, pieces: &Pieces, of_rank: &[Piece], two: Two) -> Vec<Column> {
        let of_pieces = of_rank.iter().filter_map(|piece| {
            let (corners, sign) = (pieces.corners(piece), piece.signs[2]);
            // rounded, it may be turned over: then it is next to nothing
            if sign == 0 { None } else { Column::new(corners, sign.into()) }
        });
        let lids = self.strips(pieces, of_rank, 5, two).into_iter().map(|Strip { from, to, times }| {
            let corners = vec![[from[0], 0.0, 1.0], [to[0], 0.0, 1.0], [to[0], to[1], 1.0], [from[0], from[1], 1.0]];
            Column { corners, times }
        });
        of_pieces.chain(lids).collect()
    }

    /// The inside over a face as a sum of strips.
    pub(super) fn inside_strips(&self, pieces: &Pieces, of_rank: &[Piece], face: usize, two: Two) -> Vec<Strip> {
        let more = || self.strips(pieces, of_rank, face, two);
        match two.are_inside {
            [false, false] => Vec::new(),
            [false, true] => more(),
            [true, false] => {
                more().into_iter().map(|of| Strip { times: -of.times, ..of }).chain([whole_face(1)]).collect()
            }
            [true, true] => vec![whole_face(1)],
        }
    }

    /// The inside over the cell as a sum of columns.
    pub(super) fn inside_columns(&self, pieces: &Pieces, of_rank: &[Piece], two: Two) -> Vec<Column> {
        let more = || self.columns(pieces, of_rank, two);
        match two.are_inside {
            [false, false] => Vec::new(),
            [false, true] => more(),
            [true, false] => {
                more().into_iter().map(|of| Column { times: -of.times, ..of }).chain([whole_cell(1)]).collect()
            }
            [true, true] => vec![whole_cell(1)],
        }
    }
}

/// What a side of a piece is on a face.
#[inline(always)]
fn strip(face: usize, ends: [&Point; 2], piece: &Piece) -> Strip {
    let [first, second] = ACROSS[face / 2];
    let [one, other] = ends.map(|corner| [corner[first], corner[second]]);
    Strip::new(one, other, piece.signs[second].into())
}

/// The segments of a piece on a face.
pub(super) fn strips_of<'a>(pieces: &'a Pieces, piece: &'a Piece, face: usize) -> impl Iterator<Item = Strip> + 'a {
    let (corners, sides) = (pieces.corners(piece), pieces.sides(piece));
    let of_face = sides.iter().enumerate().filter(move |(_, side)| usize::from(**side) == face + 1);
    of_face.map(move |(at, _)| {
        let next = if at + 1 == corners.len() { 0 } else { at + 1 };
        strip(face, [&corners[at], &corners[next]], piece)
    })
}

/// Pieces of which it is found out whether they are one sheet.
const MOST_OF_SHEET: usize = 32;

/// Whether pieces are one sheet: each side within the cell has one other piece beside it, all hang together, and two that have no side in common are on different sides of the plane of one
/// of them. Both pieces at a side have the same numbers for its ends.
fn are_one_sheet(pieces: &Pieces, of_rank: &[Piece]) -> bool {
    let n = of_rank.len();
    if n > MOST_OF_SHEET {
        return false;
    }
    let mut beside = [0u32; MOST_OF_SHEET];
    for (at, piece) in of_rank.iter().enumerate() {
        for [from, to] in sides_within(pieces, piece) {
            let mut others = 0;
            for (index, other) in of_rank.iter().enumerate().filter(|(index, _)| *index != at) {
                let n_common = sides_within(pieces, other).filter(|[start, end]| *start == to && *end == from).count();
                others += n_common;
                beside[at] |= u32::from(n_common > 0) << index;
            }
            if others != 1 {
                return false;
            }
        }
    }
    let are_apart = |(one, other): (usize, usize)| {
        beside[one] >> other & 1 == 1 || is_divided(pieces, [&of_rank[one], &of_rank[other]])
    };
    hang_together(&beside[..n])
        && (n == 2 || (0..n).flat_map(|one| (0..one).map(move |other| (one, other))).all(are_apart))
}

/// Whether all pieces can be reached from the first, given which are beside each.
pub(super) fn hang_together(beside: &[u32]) -> bool {
    let (mut reached, mut last) = (1u32, 0);
    while reached != last {
        last = reached;
        reached |= (0..beside.len()).filter(|at| last >> at & 1 == 1).fold(0, |all, at| all | beside[at]);
    }
    reached.count_ones() as usize == beside.len()
}

/// The sides of a piece that lie within the cell, not on its faces.
fn sides_within<'a>(pieces: &'a Pieces, piece: &Piece) -> impl Iterator<Item = [&'a Point; 2]> {
    let (corners, sides) = (pieces.corners(piece), pieces.sides(piece));
    let ends = (0..corners.len()).map(|at| [&corners[at], &corners[if at + 1 == corners.len() { 0 } else { at + 1 }]]);
    ends.zip(sides).filter(|(ends, side)| **side == 0 && ends[0] != ends[1]).map(|(ends, _)| ends)
}

/// Whether one of two pieces is on one side of the plane of the other, and not in it.
pub(super) fn is_divided(pieces: &Pieces, [one, other]: [&Piece; 2]) -> bool {
    [(one, other), (other, one)].iter().any(|(plane, piece)| {
        let (vector, base) = (below_polygon(pieces.corners(plane)).1, pieces.corners(plane)[0]);
        let limit = FLAT * vector.iter().map(|component| component.abs()).sum::<f64>();
        let height = |corner: &Point| (0..3).map(|axis| vector[axis] * (corner[axis] - base[axis])).sum::<f64>();
        let heights = pieces.corners(piece).iter().map(height);
        let (low, high) = heights.fold((0.0f64, 0.0f64), |(low, high), at| (low.min(at), high.max(at)));
        (high <= limit) != (low >= -limit)
    })
}

/// Whether all pieces are on one side of the planes of all others, and no two of them in one plane: then they are part of a convex body, or of the rest of one.
fn are_of_convex(pieces: &Pieces, of_rank: &[Piece]) -> bool {
    let (mut is_convex, mut is_concave) = (true, true);
    for (at, piece) in of_rank.iter().enumerate() {
        let (corners, vector) = (pieces.corners(piece), below_polygon(pieces.corners(piece)).1);
        let size = vector.iter().map(|component| component.abs()).sum::<f64>();
        let base = corners[0];
        for other in of_rank[..at].iter().chain(&of_rank[at + 1..]) {
            let height = |corner: &Point| (0..3).map(|axis| vector[axis] * (corner[axis] - base[axis])).sum::<f64>();
            let of_other = pieces.corners(other).iter().map(height);
            let (low, high) = of_other.fold((0.0f64, 0.0f64), |(low, high), at| (low.min(at), high.max(at)));
            let limit = FLAT * size;
            let (is_below, is_above) = (high <= limit, low >= -limit);
            if is_below == is_above {
                return false;
            }
            (is_convex, is_concave) = (is_convex && is_below, is_concave && is_above);
            if !is_convex && !is_concave {
                return false;
            }
        }
    }
    true
}
