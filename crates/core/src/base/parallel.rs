//! Loops over all cores: rayon's where there are threads; in wasm, which has one, the same calls as plain iterators, so
//! that the page does not load a scheduler that it cannot use.

#[cfg(not(target_arch = "wasm32"))]
use std::ops::Range;

#[cfg(not(target_arch = "wasm32"))]
pub use rayon::{current_num_threads, prelude::*};
#[cfg(target_arch = "wasm32")]
pub use single::*;

/// Runs `other` on another core, if there is one, while this thread runs `here`; returns what `here` does.
#[cfg(not(target_arch = "wasm32"))]
pub fn beside<T>(other: impl FnOnce() + Send, here: impl FnOnce() -> T) -> T {
    rayon::in_place_scope(|scope| {
        scope.spawn(|_| other());
        here()
    })
}

/// What becomes of numbers, in their order, on all cores; a core works in memory that it uses again.
#[cfg(not(target_arch = "wasm32"))]
pub fn map_within<S: Default, T: Send>(numbers: Range<u32>, of: impl Fn(&mut S, u32) -> T + Sync + Send) -> Vec<T> {
    numbers.into_par_iter().map_init(S::default, of).collect()
}

/// Appends what becomes of items, in their order, on all cores.
#[cfg(not(target_arch = "wasm32"))]
pub fn extend_with<A: Sync, T: Send>(all: &mut Vec<T>, items: &[A], of: impl Fn(&A) -> T + Sync + Send) {
    all.par_extend(items.par_iter().map(of));
}

/// The names of rayon on one thread.
#[cfg(target_arch = "wasm32")]
mod single {
    /// An iterator whose number of items is known.
    pub use std::iter::ExactSizeIterator as IndexedParallelIterator;
    use std::ops::Range;
    use std::slice::{Chunks, ChunksMut, Iter, IterMut};

    pub fn current_num_threads() -> usize {
        1
    }

    pub fn map_within<S: Default, T>(numbers: Range<u32>, of: impl Fn(&mut S, u32) -> T) -> Vec<T> {
        let mut memory = S::default();
        numbers.map(|number| of(&mut memory, number)).collect()
    }

    pub fn extend_with<A, T>(all: &mut Vec<T>, items: &[A], of: impl Fn(&A) -> T) {
        all.extend(items.iter().map(of));
    }

    pub fn beside<T>(other: impl FnOnce(), here: impl FnOnce() -> T) -> T {
        other();
        here()
    }

    pub trait IntoParallelIterator: IntoIterator + Sized {
        fn into_par_iter(self) -> Self::IntoIter {
            self.into_iter()
        }
    }

    impl<I: IntoIterator> IntoParallelIterator for I {}

    pub trait ParallelSlice<T> {
        fn par_iter(&self) -> Iter<'_, T>;
        fn par_iter_mut(&mut self) -> IterMut<'_, T>;
        fn par_chunks(&self, size: usize) -> Chunks<'_, T>;
        fn par_chunks_mut(&mut self, size: usize) -> ChunksMut<'_, T>;
        fn par_sort_unstable(&mut self)
        where
            T: Ord;
    }

    impl<T> ParallelSlice<T> for [T] {
        fn par_iter(&self) -> Iter<'_, T> {
            self.iter()
        }

        fn par_iter_mut(&mut self) -> IterMut<'_, T> {
            self.iter_mut()
        }

        fn par_chunks(&self, size: usize) -> Chunks<'_, T> {
            self.chunks(size)
        }

        fn par_chunks_mut(&mut self, size: usize) -> ChunksMut<'_, T> {
            self.chunks_mut(size)
        }

        fn par_sort_unstable(&mut self)
        where
            T: Ord,
        {
            self.sort_unstable();
        }
    }

    pub trait ParallelExtend<T>: Extend<T> {
        fn par_extend(&mut self, items: impl IntoIterator<Item = T>) {
            self.extend(items);
        }
    }

    impl<T> ParallelExtend<T> for Vec<T> {}
}
