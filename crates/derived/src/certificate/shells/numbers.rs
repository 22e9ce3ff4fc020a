//! Numbers the shells of a geometry: the groups of facets that are connected over shared edges.
//!
//! Facets -> [`Numbers`]. Two corners are one vertex where their f32 coordinates are equal (-0 = +0), as in [`hexcast_core::input::surface`]. A facet with two
//! equal corners is collapsed: it has no edges, and belongs to no shell. Shells are numbered by their first facets.
//!
//! # Theory
//! Facets that share an edge stand near one another in nearly all files. So some facets at a time are numbered by themselves: the edges that
//! one of them has and no other yet are kept in a table, small enough for the cache of a core. A facet takes the number of one that
//! had an edge of it before, or a new number if there is none. Edges that wait for another facet when the table is full, or at the end, are handed
//! on, and join the shells of several such pieces, by tables that have those edges each whose hashes begin alike. Where an edge may have more than two
//! facets, all edges are handed on. An edge is known by a hash of 64 bits; two of 10^7 edges have the same by accident in one of 10^5 files.
//!
//! Cost: some 30 ns a facet on one core; 4 bytes a facet where there are several shells, and for a moment 32 bytes for each edge that is handed on.

use hexcast_core::base::control::{Control, Paced};
use hexcast_core::base::error::Result;
use hexcast_core::base::memory::Memory;
use hexcast_core::base::parallel::*;
use hexcast_core::input::edges::{Groups, corner_key, product};
use hexcast_core::input::geometry::{Facet, SharedFacets};

/// Facets that are numbered by themselves.
const FACETS_OF_PIECE: usize = 1 << 17;
/// Least pieces of a step: some tens of milliseconds.
const PIECES_AT_ONCE: usize = 8;

/// The number of a facet that belongs to no shell.
const NONE: u32 = u32::MAX;

/// An edge by its hash, and the number of a facet that has it.
type Edge = (u64, u32);

/// The shell of each facet.
pub struct Numbers {
    /// By facet; empty where there is one shell or none.
    of_facet: Vec<u32>,
    /// The first facet of each shell.
    pub(crate) first_facets: Vec<u32>,
}

/// What errors of memory call what numbering needs.
const NUMBERED: &str = "the edges that connect the shells of a surface, which --quick does not ask for,";

impl Numbers {
    /// Numbers the shells; `is_proper` says that no edge has more than two facets.
    ///
    /// # Errors
    /// `cancelled`; `memory`; `io` where facets stay in their file, and that cannot be read again.
    pub async fn new(facets: &SharedFacets, is_proper: bool, memory: &Memory, control: &Control) -> Result<Numbers> {
        let mut room = memory.take(0, NUMBERED)?;
        let mut pieces: Vec<Piece> = Vec::new();
        let mut bytes = 0;
        let n_at_once = FACETS_OF_PIECE * current_num_threads().max(PIECES_AT_ONCE);
        let mut pace = Paced::new(control, n_at_once);
        let mut chunks = facets.chunks(n_at_once);
        while let Some(some) = chunks.next_some()? {
            room.set(bytes + (size_of::<u32>() * some.len()) as u64, NUMBERED)?;
            let made: Vec<Piece> =
                on_all_cores(|| some.par_chunks(FACETS_OF_PIECE).map(|facets| Piece::new(facets, is_proper)).collect());
            bytes += made.iter().map(Piece::bytes).sum::<u64>();
            pieces.extend(made);
            room.set(bytes, NUMBERED)?;
            pace.done(some.len()).await?;
        }
        // the edges are there twice, and their shells in pairs
        let n_edges: usize = pieces.iter().map(|piece| piece.handed_on.len()).sum();
        let of_facets =
            if pieces.iter().any(|piece| !piece.is_one_shell()) { size_of::<u32>() * facets.len() } else { 0 };
        room.set(bytes + (size_of::<Edge>() * n_edges * 13 / 8 + of_facets) as u64, NUMBERED)?;
        Ok(Numbers::of_pieces(facets.len(), pieces))
    }

    /// The numbers of the facets of pieces that follow each other, whose shells are joined where they have an edge in common.
    fn of_pieces(n_facets: usize, mut pieces: Vec<Piece>) -> Numbers {
        let mut groups = Groups::new(pieces.iter().map(|piece| piece.first_facets.len()).sum());
        let portions = portions(&mut pieces);
        let pairs: Vec<Vec<[u32; 2]>> = on_all_cores(|| portions.par_iter().map(|portion| pairs(portion)).collect());
        pairs.into_iter().flatten().for_each(|[one, other]| groups.join(one, other));
        let (numbers, firsts) = groups.numbers();
        let of_pieces = pieces.iter().zip((0u32..).step_by(FACETS_OF_PIECE));
        let of_shells: Vec<u32> =
            of_pieces.flat_map(|(piece, start)| piece.first_facets.iter().map(move |facet| start + facet)).collect();
        let first_facets: Vec<u32> = firsts.into_iter().map(|shell| of_shells[shell as usize]).collect();
        let mut of_facet = Vec::new();
        if first_facets.len() > 1 {
            of_facet.reserve_exact(n_facets);
            let mut rest = &numbers[..];
            for piece in &pieces {
                let own = rest.split_off(..piece.first_facets.len()).unwrap_or_default();
                match piece.is_one_shell() {
                    true => of_facet.resize(of_facet.len() + piece.n_facets, own[0]),
                    false => {
                        of_facet.extend(piece.of_facet.iter().map(|&shell| own.get(shell as usize).unwrap_or(&NONE)))
                    }
                }
            }
        }
        Numbers { of_facet, first_facets }
    }

    /// Number of shells.
    pub fn n_shells(&self) -> usize {
        self.first_facets.len()
    }

    /// The shell of a facet; of the only shell the collapsed facets are, too.
    #[inline(always)]
    pub(crate) fn of(&self, facet: usize) -> Option<usize> {
        match self.of_facet.get(facet) {
            Some(&NONE) => None,
            Some(&shell) => Some(shell as usize),
            None => (self.n_shells() == 1).then_some(0),
        }
    }
}

/// Edges by their hashes, each with a number.
struct Table {
    /// The hashes and numbers; where it is free, hash and number are 0.
    entries: Vec<Edge>,
    n_used: usize,
}

impl Table {
    /// For so many edges.
    fn new(n_edges: usize) -> Table {
        Table { entries: vec![(0, 0); (n_edges + n_edges / 3 + 4).next_power_of_two()], n_used: 0 }
    }

    /// Whether so many more edges would make searching slow.
    fn is_full(&self, n_more: usize) -> bool {
        4 * (self.n_used + n_more) > 3 * self.entries.len()
    }

    /// Where the edge is, or would be; and whether it is there.
    #[inline(always)]
    fn place(&self, hash: u64) -> (usize, bool) {
        let mask = self.entries.len() - 1;
        let mut place = hash as usize & mask;
        loop {
            match self.entries[place].0 {
                0 => return (place, false),
                known if known == hash => return (place, true),
                _ => place = (place + 1) & mask,
            }
        }
    }

    #[inline(always)]
    fn number(&self, place: usize) -> u32 {
        self.entries[place].1
    }

    /// Puts an edge where it is not yet.
    #[inline(always)]
    fn put(&mut self, edge: Edge) {
        let (place, _) = self.place(edge.0);
        self.entries[place] = edge;
        self.n_used += 1;
    }

    /// Removes the edge at a place, and moves those behind it that would not be found any more.
    #[inline(always)]
    fn remove(&mut self, mut hole: usize) {
        let mask = self.entries.len() - 1;
        let mut place = (hole + 1) & mask;
        while self.entries[place].0 != 0 {
            let from_its_own = place.wrapping_sub(self.entries[place].0 as usize) & mask;
            if from_its_own >= place.wrapping_sub(hole) & mask {
                self.entries[hole] = self.entries[place];
                hole = place;
            }
            place = (place + 1) & mask;
        }
        self.entries[hole] = (0, 0);
        self.n_used -= 1;
    }

    /// Takes all edges out.
    fn take(&mut self) -> impl Iterator<Item = Edge> {
        self.n_used = 0;
        self.entries.iter_mut().map(std::mem::take).filter(|edge| edge.0 != 0)
    }
}

/// Facets that are numbered by themselves.
struct Piece {
    n_facets: usize,
    /// The shell of each facet, from 0; empty where all are of one.
    of_facet: Vec<u32>,
    /// The first facet of each shell, from 0.
    first_facets: Vec<u32>,
    /// Edges that facets of other pieces may have, with the shells.
    handed_on: Vec<Edge>,
}

/// Edges that wait for another facet, at most: a core's cache has them.
const WAITING: usize = 3 << 12;

impl Piece {
    fn new(facets: &[Facet], is_proper: bool) -> Piece {
        let mut table = Table::new(WAITING.min(3 * facets.len()));
        // numbers of facets whose edges nobody had before, by which shells are joined
        let (mut of_facet, mut groups, mut first_facets) =
            (Vec::with_capacity(facets.len()), Groups::new(0), Vec::new());
        let mut handed_on = Vec::new();
        for (facet, corners) in (0u32..).zip(facets) {
            if is_collapsed(corners) {
                of_facet.push(NONE);
                continue;
            }
            if table.is_full(3) {
                handed_on.extend(table.take());
            }
            let [a, b, c] = [corner_hash(corners[0]), corner_hash(corners[1]), corner_hash(corners[2])];
            let hashes = [a.wrapping_add(b), b.wrapping_add(c), c.wrapping_add(a)].map(|hash| hash.max(1));
            let (mut own, mut is_new) = (NONE, [true; 3]);
            for (hash, is_new) in hashes.into_iter().zip(&mut is_new) {
                let (place, is_there) = table.place(hash);
                if is_there {
                    let number = table.number(place);
                    if own == NONE {
                        own = number;
                    } else if own != number {
                        groups.join(own, number);
                    }
                    *is_new = false;
                    if is_proper {
                        table.remove(place);
                    }
                }
            }
            if own == NONE {
                own = first_facets.len() as u32;
                groups.add();
                first_facets.push(facet);
            }
            for (hash, is_new) in hashes.into_iter().zip(is_new) {
                if is_new {
                    table.put((hash, own));
                }
            }
            of_facet.push(own);
        }
        handed_on.extend(table.take());
        Piece { n_facets: facets.len(), of_facet, first_facets, handed_on }.with_shells(groups)
    }

    /// Numbers the shells, and with them the facets and edges, whose numbers are in these groups.
    fn with_shells(mut self, mut groups: Groups) -> Piece {
        let (shells, firsts) = groups.numbers();
        self.first_facets = firsts.into_iter().map(|number| self.first_facets[number as usize]).collect();
        self.handed_on.iter_mut().for_each(|(_, number)| *number = shells[*number as usize]);
        self.handed_on.shrink_to_fit();
        if self.first_facets.len() == 1 && !self.of_facet.contains(&NONE) {
            self.of_facet = Vec::new();
        } else {
            self.of_facet.iter_mut().for_each(|number| *number = shells.get(*number as usize).copied().unwrap_or(NONE));
        }
        self
    }

    /// Whether all its facets are of one shell.
    fn is_one_shell(&self) -> bool {
        self.of_facet.is_empty()
    }

    /// Bytes that it takes.
    fn bytes(&self) -> u64 {
        let lists = size_of_val(&self.of_facet[..]) + size_of_val(&self.first_facets[..]);
        (lists + size_of_val(&self.handed_on[..])) as u64
    }
}

/// Edges of a portion, about.
const PORTION: usize = 1 << 12;

/// The edges of pieces in portions by the first bits of their hashes, with shells that are numbered through all pieces.
fn portions(pieces: &mut [Piece]) -> Vec<Vec<Edge>> {
    let n_edges: usize = pieces.iter().map(|piece| piece.handed_on.len()).sum();
    let log = (n_edges / PORTION).next_power_of_two().trailing_zeros();
    let mut portions = vec![Vec::with_capacity((n_edges >> log) + PORTION / 8); 1 << log];
    let mut first = 0;
    for piece in pieces {
        for (hash, shell) in std::mem::take(&mut piece.handed_on) {
            // the tables look at the last bits first
            portions[hash.checked_shr(u64::BITS - log).unwrap_or(0) as usize].push((hash, first + shell));
        }
        first += piece.first_facets.len() as u32;
    }
    portions
}

/// Two shells of each edge that several of a portion have: each but the first with the first.
fn pairs(portion: &[Edge]) -> Vec<[u32; 2]> {
    let mut table = Table::new(portion.len());
    let mut pairs = Vec::new();
    for &(hash, shell) in portion {
        match table.place(hash) {
            (place, true) if table.number(place) != shell => pairs.push([table.number(place), shell]),
            (_, true) => {}
            (_, false) => table.put((hash, shell)),
        }
    }
    pairs
}

/// Whether two corners of a facet are equal.
pub(super) fn is_collapsed([a, b, c]: &Facet) -> bool {
    a == b || b == c || c == a
}

/// A hash of a corner, the same for -0 and +0. The sum of two is that of their edge.
#[inline(always)]
pub(super) fn corner_hash(corner: [f32; 3]) -> u64 {
    let [x, y, z] = corner_key(corner).map(u64::from);
    // numbers without a pattern: two corners have the same sum by accident alone
    let [low, high] = product((x << 32 | y) ^ 0x9e37_79b9_7f4a_7c15, (z << 32 | z) ^ 0xc2b2_ae3d_27d4_eb4f);
    low ^ high
}

#[cfg(test)]
mod tests {
    use super::*;
    use hexcast_core::base::control::at_once;
    use hexcast_core::input::surface::surface;

    fn numbers(facets: &[Facet], is_proper: bool) -> Numbers {
        at_once(Numbers::new(&facets.to_vec().into(), is_proper, &Memory::default(), &Control::default())).unwrap()
    }

    /// The facets of a box.
    fn cuboid(low: [f32; 3], high: [f32; 3]) -> Vec<Facet> {
        let corner =
            |bits: usize| [0, 1, 2].map(|axis: usize| if bits >> axis & 1 == 1 { high[axis] } else { low[axis] });
        let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c].map(corner), [a, c, d].map(corner)]).collect()
    }

    /// Boxes in a row, in an order that tears all of them apart.
    fn torn(n: usize, distance: f32) -> Vec<Facet> {
        let boxes: Vec<Facet> = (0..n)
            .flat_map(|k| cuboid([k as f32 * distance, 0.0, 0.0], [k as f32 * distance + 1.0, 1.0, 1.0]))
            .collect();
        (0..12).flat_map(|side| boxes.iter().skip(side).step_by(12).copied().collect::<Vec<Facet>>()).collect()
    }

    #[test]
    fn edges_of_a_grid_have_hashes_of_their_own() {
        let at = |x: i32, y: i32, z: i32| corner_hash([0.25 * x as f32, y as f32, 0.1 * z as f32]);
        let mut hashes = Vec::new();
        for (x, y, z) in (-32..32).flat_map(|x| (0..64).flat_map(move |y| (0..64).map(move |z| (x, y, z)))) {
            let ends = [at(x + 1, y, z), at(x, y + 1, z), at(x, y, z + 1), at(x + 1, y + 1, z)];
            hashes.extend(ends.map(|end| at(x, y, z).wrapping_add(end)));
        }
        hashes.sort_unstable();
        assert!(hashes.windows(2).all(|two| two[0] != two[1]));
    }

    #[test]
    fn shells_are_those_that_a_check_of_the_surface_counts() {
        let collapsed = [[0.0; 3], [0.0; 3], [1.0; 3]];
        for (facets, n) in [
            (Vec::new(), 0),
            (cuboid([0.0; 3], [1.0; 3]), 1),
            (vec![collapsed, collapsed], 0),
            (torn(3, 2.0), 3),
            // of many chunks
            (torn(3000, 2.0), 3000),
            ([cuboid([-0.0; 3], [1.0; 3]), vec![collapsed], cuboid([5.0; 3], [6.0; 3])].concat(), 2),
            // two that have an edge in common, and two that have a corner
            ([cuboid([0.0; 3], [1.0; 3]), cuboid([1.0, 1.0, 0.0], [2.0, 2.0, 1.0])].concat(), 1),
            ([cuboid([0.0; 3], [1.0; 3]), cuboid([1.0; 3], [2.0; 3])].concat(), 2),
        ] {
            assert_eq!(surface(&facets).shells, n);
            assert_eq!(numbers(&facets, false).n_shells() as u64, n);
        }
        assert_eq!(numbers(&torn(3000, 2.0), true).n_shells(), 3000);
    }

    #[test]
    fn facets_have_the_number_of_their_box() {
        let numbers = numbers(&torn(2000, 2.0), true);
        for (facet, corners) in torn(2000, 2.0).iter().enumerate() {
            let least = corners.iter().map(|corner| corner[0]).fold(f32::INFINITY, f32::min);
            assert_eq!(numbers.of(facet), Some(((least + 0.5) / 2.0) as usize));
        }
        assert_eq!(numbers.first_facets[..3], [0, 1, 2]);
    }

    #[test]
    fn a_facet_that_is_collapsed_belongs_to_no_shell_of_several_and_to_none_alone() {
        let collapsed = [[0.5; 3], [0.5; 3], [1.0; 3]];
        assert_eq!(numbers(&[collapsed], true).of(0), None);
        let two = [vec![collapsed], cuboid([0.0; 3], [1.0; 3]), cuboid([2.0; 3], [3.0; 3])].concat();
        assert_eq!([0, 1, 13].map(|facet| numbers(&two, true).of(facet)), [None, Some(0), Some(1)]);
    }
}
