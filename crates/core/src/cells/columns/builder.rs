//! Builds columns: bands come in order, stay in memory as long as they fit, and spill to a store when they do not.
//!
//! Bands -> [`Columns`]. A limit on the bytes in memory; a [`Store`], if there is one, for a column file. Once the bands exceed
//! the limit all of them move to the store, and so does every later one. A store to *resume* from gets every band at once,
//! whether or not they fit in memory, so that an interrupted mesh can continue from it.

use std::sync::Arc;

use super::Columns;
use super::file::end::{self, Totals};
use super::file::head::{self, Named, START};
use super::packed_band::PackedBand;
use super::piece_store::{PieceEntry, PieceStore};
use super::run::Band;
use super::store::Store;
use crate::base::error::{Error, Result};
use crate::base::parallel::*;
use crate::grid::lines::Lines;
use crate::grid::rays::Rays;

/// Columns of the first rays of a box.
pub struct ColumnsBuilder {
    rays: Rays,
    max_bytes: u64,
    file: Option<SpillFile>,
    /// All bands, or none once they are only in the file.
    bands: Vec<PackedBand>,
    bands_bytes: u64,
    is_spilled: bool,
    n_rays: u64,
    /// What the bands hold that are only in the file.
    spilled: Totals,
    /// Most bytes in memory at once, the unpacked bands that came last included.
    pub peak_bytes: u64,
}

/// The column file for bands that do not fit in memory.
struct SpillFile {
    /// What the file starts with, written before the first band.
    head: Vec<u8>,
    pieces: PieceStore,
    /// Whether it gets every band at once.
    is_resumable: bool,
}

impl SpillFile {
    fn append(&mut self, bands: &[PackedBand]) -> Result<()> {
        if self.pieces.n_bytes == 0 {
            self.pieces.append_bytes(&self.head)?;
        }
        self.pieces.append(bands)
    }
}

impl ColumnsBuilder {
    /// Holds at most `max_bytes` of columns, and writes what exceeds them to a store, after the head of a column file; without
    /// a store what exceeds them is an error.
    pub fn new(rays: Rays, max_bytes: u64, file: Option<(Vec<u8>, Arc<dyn Store>)>) -> ColumnsBuilder {
        let file = file.map(|(head, store)| {
            let pieces = PieceStore::own(store, rays.depth, max_bytes);
            SpillFile { head, pieces, is_resumable: false }
        });
        let spilled = Totals::of(&[], rays.depth);
        let (bands, bands_bytes, is_spilled, n_rays, peak_bytes) = (Vec::new(), 0, false, 0, 0);
        ColumnsBuilder { rays, max_bytes, file, bands, bands_bytes, is_spilled, n_rays, spilled, peak_bytes }
    }

    /// Continues from a store that an earlier run wrote, or an empty one: takes all bands that it holds whole, up to the end of
    /// a row of rays, drops what follows, and writes all later bands there. The head says what is meshed.
    ///
    /// # Errors
    /// `columns-other` where the store holds something else, with the first difference; `memory`, as for [`ColumnsBuilder::push`]; `io` where the store
    /// fails.
    pub fn resume(rays: Rays, max_bytes: u64, head: Vec<u8>, store: Arc<dyn Store>) -> Result<ColumnsBuilder> {
        let failed = |error| Error::io("reading the columns of the interrupted run", error);
        let found = first_bytes(&*store, head.len());
        let mut pieces = PieceStore::own(store.clone(), rays.depth, max_bytes);
        let is_begun = found == head;
        if is_begun {
            pieces.n_bytes = head.len() as u64;
        } else if found.len() == head.len() {
            let message = format!("it holds the finished columns of something else: {}", difference(&*store, &head));
            return Err(Error::new(
                "columns-other",
                message,
                "delete it, repeat what wrote it, or name another output",
            ));
        } else if head.starts_with(&found) {
            // not even the head was finished: it comes again, before the first band
            store.truncate(0).map_err(failed)?;
        } else {
            let message =
                format!("the file exists but is not a hexcast file of this job: it has {} bytes", found.len());
            return Err(Error::new("columns-other", message, "move the file away, or name another output"));
        }
        let mut builder = ColumnsBuilder::new(rays, max_bytes, None);
        builder.file = Some(SpillFile { head, pieces, is_resumable: true });
        if is_begun {
            builder.take_whole_bands()?;
            store.truncate(builder.file.as_ref().map_or(0, |file| file.pieces.n_bytes)).map_err(failed)?;
        }
        Ok(builder)
    }

    /// Takes the bands of the file that are whole.
    fn take_whole_bands(&mut self) -> Result<()> {
        let (mut bands, mut entries, mut next_ray) = (Vec::new(), Vec::new(), 0);
        let mut at = self.file.as_ref().map_or(0, |file| file.pieces.n_bytes);
        // what cannot be read, or does not fit, ends what can be resumed
        while let Some(SpillFile { pieces, .. }) = &mut self.file
            && let Ok(head) = pieces.head(at)
            && head.is_sound(self.rays.n_rays() - next_ray, self.rays.depth)
            && let entry = (PieceEntry { at, first_ray: next_ray, n_rays: head.n_rays })
            && let Ok(band) = pieces.band(&entry)
        {
            at += head.to_bytes().len() as u64 + u64::from(head.n_stored);
            next_ray = entry.end_ray();
            bands.push(PackedBand::new(band));
            entries.push(entry);
            if head.ends_band && next_ray.is_multiple_of(u64::from(self.rays.counts[0])) {
                pieces.entries.append(&mut entries);
                pieces.n_bytes = at;
                self.add(std::mem::take(&mut bands))?;
            }
        }
        Ok(())
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
        let unpacked_bytes: u64 = bands.iter().map(|band| 4 * (band.ends.len() + band.runs.len()) as u64).sum();
        self.peak_bytes = self.peak_bytes.max(self.bands_bytes + unpacked_bytes);
        let bands: Vec<PackedBand> = on_all_cores(|| bands.into_par_iter().map(PackedBand::new).collect());
        let first = bands.first().map_or(self.n_rays, |band| band.first_ray);
        assert_eq!(first, self.n_rays, "bands must follow each other");
        if let Some(file) = self.file.as_mut().filter(|file| file.is_resumable || self.is_spilled) {
            file.append(&bands)?;
        }
        self.add(bands)
    }

    /// Counts bands, and holds them unless they are in the file or must go there.
    fn add(&mut self, bands: Vec<PackedBand>) -> Result<()> {
        self.n_rays += bands.iter().map(PackedBand::n_rays).sum::<u64>();
        if self.is_spilled {
            self.spilled.add(&bands, self.rays.depth);
            return Ok(());
        }
        self.bands_bytes += bands.iter().map(PackedBand::n_bytes).sum::<u64>();
        self.bands.extend(bands);
        self.peak_bytes = self.peak_bytes.max(self.bands_bytes);
        if self.bands_bytes > self.max_bytes { self.spill() } else { Ok(()) }
    }

    /// Frees the bands, after writing them to the file if they are not there yet.
    fn spill(&mut self) -> Result<()> {
        let Some(file) = &mut self.file else {
            let message = format!(
                "the columns of {} of {} rays take {} bytes already, and {} are left for them",
                self.n_rays,
                self.rays.n_rays(),
                self.bands_bytes,
                self.max_bytes
            );
            return Err(Error::new("memory", message, crate::base::error::MORE_MEMORY));
        };
        if !file.is_resumable {
            file.append(&self.bands)?;
        }
        self.spilled.add(&self.bands, self.rays.depth);
        (self.bands, self.bands_bytes, self.is_spilled) = (Vec::new(), 0, true);
        Ok(())
    }

    /// Ends the file, if there is one: then it is a column file like any other. Returns the columns of all rays.
    ///
    /// # Errors
    /// `io` where the store fails.
    ///
    /// # Panics
    /// If rays are missing: a bug of the caller.
    pub fn finish(mut self) -> Result<Columns> {
        assert_eq!(self.n_rays, self.rays.n_rays(), "bands must cover all rays");
        if let Some(file) = self.file.as_mut().filter(|file| file.is_resumable || self.is_spilled) {
            self.spilled.add(&self.bands, self.rays.depth);
            let index: Vec<[u64; 2]> = file.pieces.entries.iter().map(|entry| [entry.at, entry.first_ray]).collect();
            let end = end::encode(&index, &self.spilled, file.pieces.n_bytes);
            file.pieces.append_bytes(&end)?;
        }
        Ok(match self.file.filter(|_| self.is_spilled) {
            Some(file) => Columns::in_store(self.rays, file.pieces, self.spilled),
            None => Columns::in_memory(self.rays, Arc::new(self.bands)),
        })
    }
}

/// What differs first between the head of the columns in a store and that of what is to be meshed.
fn difference(store: &dyn Store, head: &[u8]) -> String {
    let unknown = || "its head cannot be read".to_string();
    // the browser resumes no file
    if cfg!(target_arch = "wasm32") {
        return unknown();
    }
    let read = |start: &[u8]| -> Option<(u32, usize)> { head::start(start).ok() };
    let (Some((version, n_theirs)), Some((_, n_ours))) = (read(&first_bytes(store, START)), read(&head[..START]))
    else {
        return unknown();
    };
    let theirs = first_bytes(store, START + n_theirs);
    let decoded = |bytes: &[u8]| head::decode(version, bytes.get(START..)?).ok();
    let (Some(theirs), Some(ours)) = (decoded(&theirs), decoded(&head[..START + n_ours])) else { return unknown() };
    let of_cells = |lines: &Lines| lines.dims().map(|n| n.to_string()).join(" x ");
    let axis = |rays: &Rays| ["x", "y", "z"][rays.axis];
    let names = |names: &[Named]| {
        names.iter().map(|named| format!("{} \"{}\"", named.flag, named.name)).collect::<Vec<_>>().join(", ")
    };
    if theirs.lines.dims() != ours.lines.dims() {
        return format!("{} cells, where {} are asked for", of_cells(&theirs.lines), of_cells(&ours.lines));
    }
    if theirs.lines != ours.lines {
        let [theirs, ours] = [&theirs, &ours].map(|head| (head.lines.origin(), head.lines.smallest()));
        return format!(
            "lines from {:?}, cells of {:?}, where {:?} and {:?} are asked for",
            theirs.0, theirs.1, ours.0, ours.1
        );
    }
    if theirs.rays != ours.rays {
        return format!("rays along {}, where {} is asked for", axis(&theirs.rays), axis(&ours.rays));
    }
    if theirs.names != ours.names {
        return format!("the flags are {}, where {} are asked for", names(&theirs.names), names(&ours.names));
    }
    "cells, lines and flags are the same, but an input file, another option of the job, or the version of hexcast differs".into()
}

/// The first bytes of a store, at most `n`.
fn first_bytes(store: &dyn Store, n: usize) -> Vec<u8> {
    let mut bytes = vec![0; n];
    let read = |bytes: &mut [u8]| store.read(0, bytes).is_ok();
    if read(&mut bytes) {
        return bytes;
    }
    // if so many bytes can be read, so can fewer
    let (mut least, mut most) = (0, n);
    while most - least > 1 {
        let middle = least.midpoint(most);
        if read(&mut bytes[..middle]) { least = middle } else { most = middle }
    }
    bytes.truncate(least);
    if read(&mut bytes) { bytes } else { Vec::new() }
}

#[cfg(test)]
mod tests;
