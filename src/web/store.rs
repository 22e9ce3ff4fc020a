//! A Zarr store for JavaScript: a ZIP archive of its files.

use std::rc::Rc;

use super::resting::Resting;
use crate::base::error::{Error, Result};
use crate::derived::mesh::Mesh;
use crate::output::measured::Measured;
use crate::output::write::solid::cells_of_store;
use crate::output::write::store::{OfCells, Place, Store};
use crate::output::write::{Options, Sink};

/// Most bytes of the numbers of a row of chunks, which is held whole, twice: wasm has 4 GiB.
const MAX_ROW: u64 = 1 << 29;

/// Starts the store of the flags of a mesh, or of the fractions that were measured.
pub(super) fn store_work(mesh: Rc<Mesh>, fractions: Option<Rc<Measured>>, options: Options) -> Result<Resting> {
    let n_bytes = store_of(&mesh, fractions.as_deref(), &options)?.row_bytes();
    if n_bytes > MAX_ROW {
        let message = format!("zarr: a row of chunks has {n_bytes} bytes, and at most {MAX_ROW} are held here");
        return Err(Error::new("memory", message, "ask for smaller chunks with the key zarr.chunks of the job"));
    }
    Ok(Resting::new(1, |mut out, control| async move {
        let files = store_of(&mesh, fractions.as_deref(), &options)?;
        files.zip(&mut Sink::new(&mut out, "the mesh"), &control).await
    }))
}

fn store_of<'a>(mesh: &'a Mesh, fractions: Option<&'a Measured>, options: &Options) -> Result<Store<'a>> {
    let cells = match fractions {
        Some(measured) => cells_of_store(mesh, measured.fractions()?)?,
        None => OfCells::flags(),
    };
    Store::new(mesh, &Place::of_whole(mesh), cells, options)
}
