//! Numbers the shells of a geometry: the groups of facets that are connected over shared edges.
//!
//! Facets -> [`Numbers`]. Two corners are one vertex where their f32 coordinates are equal (-0 = +0), as in [`crate::input::surface`]. A facet with two
//! equal corners is collapsed: it has no edges, and belongs to no shell. Shells are numbered by their first facets.
//!
//! # Theory
//! Facets that share an edge stand near one another in nearly all files. So each chunk of facets is joined by itself, in a table that the cache
//! of a core holds; the edges that a chunk has used once are handed on, and join facets of several chunks, by tables of the same kind that have
//! those edges each whose hashes begin alike. Where an edge may have more than two facets, the chunks hand on all edges. An edge is known by a
//! hash of 64 bits, of which 62 are looked at; two of 10^7 edges have the same by accident in one of 10^5 files.
//!
//! Cost: some 20 ns a facet on one core; 4 bytes a facet, and for a moment 32 bytes for each edge that is handed on.

use crate::base::control::{Control, Paced};
use crate::base::error::Result;
use crate::base::memory::Memory;
use crate::base::parallel::*;
use crate::input::edges::{Groups, mixed};
use crate::input::geometry::Facet;

/// Facets that are joined by themselves.
const CHUNK: usize = 1 << 13;
/// Facets that a core takes at a time.
const FACETS_OF_TASK: usize = 8 * CHUNK;
/// Facets of a step: some tens of milliseconds.
const FACETS_AT_ONCE: usize = 16 * FACETS_OF_TASK;

/// The number of a facet that belongs to no shell.
const NONE: u32 = u32::MAX;

/// An edge by its hash, and a facet that has it.
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
    /// `cancelled`; `memory`.
    pub async fn new(facets: &[Facet], is_proper: bool, memory: &Memory, control: &Control) -> Result<Numbers> {
        let of_facets = (size_of::<u32>() * facets.len()) as u64;
        let mut room = memory.take(of_facets, NUMBERED)?;
        // a facet of the same chunk for each facet, and the edges that are handed on
        let (mut roots, mut edges) = (Vec::with_capacity(facets.len()), Vec::new());
        let mut pace = Paced::new(control, FACETS_AT_ONCE);
        for some in facets.chunks(FACETS_AT_ONCE) {
            let first = roots.len();
            let of_task =
                |(task, facets): (usize, &[Facet])| joined(facets, (first + task * FACETS_OF_TASK) as u32, is_proper);
            let tasks: Vec<(Vec<u32>, Vec<Edge>)> =
                on_all_cores(|| some.par_chunks(FACETS_OF_TASK).enumerate().map(of_task).collect());
            for (of_task, handed_on) in tasks {
                roots.extend(of_task);
                edges.extend(handed_on);
            }
            room.set(of_facets + (size_of::<Edge>() * edges.capacity()) as u64, NUMBERED)?;
            pace.done(some.len()).await?;
        }
        // the edges are there twice, and their facets in pairs
        let of_edges = size_of::<Edge>() * (edges.capacity() + edges.len() * 9 / 8);
        room.set(2 * of_facets + of_edges as u64, NUMBERED)?;
        Ok(Numbers::of_joined(facets, roots, edges))
    }

    /// The numbers of facets that are joined where they have the same root, or an edge in common.
    fn of_joined(facets: &[Facet], roots: Vec<u32>, edges: Vec<Edge>) -> Numbers {
        let mut groups = Groups::of_roots(roots);
        let portions = portions(edges);
        let pairs: Vec<Vec<[u32; 2]>> = on_all_cores(|| portions.par_iter().map(|portion| pairs(portion)).collect());
        pairs.into_iter().flatten().for_each(|[one, other]| groups.join(one, other));
        let mut of_facet = vec![NONE; facets.len()];
        let mut first_facets = Vec::new();
        for (facet, _) in (0u32..).zip(facets).filter(|(_, corners)| !is_collapsed(corners)) {
            // the root of a group is its first facet
            let root = groups.root(facet);
            if root == facet {
                of_facet[facet as usize] = first_facets.len() as u32;
                first_facets.push(facet);
            } else {
                of_facet[facet as usize] = of_facet[root as usize];
            }
        }
        if first_facets.len() < 2 {
            of_facet = Vec::new();
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

/// Edges by their hashes, each with the index of the item that came first with it.
struct Table {
    /// The first bits of a hash, the item, and whether another had it, too; 0 where it is free.
    entries: Vec<u64>,
    /// Bits of an entry that are not of the hash.
    n_low: u32,
}

impl Table {
    /// For so many items; less than 2^31.
    fn new(n_items: usize) -> Table {
        let log = (n_items + n_items / 4 + 4).next_power_of_two().trailing_zeros();
        Table { entries: vec![0; 1 << log], n_low: log + 1 }
    }

    fn clear(&mut self) {
        self.entries.fill(0);
    }

    /// The item that had the hash of an item first; none if it is this one.
    #[inline(always)]
    fn first(&mut self, hash: u64, item: usize) -> Option<usize> {
        let mask = self.entries.len() - 1;
        // the last bits say where, the first are compared; no entry is 0
        let tag = (hash | 1 << 63) >> self.n_low;
        let mut place = hash as usize & mask;
        loop {
            let entry = self.entries[place];
            if entry >> self.n_low == tag {
                self.entries[place] |= 1;
                return Some((entry & ((1 << self.n_low) - 1)) as usize >> 1);
            }
            if entry == 0 {
                self.entries[place] = tag << self.n_low | (item as u64) << 1;
                return None;
            }
            place = (place + 1) & mask;
        }
    }

    /// The items that were first; but for those whose hash others had, if these are not asked for.
    fn items(&self, with_pairs: bool) -> impl Iterator<Item = usize> {
        let is_asked = move |entry: &u64| *entry != 0 && (with_pairs || entry & 1 == 0);
        let low = (1u64 << self.n_low) - 1;
        self.entries.iter().copied().filter(is_asked).map(move |entry| (entry & low) as usize >> 1)
    }
}

/// Joins the facets of some chunks, the first of which has the index `first`: an index for each, the same for those of one group; and the edges
/// that facets of other chunks may have.
fn joined(facets: &[Facet], first: u32, is_proper: bool) -> (Vec<u32>, Vec<Edge>) {
    let (mut roots, mut handed_on) = (Vec::with_capacity(facets.len()), Vec::new());
    let n_most = CHUNK.min(facets.len());
    let mut table = Table::new(3 * n_most);
    let mut hashes = Vec::with_capacity(3 * n_most);
    for chunk in facets.chunks(CHUNK) {
        let first = first + roots.len() as u32;
        let mut groups = Groups::new(chunk.len());
        table.clear();
        hashes.clear();
        for (facet, corners) in (0u32..).zip(chunk) {
            let [a, b, c] = [corner_hash(corners[0]), corner_hash(corners[1]), corner_hash(corners[2])];
            hashes.extend([a.wrapping_add(b), b.wrapping_add(c), c.wrapping_add(a)]);
            if is_collapsed(corners) {
                continue;
            }
            for item in 3 * facet as usize..hashes.len() {
                if let Some(other) = table.first(hashes[item], item) {
                    groups.join((other / 3) as u32, facet);
                }
            }
        }
        handed_on.extend(table.items(!is_proper).map(|item| (hashes[item], first + item as u32 / 3)));
        roots.extend((0..chunk.len() as u32).map(|facet| first + groups.root(facet)));
    }
    (roots, handed_on)
}

/// Edges of a portion, about.
const PORTION: usize = 1 << 12;

/// Edges in portions by the first bits of their hashes.
fn portions(edges: Vec<Edge>) -> Vec<Vec<Edge>> {
    let log = (edges.len() / PORTION).next_power_of_two().trailing_zeros();
    if log == 0 {
        return vec![edges];
    }
    let mut portions = vec![Vec::with_capacity((edges.len() >> log) + PORTION / 8); 1 << log];
    // those that the tables do not look at
    edges.into_iter().for_each(|edge| portions[(edge.0 << 1 >> (64 - log)) as usize].push(edge));
    portions
}

/// Two facets of each edge that several of a portion have: each but the first with the first.
fn pairs(portion: &[Edge]) -> Vec<[u32; 2]> {
    let mut table = Table::new(portion.len());
    let of = |(item, &(hash, facet)): (usize, &Edge)| table.first(hash, item).map(|other| [portion[other].1, facet]);
    portion.iter().enumerate().filter_map(of).collect()
}

/// Whether two corners of a facet are equal.
pub(super) fn is_collapsed([a, b, c]: &Facet) -> bool {
    a == b || b == c || c == a
}

/// A hash of a corner, the same for -0 and +0. The sum of two is that of their edge.
#[inline(always)]
pub(super) fn corner_hash(corner: [f32; 3]) -> u64 {
    let bits = |c: f32| u64::from((c + 0.0).to_bits());
    let [x, y, z] = [bits(corner[0]), bits(corner[1]), bits(corner[2])];
    // odd numbers without a pattern: two corners have the same sum by accident alone
    let sum = x.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(y.wrapping_mul(0xc2b2_ae3d_27d4_eb4f));
    mixed(sum.wrapping_add(z.wrapping_mul(0x1656_67b1_9e37_79f9)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::control::at_once;
    use crate::input::surface::surface;

    fn numbers(facets: &[Facet], is_proper: bool) -> Numbers {
        at_once(Numbers::new(facets, is_proper, &Memory::default(), &Control::default())).unwrap()
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
