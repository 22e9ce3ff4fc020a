//! Pictures of a mesh, and what differs between two.

use hexcast::difference::difference;
use hexcast::picture::{Look, Place, Slices, View, slices, view};
use hexcast::{Error, Result};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::mesh::RawMesh;
use crate::py_error;
use crate::run::run;

/// Pixels, the flags that are shown, colours by flag, and most bytes of memory.
type PyLook = (Option<u32>, Vec<u8>, Vec<(u8, [u8; 3])>, u64);

/// A corner of a box of cells.
type Corner = [u32; 3];

fn look_of((size, flags, colours, max_bytes): PyLook) -> Look {
    let mut look = Look::default().with_flags(flags).with_max_bytes(max_bytes);
    look.size = size;
    colours.into_iter().fold(look, |look, (flag, rgb)| look.with_colour(flag, rgb))
}

/// Draws slices, PNG: each of the places along each of the axes.
#[pyfunction]
pub(crate) fn draw_slices<'py>(
    py: Python<'py>,
    mesh: &Bound<'py, RawMesh>,
    axes: Vec<usize>,
    places: Vec<String>,
    has_lines: bool,
    look: PyLook,
) -> PyResult<Bound<'py, PyBytes>> {
    let mesh = &mesh.get().mesh;
    let png = run(py, None, |control| {
        let places = places.iter().map(|text| text.parse()).collect::<Result<Vec<Place>>>()?;
        let wanted = Slices::at(mesh, &axes, &places)?.with_lines(has_lines).with_look(look_of(look));
        slices(mesh, &wanted, control)?.png()
    })?;
    Ok(PyBytes::new(py, &png))
}

/// Draws the surface, PNG, from a direction of two angles; of a box of cells, or of all.
#[pyfunction]
pub(crate) fn draw_view<'py>(
    py: Python<'py>,
    mesh: &Bound<'py, RawMesh>,
    direction: Option<[f64; 2]>,
    cells: Option<[Corner; 2]>,
    look: PyLook,
) -> PyResult<Bound<'py, PyBytes>> {
    let mesh = &mesh.get().mesh;
    let png = run(py, None, |control| {
        let mut wanted = View::default().with_look(look_of(look));
        wanted.direction = direction.unwrap_or(wanted.direction);
        wanted.cells = cells.map(|[first, end]| [0, 1, 2].map(|axis| first[axis]..end[axis]));
        view(mesh, &wanted, control)?.png()
    })?;
    Ok(PyBytes::new(py, &png))
}

/// What differs between two meshes, as JSON, and a mask of the cells.
#[pyfunction]
pub(crate) fn diff(
    py: Python<'_>,
    one: &Bound<'_, RawMesh>,
    other: &Bound<'_, RawMesh>,
    max_bytes: u64,
) -> PyResult<(String, RawMesh)> {
    let (one, other) = (&one.get().mesh, &other.get().mesh);
    let found = run(py, None, |control| difference(one, other, max_bytes, control))?;
    let json = serde_json::to_string(&found)
        .map_err(|error| py_error(Error::new("job-value", format!("the differences as JSON: {error}"), "")))?;
    Ok((json, RawMesh::of_columns(found.mask)))
}
