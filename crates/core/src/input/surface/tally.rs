//! Tally: how many edges of a surface are not proper, what that says of the whole, and the longest open ones.
//!
//! Edges come in any order, and tallies of parts are added: neither changes what is found.

use crate::input::edges::{BadEdge, bad_edge, corner_key};

/// Length limit of [`super::Surface::worst_open_edges`].
pub const MAX_WORST_OPEN_EDGES: usize = 10;

/// What was found of some edges.
pub(super) struct Tally {
    pub(super) open: u64,
    pub(super) nonmanifold: u64,
    pub(super) flipped: u64,
    pub(super) closed_oriented: bool,
    pub(super) closed_parity: bool,
    pub(super) watertight: bool,
    /// The longest open ones, longest first.
    longest: Vec<OpenEdge>,
}

/// An open edge by its squared length and its ends, as they are sorted where lengths are equal.
struct OpenEdge {
    squared: f64,
    keys: [[u32; 3]; 2],
    ends: [[f32; 3]; 2],
}

impl Tally {
    /// That of no edge.
    pub(super) fn new() -> Tally {
        Tally {
            open: 0,
            nonmanifold: 0,
            flipped: 0,
            closed_oriented: true,
            closed_parity: true,
            watertight: true,
            longest: Vec::new(),
        }
    }

    /// Counts an edge by its uses in both directions. One that is open is to be listed, too.
    pub(super) fn count(&mut self, [n_forward, n_backward]: [usize; 2]) {
        match bad_edge([n_forward, n_backward]) {
            Some(BadEdge::Open) => self.open += 1,
            Some(BadEdge::Flipped) => self.flipped += 1,
            Some(BadEdge::Nonmanifold) => self.nonmanifold += 1,
            None => {}
        }
        self.closed_oriented &= n_forward == n_backward;
        self.closed_parity &= (n_forward + n_backward).is_multiple_of(2);
        self.watertight &= n_forward == 1 && n_backward == 1;
    }

    /// Lists an open edge, if it is one of the longest. Equal lengths are in the order of the corners, whatever that of the facets.
    pub(super) fn list(&mut self, ends: [[f32; 3]; 2]) {
        let mut ends = ends.map(|end| end.map(|c| c + 0.0));
        if corner_key(ends[0]) > corner_key(ends[1]) {
            ends.swap(0, 1);
        }
        let squared = (0..3).map(|axis| (f64::from(ends[1][axis]) - f64::from(ends[0][axis])).powi(2)).sum();
        self.insert(OpenEdge { squared, keys: ends.map(corner_key), ends });
    }

    fn insert(&mut self, edge: OpenEdge) {
        let OpenEdge { squared, keys, .. } = edge;
        let is_before = |other: &OpenEdge| other.squared > squared || (other.squared == squared && other.keys <= keys);
        let index = self.longest.partition_point(is_before);
        if index < MAX_WORST_OPEN_EDGES {
            self.longest.insert(index, edge);
            self.longest.truncate(MAX_WORST_OPEN_EDGES);
        }
    }

    /// Adds that of other edges.
    pub(super) fn add(&mut self, other: Tally) {
        self.open += other.open;
        self.nonmanifold += other.nonmanifold;
        self.flipped += other.flipped;
        self.closed_oriented &= other.closed_oriented;
        self.closed_parity &= other.closed_parity;
        self.watertight &= other.watertight;
        other.longest.into_iter().for_each(|edge| self.insert(edge));
    }

    /// The ends of the longest open edges, longest first.
    pub(super) fn longest(self) -> Vec<[[f32; 3]; 2]> {
        self.longest.into_iter().map(|edge| edge.ends).collect()
    }
}
