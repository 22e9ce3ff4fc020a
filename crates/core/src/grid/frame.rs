//! Snapping: every corner becomes three integers, once, on the host.
//!
//! Geometries and mesh lines -> [`Frame`]. On each axis a world coordinate w becomes
//! `u = (w - origin) / spacing - 1/2`, its position relative to the centre of cell 0 in units of the cell, and then the
//! integer `round(u * 2^F)`. The centre of cell i is the integer `i * 2^F`. All later stages decide on these integers
//! only, so every device gives the same flags. Where cells differ in size, `spacing` is the smallest of the axis: see `frame/centres.rs`.
//!
//! `F`, the fraction bits, is the largest number for which all corners and centres, with one cell to spare beyond both
//! ends, span at most 2^[`SPAN_BITS`] units on every axis: 26 bits over the domain, four times finer than f32 resolves a
//! domain that starts at 0.
//!
//! Degenerate cases: equal f32 corners snap to equal integers, so closed surfaces stay closed; facets that collapse to a
//! line or a point are kept and never hit. Source: the paper, Eq. 7-10 (positions); the snap is ours.
//! Cost: one pass over the corners; 38 bytes a facet.

use std::ops::Range;
use std::sync::Arc;

use crate::base::error::Result;
use crate::base::parallel::*;
use crate::grid::lines::Lines;
use crate::input::geometry::{Facet, Geometry};

mod centres;
mod limits;
mod ranks;

use centres::places;
pub use centres::{Centres, Places};
pub use centres::{Scale, nearest};
use limits::fraction_bits;
pub use limits::{MAX_CELLS_PER_AXIS, MIN_FRACTION_BITS, SPAN_BITS};
pub use limits::{check_limits, too_many_ranks};
pub use ranks::Ends;
pub use ranks::{MAX_RANKS, Ranks};

/// Three corners of three fixed-point coordinates x, y, z.
pub type SnappedFacet = [[i32; 3]; 3];

/// Normal of a facet by the right-hand rule, twice its area long: less than 2^52 along each axis, as facets lie in a box of less than 2^26 units.
pub fn normal([a, b, c]: &SnappedFacet) -> [i128; 3] {
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
    /// F: the smallest cell of each axis is 2^F units.
    pub fraction_bits: u32,
    /// Where cells are, in units, where they differ in size; of equal ones cell i has its centre at i * 2^F.
    pub centres: Option<Centres>,
    /// Number of cells on each axis.
    pub dims: [u32; 3],
    /// Facets of all geometries.
    pub facets: Vec<SnappedFacet>,
    /// Position of the geometry of each facet; see [`Ranks`].
    pub position_of_facet: Vec<u16>,
    /// The order in which overlaps are decided.
    pub ranks: Ranks,
}

impl Frame {
    /// Snaps all corners of all geometries.
    ///
    /// # Errors
    /// - `too-many-geometries`: more than [`MAX_RANKS`]; a mesh may have more.
    /// - `too-many-facets`: more than 2^31 in all.
    /// - `too-many-cells`: an axis has more than [`MAX_CELLS_PER_AXIS`] cells.
    /// - `geometry-too-far`: F would be under [`MIN_FRACTION_BITS`]; names the geometry.
    /// - `memory`: facets stay in their file.
    pub fn new(geometries: &[Geometry], lines: &Lines) -> Result<Frame> {
        let mut frame = Frame::without_facets(geometries, lines)?;
        if geometries.len() > MAX_RANKS {
            return Err(too_many_ranks(geometries.len()));
        }
        for (position, &index) in frame.ranks.geometry_at.clone().iter().enumerate() {
            let geometry = &geometries[index];
            frame.facets.par_extend(frame.snapped(geometry, geometry.facets.in_memory("the frame of all")?, lines));
            frame.position_of_facet.resize(frame.facets.len(), position as u16);
        }
        Ok(frame)
    }

    /// The frame of geometries whose facets are snapped later.
    ///
    /// # Errors
    /// Those of [`Frame::new`].
    pub fn without_facets(geometries: &[Geometry], lines: &Lines) -> Result<Frame> {
        check_limits(geometries, lines)?;
        let scale = Scale::new(lines);
        let fraction_bits = fraction_bits(geometries, lines, &scale)?;
        let centres = places(lines, &scale, fraction_bits);
        let (facets, position_of_facet, ranks) = (Vec::new(), Vec::new(), Ranks::new(geometries));
        Ok(Frame { fraction_bits, centres, dims: lines.dims(), facets, position_of_facet, ranks })
    }

    /// Whether cells differ in size.
    pub fn is_graded(&self) -> bool {
        self.places().is_some()
    }

    fn places(&self) -> Option<&Places> {
        self.centres.as_deref()
    }

    /// Centre of a cell along an axis, in units.
    #[inline(always)]
    pub fn centre(&self, axis: usize, cell: u32) -> i32 {
        match self.places() {
            None => (cell << self.fraction_bits) as i32,
            Some(places) => places.centres[axis][cell as usize],
        }
    }

    /// The face below a cell along an axis, in units; that of the number of cells is above the last.
    #[inline(always)]
    pub fn face(&self, axis: usize, cell: u32) -> i32 {
        match self.places() {
            None => (cell << self.fraction_bits) as i32 - self.half(),
            Some(places) => places.faces[axis][cell as usize],
        }
    }

    fn half(&self) -> i32 {
        1 << self.fraction_bits >> 1
    }

    /// Size of the cells along an axis on average, in units.
    pub(crate) fn mean_cell(&self, axis: usize) -> f64 {
        self.places().and_then(|places| places.mean_cell(axis)).unwrap_or(f64::from(1u32 << self.fraction_bits))
    }

    /// Number of cells of an axis whose centres lie below a place, or at it if `with_at`.
    #[inline(always)]
    pub fn n_below(&self, axis: usize, place: i32, with_at: bool) -> u32 {
        let place = i64::from(place) + i64::from(with_at);
        match self.places() {
            None => {
                let cells = (place + (1 << self.fraction_bits) - 1) >> self.fraction_bits;
                cells.clamp(0, self.dims[axis].into()) as u32
            }
            Some(places) => places.n_below(axis, place) as u32,
        }
    }

    /// The first and the last cell of an axis that touch a stretch of it, ends included, also beyond the box. A face belongs to both cells.
    #[inline(always)]
    pub(crate) fn touched(&self, axis: usize, [low, high]: [i64; 2]) -> [i64; 2] {
        let half = i64::from(self.half());
        match self.places() {
            None => [-((half - low) >> self.fraction_bits), (high + half) >> self.fraction_bits],
            Some(places) => places.touched(axis, [low, high]),
        }
    }

    /// The frame in which the cells along some axes lie around the faces of these cells: one more along such an axis, each with its
    /// centre on a face. Only rays may be cast in it, and windows cut out.
    pub fn around_faces(mut self, is_moved: [bool; 3]) -> Frame {
        for axis in (0..3).filter(|&axis| is_moved[axis]) {
            self.dims[axis] += 1;
            match self.centres.as_mut() {
                None => self.move_along(axis, self.half()),
                Some(places) => Arc::make_mut(places).put_on_faces(axis),
            }
        }
        self
    }

    /// The frame with a cell more before the first along an axis and behind the last, as large as these. Only rays may be cast in it, and windows cut out.
    pub fn with_mirrored_ends(mut self, axis: usize) -> Frame {
        self.dims[axis] += 2;
        match self.centres.as_mut() {
            None => self.move_along(axis, 1 << self.fraction_bits),
            Some(places) => Arc::make_mut(places).mirror_ends(axis),
        }
        self
    }

    /// The box and all facets seen in a mirror across each of some axes: cells are counted from the other end. Two mirrors are a turn, which leaves facets facing out.
    pub fn mirrored(mut self, axes: [bool; 3]) -> Frame {
        for axis in (0..3).filter(|&axis| axes[axis]) {
            // the first centre is at 0, and where that was is the last
            let last = self.centre(axis, self.dims[axis] - 1);
            self.facets.iter_mut().flatten().for_each(|corner| corner[axis] = last - corner[axis]);
            if let Some(places) = self.centres.as_mut() {
                Arc::make_mut(places).mirror(axis, last);
            }
        }
        self
    }

    fn move_along(&mut self, axis: usize, by: i32) {
        self.facets.iter_mut().flatten().for_each(|corner| corner[axis] += by);
    }

    /// Snaps some facets of a geometry.
    pub(crate) fn snapped(&self, geometry: &Geometry, facets: &[Facet], lines: &Lines) -> Vec<SnappedFacet> {
        facets.par_iter().map(self.snapping(geometry, lines)).collect()
    }

    /// Returns the function that snaps a facet of a geometry.
    pub fn snapping(
        &self,
        geometry: &Geometry,
        lines: &Lines,
    ) -> impl Fn(&Facet) -> SnappedFacet + Sync + Send + use<> {
        let (placing, scale, fraction_bits) = (geometry.placing(), Scale::new(lines), self.fraction_bits);
        move |&[a, b, c]| {
            let snapped = |corner| snap(placing(corner), &scale, fraction_bits);
            [snapped(a), snapped(b), snapped(c)]
        }
    }

    /// Rank of the geometry of a facet.
    #[inline(always)]
    pub fn rank_of_facet(&self, facet: usize) -> u8 {
        self.ranks.rank_at[usize::from(self.position_of_facet[facet])]
    }

    /// The facets of the geometry at a position: facets are stored in the order of positions.
    pub fn facets_at(&self, position: usize) -> &[SnappedFacet] {
        &self.facets[self.range_at(position)]
    }

    /// Where these facets are.
    pub fn range_at(&self, position: usize) -> Range<usize> {
        let end_of = |n: usize| self.position_of_facet.partition_point(|&of| usize::from(of) < n);
        end_of(position)..end_of(position + 1)
    }

    /// A frame of the same box, of one geometry with the flag 1.
    pub fn with_facets(&self, facets: Vec<SnappedFacet>) -> Frame {
        let (position_of_facet, ranks) = (vec![0; facets.len()], Ranks::of_one());
        Frame { position_of_facet, facets, ranks, centres: self.centres.clone(), ..*self }
    }

    /// The same box with the facets of some positions.
    pub fn with_some(&self, stays: impl Fn(usize) -> bool) -> Frame {
        let both = self.facets.iter().zip(&self.position_of_facet);
        let (facets, position_of_facet) = both.filter(|(_, position)| stays(usize::from(**position))).unzip();
        Frame { facets, position_of_facet, ranks: self.ranks.clone(), centres: self.centres.clone(), ..*self }
    }

    /// The frame of some cells of the box, the first and the end, exclusive: the same corners in the same units, counted from the centre
    /// of the first of these cells, so that every cell is decided as in the whole box. Facets that no ray through these cells meets,
    /// along any axis, are left out.
    pub fn window(&self, cells: [[u32; 3]; 2]) -> Frame {
        self.window_of(cells, |facet| in_window(facet, cells, self)).0
    }

    /// The same with the facets that rays along one axis through these cells may meet; and the index of each here.
    pub fn window_along(&self, axis: usize, cells: [[u32; 3]; 2]) -> (Frame, Vec<u32>) {
        let is_in_reach = |facet: &SnappedFacet| (0..3).all(|of| of == axis || is_near(facet, of, cells, self));
        self.window_of(cells, |facet| is_in_reach(facet).then(|| from_window(facet, cells, self)))
    }

    fn window_of(
        &self,
        cells: [[u32; 3]; 2],
        moved: impl Fn(&SnappedFacet) -> Option<SnappedFacet>,
    ) -> (Frame, Vec<u32>) {
        let mut window = Frame {
            dims: [0, 1, 2].map(|axis| cells[1][axis] - cells[0][axis]),
            facets: Vec::new(),
            position_of_facet: Vec::new(),
            ranks: self.ranks.clone(),
            centres: self.places().map(|places| Arc::new(places.of_cells(cells))),
            ..*self
        };
        let mut indices = Vec::new();
        for (index, facet) in (0u32..).zip(&self.facets) {
            if let Some(moved) = moved(facet) {
                window.facets.push(moved);
                window.position_of_facet.push(self.position_of_facet[index as usize]);
                indices.push(index);
            }
        }
        (window, indices)
    }

    /// Largest distance that the snap moves a corner along an axis, in cells.
    pub fn snap_in_cells(&self) -> f64 {
        0.5 / f64::from(1u32 << self.fraction_bits)
    }
}

/// A facet, counted from the centre of the first cell of a window; None if the facet is nowhere near the rays through the window's
/// cells, which would meet it along one axis and so have it within their reach along the two others.
pub(crate) fn in_window(facet: &SnappedFacet, cells: [[u32; 3]; 2], whole: &Frame) -> Option<SnappedFacet> {
    let is_in_reach = (0..3).filter(|&axis| is_near(facet, axis, cells, whole)).count() >= 2;
    is_in_reach.then(|| from_window(facet, cells, whole))
}

/// Whether a facet reaches the cells of a window along an axis.
fn is_near(facet: &SnappedFacet, axis: usize, cells: [[u32; 3]; 2], whole: &Frame) -> bool {
    let places = [facet[0][axis], facet[1][axis], facet[2][axis]];
    // cells along a surface are touched by facets beside their centres
    let [low, high] = cells.map(|cell| whole.face(axis, cell[axis]));
    places.iter().any(|&place| place >= low) && places.iter().any(|&place| place <= high)
}

/// A facet, counted from the centre of the first cell of a window.
fn from_window(facet: &SnappedFacet, [first, _]: [[u32; 3]; 2], whole: &Frame) -> SnappedFacet {
    moved(facet, [0, 1, 2].map(|axis| -whole.centre(axis, first[axis])))
}

/// A facet moved by so many units along each axis.
pub fn moved(facet: &SnappedFacet, by: [i32; 3]) -> SnappedFacet {
    let at = |[x, y, z]: [i32; 3]| [x + by[0], y + by[1], z + by[2]];
    [at(facet[0]), at(facet[1]), at(facet[2])]
}

#[inline(always)]
fn snap([x, y, z]: [f64; 3], scale: &Scale, fraction_bits: u32) -> [i32; 3] {
    let factor = f64::from(1u32 << fraction_bits);
    let snapped = |axis: usize, world: f64| nearest(scale.units_from_world(axis, world) * factor);
    [snapped(0, x), snapped(1, y), snapped(2, z)]
}

/// World coordinates of a snapped corner.
pub(crate) fn world(corner: [i32; 3], fraction_bits: u32, lines: &Lines) -> [f64; 3] {
    let scale = Scale::new(lines);
    let units = |axis: usize| f64::from(corner[axis]) / f64::from(1u32 << fraction_bits);
    [0, 1, 2].map(|axis| scale.world_from_units(axis, units(axis)))
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
    fn a_mirror_turns_the_cells_and_their_faces_around() {
        let lists = [vec![0.0, 1.0, 3.0, 3.5], vec![0.0, 1.0, 2.0], vec![0.0, 1.0, 2.0]];
        let graded = Lines::from_lists(lists).unwrap();
        let equal = Lines::new([0.0; 3], [1.0; 3], [3, 2, 2]).unwrap();
        for lines in [graded, equal] {
            let frame = Frame::new(&[corner([3.0, 0.5, 0.5])], &lines).unwrap();
            let there = frame.clone().mirrored([true, false, true]);
            for (line, place) in (0..=3).map(|line| (line, frame.face(0, 3 - line))) {
                assert_eq!(there.face(0, line), frame.centre(0, 2) - place, "line {line}");
            }
            assert_eq!(there.centre(0, 0), 0);
            assert_eq!(there.facets[0][0][0], frame.centre(0, 2) - frame.facets[0][0][0]);
            assert_eq!(there.facets[0][0][1], frame.facets[0][0][1]);
            assert_eq!(there.mirrored([true, false, true]), frame);
        }
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
        assert_eq!(Ranks::new(&geometries).geometry_at, [1, 2, 0]);
        assert_eq!(Ranks::new(&geometries).flag_of_rank, [1, 1, 7]);
    }

    #[test]
    fn nearest_integers_are_found_from_bits() {
        let halves = (-8..8).map(|half| f64::from(half) / 2.0);
        for value in [-1e9, -2.6, -0.4, 0.0, 0.4, 1.6, 134_217_728.3, 1_073_741_823.5].into_iter().chain(halves) {
            assert_eq!(f64::from(nearest(value)), libm::rint(value), "{value}");
        }
    }
}
