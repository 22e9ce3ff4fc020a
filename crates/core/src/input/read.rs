//! Reading: bytes of a file, in chunks of any size -> [`Contents`], its solids and what is odd about them.
//!
//! The caller pushes slices as they come, so that neither a browser's Blob nor a file need be in memory at once; the
//! result does not depend on where the slices are cut. Binary and ASCII STL are distinguished by length and content, never
//! by the word "solid" alone: see `sniff`. OBJ, OFF, PLY, 3MF and GLB are read, too, and any of these packed by gzip: see `whole`. The
//! file's normals are compared with the corners' and then dropped.
//!
//! Memory: of STL 36 bytes a facet, at most three times that while the list of an ASCII file grows, and one line or record; of the others
//! the file and its corners, too. A binary STL whose facets would take more than half of the memory stays in its file, if it can be read again
//! ([`Reader::again`]). All of it is counted against a limit ([`Memory`]) before it is allocated. The number of facets that a header
//! announces must fit the length of the file, too.

use std::sync::Arc;

use crate::base::error::{Error, Result};
use crate::base::memory::Memory;

mod contents;
mod elements;
mod glb;
mod gltf_json;
mod model_xml;
mod obj;
mod off;
mod package;
mod ply;
mod polygons;
mod sniff;
mod stl_ascii;
mod stl_binary;
mod stl_in_file;
mod stl_record;
mod text;
mod threemf;
mod whole;
mod words;
mod xml_events;

pub use contents::{Contents, Conversion, Format, Solid};
#[doc(hidden)]
pub use model_xml::{MILLIMETRE, UNITS};
#[doc(hidden)]
pub use sniff::cad_format;
pub use stl_in_file::ReadAt;

use stl_in_file::Again;

/// Reads a file that comes in chunks.
///
/// ```
/// # use hexcast_core as hexcast;
/// let file = b"solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n\
///              endsolid s\n";
/// let mut reader = hexcast::read::Reader::new(file.len() as u64);
/// for chunk in file.chunks(10) {
///     reader.push(chunk)?;
/// }
/// let contents = reader.finish()?;
/// assert_eq!((contents.solids[0].name.as_str(), contents.n_facets), ("s", 1));
/// # Ok::<(), hexcast::Error>(())
/// ```
#[derive(Debug)]
pub struct Reader {
    n_bytes: u64,
    n_seen: u64,
    memory: Memory,
    again: Option<Again>,
    stage: Stage,
    failed: Option<Error>,
}

#[derive(Debug)]
enum Stage {
    /// The format is not known yet: the bytes so far, at most `sniff::HEAD` of them.
    Head(Vec<u8>),
    Binary(Box<stl_binary::Parser>),
    Ascii(Box<stl_ascii::Parser>),
    Whole(whole::Parser),
}

impl Reader {
    /// Starts to read a file of `n_bytes` bytes.
    pub fn new(n_bytes: u64) -> Reader {
        Reader::within(n_bytes, &Memory::default())
    }

    /// The same within a limit of memory: what does not fit is refused before it is read. What was read stays held as long as there is the limit.
    pub fn within(n_bytes: u64, memory: &Memory) -> Reader {
        let memory = memory.clone();
        Reader { n_bytes, n_seen: 0, memory, again: None, stage: Stage::Head(Vec::new()), failed: None }
    }

    /// Lets the facets of a binary STL stay in its file, where they would take more than half of the memory that is left: they are read again
    /// whenever they are looked at. `name` is that of the file in errors.
    pub fn again(self, name: &str, file: Arc<dyn ReadAt>) -> Reader {
        Reader { again: Some(Again { name: name.to_string(), file }), ..self }
    }

    /// Takes the next bytes of the file: any number, also none. After an error every later call returns it again.
    ///
    /// # Errors
    /// - `stl-truncated`: a binary header announces more facets than the file has room for.
    /// - `stl-count`: a binary header announces far fewer facets than the file has room for.
    /// - `stl-empty`: a binary header announces no facet.
    /// - `stl-not-stl`: the bytes are of no format that can be read.
    /// - `stl-syntax`: an ASCII line breaks the grammar; the message names the line.
    /// - `stl-not-finite`: a corner is NaN, infinite or beyond f32; the message names facet and line or byte.
    /// - `too-many-facets`: more facets than a 32-bit index counts.
    /// - `memory`: the facets do not fit the memory, or what is allowed of it.
    /// - `io`: more bytes came than were announced.
    pub fn push(&mut self, chunk: &[u8]) -> Result<()> {
        if let Some(error) = &self.failed {
            return Err(error.clone());
        }
        let result = self.take(chunk);
        self.failed = result.clone().err();
        result
    }

    /// Ends the file and returns what it held.
    ///
    /// # Errors
    /// - those of [`Reader::push`];
    /// - `stl-empty`: the file holds no facet;
    /// - `stl-truncated`: an ASCII file ends inside a facet;
    /// - `stl-count`: after the facets that a binary header announces there are more that look like facets;
    /// - `file-syntax`: an OBJ, OFF, PLY, 3MF or GLB file is wrong at the named place, or one that is packed cannot be unpacked;
    /// - `io`: fewer bytes came than were announced.
    pub fn finish(mut self) -> Result<Contents> {
        if let Some(error) = self.failed {
            return Err(error);
        }
        if self.n_seen < self.n_bytes {
            return Err(changed(self.n_bytes, &format!("only {} came", self.n_seen)));
        }
        if let Stage::Head(head) = &mut self.stage {
            let head = std::mem::take(head);
            self.stage = open(&head, self.n_bytes, (&self.memory, self.again.take()))?;
        }
        match self.stage {
            Stage::Binary(parser) => parser.finish(),
            Stage::Ascii(parser) => parser.finish(self.n_bytes),
            Stage::Whole(parser) => match parser.packed() {
                Some(packed) => unpacked(packed, self.n_bytes, &self.memory),
                None => parser.finish(self.n_bytes),
            },
            Stage::Head(_) => Err(contents::empty("the file was never opened")),
        }
    }

    fn take(&mut self, mut chunk: &[u8]) -> Result<()> {
        self.n_seen += chunk.len() as u64;
        if self.n_seen > self.n_bytes {
            return Err(changed(self.n_bytes, &format!("at least {} came", self.n_seen)));
        }
        if let Stage::Head(head) = &mut self.stage {
            let n_missing = (sniff::HEAD - head.len()).min(chunk.len());
            head.extend_from_slice(&chunk[..n_missing]);
            chunk = &chunk[n_missing..];
            if head.len() < sniff::HEAD && self.n_seen < self.n_bytes {
                return Ok(());
            }
            let head = std::mem::take(head);
            self.stage = open(&head, self.n_bytes, (&self.memory, self.again.take()))?;
        }
        match &mut self.stage {
            Stage::Binary(parser) => parser.push(chunk),
            Stage::Ascii(parser) => parser.push(chunk),
            Stage::Whole(parser) => parser.push(chunk),
            Stage::Head(_) => Ok(()),
        }
    }
}

/// Chooses the parser by the first bytes and gives them to it.
fn open(head: &[u8], n_bytes: u64, (memory, again): (&Memory, Option<Again>)) -> Result<Stage> {
    let format = sniff::format(head, n_bytes)?;
    if !matches!(format, Format::StlBinary | Format::StlAscii) {
        let mut parser = whole::Parser::new(format, n_bytes, memory)?;
        parser.push(head)?;
        return Ok(Stage::Whole(parser));
    }
    if format == Format::StlBinary {
        let mut parser = Box::new(stl_binary::Parser::new(head, n_bytes, (memory, again))?);
        parser.push(&head[stl_record::HEADER..])?;
        return Ok(Stage::Binary(parser));
    }
    let mut parser = Box::new(stl_ascii::Parser::within(memory));
    parser.push(head)?;
    Ok(Stage::Ascii(parser))
}

/// Reads what is packed; the length of the contents stays that of the file. It is unpacked twice and never held: a reader must know the
/// length before, and an STL of text takes more room than its facets.
fn unpacked(packed: &[u8], n_bytes: u64, memory: &Memory) -> Result<Contents> {
    let mut n_unpacked = 0;
    whole::each_chunk(packed, |chunk| {
        if n_unpacked == 0 && chunk.starts_with(b"\x1f\x8b") {
            let message = "the file is packed by gzip twice";
            return Err(Error::new("file-syntax", message, "unpack it first (gunzip)"));
        }
        n_unpacked += chunk.len() as u64;
        if n_unpacked > whole::MAX_UNPACKED {
            let message = format!("more than {} bytes are packed in a file of {n_bytes}", whole::MAX_UNPACKED);
            return Err(Error::new("memory", message, "unpack it first (gunzip)"));
        }
        Ok(())
    })?;
    let mut reader = Reader::within(n_unpacked, memory);
    let read = whole::each_chunk(packed, |chunk| reader.push(chunk)).and_then(|()| reader.finish());
    let contents = read.map_err(|error| error.at("what is packed"))?;
    Ok(Contents { n_bytes, ..contents })
}

fn changed(n_bytes: u64, came: &str) -> Error {
    let message = format!("{n_bytes} bytes were announced, {came}: the file changed while it was read");
    Error::new("io", message, "read it again when nothing writes to it")
}

/// Reads a file that is in memory.
///
/// # Errors
/// Those of [`Reader::push`] and [`Reader::finish`].
pub fn read_bytes(bytes: &[u8]) -> Result<Contents> {
    let mut reader = Reader::new(bytes.len() as u64);
    reader.push(bytes)?;
    reader.finish()
}

#[cfg(test)]
mod tests;
