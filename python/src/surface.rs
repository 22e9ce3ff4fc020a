//! Surfaces: facets that were read, or taken from arrays, once, for any number of meshes.

use hexcast::files::{Fineness, read_fine};
use hexcast::geometry::Facet;
use hexcast::sources::Source;
use hexcast::{Control, Error, Result};
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

use crate::run::run;

/// A surface in memory. Meshes share its facets.
#[pyclass(frozen, module = "hexcast")]
pub(crate) struct Surface {
    pub(crate) source: Source,
}

#[pymethods]
impl Surface {
    /// Reads a file.
    #[staticmethod]
    #[pyo3(signature = (file, deviation=None))]
    fn from_file(py: Python<'_>, file: &str, deviation: Option<f64>) -> PyResult<Surface> {
        let read =
            |control: &Control| read_fine(file, &deviation.map_or(Ok(Fineness::default()), Fineness::within)?, control);
        run(py, None, read).map(|source| Surface { source })
    }

    /// Takes the bytes of an STL file.
    #[staticmethod]
    fn from_bytes(py: Python<'_>, name: &str, bytes: &[u8]) -> PyResult<Surface> {
        let mut input = bytes;
        let n_bytes = bytes.len() as u64;
        run(py, None, |control| Source::read(name, n_bytes, &mut input, control)).map(|source| Surface { source })
    }

    /// Takes the corners that faces choose from vertices.
    #[staticmethod]
    fn from_arrays(
        py: Python<'_>,
        name: &str,
        vertices: PyReadonlyArray2<'_, f32>,
        faces: PyReadonlyArray2<'_, i64>,
    ) -> PyResult<Surface> {
        let (vertices, faces) = (vertices.as_slice()?, faces.as_slice()?);
        run(py, None, |_| Source::from_facets(name, facets(name, vertices, faces)?)).map(|source| Surface { source })
    }

    /// Its name in reports.
    #[getter]
    fn name(&self) -> &str {
        &self.source.file
    }

    /// Number of its facets.
    #[getter]
    fn n_facets(&self) -> u64 {
        self.source.contents.n_facets
    }

    fn __repr__(&self) -> String {
        format!("<hexcast.Surface \"{}\" of {} facets>", self.source.file, self.source.contents.n_facets)
    }
}

fn facets(name: &str, vertices: &[f32], faces: &[i64]) -> Result<Vec<Facet>> {
    let (vertices, faces) = (vertices.as_chunks::<3>().0, faces.as_chunks::<3>().0);
    let corner = |&index: &i64| usize::try_from(index).ok().and_then(|index| vertices.get(index)).copied();
    let facet = |(number, face): (usize, &[i64; 3])| {
        let [a, b, c] = face.each_ref().map(corner);
        a.zip(b).zip(c).map(|((a, b), c)| [a, b, c]).ok_or_else(|| {
            let message = format!("{name}: face {number} has vertices {face:?} of {}, counted from 0", vertices.len());
            Error::new("job-value", message, "give indices from 0 to the number of vertices, exclusive")
        })
    };
    faces.iter().enumerate().map(facet).collect()
}
