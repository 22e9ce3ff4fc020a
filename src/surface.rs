//! Closedness of a surface: which edges of its facets have no partner.
//!
//! Facets -> [`Surface`], facts for reports; nothing later in the line depends on it. Two corners are one vertex where
//! their f32 coordinates are equal (-0 = +0), which is what the exact arithmetic of the mesher sees: a gap of one ulp is
//! a gap. A facet with two equal corners is collapsed: it has no edges and is only counted.
//!
//! An edge is an unordered pair of vertices; a facet uses each of its three edges once, in one of two directions. With f
//! uses one way and b the other: open is f + b = 1, non-manifold f + b > 2, flipped f + b = 2 without f = b = 1. The
//! rule `nonzero` is well defined where f = b on every edge, the rule `parity` where every f + b is even.
//!
//! Numbers the vertices by a sort of the corners, then sorts the edges: O(n log n) time, no hashing, so that the result
//! is the same on every machine and for every order of the facets. Holds at most 76 bytes a facet beside the input.

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
    let vertices = number_vertices(facets);
    let (edges, collapsed) = sorted_edges(&vertices);
    let mut surface = Surface {
        n_facets: facets.len() as u64,
        open_edges: 0,
        nonmanifold_edges: 0,
        flipped_edges: 0,
        zero_area,
        collapsed,
        closed_oriented: true,
        closed_parity: true,
        watertight: true,
        area,
        shells: 0,
        worst_open_edges: Vec::new(),
    };
    let mut shells = Shells::new(facets.len());
    for uses in edges.chunk_by(|one, next| one.pair() == next.pair()) {
        count_edge(&mut surface, uses);
        for two in uses.windows(2) {
            shells.join(two[0].facet(), two[1].facet());
        }
    }
    surface.shells = facets.len() as u64 - collapsed - shells.n_joined;
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

/// Numbers the distinct vertices in the order of their keys: three numbers a facet.
fn number_vertices(facets: &[Facet]) -> Vec<[u64; 3]> {
    let mut corners = vec![0u128; 3 * facets.len()];
    corners.par_chunks_mut(3).zip(facets).enumerate().for_each(|(index, (entries, facet))| {
        for (entry, corner) in entries.iter_mut().zip(facet) {
            *entry = corner_key(*corner) << 32 | index as u128;
        }
    });
    corners.par_sort_unstable();
    let mut vertices = vec![[0u64; 3]; facets.len()];
    for (vertex, same) in corners.chunk_by(|one, next| one >> 32 == next >> 32).enumerate() {
        let key = same[0] >> 32;
        for entry in same {
            let index = *entry as u32 as usize;
            for (number, corner) in vertices[index].iter_mut().zip(facets[index]) {
                if corner_key(corner) == key {
                    *number = vertex as u64;
                }
            }
        }
    }
    vertices
}

/// One use of an edge, as it sorts: low vertex (34 bits), high vertex (34 bits), facet (32 bits), direction (1 bit).
#[derive(Clone, Copy)]
struct Use(u128);

impl Use {
    /// Sorts after every use; for the edges that collapsed facets do not have.
    const NONE: u128 = u128::MAX;

    fn bits(from: u64, to: u64, facet: usize) -> u128 {
        let (low, high) = (from.min(to), from.max(to));
        u128::from(low) << 67 | u128::from(high) << 33 | (facet as u128) << 1 | u128::from(from > to)
    }

    fn pair(self) -> (u64, u64) {
        (((self.0 >> 67) as u64), ((self.0 >> 33) as u64) & ((1 << 34) - 1))
    }

    fn facet(self) -> u32 {
        (self.0 >> 1) as u32
    }

    fn is_backward(self) -> bool {
        self.0 & 1 == 1
    }
}

fn sorted_edges(vertices: &[[u64; 3]]) -> (Vec<Use>, u64) {
    let mut edges = vec![Use::NONE; 3 * vertices.len()];
    edges.par_chunks_mut(3).zip(vertices).enumerate().for_each(|(facet, (uses, &[a, b, c]))| {
        if a != b && b != c && c != a {
            uses.copy_from_slice(&[Use::bits(a, b, facet), Use::bits(b, c, facet), Use::bits(c, a, facet)]);
        }
    });
    edges.par_sort_unstable();
    let n_uses = edges.partition_point(|entry| *entry != Use::NONE);
    let collapsed = (edges.len() - n_uses) / 3;
    edges.truncate(n_uses);
    (edges.into_iter().map(Use).collect(), collapsed as u64)
}

fn count_edge(surface: &mut Surface, uses: &[Use]) {
    let n_backward = uses.iter().filter(|entry| entry.is_backward()).count();
    let n_forward = uses.len() - n_backward;
    match uses.len() {
        1 => surface.open_edges += 1,
        2 => surface.flipped_edges += u64::from(n_forward != 1),
        _ => surface.nonmanifold_edges += 1,
    }
    surface.closed_oriented &= n_forward == n_backward;
    surface.closed_parity &= uses.len().is_multiple_of(2);
    surface.watertight &= n_forward == 1 && n_backward == 1;
}

/// Facets joined into shells: a forest in which each tree is a shell (union by index, path halving).
struct Shells {
    parent: Vec<u32>,
    n_joined: u64,
}

impl Shells {
    fn new(n_facets: usize) -> Shells {
        Shells { parent: (0..n_facets).map(|facet| facet as u32).collect(), n_joined: 0 }
    }

    fn root(&mut self, mut facet: u32) -> u32 {
        while self.parent[facet as usize] != facet {
            let above = self.parent[self.parent[facet as usize] as usize];
            self.parent[facet as usize] = above;
            facet = above;
        }
        facet
    }

    fn join(&mut self, one: u32, other: u32) {
        let (one, other) = (self.root(one), self.root(other));
        if one != other {
            self.parent[one.max(other) as usize] = one.min(other);
            self.n_joined += 1;
        }
    }
}

fn longest_open_edges(facets: &[Facet], vertices: &[[u64; 3]], edges: &[Use]) -> Vec<[[f32; 3]; 2]> {
    let mut longest: Vec<(f64, [[f32; 3]; 2])> = Vec::new();
    for uses in edges.chunk_by(|one, next| one.pair() == next.pair()).filter(|uses| uses.len() == 1) {
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
