//! A limit of memory, from the first byte that is read: what several hold of it together, and lists whose room is counted.
//!
//! Room is taken before it is allocated. What does not fit is an error that says what it is for, so that nothing is allocated that a machine
//! or a container does not have. Only what grows with an input is counted: its bytes, corners, facets, and what is built from these. An allocator
//! may keep what was freed: where the system says what the process holds, and that is more than was counted, it counts.

use std::ops::{Deref, DerefMut};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

use crate::base::error::{Error, Result};
use crate::base::parallel::*;

/// Bytes that may be held; clones share them. By default there is no limit.
#[derive(Debug, Clone)]
pub struct Memory(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    max: u64,
    held: AtomicU64,
    /// Bytes that the process holds, if the system says so.
    resident: fn() -> Option<u64>,
}

/// Less than this is taken without asking the system, which costs some 20 microseconds.
const ASKED_BYTES: u64 = 1 << 18;

impl Default for Memory {
    fn default() -> Memory {
        Memory::limited(u64::MAX, 0)
    }
}

impl Memory {
    /// At most so many bytes, of which some are held already.
    pub fn limited(max: u64, held: u64) -> Memory {
        Memory::measured(max, held, || None)
    }

    /// The same where `resident` has the bytes that the process holds: these count where they are more.
    pub fn measured(max: u64, held: u64, resident: fn() -> Option<u64>) -> Memory {
        Memory(Arc::new(Shared { max, held: AtomicU64::new(held), resident }))
    }

    /// Another limit of the same process.
    #[doc(hidden)]
    pub fn again(&self, max: u64, program_bytes: u64) -> Memory {
        // where the program alone is too much, what it does says so better
        let (held, resident): (u64, fn() -> Option<u64>) =
            if program_bytes < max { (program_bytes, self.0.resident) } else { (0, || None) };
        Memory::measured(max, held, resident)
    }

    /// The same where a program takes some whatever it does; where that is too much, what it does says so better.
    pub fn beside_program(max: u64, program_bytes: u64) -> Memory {
        Memory::default().again(max, program_bytes)
    }

    /// Takes room for `what`, which [`Held`] gives back.
    ///
    /// # Errors
    /// `memory` where that is more than is left.
    pub fn take(&self, n_bytes: u64, what: &str) -> Result<Held> {
        let mut held = Held::of(self);
        held.grow(n_bytes, what)?;
        Ok(held)
    }

    /// Takes room for what is held already, of which the system need not be asked.
    ///
    /// # Errors
    /// `memory` where that is more than is left.
    pub fn take_held(&self, n_bytes: u64, what: &str) -> Result<Held> {
        let mut held = Held::of(self);
        held.grow_beside(n_bytes, 0, what)?;
        Ok(held)
    }

    /// Bytes that are left.
    pub fn left(&self) -> u64 {
        self.0.max.saturating_sub(self.0.held.load(Relaxed))
    }

    /// Refuses what is more than is left, and takes nothing.
    ///
    /// # Errors
    /// `memory`.
    pub fn check(&self, n_bytes: u64, what: &str) -> Result<()> {
        self.take(n_bytes, what).map(|_| ())
    }
}

/// Room that was taken; it is given back where this is dropped.
#[derive(Debug, Default)]
pub struct Held {
    memory: Memory,
    n_bytes: u64,
}

impl Held {
    /// None yet, of a limit.
    pub fn of(memory: &Memory) -> Held {
        Held { memory: memory.clone(), n_bytes: 0 }
    }

    /// Takes more room for `what`.
    ///
    /// # Errors
    /// `memory` where that is more than is left.
    pub fn grow(&mut self, n_bytes: u64, what: &str) -> Result<()> {
        self.grow_unwritten(n_bytes, 0, what)
    }

    /// The same where so much of what was taken is not written yet, so that the system does not count it.
    fn grow_unwritten(&mut self, n_bytes: u64, unwritten: u64, what: &str) -> Result<()> {
        let Shared { max, resident, .. } = &*self.memory.0;
        let asks = n_bytes >= ASKED_BYTES && *max < u64::MAX;
        let resident = if asks { resident().map_or(0, |resident| resident.saturating_add(unwritten)) } else { 0 };
        self.grow_beside(n_bytes, resident, what)
    }

    /// The same where the process holds so much.
    fn grow_beside(&mut self, n_bytes: u64, resident: u64, what: &str) -> Result<()> {
        let Shared { max, held, .. } = &*self.memory.0;
        let mut before = held.load(Relaxed);
        loop {
            let after = before.saturating_add(n_bytes);
            if after.max(resident.saturating_add(n_bytes)) > *max {
                return Err(too_little(n_bytes, before.max(resident), *max, what));
            }
            match held.compare_exchange_weak(before, after, Relaxed, Relaxed) {
                Ok(_) => break,
                Err(now) => before = now,
            }
        }
        self.n_bytes += n_bytes;
        Ok(())
    }

    /// Takes more or gives some back, so that it is so much.
    ///
    /// # Errors
    /// `memory` where that is more than is left.
    pub fn set(&mut self, n_bytes: u64, what: &str) -> Result<()> {
        self.set_unwritten(n_bytes, 0, what)
    }

    /// The same where so much of it is not written yet, so that the system does not count it.
    pub(crate) fn set_unwritten(&mut self, n_bytes: u64, unwritten: u64, what: &str) -> Result<()> {
        self.shrink(self.n_bytes.saturating_sub(n_bytes));
        self.grow_unwritten(n_bytes - self.n_bytes, unwritten, what)
    }

    /// Gives some of it back.
    pub fn shrink(&mut self, n_bytes: u64) {
        let n_bytes = n_bytes.min(self.n_bytes);
        self.n_bytes -= n_bytes;
        self.memory.0.held.fetch_sub(n_bytes, Relaxed);
    }

    /// Bytes that it has.
    pub(crate) fn n_bytes(&self) -> u64 {
        self.n_bytes
    }

    /// Leaves it taken as long as there is the limit.
    pub fn keep(mut self) {
        self.n_bytes = 0;
    }

    /// The limit that it counts against.
    pub fn memory(&self) -> &Memory {
        &self.memory
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        self.shrink(self.n_bytes);
    }
}

fn too_little(n_bytes: u64, held: u64, max: u64, what: &str) -> Error {
    let [needed, held, max] = [n_bytes, held, max].map(|bytes| format!("{:.2} MB", bytes as f64 / 1e6));
    let message = format!("{what} take {needed} of memory; {held} are held already, and {max} are allowed");
    Error::new("memory", message, "allow more with max_memory (--max-memory), or simplify the model")
}

/// A list whose room is counted before it is allocated.
#[derive(Debug)]
pub(crate) struct List<T> {
    items: Vec<T>,
    held: Held,
    /// What an error calls its items.
    what: &'static str,
}

impl<T> List<T> {
    pub(crate) fn new(memory: &Memory, what: &'static str) -> List<T> {
        List { items: Vec::new(), held: Held::of(memory), what }
    }

    /// Makes room for exactly so many more.
    pub(crate) fn reserve(&mut self, n_more: usize) -> Result<()> {
        let n = self.items.len().saturating_add(n_more);
        if n <= self.items.capacity() {
            return Ok(());
        }
        let (old, new) = (bytes_of::<T>(self.items.capacity()), bytes_of::<T>(n));
        // the old room is there until all is moved to the new one
        self.held.grow(new, self.what)?;
        self.items.try_reserve_exact(n_more).map_err(|_| too_little(new, old, u64::MAX, self.what))?;
        self.held.shrink(old);
        Ok(())
    }

    /// Adds an item.
    #[inline]
    pub(crate) fn push(&mut self, item: T) -> Result<()> {
        if self.items.len() == self.items.capacity() {
            self.reserve(self.items.len().max(16))?;
        }
        self.items.push(item);
        Ok(())
    }

    /// Removes the last item if it is as it should be.
    pub(crate) fn pop_if(&mut self, is_so: impl FnOnce(&T) -> bool) -> Option<T> {
        self.items.pop_if(|item| is_so(item))
    }

    pub(crate) fn clear(&mut self) {
        self.items.clear();
    }

    /// The items; their room stays taken.
    pub(crate) fn keep(self) -> Vec<T> {
        self.held.keep();
        self.items
    }
}

impl<T: Copy> List<T> {
    /// Adds items.
    pub(crate) fn extend(&mut self, items: &[T]) -> Result<()> {
        if self.items.len() + items.len() > self.items.capacity() {
            self.reserve(self.items.len().max(items.len()))?;
        }
        self.items.extend_from_slice(items);
        Ok(())
    }
}

impl<T: Send> List<T> {
    /// Adds items that all cores make, whose number is known.
    pub(crate) fn par_extend(&mut self, items: impl IndexedParallelIterator<Item = T>) -> Result<()> {
        let n = self.items.len() + items.len();
        if n > self.items.capacity() {
            self.reserve(self.items.len().max(items.len()))?;
        }
        self.items.par_extend(items);
        Ok(())
    }
}

fn bytes_of<T>(n: usize) -> u64 {
    (n as u64).saturating_mul(size_of::<T>() as u64)
}

impl<T> Deref for List<T> {
    type Target = [T];

    fn deref(&self) -> &[T] {
        &self.items
    }
}

impl<T> DerefMut for List<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.items
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn room_is_shared_and_comes_back() {
        let memory = Memory::limited(100, 10);
        let mut one = memory.take(50, "facets").unwrap();
        let error = memory.clone().take(41, "facets").unwrap_err();
        assert_eq!(error.code(), "memory");
        let memory_of_mb = Memory::limited(300_000_000, 12_000_000);
        let said = memory_of_mb.check(720_000_000, "20000000 facets").unwrap_err().to_string();
        assert_eq!(
            said,
            "20000000 facets take 720.00 MB of memory; 12.00 MB are held already, and 300.00 MB are allowed"
        );
        one.shrink(20);
        memory.take(60, "facets").unwrap();
        one.grow(60, "facets").unwrap();
        drop(one);
        memory.take(90, "facets").unwrap().keep();
        assert!(memory.check(1, "facets").is_err());
    }

    #[test]
    fn what_the_process_holds_counts_where_that_is_more() {
        let memory = Memory::measured(10_000_000, 1_000_000, || Some(8_000_000));
        let said = memory.check(3_000_000, "edges").unwrap_err().to_string();
        assert!(said.starts_with("edges take 3.00 MB of memory; 8.00 MB are held already"), "{said}");
        memory.take_held(5_000_000, "facets").unwrap();
        let mut held = memory.take(2_000_000, "edges").unwrap();
        held.grow(6_000_000, "edges").unwrap_err();
        // a little is counted, and the system is not asked
        (0..80).for_each(|_| held.grow(100_000, "edges").unwrap_or_default());
        assert!(memory.again(10_000_000, 0).check(3_000_000, "edges").is_err());
        assert!(memory.again(u64::MAX, 0).check(1 << 50, "edges").is_ok());
    }

    #[test]
    fn a_list_counts_the_old_room_and_the_new_while_it_grows() {
        let memory = Memory::limited(1000, 0);
        let mut list = List::new(&memory, "numbers");
        let n = (0u64..1000).take_while(|number| list.push(*number).is_ok()).count();
        // 16, 32 and 64 numbers fit; 64 beside 128 are 1536 bytes
        assert_eq!((n, list.len()), (64, 64));
        assert!(memory.check(1000 - 512, "more").is_ok() && memory.check(1000 - 511, "more").is_err());
        drop(list);
        assert!(memory.check(1000, "more").is_ok());
    }
}
