//! Edges of a cell: where surfaces cross them, and the length that each flag has.
//!
//! Pieces in a cell -> crossings, as they would be met by rays along the lines; winding numbers at the eight corners; lengths. A corner of a
//! piece that is on two faces is a crossing of the edge between these. All cells at an edge have the same ones.
//!
//! Edges are numbered by their axis: 4 along x, then y, then z; of an axis by where they are along the two others, ascending: low and low, high and low, low
//! and high, high and high. Faces: below and above along x, then y, then z. Corners: bits of x, y and z. A face across x has y and z as its first and second axis, one across y has x and z, one across z has x and y.

use super::integrals::{WHOLE, fixed};
use super::pieces::{Piece, Pieces};
use hexcast_core::input::job::Rule;
use hexcast_core::stages::inside::{Kind, is_inside};

/// A crossing of an edge.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Crossing {
    pub(super) edge: u8,
    /// 1 where a ray leaves, -1 where it enters.
    pub(super) sign: i8,
    /// From the low end of the edge, in edges.
    pub(super) at: f64,
}

/// The first and the second axis of the faces across an axis.
pub(super) const ACROSS: [[usize; 2]; 3] = [[1, 2], [0, 2], [0, 1]];

/// The corners at the ends of an edge.
#[inline(always)]
pub(super) fn ends_of(edge: usize) -> [usize; 2] {
    let (axis, place) = (edge / 4, edge % 4);
    let [first, second] = ACROSS[axis];
    let low = (place & 1) << first | (place >> 1) << second;
    [low, low | 1 << axis]
}

/// The edge of a face that lies along its first axis, at the upper end of its second.
#[inline(always)]
pub(super) fn upper_edge_of(face: usize) -> usize {
    let (axis, side) = (face / 2, face % 2);
    let [first, second] = ACROSS[axis];
    edge(first, [(axis, side), (second, 1)])
}

/// The edge of a face that lies along its first axis, at the lower end of its second.
pub(super) fn lower_edge_of(face: usize) -> usize {
    let (axis, side) = (face / 2, face % 2);
    let [first, second] = ACROSS[axis];
    edge(first, [(axis, side), (second, 0)])
}

/// The four edges of a face.
pub(super) fn edges_of(face: usize) -> [usize; 4] {
    let (axis, side) = (face / 2, face % 2);
    let [first, second] = ACROSS[axis];
    let of = |along: usize, other: usize, end: usize| edge(along, [(axis, side), (other, end)]);
    [of(first, second, 0), of(first, second, 1), of(second, first, 0), of(second, first, 1)]
}

/// The edge along an axis at the given ends of the two others.
const fn edge(along: usize, [one, other]: [(usize, usize); 2]) -> usize {
    let low = if one.0 < other.0 { one.1 + 2 * other.1 } else { other.1 + 2 * one.1 };
    4 * along + low
}

/// By the sides before and behind a corner of a piece the edge that it is on, or [`NO_EDGE`].
const EDGE_BETWEEN: [[u8; 7]; 7] = {
    let mut table = [[NO_EDGE; 7]; 7];
    let mut one = 0;
    while one < 6 {
        let mut other = 0;
        while other < 6 {
            if one / 2 != other / 2 {
                let along = 3 - one / 2 - other / 2;
                table[one + 1][other + 1] = edge(along, [(one / 2, one % 2), (other / 2, other % 2)]) as u8;
            }
            other += 1;
        }
        one += 1;
    }
    table
};
const NO_EDGE: u8 = 255;

/// Calls `each` with the crossings of a piece with the edges of its cell.
#[inline(always)]
pub(super) fn crossings(pieces: &Pieces, piece: &Piece, mut each: impl FnMut(Crossing)) {
    let (corners, sides) = (pieces.corners(piece), pieces.sides(piece));
    let mut before = sides[sides.len() - 1];
    for (corner, &behind) in corners.iter().zip(sides) {
        let edge = EDGE_BETWEEN[usize::from(before)][usize::from(behind)];
        if edge != NO_EDGE {
            let axis = usize::from(edge / 4);
            each(Crossing { edge, sign: piece.signs[axis], at: corner[axis] });
        }
        before = behind;
    }
}

/// Winding numbers at the corners, given that at the first, and how much less they are behind each edge than before it.
#[inline(always)]
pub(super) fn at_corners(first: i32, losses: &[i32; 12]) -> [i32; 8] {
    let mut at = [first; 8];
    at[1] = first - losses[0];
    (at[2], at[3]) = (first - losses[4], at[1] - losses[5]);
    for corner in 0..4 {
        at[4 + corner] = at[corner] - losses[8 + corner];
    }
    at
}

/// Which places are inside of a geometry, by its winding number there.
#[derive(Clone, Copy)]
pub(super) struct Insides<'a> {
    pub(super) rule: Rule,
    pub(super) kinds: &'a [Kind],
}

impl Insides<'_> {
    #[inline(always)]
    pub(super) fn holds(&self, rank: u8, winding: i32) -> bool {
        is_inside(self.rule, winding) != (self.kinds[usize::from(rank)] == Kind::Inverted)
    }
}

/// A change along a line: where, of which of some surfaces, and its sign.
pub(super) type Change = (f64, usize, i8);

/// Lengths along a line from 0 to 1 on which each of some surfaces wins, or, last of all, none; their order is from the weakest on. `windings` are those at 0.
pub(super) fn lengths(
    changes: &mut [Change],
    windings: &mut [i32],
    holds: impl Fn(usize, i32) -> bool,
    mut each: impl FnMut(usize, i64, i64),
) {
    changes.sort_unstable_by(|one, other| one.0.total_cmp(&other.0).then((one.1, one.2).cmp(&(other.1, other.2))));
    let winner = |windings: &[i32]| (0..windings.len()).rev().find(|&of| holds(of, windings[of]));
    let (mut start, mut at) = (0, winner(windings));
    for &(place, of, sign) in changes.iter() {
        windings[of] -= i32::from(sign);
        let next = winner(windings);
        if next != at {
            let end = fixed(place).clamp(start, WHOLE);
            each(at.unwrap_or(windings.len()), start, end);
            (start, at) = (end, next);
        }
    }
    each(at.unwrap_or(windings.len()), start, WHOLE);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_faces_and_corners_belong_together() {
        let mut n_faces = [0; 12];
        for face in 0..6 {
            let corners: Vec<usize> = (0..8).filter(|corner| corner >> (face / 2) & 1 == face % 2).collect();
            for edge in edges_of(face) {
                n_faces[edge] += 1;
                assert!(ends_of(edge).iter().all(|end| corners.contains(end)), "face {face}, edge {edge}");
            }
            let [first, second] = ACROSS[face / 2];
            for (edge, end) in [(lower_edge_of(face), 0), (upper_edge_of(face), 1)] {
                assert!(edges_of(face).contains(&edge) && edge / 4 == first);
                assert!(ends_of(edge).iter().all(|corner| corner >> second & 1 == end));
            }
        }
        assert_eq!(n_faces, [2; 12]);
        for (one, row) in EDGE_BETWEEN.iter().enumerate().skip(1) {
            for (other, &edge) in row.iter().enumerate().skip(1).filter(|(_, edge)| **edge != NO_EDGE) {
                assert!([one, other].iter().all(|face| edges_of(face - 1).contains(&edge.into())));
            }
        }
    }

    #[test]
    fn the_strongest_wins_along_a_line() {
        let mut changes = vec![(0.75, 0, 1), (0.5, 1, 1), (0.25, 1, -1)];
        let mut found = Vec::new();
        lengths(&mut changes, &mut [1, 0], |_, winding| winding != 0, |of, start, end| found.push((of, end - start)));
        let quarter = WHOLE / 4;
        assert_eq!(found, [(0, quarter), (1, quarter), (0, quarter), (2, quarter)]);
    }
}
