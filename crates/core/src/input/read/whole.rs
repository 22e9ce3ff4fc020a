//! Files that are read once all of their bytes are there: OBJ, OFF, PLY, 3MF, GLB, and what is packed by gzip.
//!
//! Memory: the bytes of the file, its corners, and 36 bytes a facet. Of gzip the packed bytes, and what the format within takes.

use std::io::Read;

use flate2::bufread::MultiGzDecoder;

use super::contents::{Contents, Format};
use super::text::without_mark;
use super::{glb, obj, off, ply, threemf};
use crate::base::error::{Error, Result};
use crate::base::memory::{List, Memory};

/// Most bytes that a packed file may have unpacked.
pub(super) const MAX_UNPACKED: u64 = 16 << 30;
const CHUNK: usize = 1 << 18;

/// The format, if it is one of these; `head` is the first bytes of a file.
pub(super) fn format(head: &[u8], is_text: bool) -> Option<Format> {
    if head.starts_with(b"\x1f\x8b") {
        return Some(Format::Gzip);
    }
    if head.starts_with(b"PK\x03\x04") {
        return Some(Format::ThreeMf);
    }
    if head.starts_with(b"glTF") {
        return Some(Format::Glb);
    }
    if ply::is_ply(head) {
        return Some(Format::PlyAscii);
    }
    let head = without_mark(head);
    if is_text && off::is_off(head) {
        return Some(Format::Off);
    }
    (is_text && obj::is_obj(head)).then_some(Format::Obj)
}

/// Collects the bytes of a file.
#[derive(Debug)]
pub(super) struct Parser {
    format: Format,
    bytes: List<u8>,
    memory: Memory,
}

impl Parser {
    pub(super) fn new(format: Format, n_bytes: u64, memory: &Memory) -> Result<Parser> {
        let mut bytes = List::new(memory, "its bytes");
        bytes.reserve(usize::try_from(n_bytes).unwrap_or(usize::MAX))?;
        Ok(Parser { format, bytes, memory: memory.clone() })
    }

    pub(super) fn push(&mut self, chunk: &[u8]) -> Result<()> {
        self.bytes.extend(chunk)
    }

    /// The bytes of a file packed by gzip.
    pub(super) fn packed(&self) -> Option<&[u8]> {
        (self.format == Format::Gzip).then_some(&self.bytes)
    }

    /// Reads the bytes, which are not packed.
    pub(super) fn finish(self, n_bytes: u64) -> Result<Contents> {
        let (text, memory) = (without_mark(&self.bytes), &self.memory);
        match self.format {
            Format::Off => off::read(text, n_bytes, memory),
            Format::Obj => obj::read(text, n_bytes, memory),
            Format::ThreeMf => threemf::read(&self.bytes, n_bytes, memory),
            Format::Glb => glb::read(&self.bytes, n_bytes, memory),
            _ => ply::read(&self.bytes, n_bytes, memory),
        }
    }
}

/// Unpacks bytes, and hands them on.
pub(super) fn each_chunk(packed: &[u8], mut take: impl FnMut(&[u8]) -> Result<()>) -> Result<()> {
    let mut decoder = MultiGzDecoder::new(packed);
    let mut chunk = vec![0; CHUNK];
    let mut n_unpacked = 0;
    loop {
        let n = decoder.read(&mut chunk).map_err(|error| {
            let message = format!("the file is packed by gzip, and unpacking fails after {n_unpacked} bytes: {error}");
            Error::new("file-syntax", message, "copy or pack the file again")
        })?;
        if n == 0 {
            return Ok(());
        }
        n_unpacked += n;
        take(&chunk[..n])?;
    }
}
