//! Refinement for Python: the leaves of an octree.

use hexcast::control::Control;
use hexcast::refine::{Refined, Refinement, refine as refined};
use hexcast::write::leaf_arrays;
use numpy::PyReadwriteArray1;
use pyo3::prelude::*;

use crate::engines::with_engine;
use crate::measured::{Described, described, fill};
use crate::meshing::{Surfaces, read, sources};
use crate::py_error;
use crate::run::{on_threads, run};

/// Leaves; `hexcast.Leaves` is the class for people.
#[pyclass(frozen, module = "hexcast._hexcast")]
pub(crate) struct RawLeaves(Refined);

/// Halves the cells of a job where surfaces are.
#[pyfunction]
#[pyo3(signature = (job, surfaces, levels, of_flags, boxes, adapter=None, threads=None, progress=None))]
#[allow(clippy::too_many_arguments, reason = "those of the function for people, which names them")]
pub(crate) fn refine(
    py: Python<'_>,
    job: &str,
    surfaces: Surfaces,
    levels: u8,
    of_flags: Vec<(u8, u8)>,
    boxes: Vec<([f64; 6], u8)>,
    adapter: Option<&str>,
    threads: Option<usize>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<RawLeaves> {
    let job = read(job).map_err(py_error)?;
    let mut how = Refinement::new(levels);
    (how.level_of_flags, how.boxes) = (of_flags, boxes);
    let work = |control: &Control| {
        let sources = sources(&job, &surfaces, control)?;
        with_engine(job.backend, adapter, |engine| pollster::block_on(refined(&job, &sources, &how, engine, control)))
    };
    run(py, progress, |control| on_threads(threads, || work(control))).map(RawLeaves)
}

#[pymethods]
impl RawLeaves {
    /// Names of the flags and the findings about the finest mesh, as JSON.
    fn facts(&self) -> (String, String, Option<String>) {
        let Refined { names, findings, unit, .. } = &self.0;
        // structs of numbers and texts always have a JSON form
        let names: Vec<(u8, &str)> = names.iter().map(|named| (named.flag, &named.name[..])).collect();
        let [names, findings] =
            [serde_json::to_string(&names), serde_json::to_string(findings)].map(Result::unwrap_or_default);
        (names, findings, unit.clone())
    }

    /// Cells of each level along x, y and z.
    fn dims(&self) -> Vec<[u32; 3]> {
        let tree = &self.0.octree;
        (0..tree.n_levels()).map(|level| tree.dims(level)).collect()
    }

    /// Name, type as NumPy names it, and shape of each array.
    fn arrays(&self) -> Vec<Described> {
        described(&leaf_arrays(&self.0.octree, &self.0.lines))
    }

    /// Puts the bytes of one of these arrays, by its place among them, into an array.
    fn fill(&self, py: Python<'_>, index: usize, mut out: PyReadwriteArray1<'_, u8>) -> PyResult<()> {
        fill(py, || Ok(leaf_arrays(&self.0.octree, &self.0.lines)), index, out.as_slice_mut()?)
    }
}
