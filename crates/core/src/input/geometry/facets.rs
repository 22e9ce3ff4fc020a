//! Facets that are shared and not copied: a range of a list.
//!
//! A file is read into one list; its solids, and the geometries of jobs, are ranges of it. A clone shares the list, so that an
//! estimate at every keystroke needs no second copy of a large model.

use std::ops::{Deref, Range};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::measures::Measures;
use crate::base::error::{Error, Result};
use crate::base::parallel::*;
use hexcast_job::input::choices::placing::Placing;

/// One triangular facet: three corners of three coordinates, in the order of the file.
pub type Facet = [[f32; 3]; 3];

/// Returns an error if a coordinate is NaN or infinite; `name` is that of the surface.
fn check_finite(name: &str, facets: &[Facet]) -> Result<()> {
    let is_sound = |facet: &Facet| facet.as_flattened().iter().all(|number| number.is_finite());
    if on_all_cores(|| facets.par_iter().all(is_sound)) {
        return Ok(());
    }
    let numbers = facets.as_flattened().as_flattened();
    let place = numbers.iter().position(|number| !number.is_finite()).unwrap_or_default();
    let message = format!("{name}: number {} of facet {} is {}", place % 9, place / 9, numbers[place]);
    Err(Error::new("stl-not-finite", message, "remove the facet"))
}

/// Measures that are kept with a list, at most: those of the parts of a job.
const MAX_KEPT: usize = 256;

/// Facets, and what was found out about them.
#[derive(Default)]
struct List {
    facets: Vec<Facet>,
    /// Whether all their coordinates are known to be finite.
    is_finite: AtomicBool,
    /// Measures of parts, each where it is placed.
    kept: Mutex<Vec<(Range<usize>, Placing, Measures)>>,
}

/// A range of a shared list of facets; derefs to a slice.
#[derive(Clone, Default)]
pub struct SharedFacets {
    all: Arc<List>,
    part: Range<usize>,
}

impl SharedFacets {
    /// Cuts a list into consecutive parts that begin at the given indices, ascending; the last reaches to the end.
    ///
    /// # Panics
    /// If an index is beyond the end or less than the one before it: a bug of the caller.
    pub fn cut(all: Vec<Facet>, starts: &[usize]) -> Vec<SharedFacets> {
        let n = all.len();
        let all = Arc::new(List { facets: all, ..List::default() });
        let ends = starts.iter().skip(1).copied().chain([n]);
        let part = |(&start, end): (&usize, usize)| {
            assert!(start <= end && end <= n, "parts must follow each other");
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

    /// Whether these are the same part of the same list: what is so needs no comparison.
    pub(crate) fn is_same(&self, other: &SharedFacets) -> bool {
        Arc::ptr_eq(&self.all, &other.all) && self.part == other.part
    }

    /// The same facets, all of whose coordinates the caller found to be finite, and the others of their list too.
    pub(crate) fn known_finite(self) -> SharedFacets {
        self.all.is_finite.store(true, Relaxed);
        self
    }

    /// Returns an error if a coordinate is NaN or infinite, unless that was found out before; `name` is that of the surface.
    ///
    /// # Errors
    /// `stl-not-finite`, with the first such facet.
    pub(crate) fn check_finite(&self, name: &str) -> Result<()> {
        if !self.all.is_finite.load(Relaxed) {
            check_finite(name, self)?;
            self.all.is_finite.store(self.part == (0..self.all.facets.len()), Relaxed);
        }
        Ok(())
    }

    /// What was kept of these facets, where they are placed.
    pub(crate) fn kept(&self, placing: Placing) -> Option<Measures> {
        let kept = self.lock();
        kept.iter().find(|(part, at, _)| (part, *at) == (&self.part, placing)).map(|(_, _, measures)| *measures)
    }

    /// Keeps the measures of these facets, where they are placed.
    pub(super) fn keep(&self, placing: Placing, measures: Measures) {
        let mut kept = self.lock();
        if kept.len() == MAX_KEPT {
            kept.remove(0);
        }
        kept.push((self.part.clone(), placing, measures));
    }

    fn lock(&self) -> MutexGuard<'_, Vec<(Range<usize>, Placing, Measures)>> {
        self.all.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl From<Vec<Facet>> for SharedFacets {
    fn from(facets: Vec<Facet>) -> SharedFacets {
        SharedFacets { part: 0..facets.len(), all: Arc::new(List { facets, ..List::default() }) }
    }
}

impl Deref for SharedFacets {
    type Target = [Facet];

    fn deref(&self) -> &[Facet] {
        &self.all.facets[self.part.clone()]
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
