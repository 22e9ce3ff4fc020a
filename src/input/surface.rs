//! Closedness of a surface: which edges of its facets have no partner.
//!
//! Facets -> [`Surface`], facts for reports; no later stage depends on it. Two corners are one vertex where
//! their f32 coordinates are equal (-0 = +0), which is what the exact arithmetic of the mesher sees: a gap of one ulp is
//! a gap. A facet with two equal corners is collapsed and only counted.
//!
//! [`crate::input::edges`] defines open, non-manifold and flipped edges. The rule `nonzero` is well defined if the facets use every
//! edge as often in one direction as in the other, the rule `parity` if they use every edge an even number of times.
//!
//! Cost: O(n log n) time; in wasm at most 24 bytes a facet beside the input, elsewhere 48. [`SurfaceCheck`] does it in steps, for callers
//! that must be able to stop.

use std::ops::Range;

use crate::base::error::Result;
use crate::base::memory::{Held, Memory};
use crate::base::parallel::*;
use crate::input::edges::{BadEdge, Groups, Use, Vertices, bad_edge, directions, each};
use crate::input::geometry::Facet;

/// Facets of a step: some tens of milliseconds. A multiple of the facets whose areas are summed first.
const FACETS_AT_ONCE: usize = 32 * AREAS_AT_ONCE;
/// Facets whose areas are summed first.
const AREAS_AT_ONCE: usize = 4096;

/// What the edges and areas of facets say about the surface they form.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Surface {
    /// Number of facets, collapsed ones included.
    pub n_facets: u64,
    /// Number of edges used once.
    pub open_edges: u64,
    /// Number of edges used more than twice.
    pub nonmanifold_edges: u64,
    /// Number of edges used twice in the same direction: one of the two facets is inside-out.
    pub flipped_edges: u64,
    /// Number of facets whose area is zero in f64, collapsed ones included.
    pub zero_area: u64,
    /// Number of facets with two or three equal corners.
    pub collapsed: u64,
    /// Every edge is used as often one way as the other: winding numbers are well defined.
    pub closed_oriented: bool,
    /// Every edge is used an even number of times: odd and even are well defined, whatever the orientation.
    pub closed_parity: bool,
    /// Every edge is used exactly once each way. Like the two above true where no facet has an edge.
    pub watertight: bool,
    /// Sum of the facets' areas, in squared file units.
    pub area: f64,
    /// Number of groups of facets connected over shared edges, collapsed facets left out.
    pub shells: u64,
    /// At most [`MAX_WORST_OPEN_EDGES`] open edges, longest first, as their two end points in file coordinates.
    pub worst_open_edges: Vec<[[f32; 3]; 2]>,
}

/// Length limit of [`Surface::worst_open_edges`].
pub const MAX_WORST_OPEN_EDGES: usize = 10;

/// The corners' normal times twice the area of a facet, right-hand rule, in f64; zero for facets of zero area.
pub fn doubled_area_vector(facet: &Facet) -> [f64; 3] {
    let [a, b, c] = facet.map(|corner| corner.map(f64::from));
    let u = [b[0] - a[0], b[1] - a[1], b[2] - a[2]];
    let v = [c[0] - a[0], c[1] - a[1], c[2] - a[2]];
    [u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]]
}

/// Examines the edges and areas of facets. Several solids that are closed together are passed as one slice.
///
/// Facets carry a 32-bit index, so that there may be at most 2^32 of them.
pub fn surface(facets: &[Facet]) -> Surface {
    let mut check = SurfaceCheck::new(facets);
    while check.step(facets) {}
    check.finish()
}

/// The same within a limit of memory.
///
/// # Errors
/// `memory` where the numbers of the vertices and the edges do not fit.
pub fn surface_within(facets: &[Facet], memory: &Memory) -> Result<Surface> {
    let mut room = Held::of(memory);
    room.set(Vertices::bytes_at_first(facets.len()), EXAMINED)?;
    let mut check = SurfaceCheck::new(facets);
    loop {
        room.set(check.bytes_of_step(), EXAMINED)?;
        if !check.step(facets) {
            return Ok(check.finish());
        }
    }
}

/// What errors of memory call what is held meanwhile.
const EXAMINED: &str = "the edges of the surface, which are examined,";

/// An examination of facets in steps, each of which gets all facets.
pub struct SurfaceCheck {
    surface: Surface,
    vertices: Vertices,
    /// Vertices whose edges were not looked at, the next ones last; None while vertices have no numbers yet.
    ranges: Option<Vec<Range<usize>>>,
    n_ranges: usize,
    shells: Groups,
    longest: Vec<OpenEdge>,
}

/// An open edge by its squared length and its ends, as they are sorted where lengths are equal.
struct OpenEdge {
    squared: f64,
    keys: [[u32; 3]; 2],
    ends: [[f32; 3]; 2],
}

impl SurfaceCheck {
    /// Starts to examine facets.
    pub fn new(facets: &[Facet]) -> SurfaceCheck {
        let surface = Surface {
            n_facets: facets.len() as u64,
            open_edges: 0,
            nonmanifold_edges: 0,
            flipped_edges: 0,
            zero_area: 0,
            collapsed: 0,
            closed_oriented: true,
            closed_parity: true,
            watertight: true,
            area: 0.0,
            shells: 0,
            worst_open_edges: Vec::new(),
        };
        let (vertices, shells) = (Vertices::new(facets.len()), Groups::new(0));
        SurfaceCheck { surface, vertices, ranges: None, n_ranges: 0, shells, longest: Vec::new() }
    }

    /// Does a part of the work; false once all is done.
    pub fn step(&mut self, facets: &[Facet]) -> bool {
        let Some(ranges) = &mut self.ranges else {
            self.number(facets);
            return true;
        };
        let Some(range) = ranges.pop() else { return false };
        let uses = self.vertices.uses(range);
        for uses in each(&uses) {
            count_edge(&mut self.surface, uses);
            for two in uses.windows(2) {
                self.shells.join(two[0].facet() as u32, two[1].facet() as u32);
            }
            if let [open] = uses {
                self.list(facets, *open);
            }
        }
        true
    }

    /// Most bytes that the next step holds.
    fn bytes_of_step(&self) -> u64 {
        let n_left = self.surface.n_facets as usize - self.vertices.n_facets();
        let groups = size_of::<u32>() as u64 * self.surface.n_facets;
        match &self.ranges {
            None => {
                self.vertices.most_bytes(n_left.min(FACETS_AT_ONCE)) + if n_left <= FACETS_AT_ONCE { groups } else { 0 }
            }
            Some(_) => self.vertices.most_bytes(0) + self.vertices.bytes_of_uses() + groups,
        }
    }

    /// Share of the work that is done, 0 to 1.
    pub fn share(&self) -> f64 {
        match &self.ranges {
            None => 0.5 * self.vertices.n_facets() as f64 / self.surface.n_facets.max(1) as f64,
            Some(ranges) => 1.0 - 0.5 * ranges.len() as f64 / self.n_ranges.max(1) as f64,
        }
    }

    /// What was found, once all is done.
    pub fn finish(mut self) -> Surface {
        self.surface.shells = self.surface.n_facets - self.surface.collapsed - self.shells.n_joined;
        self.surface.worst_open_edges = self.longest.into_iter().map(|edge| edge.ends).collect();
        self.surface
    }

    /// Numbers the vertices of the next facets, and sums their areas.
    fn number(&mut self, facets: &[Facet]) {
        let first = self.vertices.n_facets();
        let end = facets.len().min(first + FACETS_AT_ONCE);
        self.vertices.number(end, &|facet, corner| corner_key(facets[facet][corner]));
        (self.surface.area, self.surface.zero_area) =
            with_areas((self.surface.area, self.surface.zero_area), &facets[first..end]);
        if end == facets.len() {
            self.vertices.finish();
            self.surface.collapsed = self.vertices.n_collapsed() as u64;
            self.shells = Groups::new(facets.len());
            let mut ranges: Vec<Range<usize>> = self.vertices.ranges().collect();
            ranges.reverse();
            self.n_ranges = ranges.len();
            self.ranges = Some(ranges);
        }
    }

    /// Lists an open edge, if it is one of the longest. Equal lengths are in the order of the corners, whatever that of the facets.
    fn list(&mut self, facets: &[Facet], open: Use) {
        let facet = open.facet();
        let mut ends = open.pair().map(|vertex| facets[facet][self.vertices.corner(facet, vertex)].map(|c| c + 0.0));
        if corner_key(ends[0]) > corner_key(ends[1]) {
            ends.swap(0, 1);
        }
        let keys = ends.map(corner_key);
        let squared = (0..3).map(|axis| (f64::from(ends[1][axis]) - f64::from(ends[0][axis])).powi(2)).sum();
        let is_before = |other: &OpenEdge| other.squared > squared || (other.squared == squared && other.keys <= keys);
        let index = self.longest.partition_point(is_before);
        if index < MAX_WORST_OPEN_EDGES {
            self.longest.insert(index, OpenEdge { squared, keys, ends });
            self.longest.truncate(MAX_WORST_OPEN_EDGES);
        }
    }
}

/// A sum of areas and a number of facets without area, with those of more facets. Summed in blocks of fixed size, so that the number of
/// threads does not change the last bits.
fn with_areas(sum: (f64, u64), facets: &[Facet]) -> (f64, u64) {
    let block_sum = |block: &[Facet]| {
        block.iter().fold((0.0, 0), |(area, zeros), facet| {
            let [x, y, z] = doubled_area_vector(facet);
            (area + 0.5 * (x * x + y * y + z * z).sqrt(), zeros + u64::from([x, y, z] == [0.0; 3]))
        })
    };
    let blocks: Vec<(f64, u64)> = facets.par_chunks(AREAS_AT_ONCE).map(block_sum).collect();
    blocks.iter().fold(sum, |sum, block| (sum.0 + block.0, sum.1 + block.1))
}

/// The coordinates' bits; equal exactly where the coordinates are.
fn corner_key(corner: [f32; 3]) -> [u32; 3] {
    // adding +0 turns -0 into +0 and leaves all else
    corner.map(|c| (c + 0.0).to_bits())
}

fn count_edge(surface: &mut Surface, uses: &[Use]) {
    match bad_edge(uses) {
        Some(BadEdge::Open) => surface.open_edges += 1,
        Some(BadEdge::Flipped) => surface.flipped_edges += 1,
        Some(BadEdge::Nonmanifold) => surface.nonmanifold_edges += 1,
        None => {}
    }
    let [n_forward, n_backward] = directions(uses);
    surface.closed_oriented &= n_forward == n_backward;
    surface.closed_parity &= uses.len().is_multiple_of(2);
    surface.watertight &= n_forward == 1 && n_backward == 1;
}

#[cfg(test)]
mod tests;
