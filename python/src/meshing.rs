//! From a job and its surfaces to a mesh, an estimate or parts.

use hexcast::control::Control;
use hexcast::estimate::Estimate;
use hexcast::files::read_file;
use hexcast::job::{Job, PartJob};
use hexcast::pipeline::{self, MeshOptions, Prepared, part_step, prepare};
use hexcast::report::{CallerFacts, Report};
use hexcast::sources::Source;
use hexcast::write::zarr::Place;
use hexcast::{Error, Result};
use pyo3::prelude::*;
use rayon::prelude::*;
use serde_json::Value;
use std::time::Instant;

use crate::engines::with_engine;
use crate::mesh::RawMesh;
use crate::py_error;
use crate::run::run;
use crate::surface::Surface;

/// For each geometry of a job its surface; None where it is read from the file that the job names.
type Surfaces = Vec<Option<Py<Surface>>>;

/// Meshes a job.
#[pyfunction]
#[pyo3(signature = (job, surfaces, adapter=None, progress=None))]
pub(crate) fn mesh(
    py: Python<'_>,
    job: &str,
    surfaces: Surfaces,
    adapter: Option<&str>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<RawMesh> {
    let job = read(job).map_err(py_error)?;
    run(py, progress, |control| {
        let start = Instant::now();
        let sources = sources(&job, &surfaces, control)?;
        let read = start.elapsed().as_secs_f64();
        let (mesh, facts) = with_engine(job.backend, adapter, |engine| {
            let options = MeshOptions::default();
            pollster::block_on(pipeline::mesh(&job, sources, &options, engine, control))
        })?;
        let first = facts.window.as_ref().map_or([0; 3], |window| window.first);
        let place = Place { whole: facts.whole.clone(), first };
        let zarr = job.zarr.unwrap_or_default();
        let report = Report::new(facts, CallerFacts::default().with_read(read)).to_json();
        Ok(RawMesh::new(mesh, report, place, zarr))
    })
}

/// What a mesh of a job would cost, as JSON.
#[pyfunction]
pub(crate) fn estimate(py: Python<'_>, job: &str, surfaces: Surfaces) -> PyResult<String> {
    of_prepared(py, job, &surfaces, |prepared| {
        let estimate = Estimate::new(&prepared.geometries, &prepared.lines, &prepared.rays);
        let estimate = estimate.with_unit(prepared.unit.as_deref());
        // a struct of numbers always has a JSON form
        Ok(serde_json::to_string(&estimate).unwrap_or_default())
    })
}

/// The cells of a box that is divided into so many parts: the first, and the end, exclusive.
#[pyfunction]
pub(crate) fn parts(py: Python<'_>, job: &str, surfaces: Surfaces, of: [u32; 3]) -> PyResult<Vec<[[u32; 3]; 2]>> {
    let zarr = read(job).map_err(py_error)?.zarr;
    of_prepared(py, job, &surfaces, |prepared| {
        let step = part_step(zarr.as_ref(), &prepared.whole)?;
        hexcast::parts::parts(&prepared.geometries, &prepared.whole, &prepared.rays, of, step)
    })
}

/// Errors and costs at several numbers of cells along the longest side, as JSON.
#[pyfunction]
#[pyo3(signature = (job, surfaces, sizes, adapter=None))]
pub(crate) fn converge(
    py: Python<'_>,
    job: &str,
    surfaces: Surfaces,
    sizes: Vec<u32>,
    adapter: Option<&str>,
) -> PyResult<String> {
    let job = read(job).map_err(py_error)?;
    run(py, None, |control| {
        let sources = sources(&job, &surfaces, control)?;
        let levels = with_engine(job.backend, adapter, |engine| {
            pollster::block_on(hexcast::converge::converge(&job, &sources, &sizes, engine, control))
        })?;
        // structs of numbers always have a JSON form
        Ok(serde_json::to_string(&levels).unwrap_or_default())
    })
}

fn of_prepared<T: Send>(
    py: Python<'_>,
    job: &str,
    surfaces: &Surfaces,
    of: impl FnOnce(&Prepared) -> Result<T> + Send,
) -> PyResult<T> {
    let job = read(job).map_err(py_error)?;
    run(py, None, |control| of(&prepare(&job, sources(&job, surfaces, control)?)?))
}

/// Reads a job from JSON; its part may be a text such as "3/64".
fn read(json: &str) -> Result<Job> {
    let mut value: Value = serde_json::from_str(json)
        .map_err(|error| Error::new("job-syntax", format!("the job is not valid JSON: {error}"), ""))?;
    if let Some(part @ Value::String(_)) = value.get_mut("part") {
        let text = part.as_str().unwrap_or_default();
        let read: PartJob = text.parse().map_err(|problem| Error::new("job-value", format!("part: {problem}"), ""))?;
        *part = serde_json::json!(read);
    }
    Job::from_plain_json(&value.to_string())
}

fn sources(job: &Job, surfaces: &Surfaces, control: &Control) -> Result<Vec<Source>> {
    let source = |index: usize| match &surfaces[index] {
        Some(surface) => Ok(surface.get().source.clone()),
        None => read_file(&job.geometries[index].file, control),
    };
    let sources: Vec<Result<Source>> = (0..surfaces.len()).into_par_iter().map(source).collect();
    sources.into_iter().collect()
}
