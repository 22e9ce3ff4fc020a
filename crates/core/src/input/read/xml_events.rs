//! XML as it is unpacked, an event at a time. The room of an event is counted: a few packed bytes may be a tag or a text of any length.

use std::io::{self, BufRead, Read};

use quick_xml::Reader;
use quick_xml::events::Event;

use super::text::shown;
use crate::base::error::{Error, Result};
use crate::base::memory::{Held, Memory};

/// Bytes of the buffer of events that are kept for the next.
const KEPT: usize = 1 << 16;
/// What a byte of an event takes while the buffer grows, and its attributes are read.
const COPIES: u64 = 5;

/// The error of a 3MF that is not as it must be.
pub(super) fn wrong(what: &str) -> Error {
    Error::new("file-syntax", format!("3MF: {what}"), "export the model again, or as STL")
}

/// The events of a text.
pub(super) struct Events<'a> {
    reader: Reader<Metered<'a>>,
    buffer: Vec<u8>,
}

impl<'a> Events<'a> {
    pub(super) fn new(text: &'a mut dyn BufRead, memory: &Memory) -> Events<'a> {
        let metered = Metered { text, n_bytes: 0, held: Held::of(memory), n_held: 0, refused: None };
        Events { reader: Reader::from_reader(metered), buffer: Vec::new() }
    }

    /// The next event, and the byte at which it ends.
    ///
    /// # Errors
    /// `file-syntax`; `memory` where it does not fit.
    pub(super) fn next(&mut self) -> Result<(Event<'_>, u64)> {
        let Events { reader, buffer } = self;
        buffer.clear();
        buffer.shrink_to(KEPT);
        reader.get_mut().begin();
        match reader.read_event_into(buffer) {
            Ok(event) => Ok((event, reader.buffer_position())),
            Err(error) => {
                let at = reader.buffer_position();
                let refused = reader.get_mut().refused.take();
                Err(refused.unwrap_or_else(|| wrong(&format!("byte {at}: {}", shown(&error.to_string(), 150)))))
            }
        }
    }
}

/// A text whose bytes are counted from one event to the next.
struct Metered<'a> {
    text: &'a mut dyn BufRead,
    n_bytes: u64,
    held: Held,
    n_held: u64,
    refused: Option<Error>,
}

impl Metered<'_> {
    fn begin(&mut self) {
        self.n_bytes = 0;
        self.held.shrink(std::mem::take(&mut self.n_held));
    }
}

impl Read for Metered<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let n = self.fill_buf()?.read(out)?;
        self.consume(n);
        Ok(n)
    }
}

impl BufRead for Metered<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.n_bytes > KEPT as u64 && COPIES * self.n_bytes >= self.n_held {
            // twice as much, so that it is seldom asked for
            let more = COPIES * 2 * self.n_bytes - self.n_held;
            if let Err(error) = self.held.grow(more, "a tag or a text of its XML") {
                self.refused = Some(error);
                return Err(io::Error::other("refused"));
            }
            self.n_held += more;
        }
        self.text.fill_buf()
    }

    fn consume(&mut self, n: usize) {
        self.n_bytes += n as u64;
        self.text.consume(n);
    }
}
