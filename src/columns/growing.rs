//! Columns in the making: bands come in order, stay in memory as long as they fit, and go to a store when they do not.
//!
//! Bands -> [`Columns`]. A limit on the bytes held; a [`Store`], if there is one. Once the parts outgrow the limit all of
//! them move to the store, and so does every later one. A store that *keeps* gets every band at once, whether or not
//! they fit in memory, so that an interrupted mesh can go on from it.

use std::sync::Arc;

use super::spill::{KEPT_HEAD, RECORD_HEAD, kept_head};
use super::{Band, Columns, Content, Part, Record, Spill, Store, cells_of};
use crate::error::{Error, Result};
use crate::parallel::*;
use crate::rays::Rays;

/// Columns of the first rays of a box.
pub struct Growing {
    rays: Rays,
    max_bytes: u64,
    spill: Option<Arc<Spill>>,
    /// Whether the store gets every band.
    keeps: bool,
    /// All parts, or none once they are only in the store.
    held: Vec<Part>,
    held_bytes: u64,
    /// The pieces in the store: none, or those of all rays.
    records: Vec<Record>,
    is_spilled: bool,
    n_rays: u64,
    odd_rays: u64,
    n_crossings: u64,
    cells: Box<[u64; 256]>,
    /// Most bytes held at once, the band that came last included.
    pub peak_bytes: u64,
}

impl Growing {
    /// Holds at most `max_bytes` of columns, and beyond that puts them in the store; without one they end in an error.
    pub fn new(rays: Rays, max_bytes: u64, store: Option<Arc<dyn Store>>) -> Growing {
        Growing {
            rays,
            max_bytes,
            spill: store.map(|store| Arc::new(Spill::new(store, rays.depth, max_bytes))),
            keeps: false,
            held: Vec::new(),
            held_bytes: 0,
            records: Vec::new(),
            is_spilled: false,
            n_rays: 0,
            odd_rays: 0,
            n_crossings: 0,
            cells: Box::new([0; 256]),
            peak_bytes: 0,
        }
    }

    /// Goes on from a store that keeps every band, begun by an earlier run or empty: takes all bands that it holds whole,
    /// up to the end of a row of rays, drops what follows and puts all later bands there. `identity` stands for what is
    /// meshed.
    ///
    /// # Errors
    /// `job-conflict` where the store was begun for something else; `memory`, as for [`Growing::push`]; `io` where the
    /// store fails.
    pub fn keeping(rays: Rays, max_bytes: u64, store: Arc<dyn Store>, identity: &[u8; 32]) -> Result<Growing> {
        let mut growing = Growing { keeps: true, ..Growing::new(rays, max_bytes, Some(store.clone())) };
        let failed = |error| Error::io("going on from columns that were kept", error);
        let expected = kept_head(identity);
        let mut head = [0; KEPT_HEAD];
        if store.read(0, &mut head).is_ok() {
            if head != *expected {
                let message = "the columns that were kept are those of another job, file or version, or no columns";
                return Err(Error::new("job-conflict", message, "delete the file, or repeat the job that began it"));
            }
            let end = growing.take_kept(KEPT_HEAD as u64)?;
            store.truncate(end).map_err(failed)?;
        } else {
            let begun = begun(&*store);
            if !expected.starts_with(&begun) {
                let message =
                    format!("{} bytes are where columns should be kept, and no beginning of them", begun.len());
                return Err(Error::new("job-conflict", message, "move the file away, or name another output"));
            }
            // not even the head was finished
            store.truncate(0).map_err(failed)?;
            store.append(&expected).map_err(failed)?;
        }
        Ok(growing)
    }

    /// Takes the parts of the store that are closed and whole; returns their end.
    fn take_kept(&mut self, mut at: u64) -> Result<u64> {
        let Some(spill) = self.spill.clone() else { return Ok(at) };
        let (mut records, mut end) = (Vec::new(), at);
        let mut next_ray = 0;
        let mut head = [0; RECORD_HEAD];
        // whatever cannot be read, or does not fit, ends what was kept
        while spill.store.read(at, &mut head).is_ok()
            && let Some(record) = Record::from_head(at, &head)
            && record.first_ray == next_ray
            && record.end_ray() <= self.rays.n_rays()
            && let Ok(part) = spill.read(&record)
        {
            at += record.n_stored();
            next_ray = record.end_ray();
            records.push((part, record));
            let Some(counts) = record.closes else { continue };
            if next_ray.is_multiple_of(u64::from(self.rays.counts[0])) {
                end = at;
                let (parts, closed): (Vec<Part>, Vec<Record>) = records.drain(..).unzip();
                self.take(parts, closed, counts)?;
            }
        }
        Ok(end)
    }

    /// Takes parts that are in the store already.
    fn take(&mut self, parts: Vec<Part>, records: Vec<Record>, counts: [u64; 2]) -> Result<()> {
        self.records.extend(records);
        self.add(parts, counts)
    }

    /// Number of rays taken so far: the next band begins with the ray of this index.
    pub fn n_rays(&self) -> u64 {
        self.n_rays
    }

    /// Takes the bands that follow.
    ///
    /// # Errors
    /// `memory` where no more fit and there is no store; `io` where the store fails.
    ///
    /// # Panics
    /// If they do not follow: a bug of the caller.
    pub fn push(&mut self, bands: Vec<Band>) -> Result<()> {
        let band_bytes: u64 = bands.iter().map(|band| 4 * (band.ends.len() + band.runs.len()) as u64).sum();
        self.peak_bytes = self.peak_bytes.max(self.held_bytes + band_bytes);
        let pack = |band: Band| {
            let counts = [band.odd_rays, band.n_crossings];
            (Part::new(band), counts)
        };
        let parts: Vec<(Part, [u64; 2])> = bands.into_par_iter().map(pack).collect();
        let first = parts.first().map_or(self.n_rays, |(part, _)| part.first_ray);
        assert_eq!(first, self.n_rays, "bands must follow each other");
        if let Some(spill) = self.spill.as_ref().filter(|_| self.keeps || self.is_spilled) {
            self.records.extend(spill.append(&parts)?);
        }
        let counts = parts.iter().fold([0; 2], |sum, (_, counts)| [sum[0] + counts[0], sum[1] + counts[1]]);
        self.add(parts.into_iter().map(|(part, _)| part).collect(), counts)
    }

    /// Counts parts and holds them, unless they are spilled or become so.
    fn add(&mut self, parts: Vec<Part>, [odd_rays, n_crossings]: [u64; 2]) -> Result<()> {
        self.n_rays += parts.iter().map(Part::n_rays).sum::<u64>();
        self.odd_rays += odd_rays;
        self.n_crossings += n_crossings;
        if self.is_spilled {
            self.count_cells(&parts);
            return Ok(());
        }
        self.held_bytes += parts.iter().map(Part::n_bytes).sum::<u64>();
        self.held.extend(parts);
        self.peak_bytes = self.peak_bytes.max(self.held_bytes);
        if self.held_bytes > self.max_bytes { self.move_to_store() } else { Ok(()) }
    }

    /// Frees the parts, after writing those that are not in the store yet.
    fn move_to_store(&mut self) -> Result<()> {
        let Some(spill) = self.spill.clone() else {
            let message = format!(
                "the columns of {} of {} rays take {} bytes already, and {} are left for them",
                self.n_rays,
                self.rays.n_rays(),
                self.held_bytes,
                self.max_bytes
            );
            return Err(Error::new("memory", message, crate::error::MORE_MEMORY));
        };
        let held = std::mem::take(&mut self.held);
        self.count_cells(&held);
        if !self.keeps {
            let parts: Vec<(Part, [u64; 2])> = held.into_iter().map(|part| (part, [0; 2])).collect();
            self.records.extend(spill.append(&parts)?);
        }
        self.held_bytes = 0;
        self.is_spilled = true;
        Ok(())
    }

    fn count_cells(&mut self, parts: &[Part]) {
        let more = cells_of(parts, self.rays.depth);
        self.cells.iter_mut().zip(more).for_each(|(cells, more)| *cells += more);
    }

    /// The columns of all rays.
    ///
    /// # Panics
    /// If rays are missing: a bug of the caller.
    pub fn finish(self) -> Columns {
        assert_eq!(self.n_rays, self.rays.n_rays(), "bands must cover all rays");
        let Growing { rays, held, records, cells, odd_rays, n_crossings, .. } = self;
        let content = match self.spill.filter(|_| self.is_spilled) {
            Some(spill) => Content::Spilled { spill, records, cells },
            None => Content::Held(Arc::new(held)),
        };
        Columns { rays, content, odd_rays, n_crossings }
    }
}

/// The bytes of a store that is shorter than a head.
fn begun(store: &dyn Store) -> Vec<u8> {
    let mut head = [0; KEPT_HEAD];
    let n_bytes = (1..KEPT_HEAD).rev().find(|&n| store.read(0, &mut head[..n]).is_ok());
    head[..n_bytes.unwrap_or(0)].to_vec()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::columns::run;
    use crate::columns::spill::tests::Memory;
    use crate::flags::flags_of_box;

    /// Bands of some rows of a box of 5 x 7 rays with up to 4 runs each.
    fn bands(rays: &Rays, rows: u32) -> Vec<Band> {
        let starts = (0..rays.counts[1]).step_by(rows as usize);
        starts
            .map(|start| {
                let first_ray = u64::from(start * rays.counts[0]);
                let mut band = Band { first_ray, odd_rays: 1, n_crossings: 3, ..Band::default() };
                for ray in start * rays.counts[0]..(start + rows).min(rays.counts[1]) * rays.counts[0] {
                    band.runs.extend((0..ray % 5).map(|k| run(ray % 3 + 2 * k, 1 + (k % 2) as u8)));
                    band.ends.push(band.runs.len() as u32);
                }
                band
            })
            .collect()
    }

    fn grown(mut growing: Growing, bands: Vec<Band>) -> Columns {
        bands.into_iter().for_each(|band| growing.push(vec![band]).unwrap());
        growing.finish()
    }

    #[test]
    fn columns_in_a_store_answer_as_those_in_memory() {
        for axis in 0..3 {
            let mut dims = [5, 5, 7];
            dims[axis] = 12;
            let rays = Rays::new(axis, dims);
            let held = Columns::new(rays, bands(&rays, 2));
            // from the first band on, in the middle, never
            for max_bytes in [0, 150, u64::MAX] {
                let store = Arc::new(Memory::default());
                let columns = grown(Growing::new(rays, max_bytes, Some(store)), bands(&rays, 2));
                assert_eq!(columns.is_spilled(), max_bytes < u64::MAX);
                assert_eq!(columns, held);
                assert_eq!(columns.cells_per_flag(), held.cells_per_flag());
                let counts = |columns: &Columns| [columns.n_runs(), columns.n_crossings(), columns.odd_rays()];
                assert_eq!(counts(&columns), counts(&held));
                for cells in [dims.map(|n| 0..n), dims.map(|n| 1..n - 1)] {
                    let flags = flags_of_box(&held, &cells).unwrap();
                    assert_eq!(flags_of_box(&columns, &cells).unwrap(), flags);
                }
                assert_eq!(columns.flag([3, 4, 2]), held.flag([3, 4, 2]));
            }
        }
    }

    #[test]
    fn without_a_store_the_limit_is_an_error_with_numbers() {
        let rays = Rays::new(0, [12, 5, 7]);
        let mut growing = Growing::new(rays, 100, None);
        let error = bands(&rays, 1).into_iter().find_map(|band| growing.push(vec![band]).err()).unwrap();
        assert!(error.code() == "memory" && error.to_string().contains("and 100 are left"), "{error}");
    }

    #[test]
    fn a_store_that_was_cut_short_is_taken_up_at_the_last_whole_row() {
        let rays = Rays::new(0, [12, 5, 7]);
        let whole = Columns::new(rays, bands(&rays, 2));
        let store = Arc::new(Memory::default());
        let keep = |store: &Arc<Memory>, max_bytes| Growing::keeping(rays, max_bytes, store.clone(), &[7; 32]).unwrap();
        assert_eq!(grown(keep(&store, u64::MAX), bands(&rays, 2)), whole);
        let bytes = store.0.lock().unwrap().clone();
        for max_bytes in [0, u64::MAX] {
            let mut taken = std::collections::BTreeSet::new();
            for length in 0..=bytes.len() {
                let store = Arc::new(Memory::default());
                store.0.lock().unwrap().extend(&bytes[..length]);
                let growing = keep(&store, max_bytes);
                let n_rays = growing.n_rays();
                assert!(n_rays <= rays.n_rays());
                taken.insert(n_rays);
                let rest = bands(&rays, 2).into_iter().filter(|band| band.first_ray >= n_rays).collect();
                let columns = grown(growing, rest);
                assert_eq!(columns, whole, "{length} bytes");
                assert_eq!([columns.odd_rays(), columns.n_crossings()], [4, 12], "{length} bytes");
                assert_eq!(*store.0.lock().unwrap(), bytes, "{length} bytes");
            }
            assert_eq!(taken.into_iter().collect::<Vec<_>>(), [0, 10, 20, 30, 35]);
        }
    }

    #[test]
    fn a_store_of_something_else_is_refused_and_left_alone() {
        let rays = Rays::new(0, [12, 5, 7]);
        let store = Arc::new(Memory::default());
        grown(Growing::keeping(rays, 0, store.clone(), &[7; 32]).unwrap(), bands(&rays, 2));
        let before = store.0.lock().unwrap().clone();
        let error = Growing::keeping(rays, 0, store.clone(), &[8; 32]).err().unwrap();
        assert!(error.code() == "job-conflict" && error.hint().contains("delete"), "{error}");
        assert_eq!(*store.0.lock().unwrap(), before);
        // a file that happens to have the name, shorter than a head
        store.0.lock().unwrap().truncate(20);
        for foreign in [&before[..20], b"notes", &[0]] {
            *store.0.lock().unwrap() = foreign.to_vec();
            let error = Growing::keeping(rays, 0, store.clone(), &[8; 32]).err().unwrap();
            assert_eq!((error.code(), &store.0.lock().unwrap()[..]), ("job-conflict", foreign));
        }
    }

    #[test]
    fn what_the_store_gives_back_is_checked() {
        let rays = Rays::new(0, [12, 5, 7]);
        let store = Arc::new(Memory::default());
        let columns = grown(Growing::new(rays, 0, Some(store.clone())), bands(&rays, 7));
        store.0.lock().unwrap()[RECORD_HEAD] ^= 1;
        let error = columns.ray(0).unwrap_err();
        assert!(error.code() == "io" && error.to_string().contains("damaged at byte 0"), "{error}");
        store.0.lock().unwrap().clear();
        assert_eq!(columns.for_rays(0..1, |_| ()).unwrap_err().code(), "io");
        assert_ne!(columns, columns.clone());
    }
}
