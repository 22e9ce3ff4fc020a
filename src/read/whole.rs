//! Files that are read once all of their bytes are there: OBJ, OFF, PLY, 3MF, GLB, and what is packed by gzip.
//!
//! Memory: the bytes of the file, its corners, and 36 bytes a facet. Of gzip also the unpacked bytes, at most [`MAX_UNPACKED`].

use std::io::Read;

use flate2::bufread::MultiGzDecoder;

use super::contents::{Contents, Format};
use super::polygons::no_room;
use super::text::without_mark;
use super::{glb, obj, off, ply, threemf};
use crate::error::{Error, Result};

/// Most bytes that a packed file may have unpacked.
const MAX_UNPACKED: u64 = 16 << 30;
const CHUNK: u64 = 1 << 20;

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
    bytes: Vec<u8>,
}

impl Parser {
    pub(super) fn new(format: Format) -> Parser {
        Parser { format, bytes: Vec::new() }
    }

    pub(super) fn push(&mut self, chunk: &[u8]) -> Result<()> {
        self.bytes.try_reserve(chunk.len()).map_err(|_| no_room("bytes", self.bytes.len()))?;
        self.bytes.extend_from_slice(chunk);
        Ok(())
    }

    /// Reads the bytes; `read` reads what is packed.
    pub(super) fn finish(self, n_bytes: u64, read: fn(&[u8]) -> Result<Contents>) -> Result<Contents> {
        let text = without_mark(&self.bytes);
        match self.format {
            Format::Gzip => unpacked(self.bytes, n_bytes, read),
            Format::Off => off::read(text, n_bytes),
            Format::Obj => obj::read(text, n_bytes),
            Format::ThreeMf => threemf::read(&self.bytes, n_bytes),
            Format::Glb => glb::read(&self.bytes, n_bytes),
            _ => ply::read(&self.bytes, n_bytes),
        }
    }
}

/// Reads what is packed; the length of the contents stays that of the file.
fn unpacked(packed: Vec<u8>, n_bytes: u64, read: fn(&[u8]) -> Result<Contents>) -> Result<Contents> {
    let mut decoder = MultiGzDecoder::new(&packed[..]);
    let mut bytes = Vec::new();
    loop {
        bytes.try_reserve(CHUNK as usize).map_err(|_| no_room("bytes", bytes.len()))?;
        let n = (&mut decoder).take(CHUNK).read_to_end(&mut bytes).map_err(|error| {
            let message =
                format!("the file is packed by gzip, and unpacking fails after {} bytes: {error}", bytes.len());
            Error::new("file-syntax", message, "copy or pack the file again")
        })?;
        if n == 0 {
            break;
        }
        if bytes.len() as u64 > MAX_UNPACKED {
            let message = format!("more than {MAX_UNPACKED} bytes are packed in a file of {n_bytes}");
            return Err(Error::new("memory", message, "unpack it first (gunzip)"));
        }
    }
    drop(packed);
    if bytes.starts_with(b"\x1f\x8b") {
        let message = "the file is packed by gzip twice";
        return Err(Error::new("file-syntax", message, "unpack it first (gunzip)"));
    }
    let contents = read(&bytes).map_err(|error| error.at("what is packed"))?;
    Ok(Contents { n_bytes, ..contents })
}
