//! A scene for Python: a mesh that follows the edits of its job.

use std::sync::{Mutex, MutexGuard, PoisonError};

use hexcast::Scene;
use hexcast::pipeline::MeshOptions;
use hexcast::scene::Update;
use hexcast::write::zarr::Place;
use numpy::PyArray1;
use pyo3::prelude::*;

use crate::engines::with_engine;
use crate::mesh::RawMesh;
use crate::meshing::{Surfaces, read, sources};
use crate::py_error;
use crate::run::{on_threads, run};

/// A scene; `hexcast.Scene` is the class for people.
#[pyclass(frozen, module = "hexcast._hexcast")]
pub(crate) struct RawScene {
    scene: Mutex<Scene>,
    adapter: Option<String>,
    threads: Option<usize>,
}

/// Runs of cells whose flags changed: axis of the rays, and number of cells on the other two; rays, first cells, the cells after their last, flags before and after.
type Changed<'py> = (
    usize,
    (u32, u32),
    Bound<'py, PyArray1<u64>>,
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray1<u8>>,
    Bound<'py, PyArray1<u8>>,
);

/// Meshes a job that will be edited.
#[pyfunction]
#[pyo3(signature = (job, surfaces, adapter=None, threads=None, progress=None))]
pub(crate) fn scene(
    py: Python<'_>,
    job: &str,
    surfaces: Surfaces,
    adapter: Option<String>,
    threads: Option<usize>,
    progress: Option<&Bound<'_, PyAny>>,
) -> PyResult<RawScene> {
    let job = read(job).map_err(py_error)?;
    let scene = run(py, progress, |control| {
        on_threads(threads, || {
            let sources = sources(&job, &surfaces, control)?;
            with_engine(job.backend, adapter.as_deref(), |engine| {
                pollster::block_on(Scene::new(job.clone(), sources, MeshOptions::default(), engine, control))
            })
        })
    })?;
    Ok(RawScene { scene: Mutex::new(scene), adapter, threads })
}

#[pymethods]
impl RawScene {
    /// The mesh of now, which stays as it is.
    fn mesh(&self) -> RawMesh {
        let scene = self.held();
        let facts = scene.report().map(|report| &report.mesh);
        let first = facts.and_then(|facts| facts.window.as_ref()).map_or([0; 3], |window| window.first);
        let lines = facts.map_or(scene.mesh().lines(), |facts| &facts.whole);
        let place = Place::new(lines.clone(), first);
        let (mesh, zarr) = (scene.mesh().clone(), scene.job().zarr.unwrap_or_default());
        RawMesh::new(mesh, scene.report_json(), place, zarr).with_measured(scene.measured().clone())
    }

    /// Gives it another job; returns what that did, as JSON, and the cells that it changed.
    #[pyo3(signature = (job, surfaces, progress=None))]
    fn update<'py>(
        &self,
        py: Python<'py>,
        job: &str,
        surfaces: Surfaces,
        progress: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<(String, Option<Changed<'py>>)> {
        let job = read(job).map_err(py_error)?;
        let (update, rays) = run(py, progress, |control| {
            on_threads(self.threads, || {
                let sources = sources(&job, &surfaces, control)?;
                with_engine(job.backend, self.adapter.as_deref(), |engine| {
                    let mut scene = self.held();
                    let update = pollster::block_on(scene.update_to(job.clone(), sources, engine, control))?;
                    let rays = scene.mesh().columns().rays();
                    Ok((update, (rays.axis, rays.counts.into())))
                })
            })
        })?;
        Ok((update.to_json(), changed(py, &update, rays)))
    }
}

impl RawScene {
    fn held(&self) -> MutexGuard<'_, Scene> {
        // an update that crashed left the mesh as it was
        self.scene.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

fn changed<'py>(py: Python<'py>, update: &Update, (axis, counts): (usize, (u32, u32))) -> Option<Changed<'py>> {
    let runs = update.changed.as_ref()?;
    Some((
        axis,
        counts,
        PyArray1::from_iter(py, runs.iter().map(|run| run.ray)),
        PyArray1::from_iter(py, runs.iter().map(|run| run.start)),
        PyArray1::from_iter(py, runs.iter().map(|run| run.end)),
        PyArray1::from_iter(py, runs.iter().map(|run| run.before)),
        PyArray1::from_iter(py, runs.iter().map(|run| run.after)),
    ))
}
