//! Facets of a binary STL that stay in its file: read again whenever they are looked at, and checked to be those of the first time.
//!
//! Bytes of the records as they come first -> [`Checksums`], a CRC-32 of every [`READ_AT_ONCE`] of them -> [`StlInFile`], which reads them at their
//! place. Cost: 4 bytes for 8192 facets; some 20 ns a facet on one core each time, where the system has the file in its cache.

use std::io;
use std::sync::Arc;

use super::stl_record::{HEADER, RECORD, facet_of};
use crate::base::error::{Error, Result};
use crate::base::parallel::*;
use crate::input::geometry::{Facet, InFile, READ_AT_ONCE};

/// Records that are read by one call: the cache of a core holds them.
const RECORDS_OF_CALL: usize = 1 << 10;

/// A file that is read at any place, by several threads at the same time.
pub trait ReadAt: Send + Sync {
    /// Fills all of `bytes` from the byte `at` of the file.
    ///
    /// # Errors
    /// Those of the system; `UnexpectedEof` where the file ends before.
    fn read_at(&self, at: u64, bytes: &mut [u8]) -> io::Result<()>;
}

/// A file that can be read again, and its name in errors.
#[derive(Clone)]
pub(super) struct Again {
    pub(super) name: String,
    pub(super) file: Arc<dyn ReadAt>,
}

impl std::fmt::Debug for Again {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str(&self.name)
    }
}

/// Checksums of records as they come.
#[derive(Debug, Default)]
pub(super) struct Checksums {
    /// Of whole groups of records.
    of_groups: Vec<u32>,
    /// Of the group that is not whole, and the number of its records.
    crc: flate2::Crc,
    n_of_group: usize,
}

impl Checksums {
    /// Adds the next records.
    pub(super) fn add(&mut self, mut records: &[[u8; RECORD]]) {
        while !records.is_empty() {
            let (group, rest) = records.split_at(records.len().min(READ_AT_ONCE - self.n_of_group));
            self.crc.update(group.as_flattened());
            self.n_of_group += group.len();
            if self.n_of_group == READ_AT_ONCE {
                self.end_group();
            }
            records = rest;
        }
    }

    fn end_group(&mut self) {
        self.of_groups.push(self.crc.sum());
        self.crc.reset();
        self.n_of_group = 0;
    }

    /// The facets whose records were added, where they are in a file.
    pub(super) fn finish(mut self, again: Again, n_facets: usize) -> StlInFile {
        if self.n_of_group > 0 {
            self.end_group();
        }
        StlInFile { again, n_facets, checksums: self.of_groups }
    }
}

/// Facets in a binary STL.
pub(super) struct StlInFile {
    again: Again,
    n_facets: usize,
    /// Of every [`READ_AT_ONCE`] facets.
    checksums: Vec<u32>,
}

impl StlInFile {
    /// Reads a group of facets.
    fn read_group(&self, group: usize, facets: &mut [Facet]) -> Result<()> {
        let name = &self.again.name;
        let (first, mut crc) = (group * READ_AT_ONCE, flate2::Crc::new());
        let mut records = vec![[0; RECORD]; RECORDS_OF_CALL.min(facets.len())];
        for (place, facets) in (first..).step_by(RECORDS_OF_CALL).zip(facets.chunks_mut(RECORDS_OF_CALL)) {
            let records = &mut records[..facets.len()];
            let read = self.again.file.read_at((HEADER + RECORD * place) as u64, records.as_flattened_mut());
            read.map_err(|error| Error::io(format!("reading {name} again"), error))?;
            crc.update(records.as_flattened());
            facets.iter_mut().zip(records).for_each(|(facet, record)| *facet = facet_of(record).1);
        }
        if crc.sum() == self.checksums[group] {
            return Ok(());
        }
        let (n, end) = (self.n_facets, first + facets.len());
        let message = format!(
            "{name}: facets {} to {end} of {n} are others than when it was read first: the file changed while it was used",
            first + 1
        );
        Err(Error::new("io", message, "begin again when nothing writes to it"))
    }
}

impl InFile for StlInFile {
    fn n_facets(&self) -> usize {
        self.n_facets
    }

    fn read(&self, first: usize, facets: &mut [Facet]) -> Result<()> {
        let groups = facets.par_chunks_mut(READ_AT_ONCE).enumerate();
        let of_group = |(index, facets): (usize, &mut [Facet])| self.read_group(first / READ_AT_ONCE + index, facets);
        let read: Vec<Result<()>> = on_all_cores(|| groups.map(of_group).collect());
        read.into_iter().collect()
    }
}
