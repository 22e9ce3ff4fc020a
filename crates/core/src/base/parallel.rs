//! Loops over all cores: rayon's where there are threads; in wasm without shared memory, which has one, the same calls as plain iterators, so
//! that the page does not load a scheduler that it cannot use.

#[cfg(any(not(target_arch = "wasm32"), target_feature = "atomics"))]
pub use several::*;
#[cfg(not(any(not(target_arch = "wasm32"), target_feature = "atomics")))]
pub use single::*;

/// The same for what is bound to its thread in wasm, as objects of JavaScript are.
#[cfg(not(target_arch = "wasm32"))]
pub use several as bound;
#[cfg(target_arch = "wasm32")]
pub use single as bound;

/// Whether there can be more threads than one. Where not, work is done in small rounds, between which the caller rests.
pub const HAS_THREADS: bool = cfg!(any(not(target_arch = "wasm32"), target_feature = "atomics"));

#[cfg(not(target_arch = "wasm32"))]
pub use rayon::current_num_threads;

/// Does work on all cores that shares nothing but memory: natively as it is, as rayon's threads are there. In wasm with shared memory the
/// threads are those of [`start_pool`], and what is not done here stays on the thread that calls, which alone has objects of JavaScript.
#[cfg(not(all(target_arch = "wasm32", target_feature = "atomics")))]
pub fn on_all_cores<T>(act: impl FnOnce() -> T) -> T {
    act()
}

#[cfg(all(target_arch = "wasm32", target_feature = "atomics"))]
pub use pool::*;

/// Threads of wasm with shared memory.
#[cfg(all(target_arch = "wasm32", target_feature = "atomics"))]
mod pool {
    use std::sync::OnceLock;

    use rayon::{ThreadBuilder, ThreadPool, ThreadPoolBuilder};

    static POOL: OnceLock<ThreadPool> = OnceLock::new();

    /// Does work on the threads of the pool, or on this one where there is none.
    pub fn on_all_cores<T: Send>(act: impl FnOnce() -> T + Send) -> T {
        match POOL.get() {
            Some(pool) => pool.install(act),
            None => act(),
        }
    }

    pub fn current_num_threads() -> usize {
        POOL.get().map_or(1, ThreadPool::current_num_threads)
    }

    /// Starts a pool of so many threads, which `spawn` runs; false where it cannot, or there is one.
    pub fn start_pool(n_threads: usize, mut spawn: impl FnMut(ThreadBuilder)) -> bool {
        let handler = |thread| {
            spawn(thread);
            Ok(())
        };
        let pool = ThreadPoolBuilder::new().num_threads(n_threads).spawn_handler(handler).build();
        pool.is_ok_and(|pool| POOL.set(pool).is_ok())
    }
}

/// On threads.
#[cfg(any(not(target_arch = "wasm32"), target_feature = "atomics"))]
pub mod several {
    use std::ops::Range;

    pub use rayon::prelude::*;

    /// Runs `other` on another core, if there is one, while this thread runs `here`; returns what `here` does.
    pub fn beside<T>(other: impl FnOnce() + Send, here: impl FnOnce() -> T) -> T {
        rayon::in_place_scope(|scope| {
            scope.spawn(|_| other());
            here()
        })
    }

    /// What becomes of numbers, in their order, on all cores; a core works in memory that it uses again.
    pub fn map_within<S: Default, T: Send>(numbers: Range<u32>, of: impl Fn(&mut S, u32) -> T + Sync + Send) -> Vec<T> {
        numbers.into_par_iter().map_init(S::default, of).collect()
    }

    /// Appends what becomes of items, in their order, on all cores.
    pub fn extend_with<A: Sync, T: Send>(all: &mut Vec<T>, items: &[A], of: impl Fn(&A) -> T + Sync + Send) {
        all.par_extend(items.par_iter().map(of));
    }
}

/// The names of rayon on one thread: in wasm also what has objects of JavaScript, which do not leave their thread.
#[cfg(target_arch = "wasm32")]
pub mod single {
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
