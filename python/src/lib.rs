//! What the Python package `hexcast` calls, in this crate; people use `python/hexcast`.
//!
//! Jobs and reports cross as JSON, arrays without a copy where NumPy owns them. Whatever takes long runs on a thread of its own with
//! the GIL released, while the calling thread looks for Ctrl-C and calls the caller's progress function: see `run.rs`.

use std::path::PathBuf;

use hexcast::Error;
use hexcast::job::JobFile;
use pyo3::prelude::*;

mod engines;
mod measured;
mod mesh;
mod meshing;
mod pictures;
mod points;
mod refine;
mod run;
mod scene;
mod surface;

/// Makes a `hexcast.Error` of an error.
fn py_error(error: Error) -> PyErr {
    let made = |py: Python<'_>| {
        let arguments = (error.to_string(), error.code(), error.hint());
        py.import("hexcast._error")?.getattr("of_library")?.call1(arguments).map(PyErr::from_value)
    };
    Python::attach(|py| made(py).unwrap_or_else(|failed| failed))
}

/// Reads the text of a job file, TOML or JSON, and returns the job in it as JSON with its defaults; what the file asks of the command, such as
/// outputs, is left out. The values are not checked, since options may override them.
#[pyfunction]
fn read_job(text: &str, is_json: bool) -> PyResult<String> {
    let file = if is_json { JobFile::from_json(text) } else { JobFile::from_toml(text) };
    file.map(|file| file.job.to_json()).map_err(py_error)
}

/// All error codes.
#[pyfunction]
fn error_codes() -> Vec<&'static str> {
    hexcast::error::CODES.iter().map(|(code, ..)| *code).collect()
}

/// Bytes that the system and the control groups of this process leave.
#[pyfunction]
fn available_bytes() -> Option<u64> {
    hexcast::machine::available_bytes()
}

/// The compiled part of the package `hexcast`, which has the functions and classes for people.
#[pymodule(gil_used = false)]
fn _hexcast(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    // files of CAD are converted by the packages of this Python
    let python: Option<PathBuf> = module.py().import("sys")?.getattr("executable")?.extract()?;
    if let Some(program) = python.filter(|program| !program.as_os_str().is_empty()) {
        hexcast::files::use_python(program);
    }
    module.add_class::<mesh::RawMesh>()?;
    module.add_class::<surface::Surface>()?;
    module.add_class::<scene::RawScene>()?;
    module.add_class::<points::RawPoints>()?;
    module.add_function(wrap_pyfunction!(scene::scene, module)?)?;
    module.add_function(wrap_pyfunction!(read_job, module)?)?;
    module.add_function(wrap_pyfunction!(error_codes, module)?)?;
    module.add_function(wrap_pyfunction!(available_bytes, module)?)?;
    module.add_function(wrap_pyfunction!(meshing::mesh, module)?)?;
    module.add_function(wrap_pyfunction!(meshing::estimate, module)?)?;
    module.add_function(wrap_pyfunction!(meshing::parts, module)?)?;
    module.add_function(wrap_pyfunction!(meshing::converge, module)?)?;
    module.add_class::<refine::RawLeaves>()?;
    module.add_function(wrap_pyfunction!(refine::refine, module)?)?;
    module.add_function(wrap_pyfunction!(points::points, module)?)?;
    module.add_function(wrap_pyfunction!(pictures::draw_slices, module)?)?;
    module.add_function(wrap_pyfunction!(pictures::draw_view, module)?)?;
    module.add_function(wrap_pyfunction!(pictures::diff, module)?)?;
    module.add_function(wrap_pyfunction!(measured::measured_kinds, module)?)?;
    module.add_function(wrap_pyfunction!(measured::arrays, module)?)?;
    module.add_function(wrap_pyfunction!(measured::fill_array, module)?)?;
    module.add_function(wrap_pyfunction!(measured::fraction_facts, module)?)?;
    module.add_function(wrap_pyfunction!(measured::doubt, module)?)?;
    module.add_function(wrap_pyfunction!(measured::write_solid, module)?)?;
    module.add_function(wrap_pyfunction!(measured::write_arrays, module)?)?;
    module.add_function(wrap_pyfunction!(mesh::restore, module)?)?;
    module.add_function(wrap_pyfunction!(mesh::load, module)?)
}
