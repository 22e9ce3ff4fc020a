//! Facets that are shared and not copied: a range of a list.
//!
//! A file is read into one list; its solids, and the geometries of jobs, are ranges of it. A clone shares the list, so that an
//! estimate at every keystroke needs no second copy of a large model.

use std::ops::{Deref, Range};
use std::sync::Arc;

use crate::error::{Error, Result};
use crate::parallel::*;

/// One triangular facet: three corners of three coordinates, in the order of the file.
pub type Facet = [[f32; 3]; 3];

/// Returns an error if a coordinate is NaN or infinite; `name` is that of the surface.
///
/// # Errors
/// `stl-not-finite`, with the first such facet.
pub(crate) fn check_finite(name: &str, facets: &[Facet]) -> Result<()> {
    let is_sound = |facet: &Facet| facet.as_flattened().iter().all(|number| number.is_finite());
    if facets.par_iter().all(is_sound) {
        return Ok(());
    }
    let numbers = facets.as_flattened().as_flattened();
    let place = numbers.iter().position(|number| !number.is_finite()).unwrap_or_default();
    let message = format!("{name}: number {} of facet {} is {}", place % 9, place / 9, numbers[place]);
    Err(Error::new("stl-not-finite", message, "remove the facet"))
}

/// A range of a shared list of facets; derefs to a slice.
#[derive(Clone, Default)]
pub struct SharedFacets {
    all: Arc<Vec<Facet>>,
    part: Range<usize>,
}

impl SharedFacets {
    /// Cuts a list into consecutive parts that begin at the given indices, ascending; the last reaches to the end.
    ///
    /// # Panics
    /// If an index is beyond the end or less than the one before it: a bug of the caller.
    pub fn cut(all: Vec<Facet>, starts: &[usize]) -> Vec<SharedFacets> {
        let all = Arc::new(all);
        let ends = starts.iter().skip(1).copied().chain([all.len()]);
        let part = |(&start, end): (&usize, usize)| {
            assert!(start <= end && end <= all.len(), "parts must follow each other");
            SharedFacets { all: all.clone(), part: start..end }
        };
        starts.iter().zip(ends).map(part).collect()
    }

    /// Joins parts: without a copy where they are consecutive ranges of one list, as the solids of a file are.
    pub fn join(parts: &[SharedFacets]) -> SharedFacets {
        let Some((first, last)) = parts.first().zip(parts.last()) else { return SharedFacets::default() };
        let goes_on =
            |pair: &[SharedFacets]| Arc::ptr_eq(&pair[0].all, &pair[1].all) && pair[0].part.end == pair[1].part.start;
        if parts.windows(2).all(goes_on) {
            return SharedFacets { all: first.all.clone(), part: first.part.start..last.part.end };
        }
        parts.iter().flat_map(|part| part.iter().copied()).collect::<Vec<Facet>>().into()
    }
}

impl From<Vec<Facet>> for SharedFacets {
    fn from(facets: Vec<Facet>) -> SharedFacets {
        SharedFacets { part: 0..facets.len(), all: Arc::new(facets) }
    }
}

impl Deref for SharedFacets {
    type Target = [Facet];

    fn deref(&self) -> &[Facet] {
        &self.all[self.part.clone()]
    }
}

impl PartialEq for SharedFacets {
    /// Two are equal if their facets are, shared or not.
    fn eq(&self, other: &SharedFacets) -> bool {
        **self == **other
    }
}

impl std::fmt::Debug for SharedFacets {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        (**self).fmt(formatter)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn facet(number: f32) -> Facet {
        [[number; 3]; 3]
    }

    #[test]
    fn neighbours_are_joined_without_a_copy_and_others_with_one() {
        let all: Vec<Facet> = (0..5).map(|n| facet(n as f32)).collect();
        let parts = SharedFacets::cut(all.clone(), &[0, 2, 2]);
        assert_eq!(parts.iter().map(|part| part.len()).collect::<Vec<_>>(), [2, 0, 3]);
        let whole = SharedFacets::join(&parts);
        assert_eq!((&*whole, whole.as_ptr()), (&all[..], parts[0].as_ptr()));
        let turned = SharedFacets::join(&[parts[2].clone(), parts[0].clone()]);
        assert_eq!(*turned, [2.0, 3.0, 4.0, 0.0, 1.0].map(facet));
        assert_ne!(turned, whole);
        assert!(SharedFacets::join(&[]).is_empty());
    }
}
