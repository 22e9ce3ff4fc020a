//! Binary STL: 80 bytes of anything, the number of facets as u32, then 50 bytes a facet, all little-endian.
//!
//! A facet is twelve f32 (normal, three corners) and a 16-bit attribute word, which some programs use for colours.
//! The count must fit the length of the file before anything is allocated. Bytes after the last facet are ignored, with
//! a warning, unless they look as if the count was wrong. Where the file can be read again, facets that would take more than half of the
//! memory stay in it.

use super::contents::{self, Contents, FACETS, Format, Solid, Tally, Warnings};
use super::stl_in_file::{Again, Checksums};
use super::stl_record::{HEADER, RECORD, facet_of};
use crate::base::error::{Error, Result};
use crate::base::memory::{List, Memory};
use crate::base::parallel::*;
use crate::input::geometry::{Facet, SharedFacets};

/// Records that one core takes at a time.
const BLOCK: usize = 1 << 11;
/// Bytes after the facets that are accepted, besides as many as the header and the facets take.
const MAX_TRAILING: u64 = 4096;

/// The number of facets that a file with these first bytes announces, if it has a whole header.
pub(super) fn announced(head: &[u8]) -> Option<u32> {
    head.get(80..HEADER)?.first_chunk().map(|count| u32::from_le_bytes(*count))
}

/// Length in bytes of a binary STL of so many facets.
pub(super) fn n_bytes_of(n_facets: u32) -> u64 {
    HEADER as u64 + RECORD as u64 * u64::from(n_facets)
}

/// Reads the bytes after the header.
#[derive(Debug)]
pub(super) struct Parser {
    n_bytes: u64,
    n_facets: usize,
    n_read: usize,
    target: Target,
    /// Their least and greatest coordinates.
    ends: [[f32; 3]; 2],
    /// The first `n_partial` bytes of a record that the last chunk cut.
    partial: [u8; RECORD],
    n_partial: usize,
    tally: Tally,
    has_colours: bool,
    /// Records after the announced ones, and whether all of them look like facets.
    n_extra: u64,
    extra_are_facets: bool,
}

/// Where facets go.
#[derive(Debug)]
enum Target {
    Memory(List<Facet>),
    /// They stay where they are.
    File(Again, Checksums),
}

impl Target {
    /// Of so many facets.
    fn new(count: u32, memory: &Memory, again: Option<Again>) -> Result<Target> {
        let n_bytes = size_of::<Facet>() as u64 * u64::from(count);
        if let Some(again) = again.filter(|_| n_bytes > memory.left() / 2) {
            return Ok(Target::File(again, Checksums::default()));
        }
        let mut facets = List::new(memory, FACETS);
        facets
            .reserve(count as usize)
            .map_err(|error| error.at(format!("the count at byte 80 announces {count} facets")))?;
        Ok(Target::Memory(facets))
    }
}

impl Parser {
    /// Checks the header against the length of the file and reserves memory for the facets, unless they stay in their file.
    ///
    /// # Errors
    /// `stl-truncated`, `stl-count`, `stl-empty`, `stl-not-stl`, `memory` as in [`super::Reader::push`].
    pub(super) fn new(head: &[u8], n_bytes: u64, (memory, again): (&Memory, Option<Again>)) -> Result<Parser> {
        let Some(count) = announced(head) else {
            let message = format!("{n_bytes} bytes; a binary STL has at least 84");
            return Err(Error::new("stl-not-stl", message, "copy or export the file again"));
        };
        check_count(count, n_bytes)?;
        Ok(Parser {
            n_bytes,
            n_facets: count as usize,
            n_read: 0,
            target: Target::new(count, memory, again)?,
            ends: NO_ENDS,
            partial: [0; RECORD],
            n_partial: 0,
            tally: Tally::default(),
            has_colours: head[..80].windows(6).any(|window| window == b"COLOR="),
            n_extra: 0,
            extra_are_facets: true,
        })
    }

    /// Takes the next bytes after the header.
    ///
    /// # Errors
    /// `stl-not-finite` as in [`super::Reader::push`].
    pub(super) fn push(&mut self, mut bytes: &[u8]) -> Result<()> {
        if self.n_partial > 0 {
            let n_missing = (RECORD - self.n_partial).min(bytes.len());
            self.partial[self.n_partial..][..n_missing].copy_from_slice(&bytes[..n_missing]);
            self.n_partial += n_missing;
            bytes = &bytes[n_missing..];
            if self.n_partial < RECORD {
                return Ok(());
            }
            let record = self.partial;
            self.records(&[record])?;
        }
        let (records, rest) = bytes.as_chunks::<RECORD>();
        self.records(records)?;
        self.partial[..rest.len()].copy_from_slice(rest);
        self.n_partial = rest.len();
        Ok(())
    }

    fn records(&mut self, records: &[[u8; RECORD]]) -> Result<()> {
        let n_wanted = (self.n_facets - self.n_read).min(records.len());
        let (wanted, extra) = records.split_at(n_wanted);
        let looked_at: Vec<Block> = on_all_cores(|| wanted.par_chunks(BLOCK).map(Block::new).collect());
        for (index, block) in looked_at.iter().enumerate() {
            if let Some((place, facet)) = &block.not_finite {
                return Err(not_finite(facet, self.n_read + index * BLOCK + place, self.n_facets));
            }
            self.tally.add(&block.tally);
            self.has_colours |= block.has_colours;
            self.ends = with_corners(self.ends, &block.ends);
        }
        match &mut self.target {
            Target::Memory(facets) => {
                on_all_cores(|| facets.par_extend(wanted.par_iter().map(|record| facet_of(record).1)))?;
            }
            Target::File(_, checksums) => checksums.add(wanted),
        }
        self.n_read += n_wanted;
        self.n_extra += extra.len() as u64;
        self.extra_are_facets &= extra.iter().all(|record| is_plausible(&facet_of(record).1));
        Ok(())
    }

    /// Ends the file.
    ///
    /// # Errors
    /// `stl-count` as in [`super::Reader::finish`].
    pub(super) fn finish(self) -> Result<Contents> {
        let n_facets = self.n_read as u64;
        let mut warnings = Warnings::default();
        let n_trailing = self.n_extra * RECORD as u64 + self.n_partial as u64;
        if self.n_extra > 0 && self.n_partial == 0 && self.extra_are_facets {
            return Err(wrong_count(n_facets, n_facets + self.n_extra, self.n_bytes));
        }
        if n_trailing > 0 {
            let end = self.n_bytes - n_trailing;
            warnings
                .push(format!("{n_trailing} bytes after the last of {n_facets} facets (from byte {end}) are ignored"));
        }
        let facets = match self.target {
            Target::Memory(facets) => SharedFacets::from(facets.keep()).known_finite().with_ends(self.ends),
            Target::File(again, checksums) => {
                SharedFacets::in_file(Box::new(checksums.finish(again, self.n_read)), self.ends)
            }
        };
        Ok(Contents {
            format: Format::StlBinary,
            solids: vec![Solid { name: String::new(), facets }],
            n_facets,
            n_bytes: self.n_bytes,
            unit: None,
            wrong_normals: self.tally.wrong_normals,
            zero_normals: self.tally.zero_normals,
            zero_area: self.tally.zero_area,
            has_colours: self.has_colours,
            conversion: None,
            warnings: warnings.finish(),
        })
    }
}

/// The ends of no facet.
const NO_ENDS: [[f32; 3]; 2] = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];

/// Least and greatest coordinates with those of more corners.
#[inline(always)]
fn with_corners([mut low, mut high]: [[f32; 3]; 2], corners: &[[f32; 3]]) -> [[f32; 3]; 2] {
    for corner in corners {
        for axis in 0..3 {
            low[axis] = low[axis].min(corner[axis]);
            high[axis] = high[axis].max(corner[axis]);
        }
    }
    [low, high]
}

/// What is known of records that follow each other.
struct Block {
    tally: Tally,
    has_colours: bool,
    ends: [[f32; 3]; 2],
    /// The first facet with a coordinate that is not finite, and its index.
    not_finite: Option<(usize, Facet)>,
}

impl Block {
    fn new(records: &[[u8; RECORD]]) -> Block {
        let mut block = Block { tally: Tally::default(), has_colours: false, ends: NO_ENDS, not_finite: None };
        for (index, record) in records.iter().enumerate() {
            let (normal, facet) = facet_of(record);
            // a sum is shorter than a search that ends at the first
            if facet.as_flattened().iter().fold(0.0, |sum, c| sum + 0.0 * c).is_nan() {
                block.not_finite = Some((index, facet));
                break;
            }
            block.tally.count(normal, &facet);
            block.ends = with_corners(block.ends, &facet);
            block.has_colours |= record[48] != 0 || record[49] != 0;
        }
        block
    }
}

fn check_count(count: u32, n_bytes: u64) -> Result<()> {
    let expected = n_bytes_of(count);
    let n_room = n_bytes.saturating_sub(HEADER as u64) / RECORD as u64;
    if n_bytes < expected {
        let message = format!(
            "the count at byte 80 announces {count} facets, which end at byte {expected}, but the file ends at byte \
             {n_bytes}, after {n_room} whole facets"
        );
        return Err(Error::new("stl-truncated", message, "copy or export the file again; it is cut short or not STL"));
    }
    let n_trailing = n_bytes - expected;
    if (count == 0 && n_room > 0) || n_trailing > expected + MAX_TRAILING {
        return Err(wrong_count(count.into(), n_room, n_bytes));
    }
    if count == 0 {
        return Err(contents::empty("the count at byte 80 announces 0 facets"));
    }
    Ok(())
}

fn wrong_count(count: u64, n_room: u64, n_bytes: u64) -> Error {
    let message =
        format!("the count at byte 80 announces {count} facets, but the file of {n_bytes} bytes can hold {n_room}");
    Error::new("stl-count", message, "export the file again, so that count and length agree")
}

fn not_finite(facet: &Facet, index: usize, n_facets: usize) -> Error {
    let place = facet.as_flattened().iter().position(|c| !c.is_finite()).unwrap_or(0);
    let (number, corner, axis) = (index + 1, place / 3 + 1, ["x", "y", "z"][place % 3]);
    let byte = HEADER as u64 + RECORD as u64 * index as u64 + 12 + 4 * place as u64;
    let value = facet.as_flattened()[place];
    let message = format!("facet {number} of {n_facets}: {axis} of corner {corner} is {value} (byte {byte})");
    Error::new("stl-not-finite", message, "repair the model where it was made; a corner needs three finite numbers")
}

/// Whether bytes after the announced facets look like one more facet: padding is all zero, and text or other data give
/// numbers far too large or small.
fn is_plausible(facet: &Facet) -> bool {
    let corners = facet.as_flattened();
    corners.iter().all(|c| *c == 0.0 || (1e-15..1e15).contains(&c.abs())) && corners.iter().any(|c| *c != 0.0)
}
