//! The output of a writer.

use std::io;

use sha2::{Digest, Sha256};

use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::parallel::beside;

/// The output of a writer, which counts and, where asked, hashes what passes.
#[doc(hidden)]
pub struct Sink<'a> {
    pub(super) out: &'a mut dyn io::Write,
    pub(super) n_bytes: u64,
    pub(super) hash: Option<Sha256>,
    /// What is written, for errors.
    pub(super) what: &'static str,
}

impl<'a> Sink<'a> {
    /// Counts what passes; errors call it `what`.
    #[doc(hidden)]
    pub fn new(out: &'a mut dyn io::Write, what: &'static str) -> Sink<'a> {
        Sink { out, n_bytes: 0, hash: None, what }
    }

    /// Writes all bytes.
    ///
    /// # Errors
    /// `io`.
    pub(crate) fn put(&mut self, bytes: &[u8]) -> Result<()> {
        let out = &mut self.out;
        let done = match &mut self.hash {
            None => out.write_all(bytes),
            // hashing takes as long as writing: beside it
            Some(hash) => beside(|| hash.update(bytes), || out.write_all(bytes)),
        };
        done.map_err(|error| self.failed(error))?;
        self.n_bytes += bytes.len() as u64;
        Ok(())
    }

    /// Writes what is still held back; the number of bytes.
    ///
    /// # Errors
    /// `io`.
    #[doc(hidden)]
    pub fn finish(self) -> Result<u64> {
        self.out.flush().map_err(|error| self.failed(error))?;
        Ok(self.n_bytes)
    }

    fn failed(&self, error: io::Error) -> Error {
        Error::io(format!("writing {}", self.what), error)
    }
}
