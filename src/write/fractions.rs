//! The fractions of cells that surfaces cut, as `.npz`. `docs/fractions.md` describes it.

use std::io;

use super::{Compress, Sink, archive};
use crate::error::{Error, Result};
use crate::fractions::Fractions;

/// Writes a NumPy archive of the arrays `cell`, `flag` and `fraction`, an entry for each fraction, and `dims`. Returns the number of bytes.
///
/// # Errors
/// `io` where `out` fails.
pub fn write_fractions(fractions: &Fractions, compress: Compress, out: &mut dyn io::Write) -> Result<u64> {
    let mut sink = Sink { out, n_bytes: 0, hash: None };
    let (n, all) = (fractions.len(), || fractions.iter());
    archive::write(compress, &mut sink, |arrays| {
        arrays.list(("dims", "<u4"), (3, fractions.dims.iter()), |n| n.to_le_bytes())?;
        arrays.list(("cell", "<u8"), (n, all()), |fraction| fraction.cell.to_le_bytes())?;
        arrays.list(("flag", "|u1"), (n, all()), |fraction| [fraction.flag])?;
        arrays.list(("fraction", "<f4"), (n, all()), |fraction| fraction.fraction.to_le_bytes())
    })?;
    sink.out.flush().map_err(|error| Error::io("writing the fractions", error))?;
    Ok(sink.n_bytes)
}
