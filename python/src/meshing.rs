//! From a job and its surfaces to a mesh, an estimate or parts.

use hexcast::control::Control;
use hexcast::estimate::Estimate;
use hexcast::files::{FileStore, read_geometry};
use hexcast::job::{Job, PartJob};
use hexcast::measured::Measured;
use hexcast::pipeline::{self, MeshOptions, Prepared, SpillTarget, part_step, prepare};
use hexcast::report::{CallerFacts, Report};
use hexcast::sources::Source;
use hexcast::write::zarr::Place;
use hexcast::{Error, Result};
use pyo3::prelude::*;
use rayon::prelude::*;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use crate::engines::with_engine;
use crate::mesh::RawMesh;
use crate::py_error;
use crate::run::{on_threads, run};
use crate::surface::Surface;

/// For each geometry of a job its surface; None where it is read from the file that the job names.
pub(crate) type Surfaces = Vec<Option<Py<Surface>>>;

/// A part of the name of the GPU, the number of threads, the folder that columns spill to, and whether doubtful cells shall be a mesh and faces shall have
/// the names of solids.
type How = (Option<String>, Option<usize>, Option<PathBuf>, [bool; 2]);

/// Meshes a job.
#[pyfunction]
#[pyo3(signature = (job, surfaces, how=None, progress=None))]
pub(crate) fn mesh(
    py: Python<'_>,
    job: &str,
    surfaces: Surfaces,
    how: Option<How>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<RawMesh> {
    let job = read(job).map_err(py_error)?;
    let (adapter, threads, spill, [doubt, walls]) = how.unwrap_or_default();
    run(py, progress, |control| {
        on_threads(threads, || {
            let start = Instant::now();
            let sources = sources(&job, &surfaces, control)?;
            let read = start.elapsed().as_secs_f64();
            let options = MeshOptions::default().with_spill(spill_target(spill.as_deref())?);
            let options = options.with_doubt_mask(doubt).with_walls(walls);
            let (mesh, mut facts) = with_engine(job.backend, adapter.as_deref(), |engine| {
                pollster::block_on(pipeline::mesh(&job, sources, &options, engine, control))
            })?;
            let first = facts.window.as_ref().map_or([0; 3], |window| window.first);
            let place = Place::new(facts.whole.clone(), first);
            let measured = Arc::new(Measured::take(&mut facts));
            let report = Report::new(facts, CallerFacts::default().with_read(read)).to_json();
            Ok(RawMesh::new(mesh, report, place, job.zarr.unwrap_or_default()).with_measured(measured))
        })
    })
}

/// A file in a folder without a name, which is gone with the mesh.
fn spill_target(folder: Option<&Path>) -> Result<SpillTarget> {
    let Some(folder) = folder else { return Ok(SpillTarget::None) };
    let file = tempfile::tempfile_in(folder).map_err(|error| {
        let message = format!("no temporary file can be made in {}: {error}", folder.display());
        Error::new("io", message, "make sure that the folder exists and is yours")
    })?;
    Ok(SpillTarget::Temporary(Arc::new(FileStore::new(file))))
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
pub(crate) fn read(json: &str) -> Result<Job> {
    let mut value: Value = serde_json::from_str(json)
        .map_err(|error| Error::new("job-syntax", format!("the job is not valid JSON: {error}"), ""))?;
    if let Some(part @ Value::String(_)) = value.get_mut("part") {
        let text = part.as_str().unwrap_or_default();
        let read: PartJob = text.parse().map_err(|problem| Error::new("job-value", format!("part: {problem}"), ""))?;
        *part = serde_json::json!(read);
    }
    Job::from_plain_json(&value.to_string())
}

pub(crate) fn sources(job: &Job, surfaces: &Surfaces, control: &Control) -> Result<Vec<Source>> {
    let source = |index: usize| match &surfaces[index] {
        Some(surface) => Ok(surface.get().source.clone()),
        None => read_geometry(job, index, control),
    };
    let sources: Vec<Result<Source>> = (0..surfaces.len()).into_par_iter().map(source).collect();
    sources.into_iter().collect()
}
