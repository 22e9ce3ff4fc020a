//! Reading a column file from front to back.

use std::io::Read;

use crate::parallel::*;

use crate::checksum::crc32;
use crate::columns::file::corrupt;
use crate::columns::file::end;
use crate::columns::file::head::{self, START};
use crate::columns::file::piece::{PIECE_HEAD, PieceHead};
use crate::columns::{Band, Columns, Head};
use crate::control::Control;
use crate::error::{Error, Result};
use crate::mesh::Mesh;

/// Pieces read before they are decoded together.
const BATCH: usize = 16;

/// Reads a column file to its end. Every number is used only after its checksum was verified, and memory grows with the bytes
/// that arrive, not with the numbers in them; zlib can pack a few thousand bytes of columns into one.
///
/// # Errors
/// `columns-corrupt` where the file is damaged, cut short or continues, with the byte; `columns-version` where a newer
/// hexcast wrote it; `io` where `input` fails.
pub fn read_columns(input: &mut dyn Read) -> Result<Mesh> {
    read_columns_within(input, u64::MAX, &Control::default())
}

/// Reads a column file like [`read_columns`], for files from outside: at most `max_bytes` of columns.
///
/// # Errors
/// Those of [`read_columns`]; `memory` where the columns are larger than `max_bytes`; `cancelled`, looked at after every
/// few pieces.
pub fn read_columns_within(input: &mut dyn Read, max_bytes: u64, control: &Control) -> Result<Mesh> {
    let mut input = Input { bytes: input, at: 0 };
    let (version, head) = read_head(&mut input)?;
    let n_rays = head.rays.n_rays();
    let mut bands: Vec<Band> = Vec::new();
    let mut index = Vec::new();
    let (mut next, mut held) = (0, 0);
    while next < n_rays {
        control.check()?;
        let mut batch = Vec::with_capacity(BATCH);
        while next < n_rays && batch.len() < BATCH {
            index.push([input.at, next]);
            let piece = read_piece(&mut input, n_rays - next, head.rays.depth, |bytes| {
                held += bytes;
                if held > max_bytes { Err(too_large(held, max_bytes)) } else { Ok(()) }
            })?;
            batch.push((next, piece));
            next += u64::from(batch[batch.len() - 1].1.head.n_rays);
        }
        let decoded: Vec<_> = batch.par_iter().map(|(first_ray, piece)| piece.decode(&head, *first_ray)).collect();
        for band in decoded {
            bands.push(band?);
        }
    }
    // in a crafted file the sums may not fit
    let sum = |count: fn(&Band) -> u64| bands.iter().try_fold(0u64, |sum, band| sum.checked_add(count(band)));
    if sum(|band| band.odd_rays).is_none() || sum(|band| band.n_crossings).is_none() {
        return Err(corrupt("the pieces count more crossings than fit 64 bits".into()));
    }
    let columns = Columns::new(head.rays, bands);
    let end = end::encode(version, &index, &columns.totals(), input.at);
    read_end(&mut input, &end)?;
    Mesh::new(head.lines, columns, head.names, head.unit)
}

fn too_large(held: u64, max_bytes: u64) -> Error {
    let message = format!("the columns need {held} bytes and more; {max_bytes} are allowed");
    Error::new("memory", message, "allow more memory")
}

fn read_head(input: &mut Input) -> Result<(u32, Head)> {
    let mut bytes = input.take(START, "head")?;
    let (version, n_body) = head::start(&bytes)?;
    bytes.extend(input.take(n_body, "head")?);
    input.checksum(&bytes, "head")?;
    Ok((version, head::decode(version, &bytes[START..])?))
}

/// A piece, still encoded.
struct EncodedPiece {
    at: u64,
    head: PieceHead,
    bytes: Vec<u8>,
}

fn read_piece(
    input: &mut Input,
    rays_left: u64,
    depth: u32,
    mut reserve: impl FnMut(u64) -> Result<()>,
) -> Result<EncodedPiece> {
    let at = input.at;
    let bytes = input.take(PIECE_HEAD - 4, "piece")?;
    input.checksum(&bytes, "head of a piece")?;
    let Some(head) = PieceHead::from_bytes(&bytes).filter(|head| head.is_sound(rays_left, depth)) else {
        let [n_rays, n_runs] =
            [4, 8].map(|at| u32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]));
        let tag = bytes[..4].escape_ascii();
        return Err(corrupt(format!(
            "byte {at}: \"{tag}\" with {n_rays} rays and {n_runs} runs; {rays_left} rays are missing"
        )));
    };
    reserve(4 * (u64::from(head.n_rays) + u64::from(head.n_runs)))?;
    let bytes = input.take(head.n_stored as usize, "piece")?;
    if crc32(&bytes) != head.crc {
        return Err(corrupt(format!("the checksum of bytes {} to {} is wrong", at + PIECE_HEAD as u64, input.at)));
    }
    Ok(EncodedPiece { at, head, bytes })
}

impl EncodedPiece {
    fn decode(&self, head: &Head, first_ray: u64) -> Result<Band> {
        let band = self.head.decode(&self.bytes, head.zlib, head.rays.depth);
        let band = band.map_err(|what| corrupt(format!("the piece at byte {}: {what}", self.at)))?;
        Ok(Band { first_ray, ..band })
    }
}

/// Reads the end and compares it with the one that the pieces before it demand.
fn read_end(input: &mut Input, expected: &[u8]) -> Result<()> {
    let at = input.at;
    let end = input.take(expected.len(), "end")?;
    if let Some(index) = (0..end.len()).find(|&index| end[index] != expected[index]) {
        return Err(corrupt(format!("byte {} of the end does not fit the pieces before it", at + index as u64)));
    }
    match input.take(1, "end") {
        Ok(_) => Err(corrupt(format!("the file continues after its end at byte {}", input.at - 1))),
        Err(error) if error.code() == "columns-corrupt" => Ok(()),
        Err(error) => Err(error),
    }
}

/// The input, and the number of bytes read so far.
struct Input<'a> {
    bytes: &'a mut dyn Read,
    at: u64,
}

impl Input<'_> {
    /// Reads `n` bytes of a section; memory grows with the bytes that arrive.
    fn take(&mut self, n: usize, section: &str) -> Result<Vec<u8>> {
        let mut bytes = Vec::new();
        let read = (&mut *self.bytes).take(n as u64).read_to_end(&mut bytes);
        read.map_err(|error| Error::io(format_args!("reading the column file at byte {}", self.at), error))?;
        self.at += bytes.len() as u64;
        if bytes.len() < n {
            let missing = n - bytes.len();
            return Err(corrupt(format!(
                "the file ends at byte {}, {missing} bytes before the {section} does",
                self.at
            )));
        }
        Ok(bytes)
    }

    /// Reads the checksum that follows `bytes` and compares.
    fn checksum(&mut self, bytes: &[u8], section: &str) -> Result<()> {
        let start = self.at - bytes.len() as u64;
        if self.take(4, section)? != crc32(bytes) {
            return Err(corrupt(format!("the checksum of the {section}, bytes {start} to {}, is wrong", self.at - 4)));
        }
        Ok(())
    }
}
