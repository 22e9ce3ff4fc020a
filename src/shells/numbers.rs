//! Numbers the shells of a geometry: the groups of facets that are connected over shared edges.
//!
//! Facets -> [`Numbers`]. Two corners are one vertex where their f32 coordinates are equal (-0 = +0), as in [`crate::surface`]. A facet with two
//! equal corners is collapsed: it has no edges, and belongs to no shell. Shells are numbered by their first facets.
//!
//! # Theory
//! Facets that share an edge stand near one another in nearly all files. So each chunk of facets is joined by itself, in a table that the cache
//! of a core holds; then the edges that a chunk has used once are sorted, and join facets of several chunks. Where an edge may have more than two
//! facets, the chunks hand on all edges. An edge is known by a hash of 64 bits; two of 10^7 edges have the same by accident in one of 10^5 files.
//!
//! Cost: some 20 ns a facet on one core; 4 bytes a facet, and for a moment 16 bytes for each edge that is handed on.

use crate::edges::{Groups, mixed};
use crate::geometry::Facet;
use crate::parallel::*;

/// Facets that are joined by themselves.
const CHUNK: usize = 1 << 13;
/// Places of their table: at most three quarters are taken.
const N_PLACES: usize = 4 * CHUNK;
/// Facets of a step: some tens of milliseconds.
const FACETS_AT_ONCE: usize = 64 * CHUNK;

/// The number of a facet that belongs to no shell.
const NONE: u32 = u32::MAX;

/// The shell of each facet.
pub(crate) struct Numbers {
    /// By facet; empty where there is one shell or none.
    of_facet: Vec<u32>,
    /// The first facet of each shell.
    pub(crate) first_facets: Vec<u32>,
}

impl Numbers {
    /// Number of shells.
    pub(crate) fn n_shells(&self) -> usize {
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

/// Numbers the shells in steps.
pub(crate) struct Numbering<'a> {
    facets: &'a [Facet],
    /// Whether no edge has more than two facets.
    is_proper: bool,
    /// A facet of the same chunk for each facet.
    roots: Vec<u32>,
    /// Edges that are handed on, each with a facet.
    edges: Vec<(u64, u32)>,
}

/// What became of a chunk.
type Joined = (Vec<u32>, Vec<(u64, u32)>);

impl<'a> Numbering<'a> {
    /// Starts; `is_proper` says that no edge has more than two facets.
    pub(crate) fn new(facets: &'a [Facet], is_proper: bool) -> Numbering<'a> {
        Numbering { facets, is_proper, roots: Vec::with_capacity(facets.len()), edges: Vec::new() }
    }

    /// Joins the facets of some chunks; false once all are.
    pub(crate) fn step(&mut self) -> bool {
        let first = self.roots.len();
        let some = &self.facets[first..self.facets.len().min(first + FACETS_AT_ONCE)];
        let joined =
            |(chunk, facets): (usize, &[Facet])| joined(facets, (first + chunk * CHUNK) as u32, self.is_proper);
        let joined: Vec<Joined> = some.par_chunks(CHUNK).enumerate().map(joined).collect();
        for (roots, edges) in joined {
            self.roots.extend(roots);
            self.edges.extend(edges);
        }
        self.roots.len() < self.facets.len()
    }

    /// The numbers, once all is done.
    pub(crate) fn finish(mut self) -> Numbers {
        let mut groups = Groups::of_roots(self.roots);
        self.edges.par_sort_unstable();
        for two in self.edges.windows(2).filter(|two| two[0].0 == two[1].0) {
            groups.join(two[0].1, two[1].1);
        }
        let mut of_facet = vec![NONE; self.facets.len()];
        let mut first_facets = Vec::new();
        for (facet, _) in (0u32..).zip(self.facets).filter(|(_, corners)| !is_collapsed(corners)) {
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
}

/// Joins the facets of a chunk whose first has the index `first`: an index for each, the same for those of one group; and the edges that
/// facets of other chunks may have.
fn joined(facets: &[Facet], first: u32, is_proper: bool) -> Joined {
    let mut groups = Groups::new(facets.len());
    let mut hashes = vec![0; N_PLACES];
    // the facet of each hash, and whether two have it
    let mut owners = vec![0u32; N_PLACES];
    for (facet, corners) in (0u32..).zip(facets).filter(|(_, corners)| !is_collapsed(corners)) {
        let [a, b, c] = corners.map(corner_hash);
        for hash in [a.wrapping_add(b), b.wrapping_add(c), c.wrapping_add(a)] {
            // 0 is a free place
            let hash = hash.max(1);
            let mut place = (hash >> 32) as usize & (N_PLACES - 1);
            while hashes[place] != 0 && hashes[place] != hash {
                place = (place + 1) & (N_PLACES - 1);
            }
            if hashes[place] == 0 {
                (hashes[place], owners[place]) = (hash, facet << 1);
            } else {
                groups.join(owners[place] >> 1, facet);
                owners[place] |= 1;
            }
        }
    }
    let is_open = |(hash, owner): &(&u64, &u32)| **hash != 0 && (!is_proper || **owner & 1 == 0);
    let open = hashes.iter().zip(&owners).filter(is_open);
    let edges = open.map(|(&hash, &owner)| (hash, first + (owner >> 1))).collect();
    let roots = (0..facets.len() as u32).map(|facet| first + groups.root(facet)).collect();
    (roots, edges)
}

/// Whether two corners of a facet are equal.
pub(super) fn is_collapsed([a, b, c]: &Facet) -> bool {
    a == b || b == c || c == a
}

/// A hash of a corner, the same for -0 and +0. The sum of two is that of their edge.
pub(super) fn corner_hash(corner: [f32; 3]) -> u64 {
    let [x, y, z] = corner.map(|c| u64::from((c + 0.0).to_bits()));
    mixed(mixed(x << 32 | y) ^ z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::surface;

    fn numbers(facets: &[Facet], is_proper: bool) -> Numbers {
        let mut numbering = Numbering::new(facets, is_proper);
        while numbering.step() {}
        numbering.finish()
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
