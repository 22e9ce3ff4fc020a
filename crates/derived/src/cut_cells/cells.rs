//! What each flag has of a cell that is cut, of its faces and of its edges.
//!
//! Pieces in a cell, winding numbers at its low corner -> [`Shares`]. Of edges lengths are swept, as on any ray. Of faces and of the cell, where one surface decides, its inside has what the
//! integrals say, and the strongest of the others, or the background, the rest. Where several do, the strongest has its inside; each other has what is within it and
//! in none of the stronger: a product of sums of columns. Geometries that no piece of reaches the face or cell are inside all of it, or outside; those that are weaker
//! than one that is inside of all of it do not count.
//!
//! Where the winding number of a surface has more than two values, rays decide (`sampled.rs`).

use std::ops::Range;

use super::cut_cell::Asked;
use super::edges::{Change, Insides, edges_of, ends_of, lengths};
use super::integrals::*;
use super::pieces::{Piece, Pieces};
use super::sampled::{sampled_cell, sampled_face};
use super::winding::{Two, Winding};

/// Columns of a product, at most: else rays are cheaper.
const MOST_COLUMNS: usize = 1 << 14;

/// Winding numbers of all ranks at a point, and which of them are inside there.
#[derive(Clone)]
pub(super) struct State<'a> {
    insides: Insides<'a>,
    windings: Vec<i32>,
    held: [u64; 4],
}

impl<'a> State<'a> {
    /// Before all surfaces.
    pub(super) fn new(insides: Insides<'a>) -> State<'a> {
        let mut state = State { insides, windings: vec![0; insides.kinds.len()], held: [0; 4] };
        state.begin();
        state
    }

    /// Goes back there.
    pub(super) fn begin(&mut self) {
        self.windings.fill(0);
        self.held = [0; 4];
        (0..self.windings.len()).for_each(|rank| self.hold(rank as u8));
    }

    fn hold(&mut self, rank: u8) {
        let (word, bit) = (&mut self.held[usize::from(rank / 64)], 1 << (rank % 64));
        *word = if self.insides.holds(rank, self.windings[usize::from(rank)]) { *word | bit } else { *word & !bit };
    }

    /// Passes a crossing.
    pub(super) fn pass(&mut self, rank: u8, sign: i8) {
        self.windings[usize::from(rank)] -= i32::from(sign);
        self.hold(rank);
    }

    /// Of a rank.
    pub(super) fn winding(&self, rank: u8) -> i32 {
        self.windings[usize::from(rank)]
    }

    /// The highest rank that is inside where some have other winding numbers.
    pub(super) fn winner_with(&self, others: &[(u8, i32)]) -> Option<u8> {
        let mut but = [0; 4];
        others.iter().for_each(|(rank, _)| but[usize::from(rank / 64)] |= 1u64 << (rank % 64));
        let inside = others.iter().filter(|(rank, winding)| self.insides.holds(*rank, *winding));
        self.winner(&but).max(inside.map(|(rank, _)| *rank).max())
    }

    /// The highest rank that is inside, of all but one.
    pub(super) fn winner_without(&self, rank: u8) -> Option<u8> {
        let mut but = [0; 4];
        but[usize::from(rank / 64)] = 1u64 << (rank % 64);
        self.winner(&but)
    }

    /// The highest rank that is inside, of all but some.
    pub(super) fn winner(&self, but: &[u64; 4]) -> Option<u8> {
        let word = (0..4).rev().find(|&word| self.held[word] & !but[word] != 0)?;
        Some((64 * word + 63 - (self.held[word] & !but[word]).leading_zeros() as usize) as u8)
    }
}

/// What a flag has of a cell.
#[derive(Clone, Copy, Default)]
pub(super) struct Share {
    pub(super) flag: u8,
    pub(super) cell: OfCell,
}

/// What a flag has of the faces of a cell, and of its edges.
#[derive(Clone, Copy, Default)]
pub(super) struct Border {
    pub(super) faces: [OfFace; 6],
    pub(super) edges: [i64; 12],
}

impl Border {
    /// Whether nothing of faces and edges has the flag.
    pub(super) fn is_empty(&self) -> bool {
        self.faces.iter().all(|face| face[0] == 0) && self.edges.iter().all(|&edge| edge == 0)
    }
}

/// What flags have of a cell, in their order.
#[derive(Default)]
pub(super) struct Flags {
    pub(super) shares: Vec<Share>,
    /// One a share, or none where they are not asked for, as they are large.
    pub(super) borders: Vec<Border>,
    has_borders: bool,
}

impl Flags {
    fn begin(&mut self, asked: Asked) {
        self.shares.clear();
        self.borders.clear();
        self.has_borders = asked.faces || asked.edges;
    }

    /// The place of a flag, which has nothing where it was not there.
    fn place(&mut self, flag: u8) -> usize {
        let at = self.shares.iter().position(|share| share.flag >= flag).unwrap_or(self.shares.len());
        if self.shares.get(at).is_none_or(|share| share.flag > flag) {
            self.shares.insert(at, Share { flag, ..Share::default() });
            if self.has_borders {
                self.borders.insert(at, Border::default());
            }
        }
        at
    }

    fn add_cell(&mut self, flag: u8, sum: OfCell) {
        let at = self.place(flag);
        add_all(&mut self.shares[at].cell, sum);
    }

    fn add_face(&mut self, flag: u8, face: usize, sum: OfFace) {
        let at = self.place(flag);
        add_all(&mut self.borders[at].faces[face], sum);
    }

    fn add_edge(&mut self, flag: u8, edge: usize, length: i64) {
        let at = self.place(flag);
        self.borders[at].edges[edge] += length;
    }
}

/// What all flags have of a cell; memory that is used for one after the other.
#[derive(Default)]
pub(super) struct Shares {
    pub(super) flags: Flags,
    pub(super) is_sampled: bool,
    windings: Vec<Winding>,
    ranges: Vec<Range<usize>>,
}

impl Shares {
    /// Has the parts of a cell that some flags have, and nothing else.
    pub(super) fn set(&mut self, parts: [(u8, i64); 2]) {
        self.is_sampled = false;
        self.flags.begin(Asked { faces: false, edges: false, centroids: false });
        for (flag, part) in parts {
            self.flags.add_cell(flag, [part, 0, 0, 0]);
        }
    }
}

/// What all cells are measured by.
#[derive(Clone, Copy)]
pub(super) struct Scene<'a> {
    pub(super) insides: Insides<'a>,
    pub(super) flag_of_rank: &'a [u8],
    /// Whether all facets of a rank face the same side.
    pub(super) is_oriented: &'a [bool],
    pub(super) asked: Asked,
}

/// Some surfaces of a cell and the flag of what is in none.
struct Found<'a> {
    cuts: Vec<(&'a Winding, &'a [Piece])>,
    rest: u8,
}

impl Scene<'_> {
    pub(super) fn flag(&self, rank: Option<u8>) -> u8 {
        rank.map_or(0, |rank| self.flag_of_rank[usize::from(rank)])
    }

    /// Measures a cell, given the state at its low corner.
    pub(super) fn measure(&self, pieces: &Pieces, of_cell: &[Piece], state: &State, shares: &mut Shares) {
        let Shares { flags, is_sampled, windings, ranges } = shares;
        flags.begin(self.asked);
        ranges.clear();
        let (mut present, mut start) = ([0; 4], 0);
        for of_rank in of_cell.chunk_by(|one, other| one.rank() == other.rank()) {
            let rank = of_rank[0].rank();
            present[usize::from(rank / 64)] |= 1u64 << (rank % 64);
            ranges.push(start..start + of_rank.len());
            start += of_rank.len();
        }
        let constant = state.winner(&present);
        ranges.retain(|range| Some(of_cell[range.start].rank()) > constant);
        windings.resize_with(windings.len().max(ranges.len()), Winding::default);
        for (winding, range) in windings.iter_mut().zip(ranges.iter()) {
            let of_rank = &of_cell[range.clone()];
            let first = state.windings[usize::from(of_rank[0].rank())];
            winding.find(pieces, of_rank, first, self.asked);
        }
        *is_sampled = false;
        let rest = self.flag(constant);
        if let [range] = &ranges[..] {
            let (winding, of_rank) = (&windings[0], &of_cell[range.clone()]);
            if let Some(two) = self.two_of_cell(pieces, winding, of_rank) {
                return self.of_one(pieces, (winding, of_rank), two, rest, flags);
            }
        }
        let cuts =
            windings.iter().zip(ranges.iter()).map(|(winding, range)| (winding, &of_cell[range.clone()])).collect();
        let found = Found { cuts, rest };
        *is_sampled = self.cell(pieces, &found, flags);
        if self.asked.faces {
            (0..6).for_each(|face| self.face(pieces, &found, face, flags));
        }
        if self.asked.edges {
            (0..12).for_each(|edge| self.edge(&found, edge, flags));
        }
    }

    fn two_of_cell(&self, pieces: &Pieces, winding: &Winding, of_rank: &[Piece]) -> Option<Two> {
        let is_oriented = self.is_oriented[usize::from(winding.rank)];
        if is_oriented { winding.two_of_cell(pieces, of_rank, &self.insides) } else { None }
    }

    /// A cell in which one surface decides, which has two sides there: so it has on the faces.
    fn of_one(&self, pieces: &Pieces, (winding, of_rank): (&Winding, &[Piece]), two: Two, rest: u8, flags: &mut Flags) {
        let flag = self.flag(Some(winding.rank));
        let own = within(winding.inside_cell(two));
        flags.add_cell(flag, own);
        flags.add_cell(rest, less(WHOLE_CELL, own));
        if self.asked.faces {
            for face in 0..6 {
                let on_face = winding.two_of_face((pieces, of_rank), face, true, &self.insides);
                let own = within(winding.inside_face(face, on_face.unwrap_or(two)));
                flags.add_face(flag, face, own);
                flags.add_face(rest, face, less(WHOLE_FACE, own));
            }
        }
        if self.asked.edges {
            let found = Found { cuts: vec![(winding, of_rank)], rest };
            (0..12).for_each(|edge| self.edge(&found, edge, flags));
        }
    }

    /// Measures the volumes of a cell; returns whether rays had to.
    fn cell(&self, pieces: &Pieces, Found { cuts, rest }: &Found, flags: &mut Flags) -> bool {
        let twos: Option<Vec<Two>> = cuts.iter().map(|(winding, of)| self.two_of_cell(pieces, winding, of)).collect();
        let columns = twos.and_then(|twos| {
            let both = cuts.iter().zip(twos).rev();
            let sums = both.map(|((winding, of), two)| winding.inside_columns(pieces, of, two));
            shares_of(sums, (whole_cell(1), WHOLE_CELL), product_of_columns, of_columns, |of| Column {
                times: -of.times,
                ..of.clone()
            })
        });
        let is_sampled = columns.is_none();
        let sums = columns.unwrap_or_else(|| sampled_cell(pieces, cuts, &self.insides));
        let flags_of = cuts.iter().map(|(winding, _)| self.flag(Some(winding.rank))).chain([*rest]);
        for (flag, sum) in flags_of.zip(sums) {
            flags.add_cell(flag, sum);
        }
        is_sampled
    }

    /// Measures the areas of a face: by what is on it alone, so that both of its cells find the same.
    fn face(&self, pieces: &Pieces, found: &Found, face: usize, flags: &mut Flags) {
        let corner = ends_of(edges_of(face)[0])[0];
        let at_corner = |winding: &Winding| self.insides.holds(winding.rank, winding.corners[corner]);
        let whole = found.cuts.iter().rposition(|(winding, _)| !winding.is_on(face) && at_corner(winding));
        let rest = whole.map_or(found.rest, |whole| self.flag(Some(found.cuts[whole].0.rank)));
        let stronger = &found.cuts[whole.map_or(0, |whole| whole + 1)..];
        let cuts: Vec<_> = stronger.iter().filter(|(winding, _)| winding.is_on(face)).copied().collect();
        let two = |(winding, of): &(&Winding, &[Piece])| {
            let is_oriented = self.is_oriented[usize::from(winding.rank)];
            is_oriented.then(|| winding.two_of_face((pieces, of), face, false, &self.insides))?
        };
        let twos: Option<Vec<Two>> = cuts.iter().map(two).collect();
        let strips = twos.and_then(|twos| match (&cuts[..], &twos[..]) {
            ([(winding, _)], [two]) => {
                let own = within(winding.inside_face(face, *two));
                Some(vec![own, less(WHOLE_FACE, own)])
            }
            _ => {
                let both = cuts.iter().zip(&twos).rev();
                let sums = both.map(|((winding, of), two)| winding.inside_strips(pieces, of, face, *two));
                shares_of(sums, (whole_face(1), WHOLE_FACE), product_of_strips, of_strips, |of| Strip {
                    times: -of.times,
                    ..*of
                })
            }
        });
        let sums = strips.unwrap_or_else(|| sampled_face(pieces, &cuts, face, &self.insides));
        let flags_of = cuts.iter().map(|(winding, _)| self.flag(Some(winding.rank))).chain([rest]);
        for (flag, sum) in flags_of.zip(sums) {
            flags.add_face(flag, face, sum);
        }
    }

    /// Measures the lengths of an edge.
    fn edge(&self, Found { cuts, rest }: &Found, edge: usize, flags: &mut Flags) {
        let corner = ends_of(edge)[0];
        let mut windings: Vec<i32> = cuts.iter().map(|(winding, _)| winding.corners[corner]).collect();
        let changes = cuts.iter().enumerate().flat_map(|(of, (winding, _))| {
            let of_edge = winding.crossings.iter().filter(|crossing| usize::from(crossing.edge) == edge);
            of_edge.map(move |crossing| (crossing.at, of, crossing.sign))
        });
        let mut changes: Vec<Change> = changes.collect();
        let holds = |of: usize, winding| self.insides.holds(cuts[of].0.rank, winding);
        lengths(&mut changes, &mut windings, holds, |of, start, end| {
            let flag = cuts.get(of).map_or(*rest, |(winding, _)| self.flag(Some(winding.rank)));
            flags.add_edge(flag, edge, end - start);
        });
    }
}

/// Integrals over a whole cell.
const WHOLE_CELL: OfCell = [WHOLE, WHOLE / 2, WHOLE / 2, WHOLE / 2];
/// Integrals over a whole face.
const WHOLE_FACE: OfFace = [WHOLE, WHOLE / 2, WHOLE / 2];

fn add_all<const N: usize>(sum: &mut [i64; N], more: [i64; N]) {
    sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
}

fn less<const N: usize>(whole: [i64; N], sum: [i64; N]) -> [i64; N] {
    std::array::from_fn(|of| whole[of] - sum[of])
}

/// Integrals that were rounded: none below 0, none above the whole.
fn within<const N: usize>(sum: [i64; N]) -> [i64; N] {
    std::array::from_fn(|of| sum[of].clamp(0, if of == 0 { WHOLE } else { WHOLE / 2 }))
}

/// What each of some insides has, given from the strongest on, and then what none has; returned from the weakest on, with the last for none. None where the products would be too long.
fn shares_of<T: Clone, const N: usize>(
    insides: impl Iterator<Item = Vec<T>>,
    (whole, of_whole): (T, [i64; N]),
    product: fn(&[T], &[T]) -> Vec<T>,
    integrals: fn(&[T]) -> [i64; N],
    negative: fn(&T) -> T,
) -> Option<Vec<[i64; N]>> {
    let (mut left, mut sums, mut rest) = (vec![whole], Vec::new(), of_whole);
    for (index, inside) in insides.enumerate() {
        if inside.len() * left.len() > MOST_COLUMNS {
            return None;
        }
        let own = if index == 0 { inside } else { product(&inside, &left) };
        let sum = integrals(&own);
        let sum = std::array::from_fn(|of| sum[of].clamp(0, rest[of]));
        rest = less(rest, sum);
        sums.push(sum);
        left.extend(own.iter().map(negative));
    }
    sums.reverse();
    sums.push(rest);
    Some(sums)
}
