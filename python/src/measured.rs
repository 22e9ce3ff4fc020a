//! What a mesh has beside its cells, as arrays, and the files of these.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::PathBuf;

use hexcast::files::WrittenFolder;
use hexcast::fractions::Fractions;
use hexcast::measured::Measured;
use hexcast::write::zarr::write_solid as write_solid_store;
use hexcast::write::{self, Array, Compress, Format};
use hexcast::{Error, Result};
use numpy::{PyReadonlyArray1, PyReadwriteArray1};
use pyo3::prelude::*;

use crate::mesh::RawMesh;
use crate::run::run;

/// Name, type as NumPy names it, and shape of an array.
pub(crate) type Described = (String, String, Vec<u64>);
/// The same with its bytes.
type Filled<'py> = (String, String, Vec<u64>, PyReadonlyArray1<'py, u8>);
/// Rays along each axis of a cell, cells of the halo, and an entry each of the list: cells, flags, fractions.
type CutCells<'py> = (u32, u32, PyReadonlyArray1<'py, u64>, PyReadonlyArray1<'py, u8>, PyReadonlyArray1<'py, f32>);

/// What was measured, by the names that the mesh has for it.
#[pyfunction]
pub(crate) fn measured_kinds(mesh: &Bound<'_, RawMesh>) -> Vec<&'static str> {
    let raw = mesh.get();
    let Measured { links, fractions, staggered, conformal, tensors, distance, doubt, .. } = &*raw.measured;
    let kinds = [("links", links.is_some()), ("fractions", fractions.is_some())];
    let others = [
        ("staggered", staggered.is_some()),
        ("conformal", conformal.is_some()),
        ("tensors", tensors.is_some()),
        ("distance", distance.is_some()),
        ("doubt", doubt.is_some()),
    ];
    let kinds = kinds.into_iter().chain(others);
    kinds.filter_map(|(name, is_there)| is_there.then_some(name)).collect()
}

/// The arrays of `links`, `fractions`, `staggered`, `conformal`, `tensors` or `distance`.
#[pyfunction]
pub(crate) fn arrays(mesh: &Bound<'_, RawMesh>, of: &str) -> PyResult<Vec<Described>> {
    let raw = mesh.get();
    raw.measured.arrays(&raw.mesh, of).map(|arrays| described(&arrays)).map_err(crate::py_error)
}

/// Name, type and shape of each array.
pub(crate) fn described(arrays: &[Array<'_>]) -> Vec<Described> {
    arrays.iter().map(|of| (of.name().into(), of.kind().into(), of.shape().to_vec())).collect()
}

/// Puts the bytes of one of these arrays, by its place among them, into an array.
#[pyfunction]
pub(crate) fn fill_array(
    py: Python<'_>,
    mesh: &Bound<'_, RawMesh>,
    of: &str,
    index: usize,
    mut out: PyReadwriteArray1<'_, u8>,
) -> PyResult<()> {
    let raw = mesh.get();
    fill(py, || raw.measured.arrays(&raw.mesh, of), index, out.as_slice_mut()?)
}

/// Puts the bytes of one of some arrays into `out`.
pub(crate) fn fill<'a>(
    py: Python<'_>,
    arrays: impl FnOnce() -> Result<Vec<Array<'a>>> + Send,
    index: usize,
    out: &mut [u8],
) -> PyResult<()> {
    run(py, None, |control| arrays()?.get(index).map_or(Ok(()), |array| array.fill(out, control)))
}

/// Rays of fractions along each axis of a cell, and cells of the halo, which have none.
#[pyfunction]
pub(crate) fn fraction_facts(mesh: &Bound<'_, RawMesh>) -> PyResult<(u32, u32)> {
    let raw = mesh.get();
    raw.measured.fractions().map(|of| (of.rays, of.halo)).map_err(crate::py_error)
}

/// The doubtful cells as a mesh, if they were asked for.
#[pyfunction]
pub(crate) fn doubt(mesh: &Bound<'_, RawMesh>) -> Option<RawMesh> {
    let raw = mesh.get();
    raw.measured.doubt.clone().map(RawMesh::of_columns)
}

/// Writes the fraction of every cell that is not background; `path` is replaced, or is that of a folder that is not there yet.
#[pyfunction]
pub(crate) fn write_solid(
    py: Python<'_>,
    mesh: &Bound<'_, RawMesh>,
    name: &str,
    path: PathBuf,
    compress: Option<u8>,
    cut: CutCells<'_>,
) -> PyResult<()> {
    let raw = mesh.get();
    let format = Format::of_name(name).map_err(crate::py_error)?;
    let (rays, halo, cells, flags, fractions) = cut;
    let (cells, flags, fractions) = (cells.as_slice()?, flags.as_slice()?, fractions.as_slice()?);
    let list = cells.iter().zip(flags).zip(fractions).map(|((cell, flag), fraction)| (*cell, *flag, *fraction));
    run(py, None, |control| {
        let fractions = Fractions::of_cells(rays, (raw.mesh.dims(), halo), list)?;
        let options = raw.zarr_options(compress);
        let written = match format {
            Format::Zarr => {
                let folder = WrittenFolder::new(path.clone());
                write_solid_store(&raw.mesh, &fractions, &options, &|key, value| folder.put(key, value), control)
                    .and_then(|()| folder.verify())
            }
            _ => write::write_solid(&raw.mesh, &fractions, (format, &options), &mut create(&path)?, control).map(drop),
        };
        written.map_err(|error| error.at(name))
    })
}

/// Writes a NumPy archive.
#[pyfunction]
pub(crate) fn write_arrays(
    py: Python<'_>,
    path: PathBuf,
    arrays: Vec<Filled<'_>>,
    compress: Option<u8>,
) -> PyResult<()> {
    let compress = compress.map_or(Compress::None, Compress::Zlib);
    let bytes = arrays.iter().map(|of| of.3.as_slice()).collect::<std::result::Result<Vec<&[u8]>, _>>()?;
    let arrays: Vec<(&str, &str, &[u64])> =
        arrays.iter().map(|(name, kind, shape, _)| (&name[..], &kind[..], &shape[..])).collect();
    run(py, None, |_| {
        let list =
            arrays.iter().zip(&bytes).map(|((name, kind, shape), bytes)| Array::of_bytes((name, kind), shape, bytes));
        let list = list.collect::<Result<Vec<Array<'_>>>>()?;
        write::write_arrays(&list, compress, &mut create(&path)?).map(drop)
    })
}

fn create(path: &PathBuf) -> Result<impl Write + use<>> {
    let file = File::create(path).map_err(|error| Error::io("making a file", error))?;
    Ok(BufWriter::with_capacity(1 << 20, file))
}
