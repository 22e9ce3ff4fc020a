//! Who takes the hits of facets: they come in rows of consecutive rays.

use std::ops::Range;

/// Where along its ray a hit is. What its caller does not ask for is not computed.
#[derive(Clone, Copy, Default)]
pub struct Height {
    /// The place is `(below + rest / area) unit` units; `0 <= rest < area`. Among equal cells what is less than 2^-F of a cell times `1 / area` is left out.
    pub(super) below: i64,
    pub(super) rest: i64,
    pub(super) area: i64,
    pub(super) unit: f64,
    /// Whether a centre lies on the facet, and counts as above it.
    pub(super) is_at_centre: bool,
}

impl Height {
    /// The place in units, to 2^-50 of itself.
    #[inline(always)]
    pub fn place(self) -> f64 {
        self.place_of(self.parts())
    }

    /// The same of any hit of the facet, given its parts.
    #[inline(always)]
    pub(crate) fn place_of(self, [below, rest]: [f64; 2]) -> f64 {
        (below + rest / self.area as f64) * self.unit
    }

    /// What hits of a facet differ in.
    #[inline(always)]
    pub(crate) fn parts(self) -> [f64; 2] {
        [self.below as f64, self.rest as f64]
    }

    /// How far the hit is above the centre of the last cell below, in cells, times the area and rounded down: at most the area. Of equal cells, and of hits
    /// between centres.
    #[inline(always)]
    pub fn above_centre(self) -> i64 {
        if self.is_at_centre { self.area } else { self.rest }
    }
}

/// What takes the hits of facets, row after row.
pub trait Rows {
    /// Takes the hits of consecutive rays of row j: of each its first cell above, and its place.
    fn row(&mut self, j: u32, across: Range<u32>, hits: impl Iterator<Item = (u32, Height)>);
}

impl<F: FnMut(u32, u32, u32, Height)> Rows for F {
    /// Calls it with i, j, the first cell above, and the place of each hit.
    #[inline(always)]
    fn row(&mut self, j: u32, across: Range<u32>, hits: impl Iterator<Item = (u32, Height)>) {
        across.zip(hits).for_each(|(i, (above, place))| self(i, j, above, place));
    }
}

/// A list of `hit(i, j, first cell above, place)`.
pub(crate) struct List<'a, T, F> {
    pub(crate) hit: F,
    pub(crate) hits: &'a mut Vec<T>,
}

impl<T, F: Fn(u32, u32, u32, Height) -> T> Rows for List<'_, T, F> {
    #[inline(always)]
    fn row(&mut self, j: u32, across: Range<u32>, hits: impl Iterator<Item = (u32, Height)>) {
        self.hits.extend(across.zip(hits).map(|(i, (above, place))| (self.hit)(i, j, above, place)));
    }
}
