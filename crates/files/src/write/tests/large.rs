//! Files of more bytes than 32 bits count.

use std::io::{Cursor, Read, Seek, SeekFrom};

use super::super::*;
use hexcast_core::cells::columns::{Band, Columns, run};
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::rays::Rays;
use hexcast_core::set;

/// A sink that counts all bytes and keeps the first and the last of them.
#[derive(Default)]
struct Ends {
    n_bytes: u64,
    first: Vec<u8>,
    last: Vec<u8>,
}

/// Bytes that [`Ends`] keeps on each side.
const KEPT: usize = 2000;

impl std::io::Write for Ends {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.n_bytes += bytes.len() as u64;
        let missing = (KEPT - self.first.len()).min(bytes.len());
        self.first.extend_from_slice(&bytes[..missing]);
        self.last.extend_from_slice(&bytes[bytes.len().saturating_sub(KEPT)..]);
        let excess = self.last.len().saturating_sub(KEPT);
        self.last.drain(..excess);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

#[test]
fn files_of_more_than_4_gib_end_as_they_should() {
    // 4.6e9 cells; the last of them alone is flagged
    let dims = [1 << 20, 66, 67];
    let rays = Rays::new(0, dims);
    let n_rays = rays.n_rays() as usize;
    let ends = (0..n_rays).map(|ray| u32::from(ray + 1 == n_rays)).collect();
    let runs = vec![run(dims[0] - 1, 1)];
    let columns = Columns::new(rays, vec![set!(Band { ends, runs, ..Band::default() })]).unwrap();
    let lines = Lines::new([0.0; 3], [1.0; 3], dims).unwrap();
    let mesh = Mesh::new(lines, columns, vec![], None).unwrap();
    let n_cells = mesh.n_cells();
    assert!(n_cells > 1 << 32);
    for (format, bits) in [(Format::Vti, false), (Format::Npy, false), (Format::Raw, true)] {
        let options = Options { bits, ..Options::default() };
        let mut out = Ends::default();
        let written = write(&mesh, format, &options, &mut out, &Control::default()).unwrap();
        assert_eq!(Some(out.n_bytes), exact_size(&mesh, format, &options), "{format:?}");
        assert_eq!(written.n_bytes, out.n_bytes);
        let (before, after) = around(&mesh, format, &options).unwrap().unwrap();
        assert_eq!(out.first[..before.len()], before, "{format:?}");
        let flags = &out.last[..KEPT - after.len()];
        assert_eq!(out.last[flags.len()..], after, "{format:?}");
        assert_eq!(flags.iter().position(|&flag| flag != 0), Some(flags.len() - 1), "{format:?}");
        assert_eq!(flags[flags.len() - 1], if bits { 0x80 } else { 1 }, "{format:?}");
        if format == Format::Vti {
            // the length of the appended data is a 64-bit number
            assert_eq!(before[before.len() - 8..], n_cells.to_le_bytes());
        }
    }
}

/// What was written to an [`Ends`], with zeros for all that it has not kept.
struct Kept {
    of: Ends,
    at: u64,
}

impl Read for Kept {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        let Ends { n_bytes, first, last } = &self.of;
        let (n_first, from_last) = (first.len() as u64, n_bytes - last.len() as u64);
        let (from, end) = match self.at {
            at if at < n_first => (Some(&first[at as usize..]), n_first),
            at if at < from_last => (None, from_last),
            at => (Some(&last[(at - from_last) as usize..]), *n_bytes),
        };
        let n = out.len().min((end - self.at) as usize);
        match from {
            Some(from) => out[..n].copy_from_slice(&from[..n]),
            None => out[..n].fill(0),
        }
        self.at += n as u64;
        Ok(n)
    }
}

impl Seek for Kept {
    fn seek(&mut self, to: SeekFrom) -> std::io::Result<u64> {
        self.at = match to {
            SeekFrom::Start(at) => at,
            SeekFrom::End(by) => self.of.n_bytes.saturating_add_signed(by),
            SeekFrom::Current(by) => self.at.saturating_add_signed(by),
        };
        Ok(self.at)
    }
}

#[test]
fn archives_of_more_than_4_gib_are_read() {
    let (n_pieces, of_piece) = (257, 1 << 24);
    let n_bytes = (n_pieces * of_piece) as u64;
    let written = |compress, out: &mut dyn std::io::Write| {
        let large = Array::new(("large", "|u1"), &[n_bytes], n_pieces, |_| Ok(vec![0; of_piece]));
        let small = Array::of_bytes(("small", "|u1"), &[3], &[1, 2, 3]).unwrap();
        write_arrays(&[large, small], compress, out).unwrap()
    };
    let mut stored = Ends::default();
    assert_eq!(written(Compress::None, &mut stored), stored.n_bytes);
    let mut stored = zip::ZipArchive::new(Kept { of: stored, at: 0 }).unwrap();
    holds_both(&mut stored, n_bytes);
    // to its end, where its checksum is compared
    let read = std::io::copy(&mut stored.by_name("large.npy").unwrap(), &mut std::io::sink());
    assert_eq!(read.unwrap(), 128 + n_bytes);
    // the record of `large.npy` has 76 bytes, but for its comment
    let mut deflated = Vec::new();
    assert!(written(Compress::Zlib(1), &mut deflated) < n_bytes / 50);
    holds_both(&mut zip::ZipArchive::new(Cursor::new(deflated)).unwrap(), n_bytes);
}

fn holds_both(archive: &mut zip::ZipArchive<impl Read + Seek>, n_bytes: u64) {
    assert_eq!(archive.by_name("large.npy").unwrap().size(), 128 + n_bytes);
    let mut bytes = Vec::new();
    archive.by_name("small.npy").unwrap().read_to_end(&mut bytes).unwrap();
    assert_eq!(bytes[128..], [1, 2, 3]);
}
