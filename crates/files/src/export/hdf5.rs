//! HDF5 files: attributes, lists of strings, and datasets that are filled from their first item to their last.
//!
//! Natively (`on_disk`) by crate `rust-hdf5`: it writes chunk by chunk to a path, and so needs a file system. In wasm (`in_memory`) by `hdf5-pure`,
//! which needs none, but takes whole datasets: a file is held, up to a limit. Neither can do both: `rust-hdf5` knows `std::fs::File` alone, and
//! `hdf5-pure` appends to lists on disk only. Both modules have the same types and functions, so exporters are written once.

#[cfg(any(target_arch = "wasm32", test))]
pub(super) mod in_memory;
#[cfg(not(target_arch = "wasm32"))]
pub(super) mod on_disk;

#[cfg(target_arch = "wasm32")]
pub(super) use in_memory::{File, Item, Table};
#[cfg(not(target_arch = "wasm32"))]
pub(super) use on_disk::{File, Item, Table};

use crate::write::Compress;
use hexcast_core::base::error::Error;

/// Bytes of a chunk, about: readers hold 1 MiB of chunks by default.
const CHUNK_BYTES: usize = 1 << 19;

/// What a dataset is like.
#[derive(Clone, Copy)]
pub(super) struct Shape<'a> {
    pub(super) name: &'a str,
    /// Lengths of its axes, the last one fastest.
    pub(super) dims: &'a [usize],
    pub(super) compress: Compress,
}

impl Shape<'_> {
    /// The lengths of a chunk of items of so many bytes: whole rows of the last axes, as many as fit.
    fn chunk(&self, item_bytes: usize) -> Vec<usize> {
        let mut n_bytes = item_bytes;
        let mut chunk: Vec<usize> = self
            .dims
            .iter()
            .rev()
            .map(|&n| {
                let n = (CHUNK_BYTES / n_bytes).clamp(1, n.max(1));
                n_bytes *= n;
                n
            })
            .collect();
        chunk.reverse();
        chunk
    }
}

fn failed(error: impl std::fmt::Display) -> Error {
    let error = error.to_string();
    // what the system says, without the layers that it came through
    let said = error.rsplit("I/O error: ").next().unwrap_or_default();
    Error::io("writing HDF5", std::io::Error::other(said))
}

#[cfg(test)]
mod tests;
