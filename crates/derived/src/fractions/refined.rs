//! Rays within cells, or within their faces: where they are, and where in a cell a place along them is.

use std::borrow::Cow;
use std::sync::Arc;

use hexcast_core::grid::frame::{Frame, Places, Scale, moved};
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::rays::Rays;
use hexcast_core::grid::window::CellWindow;

/// Bits of a length within a cell.
const BITS: u32 = 24;
/// The length of a cell.
pub(super) const WHOLE: i64 = 1 << BITS;
/// Bits of a place within a cell: it may be at its end.
pub(super) const PLACE_BITS: u32 = BITS + 1;

/// Several rays for each column of cells, or of faces.
pub(super) struct Refined {
    /// The facets, and in place of the centres of cells the places of the rays.
    pub(super) frame: Frame,
    pub(super) rays: Rays,
    /// Rays of a column along each axis across.
    pub(super) per_column: [u32; 2],
    /// Cells of a column.
    pub(super) n: u32,
    /// Lines across the rays in units, where cells differ in size.
    lines: Option<Vec<f64>>,
    /// Line 0 in units and cells a unit along the rays, where all are equal.
    first: f64,
    per_size: f64,
}

impl Refined {
    /// m x m rays for each column of cells along x through a window, from end to end of the box: each in the middle of a square.
    pub(super) fn of_cells(whole: &Frame, lines: &Lines, m: u32, window: &CellWindow) -> Refined {
        let (frame, cells) = across(whole, 0, window);
        let dims = [0, 1, 2].map(|axis| m * (cells[1][axis] - cells[0][axis]));
        let rays = Rays::new(0, dims);
        let (per_column, n) = ([m; 2], whole.dims[0]);
        if !frame.is_graded() {
            let bits = frame.fraction_bits - m.trailing_zeros();
            // from the first centre within a cell to that of the cell
            let by = ((1i32 << frame.fraction_bits) - (1 << bits)) / 2;
            let facets = frame.facets.iter().map(|facet| moved(facet, [by; 3])).collect();
            let (position_of_facet, ranks) = (frame.position_of_facet.clone(), frame.ranks.clone());
            let per_size = 1.0 / f64::from(1u32 << frame.fraction_bits);
            let frame = Frame { fraction_bits: bits, centres: None, dims, facets, position_of_facet, ranks };
            return Refined {
                frame,
                rays,
                per_column,
                n,
                lines: None,
                first: -0.5 * f64::from(1u32 << bits),
                per_size,
            };
        }
        let places = InUnits::new(whole, lines, cells);
        let centres = [0, 1, 2].map(|axis| places.within(axis, m));
        let frame = Frame { centres: Some(table(centres)), dims, ..frame.into_owned() };
        Refined { frame, rays, per_column, n, lines: Some(places.lines(0)), first: 0.0, per_size: 1.0 }
    }

    /// m rays for each column of faces across an axis of the cells of a window, in the planes of these faces.
    pub(super) fn of_faces(whole: &Frame, lines: &Lines, m: u32, axis: usize, window: &CellWindow) -> Refined {
        let along = usize::from(axis == 0);
        let (frame, cells) = across(whole, along, window);
        let places = InUnits::new(whole, lines, cells);
        let centres = [0, 1, 2].map(|of| match of {
            _ if of == axis => places.lines(axis).into_iter().map(|line| places.place(axis, line)).collect(),
            _ if of == along => places.within(along, 1),
            _ => places.within(of, m),
        });
        let dims = [0, 1, 2].map(|of| centres[of].len() as u32);
        let rays = Rays::new(along, dims);
        let per_column = rays.across.map(|of| if of == axis { 1 } else { m });
        let size = f64::from(1u32 << frame.fraction_bits);
        let (first, per_size) = (-0.5 * size, 1.0 / size);
        let list = frame.is_graded().then(|| places.lines(along));
        let frame = Frame { centres: Some(table(centres)), dims, ..frame.into_owned() };
        Refined { frame, rays, per_column, n: lines.dims()[along], lines: list, first, per_size }
    }

    /// Where cells along rays are.
    pub(super) fn along(&self) -> Along<'_> {
        match &self.lines {
            None => Along::Equal(Equal { first: self.first, per_size: self.per_size, n: self.n.into() }),
            Some(lines) => Along::Lines(lines),
        }
    }
}

/// Where cells along rays are. A place becomes `cell << 25 | length in the cell before it`; cell 0 and 0 before the first cell, the number of cells behind the
/// last.
pub(super) enum Along<'a> {
    Equal(Equal),
    Lines(&'a [f64]),
}

/// Cells of one size: line 0 in units, cells a unit, and how many cells there are.
#[derive(Clone, Copy)]
pub(super) struct Equal {
    first: f64,
    per_size: f64,
    n: f64,
}

/// Added to a number from 0 to 2^31 it rounds that to a whole number, which the low bits then have.
const TO_WHOLE: f64 = (1u64 << 52) as f64;

impl Equal {
    /// Compiled for several places at once: without conversions, which processors have for single numbers alone.
    #[inline(always)]
    pub(super) fn place(&self, at: f64) -> u64 {
        let cells = ((at - self.first) * self.per_size).max(0.0);
        let cells = if cells < self.n { cells } else { self.n };
        let (cell, cell_bits) = rounded_down(cells);
        let (_, left) = rounded_down((1.0 - (cells - cell)) * WHOLE as f64 + 0.5);
        cell_bits << PLACE_BITS | (WHOLE as u64 - left)
    }
}

/// A number from 0 to 2^31, rounded down, as f64 and as integer.
#[inline(always)]
fn rounded_down(number: f64) -> (f64, u64) {
    let sum = number + TO_WHOLE;
    let nearest = sum - TO_WHOLE;
    let sum = if nearest > number { sum - 1.0 } else { sum };
    (sum - TO_WHOLE, sum.to_bits() & 0xffff_ffff)
}

/// The same where cells differ in size, by their lines.
pub(super) fn place_among(lines: &[f64], at: f64) -> u64 {
    let above = lines.partition_point(|&line| line <= at);
    let (cell, fraction) = match above {
        0 => (0, 0.0),
        _ if above == lines.len() => (above - 1, 0.0),
        _ => (above - 1, (at - lines[above - 1]) / (lines[above] - lines[above - 1])),
    };
    let left = ((1.0 - fraction) * WHOLE as f64 + 0.5) as i32;
    (cell as u64) << PLACE_BITS | (WHOLE as i32 - left).min(WHOLE as i32) as u64
}

/// The frame of rays along an axis through the cells of a window, which go from end to end of the box; and all cells that they go through.
fn across<'a>(whole: &'a Frame, along: usize, window: &CellWindow) -> (Cow<'a, Frame>, [[u32; 3]; 2]) {
    let mut cells = [window.first, window.end];
    (cells[0][along], cells[1][along]) = (0, whole.dims[along]);
    match cells == [[0; 3], whole.dims] {
        true => (Cow::Borrowed(whole), cells),
        false => (Cow::Owned(whole.window_along(along, cells).0), cells),
    }
}

/// Places of some cells of a box in the units of its frame.
pub(super) struct InUnits<'a> {
    lines: &'a Lines,
    scale: Scale,
    factor: f64,
    cells: [[u32; 3]; 2],
    /// Centres of the first of these cells, which rays are counted from.
    first: [i32; 3],
}

impl InUnits<'_> {
    pub(super) fn new<'a>(frame: &Frame, lines: &'a Lines, cells: [[u32; 3]; 2]) -> InUnits<'a> {
        let first = [0, 1, 2].map(|axis| frame.centre(axis, cells[0][axis]));
        InUnits { lines, scale: Scale::new(lines), factor: f64::from(1u32 << frame.fraction_bits), cells, first }
    }

    fn units(&self, axis: usize, world: f64) -> f64 {
        self.scale.units_from_world(axis, world) * self.factor
    }

    /// All lines of an axis of these cells, counted in the box.
    pub(super) fn lines(&self, axis: usize) -> Vec<f64> {
        let [first, end] = self.cells.map(|cell| cell[axis]);
        (first..=end).map(|line| self.units(axis, self.lines.line(axis, line))).collect()
    }

    /// The place of a ray.
    fn place(&self, axis: usize, units: f64) -> i32 {
        libm::rint(units) as i32 - self.first[axis]
    }

    /// Size of a unit along each axis.
    pub(super) fn sizes(&self) -> [f64; 3] {
        self.lines.smallest().map(|size| size / self.factor)
    }

    /// The middles of m equal pieces of each cell of an axis.
    fn within(&self, axis: usize, m: u32) -> Vec<i32> {
        let place = |index: u32| {
            let fraction = (f64::from(index % m) + 0.5) / f64::from(m);
            self.place(axis, self.units(axis, self.lines.at(axis, f64::from(index / m) + fraction)))
        };
        (m * self.cells[0][axis]..m * self.cells[1][axis]).map(place).collect()
    }
}

/// Rays have places of their own, and no faces.
fn table(centres: [Vec<i32>; 3]) -> Arc<Places> {
    Arc::new(Places { centres, faces: Default::default() })
}
