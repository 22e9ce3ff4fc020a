//! Reading a column file from front to back.

use std::io::Read;

use crate::parallel::*;

use crate::checksum::crc32;
use crate::columns::codec::{self, PIECE_RAYS, PIECE_RUNS};
use crate::columns::{Band, Columns};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use crate::write::zlib;

use super::head::{self, Head};
use super::layout::{END_MAGIC, END_TAG, MAGIC, MAX_BODY, PIECE_HEAD, PIECE_TAG, VERSION, corrupt};

/// Pieces read before they are decoded together.
const BATCH: usize = 16;

/// Reads a column file to its end. Nothing is believed before its checksum is right, and memory grows with the bytes that
/// arrive, never with what they announce; zlib can pack a few thousand bytes of columns in one.
///
/// # Errors
/// `columns-corrupt` where the file is damaged, cut short or continues, with the byte; `columns-version` where a newer
/// hexcast wrote it; `io` where `input` fails.
pub fn read_columns(input: &mut dyn Read) -> Result<Mesh> {
    read_columns_within(input, u64::MAX, &Control::default())
}

/// Reads a column file like [`read_columns`], unless its columns take more than `max_bytes` in memory: for files of
/// strangers.
///
/// # Errors
/// Those of [`read_columns`]; `memory` where the columns are larger than `max_bytes`; `cancelled`, looked at after every
/// few pieces.
pub fn read_columns_within(input: &mut dyn Read, max_bytes: u64, control: &Control) -> Result<Mesh> {
    let mut source = Source { input, at: 0 };
    let head = read_head(&mut source)?;
    let n_rays = head.rays.n_rays();
    let mut bands: Vec<Band> = Vec::new();
    let mut index = Vec::new();
    let (mut next, mut held) = (0, 0);
    while next < n_rays {
        control.check()?;
        let mut batch = Vec::with_capacity(BATCH);
        while next < n_rays && batch.len() < BATCH {
            index.extend([source.at, next]);
            let stored = read_piece(&mut source, n_rays - next, head.rays.depth, |bytes| {
                held += bytes;
                if held > max_bytes { Err(too_large(held, max_bytes)) } else { Ok(()) }
            })?;
            batch.push((next, stored));
            next += u64::from(batch[batch.len() - 1].1.n_rays);
        }
        let decoded: Vec<_> = batch.par_iter().map(|(first_ray, stored)| stored.decode(&head, *first_ray)).collect();
        for band in decoded {
            bands.push(band?);
        }
    }
    // counts of strangers may not add up
    let sum = |count: fn(&Band) -> u64| bands.iter().try_fold(0u64, |sum, band| sum.checked_add(count(band)));
    if sum(|band| band.odd_rays).is_none() || sum(|band| band.n_crossings).is_none() {
        return Err(corrupt("the pieces count more crossings than fit 64 bits".into()));
    }
    let columns = Columns::new(head.rays, bands);
    read_end(&mut source, &index, columns.n_runs())?;
    Mesh::new(head.lines, columns, head.names, head.unit)
}

fn too_large(held: u64, max_bytes: u64) -> Error {
    let message = format!("the columns need {held} bytes and more; {max_bytes} are allowed");
    Error::new("memory", message, "allow more memory")
}

fn read_head(source: &mut Source) -> Result<Head> {
    let mut bytes = source.take(16, "head")?;
    if bytes[..8] != MAGIC {
        return Err(corrupt("this is no column file: byte 0 does not start with its signature".into()));
    }
    let version = number(&bytes, 8);
    if version > VERSION {
        let message = format!("the column file has version {version}; this hexcast reads up to {VERSION}");
        return Err(Error::new("columns-version", message, "use a newer hexcast"));
    }
    let n_body = number(&bytes, 12) as usize;
    if version != VERSION || n_body > MAX_BODY {
        return Err(corrupt(format!("the head says, at byte 8: version {version}, {n_body} bytes")));
    }
    bytes.extend(source.take(n_body, "head")?);
    source.checksum(&bytes, "head")?;
    head::decode(&bytes[16..], 16)
}

/// A piece as it stands in the file.
struct Stored {
    at: u64,
    n_rays: u32,
    n_runs: u32,
    n_content: u32,
    counts: [u64; 2],
    bytes: Vec<u8>,
}

fn read_piece(
    source: &mut Source,
    rays_left: u64,
    depth: u32,
    mut reserve: impl FnMut(u64) -> Result<()>,
) -> Result<Stored> {
    let at = source.at;
    let head = source.take(PIECE_HEAD - 4, "piece")?;
    source.checksum(&head, "head of a piece")?;
    let [n_rays, n_runs, n_content, n_stored] = [4, 8, 12, 16].map(|place| number(&head, place));
    let sound = head[..4] == PIECE_TAG
        && (1..=PIECE_RAYS).contains(&n_rays)
        && u64::from(n_rays) <= rays_left
        && (n_runs <= PIECE_RUNS || n_rays == 1)
        && u64::from(n_runs) <= u64::from(n_rays) * u64::from(depth);
    if !sound {
        let tag = head[..4].escape_ascii();
        return Err(corrupt(format!(
            "byte {at}: \"{tag}\" with {n_rays} rays and {n_runs} runs; {rays_left} rays are missing"
        )));
    }
    reserve(4 * (u64::from(n_rays) + u64::from(n_runs)))?;
    let bytes = source.take(n_stored as usize, "piece")?;
    if crc32(&bytes) != head[20..24] {
        return Err(corrupt(format!("the checksum of bytes {} to {} is wrong", at + PIECE_HEAD as u64, source.at)));
    }
    Ok(Stored { at, n_rays, n_runs, n_content, counts: [long(&head, 24), long(&head, 32)], bytes })
}

impl Stored {
    fn decode(&self, head: &Head, first_ray: u64) -> Result<Band> {
        let wrong = |what: String| corrupt(format!("the piece at byte {}: {what}", self.at));
        let inflated;
        let content = if head.zlib {
            inflated = self.inflate().map_err(wrong)?;
            &inflated
        } else {
            &self.bytes
        };
        if content.len() != self.n_content as usize {
            return Err(wrong(format!("its content has {} bytes, its head says {}", content.len(), self.n_content)));
        }
        let band = codec::decode(content, self.n_rays, self.n_runs, head.rays.depth).map_err(wrong)?;
        let [odd_rays, n_crossings] = self.counts;
        Ok(Band { first_ray, odd_rays, n_crossings, ..band })
    }

    fn inflate(&self) -> std::result::Result<Vec<u8>, String> {
        // five bytes a number and one a flag are the most that rays and runs can need
        let most = 5 * u64::from(self.n_rays) + 6 * u64::from(self.n_runs);
        let limit = most.min(u64::from(self.n_content)) + 1;
        zlib::inflate(&self.bytes, limit).map_err(|error| error.to_string())
    }
}

/// Reads the end and holds it against the pieces seen: where they start and their first rays, in turn.
fn read_end(source: &mut Source, index: &[u64], n_runs: u64) -> Result<()> {
    let at = source.at;
    let mut expected = END_TAG.to_vec();
    expected.extend((index.len() as u64 / 2).to_le_bytes());
    index.iter().chain([&n_runs]).for_each(|number| expected.extend(number.to_le_bytes()));
    expected.extend(crc32(&expected));
    expected.extend(at.to_le_bytes());
    expected.extend(END_MAGIC);
    let end = source.take(expected.len(), "end")?;
    if let Some(place) = (0..end.len()).find(|&place| end[place] != expected[place]) {
        return Err(corrupt(format!("byte {} of the end does not fit the pieces before it", at + place as u64)));
    }
    match source.take(1, "end") {
        Ok(_) => Err(corrupt(format!("the file continues behind its end at byte {}", source.at - 1))),
        Err(error) if error.code() == "columns-corrupt" => Ok(()),
        Err(error) => Err(error),
    }
}

/// The little-endian u32 at a place.
fn number(bytes: &[u8], at: usize) -> u32 {
    u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]])
}

/// The little-endian u64 at a place.
fn long(bytes: &[u8], at: usize) -> u64 {
    u64::from(number(bytes, at)) | u64::from(number(bytes, at + 4)) << 32
}

/// The input and the byte it has come to.
struct Source<'a> {
    input: &'a mut dyn Read,
    at: u64,
}

impl Source<'_> {
    /// Reads `n` bytes of a part; memory grows with what arrives, not with what is announced.
    fn take(&mut self, n: usize, part: &str) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let read = (&mut *self.input).take(n as u64).read_to_end(&mut bytes);
        read.map_err(|error| Error::io(format_args!("reading the column file at byte {}", self.at), error))?;
        self.at += bytes.len() as u64;
        if bytes.len() < n {
            let missing = n - bytes.len();
            return Err(corrupt(format!("the file ends at byte {}, {missing} bytes before the {part} does", self.at)));
        }
        Ok(bytes)
    }

    /// Reads the checksum that follows `bytes` and compares.
    fn checksum(&mut self, bytes: &[u8], part: &str) -> Result<()> {
        let start = self.at - bytes.len() as u64;
        if self.take(4, part)? != crc32(bytes) {
            return Err(corrupt(format!("the checksum of the {part}, bytes {start} to {}, is wrong", self.at - 4)));
        }
        Ok(())
    }
}
