//! Links from cells to surfaces as HDF5: a list for each array of the `.npz`. `docs/links.md` describes them.

use super::hdf5::{File, Item, Shape, Table};
use super::output::Files;
use crate::write::Compress;
use hexcast_core::base::error::Result;
use hexcast_derived::links::{Link, Links};

/// Bytes of a link.
const LINK_BYTES: u64 = 24;

/// Writes links to a file, which need not be there.
///
/// # Errors
/// `io` where the file cannot be written.
#[cfg(not(target_arch = "wasm32"))]
pub fn write_links_hdf5(links: &Links, place: &std::path::Path, compress: Compress) -> Result<()> {
    write(links, "", compress, &mut At(place))
}

/// The place of the only file.
#[cfg(not(target_arch = "wasm32"))]
struct At<'a>(&'a std::path::Path);

#[cfg(not(target_arch = "wasm32"))]
impl Files for At<'_> {
    fn create(&mut self, _: &str) -> Result<Box<dyn std::io::Write + '_>> {
        Err(super::output::failed(std::io::Error::other("HDF5 is written to a path")))
    }

    fn place(&mut self, _: &str) -> Result<std::path::PathBuf> {
        Ok(self.0.to_path_buf())
    }
}

/// Writes links to a file of these.
pub fn write(links: &Links, name: &str, compress: Compress, files: &mut dyn Files) -> Result<()> {
    let mut list = Lists { file: File::create(files, name, LINK_BYTES * links.len() as u64)?, links, compress };
    let directions = links.stencil.directions();
    list.put("directions", &[directions.len(), 3], directions.as_flattened())?;
    list.put("dims", &[3], &links.dims)?;
    list.put("origin", &[3], &links.origin)?;
    list.put("fluid", &[links.fluid.len()], &links.fluid)?;
    list.put_each("x", |link| link.cell[0])?;
    list.put_each("y", |link| link.cell[1])?;
    list.put_each("z", |link| link.cell[2])?;
    list.put_each("direction", |link| link.direction)?;
    list.put_each("q", |link| link.q)?;
    list.put_each("facet", |link| link.facet)?;
    list.put_each("geometry", |link| link.geometry)?;
    list.put_each("flag", |link| link.flag)?;
    list.file.finish(files)
}

/// Lists of an item a link.
struct Lists<'a> {
    file: File,
    links: &'a Links,
    compress: Compress,
}

impl Lists<'_> {
    fn put<T: Item>(&mut self, name: &str, dims: &[usize], items: &[T]) -> Result<()> {
        let mut table = Table::new(&mut self.file, Shape { name, dims, compress: self.compress })?;
        table.push(items)?;
        table.finish(&mut self.file)
    }

    fn put_each<T: Item>(&mut self, name: &str, of: impl Fn(&Link) -> T) -> Result<()> {
        let shape = Shape { name, dims: &[self.links.len()], compress: self.compress };
        let mut table = Table::new(&mut self.file, shape)?;
        self.links.iter().try_for_each(|link| table.push(&[of(link)]))?;
        table.finish(&mut self.file)
    }
}
