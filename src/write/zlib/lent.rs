//! zlib by somebody else: the core knows no browser.

use std::cell::OnceCell;
use std::io;

/// The library's functions, by whoever has them.
pub(crate) trait Zlib {
    /// Compresses bytes to one zlib stream; level 1 to 9.
    fn deflate(&self, bytes: &[u8], level: u8) -> io::Result<Vec<u8>>;

    /// Expands a zlib stream to at most `most` bytes; a stream that goes on is cut there.
    fn inflate(&self, stream: &[u8], most: u64) -> io::Result<Vec<u8>>;
}

thread_local! {
    static LENT: OnceCell<Box<dyn Zlib>> = const { OnceCell::new() };
}

/// Takes the library for all that comes; one that was taken before stays.
pub(crate) fn lend(zlib: impl Zlib + 'static) {
    LENT.with(|lent| lent.set(Box::new(zlib)).ok());
}

fn ask(act: impl FnOnce(&dyn Zlib) -> io::Result<Vec<u8>>) -> io::Result<Vec<u8>> {
    LENT.with(|lent| act(&**lent.get().ok_or_else(|| io::Error::other("zlib is not loaded"))?))
}

/// Compresses bytes to one zlib stream; level 1 to 9.
///
/// # Errors
/// Those of the lender, or that there is none.
pub(crate) fn deflate(bytes: &[u8], level: u8) -> io::Result<Vec<u8>> {
    ask(|zlib| zlib.deflate(bytes, level))
}

/// Expands a zlib stream to at most `most` bytes; a stream that goes on is cut there.
///
/// # Errors
/// Those of the lender, or that there is none.
pub(crate) fn inflate(stream: &[u8], most: u64) -> io::Result<Vec<u8>> {
    ask(|zlib| zlib.inflate(stream, most))
}
