//! The bound of the volume: how far the volume of the cells of a closed surface can be from that of the surface.
//!
//! Snapped facets -> half cells, which [`volume_bound`] makes a volume of.
//!
//! # Theory
//! Cells are boxes of size hx, hy, hz. w(p) is the winding number of the surface at p, V the integral of w, which is the volume that the
//! surface encloses where w is 0 or 1, and Vh the sum of w at all centres times hx hy hz: the volume of the cells. Then
//!
//! |Vh - V| <= hx hy hz / 2 (N + L / hx + A / (hx hy)),
//!
//! where N counts the crossings of the surface with the lines along x through centres; L is the length along x of the segments in which
//! facets meet the planes across z through centres; and A is the area of all facets seen along z.
//!
//! Proof. Vh - V is the integral over all points p of w(c) - w(p), with c the centre of the cell of p. Go from c = (cx, cy, cz) by
//! (px, cy, cz) and (px, py, cz) to p: w changes by at most the number of crossings on the way. A crossing on the first leg is on the way
//! of those points only whose px lies beyond it within the cell, at most hx / 2, and of all py and pz of the cell: all first legs add at
//! most N hx / 2 hy hz. On the second leg lines along y through (px, cz) are crossed, each crossing on the way of at most hy / 2; the
//! number of crossings, integrated over px, is L: at most L hy / 2 hz. On the third, lines along z through (px, py): at most A hz / 2.
//! The tie rule moves all centres by the same, so the theorem holds for the moved cells; of moved centres a line is counted here if it
//! is nearer than two units of the snap to a segment, so that N is not too small.
//!
//! For a smooth surface N, L / hx and A / (hx hy) tend to its area seen along x, y and z, in cells: the bound is half of the cells that the
//! surface cuts. The error is smaller by far where it is to both sides as often. V is that of the snapped corners, from integers; what
//! it differs from that of the file is added.
//!
//! Of cells that differ in size no bound is given.
//!
//! Cost: some 20 ns a facet and 5 ns a plane of cells that it meets.

use crate::base::parallel::*;
use crate::grid::frame::{SnappedFacet, nearest};

/// Facets that are summed together, so that the number of threads does not change the last bits.
pub(crate) const CHUNK: usize = 4096;

/// Sums over the facets of a surface, which [`BoundSums::bound`] makes the bound of.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct BoundSums {
    /// Crossings with lines along x.
    n: u64,
    /// Length along x, in units.
    length: f64,
    /// Area seen along z, twice, in square units.
    doubled_area: f64,
    /// Volume, six times, in cubic units.
    volume: i128,
}

/// For cells of one volume the largest difference that there can be between the volume of the cells of snapped facets and `mesh_volume`, the volume of the surface
/// without a sign, where no cell is inside of two of its shells.
pub fn volume_bound(facets: &[SnappedFacet], fraction_bits: u32, cell_volume: f64, mesh_volume: f64) -> f64 {
    let parts: Vec<BoundSums> = facets.par_chunks(CHUNK).map(|facets| BoundSums::of(facets, fraction_bits)).collect();
    let sums = parts.into_iter().fold(BoundSums::default(), BoundSums::plus);
    sums.bound(fraction_bits, cell_volume, mesh_volume)
}

impl BoundSums {
    /// Those of facets, one after another; the last bits of a sum of parts depend on where they begin: see [`CHUNK`].
    pub(crate) fn of(facets: &[SnappedFacet], fraction_bits: u32) -> BoundSums {
        let mut sums = BoundSums::default();
        facets.iter().for_each(|facet| sums.add_facet(facet, fraction_bits));
        sums
    }

    /// Adds a facet.
    pub fn add_facet(&mut self, facet: &SnappedFacet, fraction_bits: u32) {
        let [a, b, c] = facet.map(|corner| corner.map(i64::from));
        let along_z = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
        self.doubled_area += along_z.unsigned_abs() as f64;
        // of the prism from the facet down to the plane of the first centres
        self.volume += i128::from(along_z) * i128::from(a[2] + b[2] + c[2]);
        add_planes(self, facet, fraction_bits);
    }

    /// The bound, as of [`volume_bound`].
    pub fn bound(&self, fraction_bits: u32, cell_volume: f64, mesh_volume: f64) -> f64 {
        let cell = f64::from(1u32 << fraction_bits);
        let volume = (self.volume as f64 / (6.0 * cell * cell * cell)).abs() * cell_volume;
        self.of_cells(fraction_bits, cell_volume) + (volume - mesh_volume).abs()
    }

    /// The bound where the volume is that of the snapped facets; no more than this of some of the facets, if these are closed.
    pub fn of_cells(&self, fraction_bits: u32, cell_volume: f64) -> f64 {
        let cell = f64::from(1u32 << fraction_bits);
        let half_cells = 0.5 * (self.n as f64 + self.length / cell + 0.5 * self.doubled_area / (cell * cell));
        // sums of numbers that are not negative are off by far less
        half_cells * cell_volume * (1.0 + 1e-9)
    }

    pub fn plus(self, other: BoundSums) -> BoundSums {
        BoundSums {
            n: self.n + other.n,
            length: self.length + other.length,
            doubled_area: self.doubled_area + other.doubled_area,
            volume: self.volume + other.volume,
        }
    }
}

/// Adds the segments in which a facet meets planes across z.
fn add_planes(sums: &mut BoundSums, facet: &SnappedFacet, fraction_bits: u32) {
    let [low, mid, high] = sorted(*facet);
    // those of moved centres, which lie a little below
    let (first, end) = ((low[2] >> fraction_bits) + 1, (high[2] >> fraction_bits) + 1);
    if first >= end {
        return;
    }
    let long = Line::new(low, high);
    let (below, above) = (Line::new(low, mid), Line::new(mid, high));
    for plane in first..end {
        let z = f64::from(plane << fraction_bits);
        let [x, y] = long.at(z);
        let [other_x, other_y] = if plane << fraction_bits <= mid[2] { below.at(z) } else { above.at(z) };
        // f64 is off by less than a millionth of a unit
        sums.length += (x - other_x).abs() + 1e-6;
        let [from, to] = [y.min(other_y) - 2.0, y.max(other_y) + 2.0].map(nearest);
        sums.n += u64::from(((to >> fraction_bits) - ((from - 1) >> fraction_bits)).unsigned_abs());
    }
}

/// Its corners by z. Three swaps, as the library's sort is large.
fn sorted(mut facet: SnappedFacet) -> SnappedFacet {
    for (one, other) in [(0, 1), (1, 2), (0, 1)] {
        if facet[one][2] > facet[other][2] {
            facet.swap(one, other);
        }
    }
    facet
}

/// x and y along an edge, by z.
#[derive(Clone, Copy)]
struct Line {
    from: [f64; 3],
    slopes: [f64; 2],
}

impl Line {
    fn new(from: [i32; 3], to: [i32; 3]) -> Line {
        let (from, to) = (from.map(f64::from), to.map(f64::from));
        // of a level edge nothing but its ends is asked for
        let per_z = if to[2] > from[2] { 1.0 / (to[2] - from[2]) } else { 0.0 };
        Line { from, slopes: [0, 1].map(|axis: usize| (to[axis] - from[axis]) * per_z) }
    }

    fn at(self, z: f64) -> [f64; 2] {
        [0, 1].map(|axis: usize| self.from[axis] + self.slopes[axis] * (z - self.from[2]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_of_a_box_are_those_of_its_faces() {
        // 3 x 2 x 4 cells, corners between centres
        let (low, high) = ([-32, -32, -32], [160, 96, 224]);
        let corner =
            |bits: usize| [0, 1, 2].map(|axis: usize| if bits >> axis & 1 == 1 { high[axis] } else { low[axis] });
        let sides = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let facets: Vec<SnappedFacet> =
            sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c].map(corner), [a, c, d].map(corner)]).collect();
        let found = BoundSums::of(&facets, 6);
        // 2 faces of 2 x 4 centres
        assert_eq!(found.n, 16);
        // 2 faces of length 3 on each of 4 planes, and what f64 is given
        assert!((found.length - 2.0 * 3.0 * 64.0 * 4.0).abs() < 1e-3, "{}", found.length);
        assert_eq!(found.doubled_area, 2.0 * 2.0 * 6.0 * 4096.0);
        assert_eq!(found.volume, 6 * 24 * 64 * 64 * 64);
    }
}
