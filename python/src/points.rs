//! The flags at points, for Python.

use hexcast::pipeline::MeshOptions;
use hexcast::points::PointFlags;
use hexcast::{Error, Result, Source};
use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::prelude::*;

use crate::meshing::{Surfaces, read, sources};
use crate::py_error;
use crate::run::run;

/// The surfaces of a mesh, ready to be asked; `hexcast.Mesh.at` asks them.
#[pyclass(frozen, module = "hexcast._hexcast")]
pub(crate) struct RawPoints {
    flags: PointFlags,
}

#[pymethods]
impl RawPoints {
    /// Most that a point is moved along x, y and z.
    #[getter]
    fn snap(&self) -> (f64, f64, f64) {
        self.flags.snap().into()
    }

    /// The flags at points, given as x, y, z of one after the other.
    fn at<'py>(&self, py: Python<'py>, points: PyReadonlyArray1<'py, f64>) -> PyResult<Bound<'py, PyArray1<u8>>> {
        let (points, _) = points.as_slice()?.as_chunks();
        let flags = run(py, None, |control| self.flags.flags(points, control))?;
        Ok(PyArray1::from_vec(py, flags))
    }
}

/// Prepares the surfaces of a job whose mesh is there; `digests` are those of the files that it was made of.
#[pyfunction]
pub(crate) fn points(
    py: Python<'_>,
    job: &str,
    surfaces: Surfaces,
    digests: Vec<Option<String>>,
) -> PyResult<RawPoints> {
    let job = read(job).map_err(py_error)?;
    let flags = run(py, None, |control| {
        let sources = sources(&job, &surfaces, control)?;
        sources.iter().zip(&digests).try_for_each(check)?;
        PointFlags::new(&job, sources, &MeshOptions::default(), control)
    })?;
    Ok(RawPoints { flags })
}

/// Refuses a file that has changed since it was meshed.
fn check((source, digest): (&Source, &Option<String>)) -> Result<()> {
    if source.blake3 == *digest {
        return Ok(());
    }
    let message = format!("{} has changed since it was meshed: its points would not be those of the mesh", source.file);
    Err(Error::new("io", message, "mesh it again"))
}
