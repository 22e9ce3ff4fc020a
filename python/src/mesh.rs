//! A mesh for Python: arrays and files.

use std::fs::File;
use std::path::PathBuf;
use std::sync::{Arc, Mutex, PoisonError};

use hexcast::Error;
use hexcast::column_file;
use hexcast::columns::{run_cell, run_flag};
use hexcast::files::saved::{FileOptions, save};
use hexcast::job::ZarrJob;
use hexcast::lines::Lines;
use hexcast::measured::Measured;
use hexcast::mesh::Mesh;
use hexcast::report::ColumnsReport;
use hexcast::write::zarr::{Place, Stored};
use hexcast::write::{self, Compress, Format, Options};
use numpy::{PyArray1, PyReadwriteArray1};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::py_error;
use crate::run::run;

/// Flags that are expanded between two looks for Ctrl-C.
const STEP_BYTES: usize = 256 << 20;

/// A finished mesh; `hexcast.Mesh` is the class for people.
#[pyclass(frozen, module = "hexcast._hexcast")]
pub(crate) struct RawMesh {
    pub(crate) mesh: Mesh,
    report: String,
    /// Where its cells lie in the whole box.
    place: Place,
    zarr: ZarrJob,
    pub(crate) measured: Arc<Measured>,
}

impl RawMesh {
    pub(crate) fn new(mesh: Mesh, report: String, place: Place, zarr: ZarrJob) -> RawMesh {
        RawMesh { mesh, report, place, zarr, measured: Arc::default() }
    }

    pub(crate) fn with_measured(self, measured: Arc<Measured>) -> RawMesh {
        RawMesh { measured, ..self }
    }

    /// A mesh of which nothing but its columns is known.
    pub(crate) fn of_columns(mesh: Mesh) -> RawMesh {
        // a struct of numbers and strings always has a JSON form
        let report = serde_json::to_string(&ColumnsReport::new(&mesh)).unwrap_or_default();
        let place = Place::new(mesh.lines().clone(), [0; 3]);
        RawMesh::new(mesh, report, place, ZarrJob::default())
    }
}

/// The lines of a whole box: origin, spacing and numbers of equal cells, or all lines; and the first cell of the mesh in it.
type Whole = (Option<([f64; 3], [f64; 3], [u32; 3])>, [Vec<f64>; 3], [u32; 3]);
/// The bytes of a column file, the report, the whole box, and the shapes of shards as JSON.
type State = (Py<PyBytes>, String, Whole, String);

/// Columns as arrays: the axis of the rays, then offsets, first cells and flags.
type ColumnArrays<'py> = (usize, Bound<'py, PyArray1<u64>>, Bound<'py, PyArray1<u32>>, Bound<'py, PyArray1<u8>>);

#[pymethods]
impl RawMesh {
    /// The report as JSON.
    #[getter]
    fn report(&self) -> &str {
        &self.report
    }

    /// Number of cells on x, y and z.
    #[getter]
    fn dims(&self) -> (u32, u32, u32) {
        self.mesh.dims().into()
    }

    /// First mesh line on each axis.
    #[getter]
    fn origin(&self) -> (f64, f64, f64) {
        self.mesh.lines().origin().into()
    }

    /// Cell size on each axis; None where cells differ in size.
    #[getter]
    fn spacing(&self) -> Option<(f64, f64, f64)> {
        self.mesh.lines().spacing().map(Into::into)
    }

    /// Unit of lengths.
    #[getter]
    fn unit(&self) -> Option<&str> {
        self.mesh.unit()
    }

    /// Flags and their names.
    #[getter]
    fn names(&self) -> Vec<(u8, &str)> {
        self.mesh.names().iter().map(|named| (named.flag, named.name.as_str())).collect()
    }

    /// All mesh lines of an axis.
    fn lines<'py>(&self, py: Python<'py>, axis: usize) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_vec(py, self.mesh.lines().list(axis))
    }

    /// Expands the flags of a box into an array, x fastest.
    fn fill(&self, py: Python<'_>, first: [u32; 3], end: [u32; 3], mut out: PyReadwriteArray1<'_, u8>) -> PyResult<()> {
        let mut out = out.as_slice_mut()?;
        let [x, y, z] = [0, 1, 2].map(|axis| first[axis]..end[axis]);
        let plane = x.len() * y.len();
        let planes = (STEP_BYTES / plane.max(1)).clamp(1, z.len().max(1));
        run(py, None, |control| {
            for start in z.clone().step_by(planes) {
                control.check()?;
                let end = start.saturating_add(planes as u32).min(z.end);
                let n = plane * (end - start) as usize;
                let Some(some) = out.split_off_mut(..n) else {
                    return Err(Error::new("job-value", "an array with fewer bytes than cells", ""));
                };
                self.mesh.fill_box(&[x.clone(), y.clone(), start..end], some)?;
            }
            Ok(())
        })
    }

    /// All columns as arrays.
    fn columns<'py>(&self, py: Python<'py>) -> PyResult<ColumnArrays<'py>> {
        let columns = self.mesh.columns();
        let (offsets, starts, flags) = run(py, None, |_| {
            let (mut offsets, mut starts, mut flags) = (vec![0], Vec::new(), Vec::new());
            columns.for_rays(0..columns.rays().n_rays(), |runs| {
                starts.extend(runs.iter().map(|&run| run_cell(run)));
                flags.extend(runs.iter().map(|&run| run_flag(run)));
                offsets.push(starts.len() as u64);
            })?;
            Ok((offsets, starts, flags))
        })?;
        let axis = columns.rays().axis;
        Ok((axis, PyArray1::from_vec(py, offsets), PyArray1::from_vec(py, starts), PyArray1::from_vec(py, flags)))
    }

    /// What pickle makes it of again: [`restore`] and its arguments.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, State)> {
        let bytes = run(py, None, |control| {
            let mut bytes = Vec::new();
            let options = Options::default().with_compress(Compress::Zlib(1));
            write::write(&self.mesh, Format::Columns, &options, &mut bytes, control)?;
            Ok(bytes)
        })?;
        let whole = &self.place.whole;
        let equal = whole.spacing().map(|spacing| (whole.origin(), spacing, whole.dims()));
        let lists = if equal.is_some() { Default::default() } else { [0, 1, 2].map(|axis| whole.list(axis)) };
        // a struct of numbers always has a JSON form
        let zarr = serde_json::to_string(&self.zarr).unwrap_or_default();
        let restore = py.import("hexcast._hexcast")?.getattr("restore")?;
        Ok((restore, (PyBytes::new(py, &bytes).unbind(), self.report.clone(), (equal, lists, self.place.first), zarr)))
    }

    /// Writes a file, or the files of a solver or of a store, and returns what they lack. `inputs` are files that are not written over.
    fn save(&self, py: Python<'_>, path: PathBuf, options: &str, inputs: Vec<PathBuf>) -> PyResult<Vec<String>> {
        let options = FileOptions::of_json(options).map_err(py_error)?;
        let inputs: Vec<PathBuf> = inputs.iter().filter_map(|input| input.canonicalize().ok()).collect();
        run(py, None, |control| save(&self.mesh, &path, &options, (self.zarr, &inputs), control))
    }

    /// The files of a Zarr store of the whole box that this window fills, by their keys: metadata first, then shards.
    fn zarr_part<'py>(&self, py: Python<'py>, compress: Option<u8>) -> PyResult<Vec<(String, Bound<'py, PyBytes>)>> {
        let files: Mutex<Vec<(String, Vec<u8>)>> = Mutex::default();
        let options = self.zarr_options(compress);
        let keep = |key: &str, value: &[u8]| {
            files.lock().unwrap_or_else(PoisonError::into_inner).push((key.into(), value.to_vec()));
            Ok(())
        };
        run(py, None, |control| write::zarr::write_part(&self.mesh, &self.place, &options, &keep, control, |_| ()))?;
        let mut files = files.into_inner().unwrap_or_else(PoisonError::into_inner);
        files.sort_by_key(|(key, _)| (Stored::is_of_shard(key), key.clone()));
        Ok(files.into_iter().map(|(key, value)| (key, PyBytes::new(py, &value))).collect())
    }
}

impl RawMesh {
    pub(crate) fn zarr_options(&self, compress: Option<u8>) -> Options {
        let compress = compress.map_or(Compress::None, Compress::Zlib);
        Options::default().with_compress(compress).with_zarr(self.zarr)
    }
}

/// Makes a mesh of its state, such as one that was pickled; without what was measured.
#[pyfunction]
pub(crate) fn restore(py: Python<'_>, columns: &[u8], report: String, whole: Whole, zarr: &str) -> PyResult<RawMesh> {
    run(py, None, |_| {
        let mesh = column_file::read(&mut &columns[..], u64::MAX)?;
        let (equal, lists, first) = whole;
        let whole = match equal {
            Some((origin, spacing, dims)) => Lines::new(origin, spacing, dims)?,
            None => Lines::from_lists(lists)?,
        };
        let of_zarr = |error| Error::new("job-value", format!("the state of a mesh: {error}"), "mesh it again");
        let zarr = serde_json::from_str(zarr).map_err(of_zarr)?;
        Ok(RawMesh::new(mesh, report, Place::new(whole, first), zarr))
    })
}

/// Reads a column file.
#[pyfunction]
pub(crate) fn load(py: Python<'_>, path: &str) -> PyResult<RawMesh> {
    run(py, None, |_| {
        let mut file = File::open(path).map_err(|error| Error::io(format!("reading {path}"), error))?;
        let mesh = column_file::read(&mut file, u64::MAX).map_err(|error| error.at(path))?;
        Ok(RawMesh::of_columns(mesh))
    })
}
