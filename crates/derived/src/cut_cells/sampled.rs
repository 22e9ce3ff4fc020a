//! Rays within a cell or a face, where a surface passes through itself: there its winding number has more than two values.
//!
//! Pieces in a cell -> integrals, by 16 x 16 rays along z, or 16 along the second axis of a face: each in the middle of a square or a strip. They begin at corner 0 of the cell or face, go along
//! an edge, then along a face. Places along a ray are exact; what was found depends on the face or the cell alone.

use super::edges::{Change, Insides, lengths, lower_edge_of};
use super::integrals::*;
use super::pieces::{Piece, Pieces};
use super::winding::{Winding, strips_of};

/// Rays along each axis across.
const N: u32 = 16;

/// Surfaces in a cell, from the weakest on: the winding numbers of each, and its pieces.
pub(super) type Cuts<'a> = [(&'a Winding, &'a [Piece])];

fn place(index: u32) -> f64 {
    (f64::from(index) + 0.5) / f64::from(N)
}

/// Length and middle of a part of one of n rays, which is a power of two: the lengths of all add up to the whole.
fn between(start: i64, end: i64, n: u32) -> (i64, f64) {
    let [from, to] = [start, end].map(|at| at / i64::from(n));
    (to - from, 0.5 * (number(start) + number(end)))
}

/// What each of some surfaces wins of a face, or, last of all, none.
pub(super) fn sampled_face(pieces: &Pieces, cuts: &Cuts, face: usize, insides: &Insides) -> Vec<OfFace> {
    let mut sums = vec![[0; 3]; cuts.len() + 1];
    for index in 0..N {
        let at = place(index);
        let mut windings = at_edge(cuts, face, at);
        let mut changes: Vec<Change> = on_face(pieces, cuts, face, at).collect();
        let holds = |of: usize, winding| insides.holds(cuts[of].0.rank, winding);
        lengths(&mut changes, &mut windings, holds, |of, start, end| {
            let (length, middle) = between(start, end, N);
            let moment = |at: f64| fixed(at * number(length));
            add_all(&mut sums[of], [length, moment(at), moment(middle)]);
        });
    }
    sums
}

/// What each of some surfaces wins of a cell, or, last of all, none.
pub(super) fn sampled_cell(pieces: &Pieces, cuts: &Cuts, insides: &Insides) -> Vec<OfCell> {
    const FLOOR: usize = 4;
    let mut sums = vec![[0; 4]; cuts.len() + 1];
    for x in (0..N).map(place) {
        let start = at_edge(cuts, FLOOR, x);
        let on_floor: Vec<Change> = on_face(pieces, cuts, FLOOR, x).collect();
        for y in (0..N).map(place) {
            let mut windings = start.clone();
            on_floor.iter().filter(|of| of.0 < y).for_each(|&(_, of, sign)| windings[of] -= i32::from(sign));
            let mut changes = Vec::new();
            for (of, (_, of_rank)) in cuts.iter().enumerate() {
                let met = of_rank
                    .iter()
                    .filter_map(|piece| Some((height(pieces.corners(piece), [x, y])?, of, piece.signs[2])));
                changes.extend(met);
            }
            let holds = |of: usize, winding| insides.holds(cuts[of].0.rank, winding);
            lengths(&mut changes, &mut windings, holds, |of, start, end| {
                let (length, middle) = between(start, end, N * N);
                let moment = |at: f64| fixed(at * number(length));
                add_all(&mut sums[of], [length, moment(x), moment(y), moment(middle)]);
            });
        }
    }
    sums
}

fn add_all<const M: usize>(sum: &mut [i64; M], more: [i64; M]) {
    sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
}

/// Winding numbers where a ray along the second axis of a face begins.
fn at_edge(cuts: &Cuts, face: usize, at: f64) -> Vec<i32> {
    let edge = lower_edge_of(face);
    let corner = super::edges::ends_of(edge)[0];
    let number = |(winding, _): &(&Winding, &[Piece])| {
        let before = winding.crossings.iter().filter(|of| usize::from(of.edge) == edge && of.at < at);
        winding.corners[corner] - before.map(|of| i32::from(of.sign)).sum::<i32>()
    };
    cuts.iter().map(number).collect()
}

/// Changes along a ray on a face.
fn on_face<'a>(pieces: &'a Pieces, cuts: &'a Cuts, face: usize, at: f64) -> impl Iterator<Item = Change> + 'a {
    cuts.iter().enumerate().flat_map(move |(of, (_, of_rank))| {
        let strips = of_rank.iter().flat_map(move |piece| strips_of(pieces, piece, face));
        let met = strips.filter(move |strip| strip.from[0] < at && at <= strip.to[0]);
        met.map(move |strip| (strip.height(at), of, strip.times as i8))
    })
}

/// Where a ray along z meets a piece.
fn height(corners: &[Point], [x, y]: [f64; 2]) -> Option<f64> {
    let mut is_within = false;
    for (at, from) in corners.iter().enumerate() {
        let to = &corners[if at + 1 == corners.len() { 0 } else { at + 1 }];
        if (from[1] < y) != (to[1] < y) {
            // the same for both pieces at a side
            let [from, to] = if from[1] < to[1] { [from, to] } else { [to, from] };
            is_within ^= from[0] + (to[0] - from[0]) * ((y - from[1]) / (to[1] - from[1])) < x;
        }
    }
    let vector = below_polygon(corners).1;
    let rise = |base: &Point| (vector[0] * (x - base[0]) + vector[1] * (y - base[1])) / vector[2];
    (is_within && vector[2] != 0.0).then(|| (corners[0][2] - rise(&corners[0])).clamp(0.0, 1.0))
}
