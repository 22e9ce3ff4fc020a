//! What was measured as HDF5: a dataset for each array of the `.npz`, of the same name, type and order. `docs/links.md` and `docs/distance.md` describe them.

use super::hdf5::{File, Item, Shape, Table};
use super::output::Files;
use crate::write::{Array, Compress};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};

/// Writes arrays to a file at a path, which need not be there.
///
/// # Errors
/// `io` where the file cannot be written, or an array is made from what is in a store that fails; `cancelled`.
#[cfg(not(target_arch = "wasm32"))]
pub fn write_arrays_hdf5(
    arrays: &[Array],
    place: &std::path::Path,
    compress: Compress,
    control: &Control,
) -> Result<()> {
    write(arrays, "", compress, &mut At(place), control)
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

/// Writes arrays to a file of these.
pub fn write(arrays: &[Array], name: &str, compress: Compress, files: &mut dyn Files, control: &Control) -> Result<()> {
    let mut file = File::create(files, name, arrays.iter().map(Array::n_bytes).sum())?;
    for array in arrays {
        let to = (&mut file, compress, control);
        match array.kind() {
            "|u1" => put(array, to, u8::from_le_bytes),
            "|i1" => put(array, to, i8::from_le_bytes),
            "<i2" => put(array, to, i16::from_le_bytes),
            "<i4" => put(array, to, i32::from_le_bytes),
            "<u4" => put(array, to, u32::from_le_bytes),
            "<u8" => put(array, to, u64::from_le_bytes),
            "<f4" => put(array, to, f32::from_le_bytes),
            "<f8" => put(array, to, f64::from_le_bytes),
            kind => Err(Error::new("job-value", format!("HDF5 of an array of type {kind}"), "write .npz")),
        }?;
    }
    file.finish(files)
}

/// Writes a dataset of numbers of so many bytes.
fn put<T: Item, const N: usize>(
    array: &Array,
    (file, compress, control): (&mut File, Compress, &Control),
    of_bytes: fn([u8; N]) -> T,
) -> Result<()> {
    let dims: Vec<usize> = array.shape().iter().map(|&n| n as usize).collect();
    // a number is a list of one
    let dims = if dims.is_empty() { &[1][..] } else { &dims };
    let mut table = Table::new(file, Shape { name: array.name(), dims, compress })?;
    array.for_each_piece(control, |bytes| {
        let items: Vec<T> = bytes.as_chunks::<N>().0.iter().map(|bytes| of_bytes(*bytes)).collect();
        table.push(&items)
    })?;
    table.finish(file)
}
