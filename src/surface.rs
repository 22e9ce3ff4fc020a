//! Closedness of a surface: which edges of its facets have no partner.
//!
//! Facets -> [`Surface`], facts for reports; nothing later in the line depends on it. Two corners are one vertex where
//! their f32 coordinates are equal (-0 = +0), which is what the exact arithmetic of the mesher sees: a gap of one ulp is
//! a gap. A facet with two equal corners is collapsed and only counted.
//!
//! [`crate::edges`] says what open, non-manifold and flipped edges are. The rule `nonzero` is well defined where every edge is used as
//! often one way as the other, the rule `parity` where it is used an even number of times.
//!
//! Cost: O(n log n) time; at most 76 bytes a facet beside the input.

use crate::edges::{BadEdge, Edges, Groups, Use, bad_edge, directions, number_vertices};
use crate::geometry::Facet;
use crate::parallel::*;

/// What the edges and areas of facets say about the surface they form.
#[derive(Debug, Clone, PartialEq)]
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
    let (area, zero_area) = total_area(facets);
    let vertices = number_vertices(facets, corner_key);
    let edges = Edges::new(&vertices);
    let mut surface = Surface {
        n_facets: facets.len() as u64,
        open_edges: 0,
        nonmanifold_edges: 0,
        flipped_edges: 0,
        zero_area,
        collapsed: edges.n_collapsed,
        closed_oriented: true,
        closed_parity: true,
        watertight: true,
        area,
        shells: 0,
        worst_open_edges: Vec::new(),
    };
    let mut shells = Groups::new(facets.len());
    for uses in edges.each() {
        count_edge(&mut surface, uses);
        for two in uses.windows(2) {
            shells.join(two[0].facet(), two[1].facet());
        }
    }
    surface.shells = facets.len() as u64 - edges.n_collapsed - shells.n_joined;
    surface.worst_open_edges = longest_open_edges(facets, &vertices, &edges);
    surface
}

/// Sum of areas and number of facets without area. Summed in blocks of fixed size, so that the number of threads does
/// not change the last bits.
fn total_area(facets: &[Facet]) -> (f64, u64) {
    let block_sum = |block: &[Facet]| {
        block.iter().fold((0.0, 0), |(area, zeros), facet| {
            let [x, y, z] = doubled_area_vector(facet);
            (area + 0.5 * (x * x + y * y + z * z).sqrt(), zeros + u64::from([x, y, z] == [0.0; 3]))
        })
    };
    let blocks: Vec<(f64, u64)> = facets.par_chunks(4096).map(block_sum).collect();
    blocks.iter().fold((0.0, 0), |sum, block| (sum.0 + block.0, sum.1 + block.1))
}

/// The coordinates' bits in 96 bits; equal exactly where the coordinates are.
fn corner_key(corner: [f32; 3]) -> u128 {
    // adding +0 turns -0 into +0 and leaves all else
    let [x, y, z] = corner.map(|c| u128::from((c + 0.0).to_bits()));
    x << 64 | y << 32 | z
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

fn longest_open_edges(facets: &[Facet], vertices: &[[u64; 3]], edges: &Edges) -> Vec<[[f32; 3]; 2]> {
    let mut longest: Vec<(f64, [[f32; 3]; 2])> = Vec::new();
    for uses in edges.each().filter(|uses| uses.len() == 1) {
        let facet = uses[0].facet() as usize;
        let (low, high) = uses[0].pair();
        let ends = [low, high].map(|vertex| {
            let corner = vertices[facet].iter().position(|number| *number == vertex).unwrap_or(0);
            facets[facet][corner].map(|c| c + 0.0)
        });
        let squared: f64 = (0..3).map(|axis| (f64::from(ends[1][axis]) - f64::from(ends[0][axis])).powi(2)).sum();
        // equal lengths stay in the order of the vertices' keys, whatever the order of the facets
        let index = longest.partition_point(|(other, _)| *other >= squared);
        if index < MAX_WORST_OPEN_EDGES {
            longest.insert(index, (squared, ends));
            longest.truncate(MAX_WORST_OPEN_EDGES);
        }
    }
    longest.into_iter().map(|(_, ends)| ends).collect()
}

#[cfg(test)]
mod tests;
