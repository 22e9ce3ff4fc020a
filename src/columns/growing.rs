//! Columns in the making: bands come in order, stay in memory as long as they fit, and go to a store when they do not.
//!
//! Bands -> [`Columns`]. A limit on the bytes held; a [`Store`], if there is one, for a column file. Once the parts outgrow the
//! limit all of them move to the store, and so does every later one. A store that *keeps* gets every band at once, whether or
//! not they fit in memory, so that an interrupted mesh can go on from it.

use std::sync::Arc;

use super::file::end::{self, Totals};
use super::file::head::VERSION;
use super::part::Part;
use super::run::Band;
use super::store::Store;
use super::stored::Record;
use super::target::{Target, begun};
use super::{Columns, Content, cells_of};
use crate::error::{Error, Result};
use crate::parallel::*;
use crate::rays::Rays;

/// Columns of the first rays of a box.
pub struct Growing {
    rays: Rays,
    max_bytes: u64,
    target: Option<Target>,
    /// All parts, or none once they are only in the store.
    held: Vec<Part>,
    held_bytes: u64,
    is_spilled: bool,
    n_rays: u64,
    /// Of all rays; the cells only of parts that are no longer held.
    totals: Totals,
    /// Most bytes held at once, the band that came last included.
    pub peak_bytes: u64,
}

impl Growing {
    /// Holds at most `max_bytes` of columns, and beyond that writes them to a store, behind the head of a column file; without a
    /// store they end in an error.
    pub fn new(rays: Rays, max_bytes: u64, target: Option<(Vec<u8>, Arc<dyn Store>)>) -> Growing {
        let totals = Totals { n_runs: 0, odd_rays: 0, n_crossings: 0, cells: Box::new([0; 256]) };
        let target = target.map(|target| Target::new(&rays, max_bytes, target));
        let (held, held_bytes, is_spilled, n_rays, peak_bytes) = (Vec::new(), 0, false, 0, 0);
        Growing { rays, max_bytes, target, held, held_bytes, is_spilled, n_rays, totals, peak_bytes }
    }

    /// Goes on from a store that keeps every band, begun by an earlier run or empty: takes all bands that it holds whole,
    /// up to the end of a row of rays, drops what follows and puts all later bands there. The head says what is meshed.
    ///
    /// # Errors
    /// `job-conflict` where the store was begun for something else; `memory`, as for [`Growing::push`]; `io` where the
    /// store fails.
    pub fn keeping(rays: Rays, max_bytes: u64, head: Vec<u8>, store: Arc<dyn Store>) -> Result<Growing> {
        let mut growing = Growing::new(rays, max_bytes, Some((head, store.clone())));
        let Some(target) = &mut growing.target else { return Ok(growing) };
        target.keeps = true;
        let failed = |error| Error::io("going on from columns that were kept", error);
        let expected = target.head.clone();
        let begun = begun(&*store, expected.len());
        if begun == expected {
            target.n_bytes = expected.len() as u64;
            let end = growing.take_kept(expected.len() as u64)?;
            store.truncate(end).map_err(failed)?;
        } else if begun.len() == expected.len() {
            let message = "the columns that were kept are those of another job, file or version, or no columns";
            return Err(Error::new("job-conflict", message, "delete the file, or repeat the job that began it"));
        } else if expected.starts_with(&begun) {
            // not even the head was finished
            store.truncate(0).map_err(failed)?;
            target.append_bytes(&expected)?;
        } else {
            let message =
                format!("the file exists but is not a hexcast file of this job: it has {} bytes", begun.len());
            return Err(Error::new("job-conflict", message, "move the file away, or name another output"));
        }
        Ok(growing)
    }

    /// Takes the bands of the store that are whole; returns their end.
    fn take_kept(&mut self, mut at: u64) -> Result<u64> {
        let Some(stored) = self.target.as_ref().map(|target| target.stored.clone()) else { return Ok(at) };
        let (mut taken, mut end) = (Vec::new(), at);
        let mut next_ray = 0;
        // whatever cannot be read, or does not fit, ends what was kept
        while let Ok(head) = stored.head(at)
            && head.is_sound(self.rays.n_rays() - next_ray, self.rays.depth)
            && let record = (Record { at, first_ray: next_ray, n_rays: head.n_rays })
            && let Ok(part) = stored.read(&record)
        {
            at += head.to_bytes().len() as u64 + u64::from(head.n_stored);
            next_ray = record.end_ray();
            taken.push((part, record));
            if head.ends_band && next_ray.is_multiple_of(u64::from(self.rays.counts[0])) {
                let (parts, records): (Vec<Part>, Vec<Record>) = taken.drain(..).unzip();
                if let Some(target) = &mut self.target {
                    target.records.extend(records);
                    target.n_bytes += at - end;
                }
                end = at;
                self.add(parts, head.counts)?;
            }
        }
        Ok(end)
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
        let is_spilled = self.is_spilled;
        if let Some(target) = self.target.as_mut().filter(|target| target.keeps || is_spilled) {
            target.append(&parts)?;
        }
        let counts = parts.iter().fold([0; 2], |sum, (_, counts)| [sum[0] + counts[0], sum[1] + counts[1]]);
        self.add(parts.into_iter().map(|(part, _)| part).collect(), counts)
    }

    /// Counts parts and holds them, unless they are spilled or become so.
    fn add(&mut self, parts: Vec<Part>, [odd_rays, n_crossings]: [u64; 2]) -> Result<()> {
        self.n_rays += parts.iter().map(Part::n_rays).sum::<u64>();
        self.totals.n_runs += parts.iter().map(Part::n_runs).sum::<u64>();
        self.totals.odd_rays += odd_rays;
        self.totals.n_crossings += n_crossings;
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
        if self.target.is_none() {
            let message = format!(
                "the columns of {} of {} rays take {} bytes already, and {} are left for them",
                self.n_rays,
                self.rays.n_rays(),
                self.held_bytes,
                self.max_bytes
            );
            return Err(Error::new("memory", message, crate::error::MORE_MEMORY));
        }
        let held = std::mem::take(&mut self.held);
        self.count_cells(&held);
        if let Some(target) = self.target.as_mut().filter(|target| !target.keeps) {
            let mut parts: Vec<(Part, [u64; 2])> = held.into_iter().map(|part| (part, [0; 2])).collect();
            // the counts of all bands so far, with the last of them
            if let Some((_, counts)) = parts.last_mut() {
                *counts = [self.totals.odd_rays, self.totals.n_crossings];
            }
            target.append(&parts)?;
        }
        self.held_bytes = 0;
        self.is_spilled = true;
        Ok(())
    }

    fn count_cells(&mut self, parts: &[Part]) {
        let more = cells_of(parts, self.rays.depth);
        self.totals.cells.iter_mut().zip(more).for_each(|(cells, more)| *cells += more);
    }

    /// Writes the end of the file, if there is one: then it is a column file like any other.
    ///
    /// # Errors
    /// `io` where the store fails.
    pub fn close(&mut self) -> Result<()> {
        let (is_spilled, n_rays) = (self.is_spilled, self.n_rays);
        let mut totals = self.totals.clone();
        let Some(target) = self.target.as_mut().filter(|target| target.keeps || is_spilled) else { return Ok(()) };
        if n_rays < self.rays.n_rays() {
            return Ok(());
        }
        if !is_spilled {
            *totals.cells = cells_of(&self.held, self.rays.depth);
        }
        let index: Vec<[u64; 2]> = target.records.iter().map(|record| [record.at, record.first_ray]).collect();
        target.append_bytes(&end::encode(VERSION, &index, &totals, target.n_bytes))
    }

    /// The columns of all rays.
    ///
    /// # Panics
    /// If rays are missing: a bug of the caller.
    pub fn finish(self) -> Columns {
        assert_eq!(self.n_rays, self.rays.n_rays(), "bands must cover all rays");
        let Growing { rays, held, totals, .. } = self;
        let [odd_rays, n_crossings] = [totals.odd_rays, totals.n_crossings];
        let content = match self.target.filter(|_| self.is_spilled) {
            Some(Target { stored, records, n_bytes, .. }) => {
                Content::Spilled { stored, records: records.into(), totals, n_bytes }
            }
            None => Content::Held(Arc::new(held)),
        };
        Columns { rays, content, odd_rays, n_crossings }
    }
}

#[cfg(test)]
mod tests;
