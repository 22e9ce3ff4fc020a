//! Facets that are shared and not copied: a range of a list.
//!
//! A file is read into one list; its solids, and the geometries of jobs, are ranges of it. A clone shares the list, so that an
//! estimate at every keystroke needs no second copy of a large model. Where memory is small for it, a list stays in its file, which is read again
//! whenever its facets are looked at: some at a time, by [`SharedFacets::chunks`].

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

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

/// What is known of placed facets.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Measures {
    /// Least and greatest world coordinates; None without facets.
    pub(crate) ends: Option<[[f64; 3]; 2]>,
    /// The volume by the divergence theorem, relative to the centre of the box, with the sign of its facets in the file.
    pub(crate) signed_volume: f64,
}

/// Measures that are kept with a list, at most: those of the parts of a job.
const MAX_KEPT: usize = 256;

/// Facets that stay in their file.
pub(crate) trait InFile: Send + Sync {
    fn n_facets(&self) -> usize;

    /// Reads some, from a multiple of [`READ_AT_ONCE`], up to another or the end.
    ///
    /// # Errors
    /// `io` where the file cannot be read, or has changed.
    fn read(&self, first: usize, facets: &mut [Facet]) -> Result<()>;
}

/// Facets in a file that are read and checked together.
pub(crate) const READ_AT_ONCE: usize = 1 << 13;

/// Where a list is.
enum Place {
    Memory(Vec<Facet>),
    File(Box<dyn InFile>),
}

/// Facets, and what was found out about them.
struct List {
    facets: Place,
    /// Whether all their coordinates are known to be finite.
    is_finite: AtomicBool,
    /// Their least and greatest coordinates, where these are known.
    ends: OnceLock<[[f32; 3]; 2]>,
    /// Measures of parts, each where it is placed.
    kept: Mutex<Vec<(Range<usize>, Placing, Measures)>>,
}

impl List {
    fn new(facets: Place) -> Arc<List> {
        Arc::new(List { facets, is_finite: AtomicBool::default(), ends: OnceLock::default(), kept: Mutex::default() })
    }

    fn len(&self) -> usize {
        match &self.facets {
            Place::Memory(facets) => facets.len(),
            Place::File(file) => file.n_facets(),
        }
    }
}

/// A range of a shared list of facets.
#[derive(Clone)]
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
        let all = List::new(Place::Memory(all));
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
        // a list in a file is one part
        parts.iter().flat_map(|part| part.held().unwrap_or_default()).copied().collect::<Vec<Facet>>().into()
    }

    /// Those that stay in their file, of which the ends are known, and that all coordinates are finite.
    pub(crate) fn in_file(file: Box<dyn InFile>, ends: [[f32; 3]; 2]) -> SharedFacets {
        let part = 0..file.n_facets();
        SharedFacets { all: List::new(Place::File(file)), part }.known_finite().with_ends(ends)
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.part.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.part.is_empty()
    }

    /// Whether they stay in their file.
    #[doc(hidden)]
    pub fn stay_in_file(&self) -> bool {
        self.held().is_none()
    }

    /// Bytes of memory that they take; 0 where they stay in their file.
    pub fn n_bytes(&self) -> u64 {
        self.held().map_or(0, |facets| size_of_val(facets) as u64)
    }

    /// Bytes of memory that the largest of their chunks takes while it is looked at; 0 where they are in memory.
    pub fn chunk_bytes(&self) -> u64 {
        self.held().map_or((size_of::<Facet>() * self.most_at_once()) as u64, |_| 0)
    }

    /// Facets of a file that are in memory at a time, at most: a sixteenth of them, about, so that many cores have work, and memory suffices.
    fn most_at_once(&self) -> usize {
        (self.len() / 16).next_power_of_two().clamp(1 << 17, 1 << 20)
    }

    fn held(&self) -> Option<&[Facet]> {
        match &self.all.facets {
            Place::Memory(facets) => Some(&facets[self.part.clone()]),
            Place::File(_) => None,
        }
    }

    /// All of them, which `what_for` needs at once.
    ///
    /// # Errors
    /// `memory` where they stay in their file.
    pub fn in_memory(&self, what_for: &str) -> Result<&[Facet]> {
        self.held().ok_or_else(|| {
            let (n, megabytes) = (self.len(), size_of::<Facet>() as f64 * self.len() as f64 / 1e6);
            let message = format!(
                "{n} facets would take {megabytes:.2} MB of memory, more than half of what was left, and stay in their file; {what_for} \
                 needs all at once"
            );
            Error::new("memory", message, "allow more with max_memory (--max-memory), or leave that out")
        })
    }

    /// Calls `each` with all facets, one after the other.
    ///
    /// # Errors
    /// `io` where they stay in their file, and that cannot be read again.
    pub fn for_each(&self, mut each: impl FnMut(&Facet)) -> Result<()> {
        let mut chunks = self.chunks(1 << 17);
        while let Some(some) = chunks.next_some()? {
            some.iter().for_each(&mut each);
        }
        Ok(())
    }

    /// Those with the given indices, which ascend.
    ///
    /// # Errors
    /// `io` where they stay in their file, and that cannot be read again.
    #[doc(hidden)]
    pub fn some(&self, indices: &[u32]) -> Result<Vec<Facet>> {
        let (mut some, mut first) = (Vec::with_capacity(indices.len()), 0);
        let mut chunks = self.chunks(1 << 17);
        while some.len() < indices.len()
            && let Some(facets) = chunks.next_some()?
        {
            let here = indices[some.len()..].iter().map_while(|&index| facets.get(index as usize - first));
            some.extend(here.copied().collect::<Vec<Facet>>());
            first += facets.len();
        }
        Ok(some)
    }

    #[cfg(any(test, feature = "testing"))]
    pub fn slice(&self) -> &[Facet] {
        self.in_memory("a test").unwrap()
    }

    /// The facets in chunks of so many, which are a multiple of 8192, or fewer.
    pub fn chunks(&self, n_at_once: usize) -> Chunks<'_> {
        debug_assert!(n_at_once.is_multiple_of(READ_AT_ONCE));
        let n_at_once = self.held().map_or(n_at_once.min(self.most_at_once()), |_| n_at_once);
        Chunks { facets: self, next: 0, n_at_once, read: Vec::new() }
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

    /// The same facets, with the least and the greatest coordinates of all of their list, which the caller found.
    pub(crate) fn with_ends(self, ends: [[f32; 3]; 2]) -> SharedFacets {
        self.all.ends.get_or_init(|| ends);
        self
    }

    /// Least and greatest coordinates, if these are known.
    pub(super) fn ends(&self) -> Option<[[f32; 3]; 2]> {
        self.all.ends.get().copied().filter(|_| self.is_all())
    }

    fn is_all(&self) -> bool {
        self.part == (0..self.all.len())
    }

    /// Returns an error if a coordinate is NaN or infinite, unless that was found out before; `name` is that of the surface.
    ///
    /// # Errors
    /// `stl-not-finite`, with the first such facet.
    pub(crate) fn check_finite(&self, name: &str) -> Result<()> {
        if !self.all.is_finite.load(Relaxed) {
            check_finite(name, self.held().unwrap_or_default())?;
            self.all.is_finite.store(self.is_all(), Relaxed);
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

/// Facets, some at a time.
pub struct Chunks<'a> {
    facets: &'a SharedFacets,
    next: usize,
    n_at_once: usize,
    /// Those that were read again.
    read: Vec<Facet>,
}

impl Chunks<'_> {
    /// The next ones; None at the end.
    ///
    /// # Errors
    /// `io` where their file cannot be read again, or has changed.
    pub fn next_some(&mut self) -> Result<Option<&[Facet]>> {
        let first = self.next;
        self.next = self.facets.len().min(first + self.n_at_once);
        if first == self.next {
            return Ok(None);
        }
        match &self.facets.all.facets {
            Place::Memory(facets) => Ok(Some(&facets[self.facets.part.clone()][first..self.next])),
            Place::File(file) => {
                self.read.resize(self.next - first, Facet::default());
                file.read(first, &mut self.read)?;
                Ok(Some(&self.read))
            }
        }
    }
}

impl From<Vec<Facet>> for SharedFacets {
    fn from(facets: Vec<Facet>) -> SharedFacets {
        SharedFacets { part: 0..facets.len(), all: List::new(Place::Memory(facets)) }
    }
}

impl Default for SharedFacets {
    fn default() -> SharedFacets {
        Vec::new().into()
    }
}

impl PartialEq for SharedFacets {
    /// Two are equal if their facets are, shared or not; those that stay in a file if they are the same.
    fn eq(&self, other: &SharedFacets) -> bool {
        self.is_same(other) || self.held().zip(other.held()).is_some_and(|(one, other)| one == other)
    }
}

impl std::fmt::Debug for SharedFacets {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.held() {
            Some(facets) => facets.fmt(formatter),
            None => write!(formatter, "{} facets in their file", self.len()),
        }
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
        assert_eq!((whole.slice(), whole.slice().as_ptr()), (&all[..], parts[0].slice().as_ptr()));
        let turned = SharedFacets::join(&[parts[2].clone(), parts[0].clone()]);
        assert_eq!(turned.slice(), [2.0, 3.0, 4.0, 0.0, 1.0].map(facet));
        assert_ne!(turned, whole);
        assert!(SharedFacets::join(&[]).is_empty());
    }
}
