//! Snapping: every corner becomes three integers, once, on the host.
//!
//! Geometries and mesh lines -> [`Frame`]. On each axis a world coordinate w becomes
//! `u = (w - origin) / spacing - 1/2`, its position relative to the centre of cell 0 in units of the cell, and then the
//! integer `round(u * 2^F)`. The centre of cell i is the integer `i * 2^F`. All later stages decide on these integers
//! only, so every device gives the same flags.
//!
//! `F`, the fraction bits, is the largest number for which all corners and centres, with one cell to spare beyond both
//! ends, span at most 2^[`SPAN_BITS`] units on every axis: 26 bits over the domain, four times finer than f32 resolves a
//! domain that starts at 0.
//!
//! Degenerate cases: equal f32 corners snap to equal integers, so closed surfaces stay closed; facets that collapse to a
//! line or a point are kept and never hit. Source: the paper, Eq. 7-10 (positions); the snap is ours.
//! Cost: one pass over the corners; 37 bytes a facet.

use std::ops::Range;

use crate::error::{Error, Result};
use crate::geometry::{Facet, Geometry};
use crate::lines::Lines;
use crate::parallel::*;

/// Bits that span all snapped coordinates of an axis. 26 keeps the kernels' inner loop in one 32-bit word.
pub const SPAN_BITS: u32 = 26;
/// Fewer fraction bits than this would snap visibly: an error.
pub const MIN_FRACTION_BITS: u32 = 8;
/// Most cells along an axis: 2^([`SPAN_BITS`] - [`MIN_FRACTION_BITS`]), less the room for half a cell at both ends.
pub const MAX_CELLS_PER_AXIS: u32 = (1 << (SPAN_BITS - MIN_FRACTION_BITS)) - 2;

/// Three corners of three fixed-point coordinates x, y, z.
pub type SnappedFacet = [[i32; 3]; 3];

/// Normal of a facet by the right-hand rule, twice its area long: less than 2^52 along each axis, as facets lie in a box of less than 2^26 units.
pub(crate) fn normal([a, b, c]: &SnappedFacet) -> [i128; 3] {
    let side = |to: &[i32; 3]| [0, 1, 2].map(|axis| i128::from(to[axis]) - i128::from(a[axis]));
    let (u, v) = (side(b), side(c));
    [0, 1, 2].map(|axis: usize| {
        let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
        u[i] * v[j] - u[j] * v[i]
    })
}

/// All facets of all geometries in fixed-point coordinates.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// F: a cell is 2^F units.
    pub fraction_bits: u32,
    /// Number of cells on each axis.
    pub dims: [u32; 3],
    /// Facets of all geometries.
    pub facets: Vec<SnappedFacet>,
    /// Rank of the geometry of each facet; see [`Ranks`].
    pub rank_of_facet: Vec<u8>,
    /// The order in which overlaps are decided.
    pub ranks: Ranks,
}

/// Geometries in the order in which they win: rank 0 loses against all others.
///
/// Sorted by priority, at equal priority by position in the job ("meshed in order": the later wins).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Ranks {
    /// Index in the job of the geometry of each rank.
    pub geometry_of_rank: Vec<usize>,
    /// Property flag of each rank.
    pub flag_of_rank: Vec<u8>,
}

impl Ranks {
    /// Ranks geometries by priority and order.
    pub fn new(geometries: &[Geometry]) -> Ranks {
        let mut geometry_of_rank: Vec<usize> = Vec::new();
        for (index, geometry) in geometries.iter().enumerate() {
            let rank = geometry_of_rank.partition_point(|&other| geometries[other].priority <= geometry.priority);
            geometry_of_rank.insert(rank, index);
        }
        let flag_of_rank = geometry_of_rank.iter().map(|&index| geometries[index].flag).collect();
        Ranks { geometry_of_rank, flag_of_rank }
    }
}

impl Frame {
    /// Snaps all corners of all geometries.
    ///
    /// # Errors
    /// - `too-many-geometries`: more than 255.
    /// - `too-many-facets`: more than 2^31 in all.
    /// - `too-many-cells`: an axis has more than [`MAX_CELLS_PER_AXIS`] cells.
    /// - `geometry-too-far`: F would be under [`MIN_FRACTION_BITS`]; names the geometry.
    pub fn new(geometries: &[Geometry], lines: &Lines) -> Result<Frame> {
        let mut frame = Frame::without_facets(geometries, lines)?;
        for (rank, &index) in frame.ranks.geometry_of_rank.clone().iter().enumerate() {
            let geometry = &geometries[index];
            frame.facets.par_extend(frame.snapped(geometry, &geometry.facets, lines));
            frame.rank_of_facet.resize(frame.facets.len(), rank as u8);
        }
        Ok(frame)
    }

    /// The frame of geometries whose facets are snapped later.
    ///
    /// # Errors
    /// Those of [`Frame::new`].
    pub(crate) fn without_facets(geometries: &[Geometry], lines: &Lines) -> Result<Frame> {
        check_limits(geometries, lines)?;
        let fraction_bits = fraction_bits(geometries, lines)?;
        let (facets, rank_of_facet, ranks) = (Vec::new(), Vec::new(), Ranks::new(geometries));
        Ok(Frame { fraction_bits, dims: lines.dims, facets, rank_of_facet, ranks })
    }

    /// Snaps some facets of a geometry.
    pub(crate) fn snapped(&self, geometry: &Geometry, facets: &[Facet], lines: &Lines) -> Vec<SnappedFacet> {
        let placing = geometry.placing();
        let snap = |corner: [f32; 3]| snap(placing(corner), lines, self.fraction_bits);
        facets.par_iter().map(|facet| facet.map(snap)).collect()
    }

    /// The facets of a rank: facets are stored rank after rank.
    pub(crate) fn facets_of_rank(&self, rank: usize) -> &[SnappedFacet] {
        &self.facets[self.range_of_rank(rank)]
    }

    /// Where the facets of a rank are.
    pub(crate) fn range_of_rank(&self, rank: usize) -> Range<usize> {
        let end_of = |n_ranks: usize| self.rank_of_facet.partition_point(|&of| usize::from(of) < n_ranks);
        end_of(rank)..end_of(rank + 1)
    }

    /// A frame of the same box, of one geometry with the flag 1.
    pub(crate) fn with_facets(&self, facets: Vec<SnappedFacet>) -> Frame {
        let ranks = Ranks { geometry_of_rank: vec![0], flag_of_rank: vec![1] };
        Frame { rank_of_facet: vec![0; facets.len()], facets, ranks, ..*self }
    }

    /// The frame of some cells of the box, the first and the end, exclusive: the same corners in the same units, counted from the centre
    /// of the first of these cells, so that every cell is decided as in the whole box. Facets that no ray through these cells meets,
    /// along any axis, are left out.
    pub(crate) fn window(&self, cells: [[u32; 3]; 2]) -> Frame {
        let mut window = Frame {
            dims: [0, 1, 2].map(|axis| cells[1][axis] - cells[0][axis]),
            facets: Vec::new(),
            rank_of_facet: Vec::new(),
            ranks: self.ranks.clone(),
            ..*self
        };
        for (facet, &rank) in self.facets.iter().zip(&self.rank_of_facet) {
            if let Some(moved) = in_window(facet, cells, self.fraction_bits) {
                window.facets.push(moved);
                window.rank_of_facet.push(rank);
            }
        }
        window
    }

    /// Largest distance that the snap moves a corner along an axis, in cells.
    pub fn snap_in_cells(&self) -> f64 {
        0.5 / f64::from(1u32 << self.fraction_bits)
    }
}

/// A facet, counted from the centre of the first cell of a window; None if the facet is nowhere near the rays through the window's
/// cells, which would meet it along one axis and so have it within their reach along the two others.
pub(crate) fn in_window(facet: &SnappedFacet, [first, end]: [[u32; 3]; 2], fraction_bits: u32) -> Option<SnappedFacet> {
    let unit = 1i64 << fraction_bits;
    let is_near = |axis: usize| {
        let places = facet.map(|corner| i64::from(corner[axis]));
        // a cell more: cells along a surface are touched by facets beside their centres
        let [low, high] = [(i64::from(first[axis]) - 1) * unit, i64::from(end[axis]) * unit];
        places.iter().any(|&place| place >= low) && places.iter().any(|&place| place <= high)
    };
    let is_in_reach = (0..3).filter(|&axis| is_near(axis)).count() >= 2;
    is_in_reach.then(|| moved(facet, first.map(|cell| -((cell << fraction_bits) as i32))))
}

/// A facet moved by so many units along each axis.
pub(crate) fn moved(facet: &SnappedFacet, by: [i32; 3]) -> SnappedFacet {
    facet.map(|corner| [0, 1, 2].map(|axis| corner[axis] + by[axis]))
}

/// Refuses what the exact arithmetic cannot index.
///
/// # Errors
/// `too-many-geometries`, `too-many-facets`, `too-many-cells`, as for [`Frame::new`].
pub(crate) fn check_limits(geometries: &[Geometry], lines: &Lines) -> Result<()> {
    if geometries.len() > 255 {
        let message = format!("{} geometries: a flag is one byte, so at most 255 fit", geometries.len());
        return Err(Error::new("too-many-geometries", message, "join geometries of the same substance in one file"));
    }
    let n_facets: usize = geometries.iter().map(|geometry| geometry.facets.len()).sum();
    if n_facets > 1 << 31 {
        return Err(Error::new("too-many-facets", format!("{n_facets} facets: at most 2^31 fit"), "split the job"));
    }
    for axis in 0..3 {
        if lines.dims[axis] > MAX_CELLS_PER_AXIS {
            let name = ["x", "y", "z"][axis];
            let message = format!("{} cells along {name}: at most {MAX_CELLS_PER_AXIS} fit", lines.dims[axis]);
            return Err(Error::new("too-many-cells", message, "use larger cells or split the domain"));
        }
    }
    Ok(())
}

/// Position relative to the centre of cell 0, in cells.
#[inline(always)]
fn cells_from_world(world: [f64; 3], lines: &Lines) -> [f64; 3] {
    let mut cells = world;
    for axis in 0..3 {
        cells[axis] = (world[axis] - lines.origin[axis]) / lines.spacing[axis] - 0.5;
    }
    cells
}

#[inline(always)]
fn snap(world: [f64; 3], lines: &Lines, fraction_bits: u32) -> [i32; 3] {
    let scale = f64::from(1u32 << fraction_bits);
    // rint (ties to even) is one instruction; any fixed rule serves
    let [x, y, z] = cells_from_world(world, lines);
    [libm::rint(x * scale) as i32, libm::rint(y * scale) as i32, libm::rint(z * scale) as i32]
}

/// World coordinates of a snapped corner.
pub(crate) fn world(corner: [i32; 3], fraction_bits: u32, lines: &Lines) -> [f64; 3] {
    [0, 1, 2].map(|axis| {
        let cells = f64::from(corner[axis]) / f64::from(1u32 << fraction_bits) + 0.5;
        lines.origin[axis] + cells * lines.spacing[axis]
    })
}

/// The largest F for which corners and centres of every axis span at most 2^SPAN_BITS units.
fn fraction_bits(geometries: &[Geometry], lines: &Lines) -> Result<u32> {
    let mut widest = 0.0f64;
    let mut widest_name = "";
    let domain_span = lines.dims.map(|n| f64::from(n) + 1.0).into_iter().fold(0.0, f64::max);
    let mut low = [-1.0f64; 3];
    let mut high = lines.dims.map(f64::from);
    for geometry in geometries {
        let Some(bounding_box) = geometry.bounding_box() else { continue };
        let ends = bounding_box.map(|corner| cells_from_world(corner, lines));
        for axis in 0..3 {
            low[axis] = low[axis].min(ends[0][axis] - 1.0);
            high[axis] = high[axis].max(ends[1][axis] + 1.0);
            if high[axis] - low[axis] > widest {
                widest = high[axis] - low[axis];
                widest_name = &geometry.name;
            }
        }
    }
    let span = widest.max(domain_span);
    let bits = (0..=SPAN_BITS).rev().find(|&bits| span * f64::from(1u32 << bits) <= f64::from(1u32 << SPAN_BITS));
    match bits {
        Some(bits) if bits >= MIN_FRACTION_BITS => Ok(bits),
        _ => {
            let limit = 1u32 << (SPAN_BITS - MIN_FRACTION_BITS);
            let message = format!(
                "geometry \"{widest_name}\" and the domain together span {} cells along an axis: \
                 the exact arithmetic holds {limit}",
                widest.round(),
            );
            Err(Error::new("geometry-too-far", message, "remove the far facets, enlarge the cells or move the domain"))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corner(at: [f32; 3]) -> Geometry {
        Geometry::new("g", 1, vec![[at; 3]]).unwrap()
    }

    #[test]
    fn cell_centres_and_lines_are_exact() {
        let lines = Lines::new([0.0; 3], [0.1; 3], [10; 3]).unwrap();
        let frame = Frame::new(&[corner([1.0, 0.0, 0.5])], &lines).unwrap();
        let half = 1 << (frame.fraction_bits - 1);
        assert_eq!(frame.facets[0][0], [19 * half, -half, 9 * half]);
    }

    #[test]
    fn the_span_decides_the_fraction_bits() {
        for (cells, bits) in [(1u32, 25), (6, 23), (14, 22), (1000, 16), (10_000, 12), (MAX_CELLS_PER_AXIS, 8)] {
            let lines = Lines::new([0.0; 3], [1.0; 3], [cells, 1, 1]).unwrap();
            assert_eq!(Frame::new(&[corner([0.5; 3])], &lines).unwrap().fraction_bits, bits, "{cells} cells");
        }
    }

    #[test]
    fn a_far_geometry_is_named() {
        let lines = Lines::new([0.0; 3], [1.0; 3], [8; 3]).unwrap();
        let far = Geometry::new("antenna", 1, vec![[[1e6, 0.0, 0.0]; 3]]).unwrap();
        let error = Frame::new(&[corner([0.5; 3]), far], &lines).unwrap_err();
        assert_eq!(error.code(), "geometry-too-far");
        assert!(error.to_string().contains("antenna"), "{error}");
    }

    #[test]
    fn higher_priority_then_later_wins() {
        let mut geometries = [corner([0.0; 3]), corner([0.0; 3]), corner([0.0; 3])];
        geometries[0].priority = 1;
        geometries[0].flag = 7;
        assert_eq!(Ranks::new(&geometries).geometry_of_rank, [1, 2, 0]);
        assert_eq!(Ranks::new(&geometries).flag_of_rank, [1, 1, 7]);
    }
}
