//! The crossings of one geometry with all rays along an axis, in the order of planes and rows of cells.
//!
//! [`Crossings`] of either backend -> [`AxisCrossings`]. A crossing is one word,
//! `c << 37 | a << 19 | b << 1 | direction`, whatever the axis of its ray. a, b and c are the numbers of a cell: a along the
//! axis of the mesh's rays, b and c along the axes across it. Along its own ray it is the first cell whose centre counts as
//! above the crossing.
//! Cost: O(crossings) time; 8 bytes per crossing, 16 while they are grouped.

use std::collections::BTreeMap;
use std::ops::Range;

use crate::base::parallel::*;
use crate::grid::frame::{Frame, SnappedFacet};
use crate::grid::rays::Rays;
use crate::stages::crossings::Crossings;

/// Crossings of all rays of an axis; the plane, row and place that they begin at, and a direction.
pub(crate) type Words = Vec<u64>;

pub(crate) const EXITS: u64 = 1;

pub(crate) fn plane_of(word: u64) -> u32 {
    (word >> 37) as u32
}

pub(crate) fn row_of(word: u64) -> u32 {
    (word >> 19) as u32 & 0x3_ffff
}

pub(crate) fn place_of(word: u64) -> u32 {
    (word >> 1) as u32 & 0x3_ffff
}

/// The lowest bit, in a word, of the cell along an axis.
pub(crate) fn bit_of_axis(axis: usize, main: &Rays) -> u32 {
    if axis == main.axis {
        19
    } else if axis == main.across[0] {
        1
    } else {
        37
    }
}

/// A frame of one geometry, and the axes of the rays that shall be cast at it.
pub struct AxisCasts {
    /// The facets.
    pub frame: Frame,
    /// Axes; with true only those crossings count where the number of the facets that were entered, less those left, becomes 0 or
    /// ceases to be.
    pub axes: Vec<(usize, bool)>,
}

/// The crossings of a frame of one geometry with all rays along an axis.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct AxisCrossings {
    pub(crate) words: Words,
    /// Rays that do not leave what they enter.
    pub(crate) n_odd: u64,
    /// Of rays along those of the mesh: planes, ascending, and how many crossings in each do not count.
    pub(crate) uncounted: Vec<(u32, u64)>,
}

/// Crossings of an axis, as they come.
#[derive(Default)]
pub struct Collected {
    parts: Vec<Words>,
    n_odd: u64,
    uncounted: BTreeMap<u32, u64>,
}

impl Collected {
    /// Adds the crossings of more rays, for a mesh whose rays are `main`; `is_counted` as in [`AxisCasts`].
    pub fn add(&mut self, more: Vec<Crossings>, rays: &Rays, main: &Rays, is_counted: bool) {
        let of_band = |crossings: Crossings| words(&crossings, rays, main, is_counted);
        let found: Vec<AxisCrossings> = on_all_cores(|| more.into_par_iter().map(of_band).collect());
        for found in found {
            self.parts.push(found.words);
            self.n_odd += found.n_odd;
            found.uncounted.into_iter().for_each(|(plane, n)| *self.uncounted.entry(plane).or_insert(0) += n);
        }
    }

    /// All crossings, in order.
    pub fn in_order(self) -> AxisCrossings {
        let uncounted = self.uncounted.into_iter().collect();
        AxisCrossings { words: grouped(&self.parts), n_odd: self.n_odd, uncounted }
    }
}

/// Crossings as words, ray after ray.
fn words(crossings: &Crossings, rays: &Rays, main: &Rays, is_counted: bool) -> AxisCrossings {
    let (mut words, mut n_odd, mut uncounted) = (Vec::with_capacity(crossings.events.len()), 0, Vec::new());
    let mut events = Vec::new();
    for (ray, ends) in (crossings.first_ray..).zip(crossings.offsets.windows(2)) {
        let of_ray = &crossings.events[ends[0] as usize..ends[1] as usize];
        let n_i = u64::from(rays.counts[0]);
        let mut cell = [0u64; 3];
        (cell[rays.across[0]], cell[rays.across[1]]) = (ray % n_i, ray / n_i);
        let mut push = |event: u32| {
            cell[rays.axis] = u64::from(event >> 9);
            let place: u64 = (0..3).map(|axis| cell[axis] << bit_of_axis(axis, main)).sum();
            words.push(place | u64::from(event & 1));
        };
        if is_counted {
            events.clear();
            events.extend_from_slice(of_ray);
            events.sort_unstable();
            let (mut winding, mut n_left) = (0, events.len() as u64);
            for &event in &events {
                let was_inside = winding != 0;
                winding += 1 - 2 * (event & 1) as i32;
                if was_inside != (winding != 0) {
                    push(event);
                    n_left -= 1;
                }
            }
            if n_left > 0 && rays.axis == main.axis {
                uncounted.push(((ray / n_i) as u32, n_left));
            }
            n_odd += u64::from(winding != 0);
        } else {
            of_ray.iter().for_each(|&event| push(event));
            n_odd += of_ray.len() as u64 % 2;
        }
    }
    AxisCrossings { words, n_odd, uncounted }
}

/// Crossings of facets with all rays along an axis, about: one for each cell of the area that they cover across it.
pub(crate) fn n_expected(facets: &[SnappedFacet], axis: usize, frame: &Frame) -> f64 {
    let (i, j) = ((axis + 1) % 3, (axis + 2) % 3);
    let cells = [0, 1, 2].map(|axis| frame.mean_cell(axis));
    let area = |[a, b, c]: &SnappedFacet| {
        let side = |to: &[i32; 3], axis: usize| (f64::from(to[axis]) - f64::from(a[axis])) / cells[axis];
        0.5 * (side(b, i) * side(c, j) - side(c, i) * side(b, j)).abs()
    };
    facets.iter().map(area).sum()
}

/// Words in the order of their planes and rows, in any order within a row: by counting, planes first, then the rows of each.
pub(crate) fn grouped(parts: &[impl AsRef<[u64]>]) -> Words {
    let (mut words, ends) = counted(parts.iter().flat_map(AsRef::as_ref).copied(), plane_of);
    let mut planes = Vec::with_capacity(ends.len());
    let (mut rest, mut start) = (&mut words[..], 0);
    for end in ends {
        let (plane, after) = rest.split_at_mut(end - start);
        planes.push(plane);
        (rest, start) = (after, end);
    }
    let by_rows = |plane: &mut [u64]| {
        let by_row = counted(plane.iter().copied(), row_of).0;
        plane.copy_from_slice(&by_row);
    };
    on_all_cores(|| planes.into_par_iter().for_each(by_rows));
    words
}

/// Words in the order of a part of each, and the end of those of every value of that part.
fn counted(words: impl Iterator<Item = u64> + Clone, part: fn(u64) -> u32) -> (Words, Vec<usize>) {
    let mut next = Vec::new();
    for word in words.clone() {
        let value = part(word) as usize;
        if value >= next.len() {
            next.resize(value + 1, 0);
        }
        next[value] += 1;
    }
    let mut n = 0;
    for count in &mut next {
        n += std::mem::replace(count, n);
    }
    let mut ordered = vec![0; n];
    for word in words {
        let at = &mut next[part(word) as usize];
        ordered[*at] = word;
        *at += 1;
    }
    (ordered, next)
}

pub(crate) fn of_planes<'a>(words: &'a [u64], planes: &Range<u32>) -> &'a [u64] {
    let [start, end] = [planes.start, planes.end].map(|plane| words.partition_point(|&word| plane_of(word) < plane));
    &words[start..end]
}

/// Takes the words of a row off the front.
pub(crate) fn take_row<'a>(words: &mut &'a [u64], row: u32) -> &'a [u64] {
    let n = words.iter().take_while(|&&word| row_of(word) == row).count();
    let (own, rest) = words.split_at(n);
    *words = rest;
    own
}
