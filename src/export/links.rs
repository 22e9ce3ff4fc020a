//! Links from cells to surfaces as HDF5: a list for each array of the `.npz`. `docs/links.md` describes them.

use std::path::Path;

use rust_hdf5::{FileLocking, H5File, H5Type};

use super::hdf5::{Table, finish, wrong};
use crate::error::Result;
use crate::links::{Link, Links};
use crate::write::Compress;

/// Writes links to a file, which need not be there.
///
/// # Errors
/// `io` where the file cannot be written.
pub fn write_links_hdf5(links: &Links, place: &Path, compress: Compress) -> Result<()> {
    // the caller may hold a lock of its own
    let file = H5File::options().locking(FileLocking::Disabled).create(place).map_err(wrong)?;
    let directions = links.stencil.directions();
    rows(&file, ("directions", directions.len(), 3), directions, compress)?;
    rows(&file, ("dims", 3, 1), links.dims.map(|n| [n]), compress)?;
    rows(&file, ("origin", 3, 1), links.origin.map(|n| [n]), compress)?;
    rows(&file, ("fluid", links.fluid.len(), 1), links.fluid.iter().map(|&flag| [flag]), compress)?;
    let list = Lists { file: &file, links, compress };
    list.put("x", |link| link.cell[0])?;
    list.put("y", |link| link.cell[1])?;
    list.put("z", |link| link.cell[2])?;
    list.put("direction", |link| link.direction)?;
    list.put("q", |link| link.q)?;
    list.put("facet", |link| link.facet)?;
    list.put("geometry", |link| link.geometry)?;
    list.put("flag", |link| link.flag)?;
    finish(file)
}

/// Lists of an item a link.
struct Lists<'a> {
    file: &'a H5File,
    links: &'a Links,
    compress: Compress,
}

impl Lists<'_> {
    fn put<T: H5Type>(&self, name: &str, of: impl Fn(&Link) -> T) -> Result<()> {
        rows(self.file, (name, self.links.len(), 1), self.links.iter().map(|link| [of(link)]), self.compress)
    }
}

fn rows<T: H5Type, const N: usize>(
    file: &H5File,
    (name, n, width): (&str, usize, usize),
    rows: impl IntoIterator<Item = [T; N]>,
    compress: Compress,
) -> Result<()> {
    let mut table = Table::new(file, name, n, width, compress)?;
    rows.into_iter().try_for_each(|row| table.push(&row))?;
    table.finish()
}
