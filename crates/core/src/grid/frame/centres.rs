//! Where the centres and the faces of cells are in the frame.
//!
//! Of equal cells the centre of cell i is the integer `i * 2^F`, and its lower face is half a cell below; of listed lines they are
//! `round(u * 2^F)` like any other place, from a table.
//! u is counted from the centre of cell 0 in sizes of the smallest cell of the axis, so neighbouring centres are at least `2^F - 1`
//! units from each other.

use std::sync::Arc;

use crate::grid::lines::Lines;

/// Places in the frame of cells that differ in size.
pub type Centres = Arc<Places>;

/// Where cells are along each axis, in units.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Places {
    /// Centres of all cells, ascending from 0.
    pub centres: [Vec<i32>; 3],
    /// The faces below all cells, and that above the last.
    pub faces: [Vec<i32>; 3],
}

impl Places {
    /// Number of cells of an axis whose centres lie below a place.
    #[inline(always)]
    pub(super) fn n_below(&self, axis: usize, place: i64) -> usize {
        n_below(&self.centres[axis], place)
    }

    /// Size of the cells along an axis on average; None of one cell.
    pub(super) fn mean_cell(&self, axis: usize) -> Option<f64> {
        let centres = &self.centres[axis];
        let n = centres.len();
        (n > 1).then(|| f64::from(centres[n - 1] - centres[0]) / (n - 1) as f64)
    }

    /// As [`super::Frame::touched`].
    #[inline(always)]
    pub(super) fn touched(&self, axis: usize, [low, high]: [i64; 2]) -> [i64; 2] {
        [low, high + 1].map(|place| n_below(&self.faces[axis], place) as i64 - 1)
    }

    /// The places of some cells, counted from the centre of the first.
    pub(super) fn of_cells(&self, [first, end]: [[u32; 3]; 2]) -> Places {
        let of = |tables: &[Vec<i32>; 3], more: usize| {
            [0, 1, 2].map(|axis: usize| {
                let start = self.centres[axis][first[axis] as usize];
                let some = &tables[axis][first[axis] as usize..end[axis] as usize + more];
                some.iter().map(|place| place - start).collect()
            })
        };
        Places { centres: of(&self.centres, 0), faces: of(&self.faces, 1) }
    }

    /// Puts the centres of cells, one more, on the faces along an axis, and the faces on the centres.
    pub(super) fn put_on_faces(&mut self, axis: usize) {
        let (centres, faces) = (&mut self.centres[axis], &mut self.faces[axis]);
        add_images(centres, faces);
        std::mem::swap(centres, faces);
    }

    /// Counts the cells of an axis from the other end, whose centre is at `last`.
    pub(super) fn mirror(&mut self, axis: usize, last: i32) {
        for places in [&mut self.centres[axis], &mut self.faces[axis]] {
            places.reverse();
            places.iter_mut().for_each(|place| *place = last - *place);
        }
    }

    /// Adds the mirror images of the first and the last centre along an axis, in the faces at its ends; and faces beyond them.
    pub(super) fn mirror_ends(&mut self, axis: usize) {
        let (centres, faces) = (&mut self.centres[axis], &mut self.faces[axis]);
        add_images(centres, faces);
        add_images(faces, centres);
    }
}

/// Adds the mirror images of the first and the last of some places, in the first and the last of others.
fn add_images(places: &mut Vec<i32>, mirrors: &[i32]) {
    let image = |place: i32, mirror: i32| 2 * mirror - place;
    let (first, last) = (image(places[0], mirrors[0]), image(places[places.len() - 1], mirrors[mirrors.len() - 1]));
    places.insert(0, first);
    places.push(last);
}

/// Number of places of an ascending list below one.
#[inline(always)]
fn n_below(places: &[i32], place: i64) -> usize {
    places.partition_point(|&at| i64::from(at) < place)
}

/// How places are counted: from the centre of cell 0, in cells of the smallest size.
#[derive(Debug, Clone, Copy)]
pub struct Scale {
    origin: [f64; 3],
    unit: [f64; 3],
    /// From line 0 to the centre of cell 0.
    half: [f64; 3],
}

impl Scale {
    pub fn new(lines: &Lines) -> Scale {
        let (origin, unit) = (lines.origin(), lines.smallest());
        Scale { origin, unit, half: [0, 1, 2].map(|axis| 0.5 * (lines.cell_size(axis, 0) / unit[axis])) }
    }

    #[inline(always)]
    pub fn units_from_world(&self, axis: usize, world: f64) -> f64 {
        (world - self.origin[axis]) / self.unit[axis] - self.half[axis]
    }

    pub(crate) fn world_from_units(&self, axis: usize, units: f64) -> f64 {
        self.origin[axis] + (units + self.half[axis]) * self.unit[axis]
    }
}

/// The nearest integer of a number below 2^30, ties to even: adding 1.5 2^52 leaves it in the low bits. Two instructions, where `rint` is a call.
#[inline(always)]
pub fn nearest(value: f64) -> i32 {
    (value + 6_755_399_441_055_744.0).to_bits() as i32
}

/// The places of listed lines; None where cells are equal.
pub(super) fn places(lines: &Lines, scale: &Scale, fraction_bits: u32) -> Option<Centres> {
    let factor = f64::from(1u32 << fraction_bits);
    let place = |axis: usize, world: f64| nearest(scale.units_from_world(axis, world) * factor);
    let middle = |axis: usize, cell: u32| 0.5 * (lines.line(axis, cell) + lines.line(axis, cell + 1));
    let centres = |axis: usize| (0..lines.dims()[axis]).map(|cell| place(axis, middle(axis, cell))).collect();
    let faces = |axis: usize| (0..=lines.dims()[axis]).map(|line| place(axis, lines.line(axis, line))).collect();
    lines.is_graded().then(|| Arc::new(Places { centres: [0, 1, 2].map(centres), faces: [0, 1, 2].map(faces) }))
}
