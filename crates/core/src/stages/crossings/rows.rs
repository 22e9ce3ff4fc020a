//! Who takes the hits of facets: they come in rows of consecutive rays.

use std::ops::Range;

/// What takes the hits of facets, row after row.
pub(crate) trait Rows {
    /// Takes the hits of consecutive rays of row j: of each its first cell above, and its place in units, to 2^-50 of itself.
    fn row(&mut self, j: u32, across: Range<u32>, hits: impl Iterator<Item = (u32, f64)>);
}

impl<F: FnMut(u32, u32, u32, f64)> Rows for F {
    /// Calls it with i, j, the first cell above, and the place of each hit.
    #[inline(always)]
    fn row(&mut self, j: u32, across: Range<u32>, hits: impl Iterator<Item = (u32, f64)>) {
        across.zip(hits).for_each(|(i, (above, place))| self(i, j, above, place));
    }
}

/// A list of `hit(i, j, first cell above, place)`.
pub(crate) struct List<'a, T, F> {
    pub(crate) hit: F,
    pub(crate) hits: &'a mut Vec<T>,
}

impl<T, F: Fn(u32, u32, u32, f64) -> T> Rows for List<'_, T, F> {
    #[inline(always)]
    fn row(&mut self, j: u32, across: Range<u32>, hits: impl Iterator<Item = (u32, f64)>) {
        self.hits.extend(across.zip(hits).map(|(i, (above, place))| (self.hit)(i, j, above, place)));
    }
}
