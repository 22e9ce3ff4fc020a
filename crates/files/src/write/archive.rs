//! A ZIP archive of NumPy arrays, as `numpy.savez` writes them: what `.npz` files are.
//!
//! Arrays -> bytes, piece by piece, with rests between them for callers that take them one by one. Entries are stored, or
//! deflated. Sizes follow the data, so that nothing is written twice, and are 64-bit from 4 GiB on.
//! Source: NumPy's `numpy.lib.npyio`, PKWARE's APPNOTE. Cost: a piece of memory; 1 MiB a core where they are deflated.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::io::{self, Write};
use std::rc::Rc;

use flate2::Crc;
use rawzip::path::EntryPath;
use rawzip::time::UtcDateTime;
use rawzip::{CompressionMethod, DataDescriptorOutput, ZipArchiveWriter, ZipEntryWriter};

use super::{Compress, Sink, npy};
use hexcast_core::base::control::{Control, at_once};
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::zlib::Deflate;

/// Items of a list that are laid out at a time.
const AT_ONCE: usize = 1 << 16;
/// Bytes that pass through an archive at a time.
const BYTES_AT_ONCE: usize = 1 << 18;
/// Mode of every file: a file that its owner may write and all may read.
const OF_FILES: u32 = 0o100_644;
/// Time of every file, the first that archives can have: 1980-01-01.
const FIRST_DAY: i64 = 315_532_800;
/// Comment of deflated files. With it the directory has no second record where readers that go back by its length from the end look for the
/// first, such as the crate `zip`: 76 bytes too far, if a file of 4 GiB makes an archive of less, whose end is 64-bit.
const COMMENT: &str = "written by hexcast";

/// An array, which is made piece by piece.
pub struct Array<'a> {
    name: &'a str,
    kind: &'a str,
    shape: Vec<u64>,
    n_pieces: usize,
    piece: Box<dyn Fn(usize) -> Result<Vec<u8>> + 'a>,
}

impl<'a> Array<'a> {
    /// An array of as many pieces, each of which `piece` makes.
    pub(super) fn new(
        (name, kind): (&'a str, &'a str),
        shape: &[u64],
        n_pieces: usize,
        piece: impl Fn(usize) -> Result<Vec<u8>> + 'a,
    ) -> Array<'a> {
        Array { name, kind, shape: shape.to_vec(), n_pieces, piece: Box::new(piece) }
    }

    /// An array of an item each of a list.
    pub(super) fn of_list<T>(named: (&'a str, &'a str), list: &'a [T], put: Put<T>) -> Array<'a> {
        let chunk = move |index: usize| &list[index * AT_ONCE..list.len().min((index + 1) * AT_ONCE)];
        Array::new(named, &[list.len() as u64], list.len().div_ceil(AT_ONCE), move |index| {
            Ok(laid_out(chunk(index), put))
        })
    }

    /// An array of an item each of a list in parts.
    pub(super) fn of_parts<P, T: 'a>(
        named: (&'a str, &'a str),
        parts: &'a [P],
        list: fn(&P) -> &[T],
        put: Put<T>,
    ) -> Array<'a> {
        let n = parts.iter().map(|part| list(part).len() as u64).sum::<u64>();
        Array::new(named, &[n], parts.len(), move |index| Ok(laid_out(list(&parts[index]), put)))
    }

    /// The same with so many numbers an item.
    pub(super) fn with_rows(mut self, of_row: u64) -> Array<'a> {
        self.shape.push(of_row);
        self
    }

    /// An array of a caller's, by its bytes: little-endian, the last axis fastest.
    ///
    /// # Errors
    /// `job-value` where type and shape are those of another number of bytes.
    pub fn of_bytes((name, kind): (&'a str, &'a str), shape: &[u64], bytes: &'a [u8]) -> Result<Array<'a>> {
        let chunk = move |index: usize| &bytes[index * BYTES_AT_ONCE..bytes.len().min((index + 1) * BYTES_AT_ONCE)];
        let n_pieces = bytes.len().div_ceil(BYTES_AT_ONCE);
        let array = Array::new((name, kind), shape, n_pieces, move |index| Ok(chunk(index).to_vec()));
        match array.n_bytes() == bytes.len() as u64 {
            true => Ok(array),
            false => Err(other_length(&array, bytes.len())),
        }
    }

    /// Its name in the archive.
    pub fn name(&self) -> &str {
        self.name
    }

    /// Its type as NumPy names it, such as `<f4`.
    pub fn kind(&self) -> &str {
        self.kind
    }

    /// Lengths of its axes, the last one fastest.
    pub fn shape(&self) -> &[u64] {
        &self.shape
    }

    /// Number of its bytes.
    pub fn n_bytes(&self) -> u64 {
        let of_item = self.kind.get(2..).and_then(|digits| digits.parse::<u64>().ok()).unwrap_or(0);
        self.shape.iter().fold(of_item, |product, n| product.saturating_mul(*n))
    }

    /// Puts all its bytes, little-endian, into memory of the caller's.
    ///
    /// # Errors
    /// `job-value` where that has another length; `io` where the array is made from what is in a store; `cancelled`, looked at before
    /// every piece.
    pub fn fill(&self, out: &mut [u8], control: &Control) -> Result<()> {
        let (mut at, n_bytes) = (0, out.len());
        self.for_each_piece(control, |piece| {
            let place = out.get_mut(at..at + piece.len()).ok_or_else(|| other_length(self, n_bytes))?;
            place.copy_from_slice(piece);
            at += piece.len();
            Ok(())
        })?;
        if at == n_bytes { Ok(()) } else { Err(other_length(self, n_bytes)) }
    }

    /// Hands all its bytes over, piece by piece.
    ///
    /// # Errors
    /// Those of `take`; `io` where the array is made from what is in a store; `cancelled`.
    pub(crate) fn for_each_piece(&self, control: &Control, mut take: impl FnMut(&[u8]) -> Result<()>) -> Result<()> {
        (0..self.n_pieces).try_for_each(|index| {
            control.check()?;
            take(&(self.piece)(index)?)
        })
    }

    /// All bytes of the array, without a header.
    ///
    /// # Errors
    /// `memory` where there is no room for them; `io` where it is made from what is in a store.
    #[cfg(target_arch = "wasm32")]
    pub fn bytes(&self) -> Result<Vec<u8>> {
        let n_bytes = self.n_bytes();
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(usize::try_from(n_bytes).unwrap_or(usize::MAX)).map_err(|_| {
            let message = format!("the array {} takes {n_bytes} bytes, for which wasm has no room", self.name);
            Error::new("memory", message, "save the .npz, which is written piece by piece, or use larger cells")
        })?;
        (0..self.n_pieces).try_for_each(|index| (self.piece)(index).map(|piece| bytes.extend(piece)))?;
        Ok(bytes)
    }

    fn header(&self) -> Vec<u8> {
        let shape = match self.shape[..] {
            [n] => format!("({n},)"),
            _ => format!("({})", self.shape.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")),
        };
        npy::header_of(self.kind, &shape)
    }
}

fn other_length(array: &Array, n_bytes: usize) -> Error {
    let Array { name, kind, shape, .. } = array;
    let message = format!("{n_bytes} bytes for the array {name}, which has the type {kind} and the shape {shape:?}");
    Error::new("job-value", message, "give as many bytes as the array has")
}

/// Lays out the bytes of an item behind others.
pub(super) type Put<T> = fn(&T, &mut Vec<u8>);

fn laid_out<T>(items: &[T], put: Put<T>) -> Vec<u8> {
    let mut bytes = Vec::new();
    for item in items {
        put(item, &mut bytes);
    }
    bytes
}

/// What an archive writes to, and its caller takes from.
#[derive(Clone, Default)]
pub struct Buffer(Rc<RefCell<Vec<u8>>>);

impl Buffer {
    /// What was written since the last time.
    pub fn take(&self) -> Vec<u8> {
        self.0.take()
    }
}

impl Write for Buffer {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0.borrow_mut().extend_from_slice(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

/// An archive while it is made, file by file.
pub struct Archive {
    zip: ZipArchiveWriter<Buffer>,
    made: Buffer,
    compress: Compress,
}

impl Archive {
    /// Begins an archive whose bytes go to a buffer.
    pub fn new(compress: Compress, made: Buffer) -> Archive {
        Archive { zip: ZipArchiveWriter::new(made.clone()), made, compress }
    }

    /// Begins a file.
    ///
    /// # Errors
    /// `io`, where its name is too long.
    pub fn file(&mut self, name: &str) -> Result<Entry<'_>> {
        // by its very name: of other paths rawzip drops what is before a colon
        let path = if name.is_ascii() { EntryPath::verbatim(name.as_bytes()) } else { EntryPath::conformant(name) };
        let new = self.zip.new_file(path).unix_permissions(OF_FILES);
        let new = match self.compress {
            Compress::None => new.compression_method(CompressionMethod::STORE),
            Compress::Zlib(_) => new.compression_method(CompressionMethod::DEFLATE).comment(COMMENT),
        };
        // the same bytes whenever they are written
        let new = new.last_modified(UtcDateTime::from_unix(FIRST_DAY));
        let (entry, _) = new.start().map_err(|error| failed(io::Error::other(error)))?;
        let packed = match self.compress {
            Compress::None => Packed::Stored(entry, Crc::new(), 0),
            Compress::Zlib(level) => Packed::Deflated(Deflate::new(entry, level)),
        };
        Ok(Entry { packed: Some(packed), made: self.made.clone() })
    }

    /// Begins an array.
    pub(super) fn begin(&mut self, name: &str, header: &[u8]) -> Result<Entry<'_>> {
        let mut entry = self.file(&format!("{name}.npy"))?;
        entry.write_all(header).map_err(failed)?;
        Ok(entry)
    }

    /// Writes an array to a sink; rests before every piece of it.
    pub(super) async fn add(&mut self, array: &Array<'_>, sink: &mut Sink<'_>, control: &Control) -> Result<()> {
        let mut entry = self.begin(array.name, &array.header())?;
        for index in 0..array.n_pieces {
            control.rest().await?;
            entry.pass(&(array.piece)(index)?, sink)?;
        }
        entry.end()
    }

    /// Ends the archive, and returns its last bytes.
    pub fn finish(self) -> Result<Vec<u8>> {
        self.zip.finish().map_err(|error| failed(io::Error::other(error)))?;
        Ok(self.made.take())
    }
}

/// A file of an archive while it is made. Dropped, it ends as well: its bytes go to a buffer, which takes them all.
pub struct Entry<'a> {
    /// None once it has ended.
    packed: Option<Packed<'a>>,
    made: Buffer,
}

/// Where the bytes of a file go, which are stored as they are, with their checksum and number, or deflated.
enum Packed<'a> {
    Stored(ZipEntryWriter<'a, Buffer>, Crc, u64),
    Deflated(Deflate<ZipEntryWriter<'a, Buffer>>),
}

impl Entry<'_> {
    /// Writes more of the file to a sink.
    pub(super) fn pass(&mut self, bytes: &[u8], sink: &mut Sink) -> Result<()> {
        bytes.chunks(BYTES_AT_ONCE).try_for_each(|some| {
            self.write_all(some).map_err(failed)?;
            sink.put(&self.made.take())
        })
    }

    /// Ends the file.
    pub(super) fn end(mut self) -> Result<()> {
        self.finish().map_err(failed)
    }

    fn finish(&mut self) -> io::Result<()> {
        let (entry, crc, n_bytes) = match self.packed.take() {
            None => return Ok(()),
            Some(Packed::Stored(entry, crc, n_bytes)) => (entry, crc.sum(), n_bytes),
            Some(Packed::Deflated(deflate)) => deflate.finish()?,
        };
        entry.finish(DataDescriptorOutput::new(crc, n_bytes)).map_err(io::Error::other)?;
        Ok(())
    }
}

impl Write for Entry<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match &mut self.packed {
            // it has ended
            None => Ok(0),
            Some(Packed::Stored(entry, crc, n_bytes)) => {
                let n = entry.write(bytes)?;
                crc.update(&bytes[..n]);
                *n_bytes += n as u64;
                Ok(n)
            }
            Some(Packed::Deflated(deflate)) => deflate.write(bytes),
        }
    }

    /// Hands nothing over: blocks that are deflated have their length.
    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Drop for Entry<'_> {
    fn drop(&mut self) {
        // nothing fails here, as said above
        let _ = self.finish();
    }
}

/// Writes a NumPy archive of arrays, `.npz`. Returns the number of bytes.
///
/// # Errors
/// `job-value` where two arrays have the same name, and for levels that zlib does not have; `io` where `out` fails, or an array is made from
/// what is in a store that does.
pub fn write_arrays(arrays: &[Array], compress: Compress, out: &mut dyn Write) -> Result<u64> {
    write_named(arrays, "the arrays", compress, out)
}

/// The same; errors call them `what`.
pub(super) fn write_named(
    arrays: &[Array],
    what: &'static str,
    compress: Compress,
    out: &mut dyn Write,
) -> Result<u64> {
    at_once(write_with_rests(arrays, what, compress, out, &Control::default()))
}

/// The same, with rests.
///
/// # Errors
/// Those of [`write_arrays`]; `cancelled`.
pub async fn write_with_rests(
    arrays: &[Array<'_>],
    what: &'static str,
    compress: Compress,
    out: &mut dyn Write,
    control: &Control,
) -> Result<u64> {
    let mut sink = Sink::new(out, what);
    compress.check()?;
    let mut names = BTreeSet::new();
    if let Some(twice) = arrays.iter().find(|array| !names.insert(array.name)) {
        let message = format!("two arrays have the name {}, and an archive has one of each", twice.name);
        return Err(Error::new("job-value", message, "give each array a name of its own"));
    }
    let mut archive = Archive::new(compress, Buffer::default());
    for array in arrays {
        archive.add(array, &mut sink, control).await?;
    }
    sink.put(&archive.finish()?)?;
    sink.finish()
}

fn failed(error: io::Error) -> Error {
    Error::io("writing the mesh", error)
}

#[cfg(test)]
mod tests {
    use std::io::Read;

    use super::*;

    #[test]
    fn the_bytes_do_not_depend_on_the_pieces_of_arrays() {
        let bytes: Vec<u8> = (0..700_000_u32).map(|n| (n.wrapping_mul(2_654_435_761) >> 27) as u8).collect();
        let written = |of_piece: usize| {
            let n_pieces = bytes.len().div_ceil(of_piece);
            let piece = |index: usize| Ok(bytes[index * of_piece..bytes.len().min((index + 1) * of_piece)].to_vec());
            let array = Array::new(("a", "|u1"), &[bytes.len() as u64], n_pieces, piece);
            let mut out = Vec::new();
            write_arrays(&[array], Compress::Zlib(6), &mut out).unwrap();
            out
        };
        let whole = written(bytes.len());
        assert!(whole.len() < bytes.len());
        for of_piece in [1000, 65_537, BYTES_AT_ONCE, BYTES_AT_ONCE + 1] {
            assert!(written(of_piece) == whole, "pieces of {of_piece} bytes");
        }
    }

    #[test]
    fn arrays_of_bytes_have_as_many_as_their_shape_says() {
        let array = Array::of_bytes(("a", "<f4"), &[2, 3], &[7; 24]).unwrap();
        let mut out = [0; 24];
        array.fill(&mut out, &Control::default()).unwrap();
        assert_eq!((out, array.n_bytes()), ([7; 24], 24));
        assert_eq!(array.fill(&mut [0; 25], &Control::default()).unwrap_err().code(), "job-value");
        assert_eq!(array.fill(&mut [0; 23], &Control::default()).unwrap_err().code(), "job-value");
        assert!(Array::of_bytes(("a", "<f4"), &[2, 3], &[7; 23]).is_err());
    }

    #[test]
    fn two_arrays_of_a_name_and_unknown_levels_are_refused() {
        let array = || Array::of_bytes(("a", "|u1"), &[1], &[7]).unwrap();
        for (arrays, compress) in [(vec![array(), array()], Compress::None), (vec![array()], Compress::Zlib(10))] {
            let error = write_arrays(&arrays, compress, &mut Vec::new()).unwrap_err();
            assert_eq!(error.code(), "job-value", "{error}");
        }
    }

    /// As exporters write them: each file is dropped before the next.
    #[test]
    fn files_that_are_dropped_are_whole() {
        for compress in [Compress::None, Compress::Zlib(6)] {
            let made = Buffer::default();
            let mut archive = Archive::new(compress, made.clone());
            let files = [("a/b", vec![1; 300_000]), ("a:c", vec![]), ("\u{e9}", vec![2; 3])];
            for (name, bytes) in &files {
                archive.file(name).unwrap().write_all(bytes).unwrap();
            }
            let bytes = [made.take(), archive.finish().unwrap()].concat();
            let mut archive = zip::ZipArchive::new(io::Cursor::new(bytes)).unwrap();
            assert_eq!(archive.len(), files.len());
            for (name, bytes) in files {
                let mut file = archive.by_name(name).unwrap();
                let mut found = Vec::new();
                file.read_to_end(&mut found).unwrap();
                assert!(found == bytes, "{name}");
                assert_eq!(file.unix_mode(), Some(OF_FILES));
                assert_eq!(file.last_modified(), Some(zip::DateTime::default()));
            }
        }
    }
}
