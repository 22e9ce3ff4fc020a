//! From arguments and a job file to a job.

use std::path::{Path, PathBuf};

use hexcast::error::{Error, Result};
use hexcast::job::{AxisChoice, BackendChoice, GeometryJob, Job, Padding, PerAxis, Rule};

use crate::args::JobArgs;

/// Builds and validates the job that the arguments ask for.
pub(crate) fn job(arguments: &JobArgs) -> Result<Job> {
    let mut job = match &arguments.job {
        Some(file) => job_of_file(file)?,
        None => Job::default(),
    };
    for file in &arguments.files {
        job.geometries.push(GeometryJob::from_argument(file)?);
    }
    if arguments.split {
        job.geometries.iter_mut().for_each(|geometry| geometry.split = true);
    }
    set_cells(&mut job, arguments)?;
    if arguments.domain.is_some() {
        job.domain = arguments.domain;
        job.padding = None;
    }
    if let Some(cells) = &arguments.padding_cells {
        job.padding = Some(Padding::Cells(per_axis("--padding-cells", cells)?));
    }
    if let Some(lengths) = &arguments.padding_length {
        job.padding = Some(Padding::Length(per_axis("--padding-length", lengths)?));
    }
    // clap has checked the words
    match arguments.rule.as_deref() {
        Some("nonzero") => job.rule = Rule::Nonzero,
        Some(_) => job.rule = Rule::Parity,
        None => {}
    }
    match arguments.backend.as_deref() {
        Some("gpu") => job.backend = BackendChoice::Gpu,
        Some("cpu") => job.backend = BackendChoice::Cpu,
        Some(_) => job.backend = BackendChoice::Auto,
        None => {}
    }
    match arguments.axis.as_deref() {
        Some("x") => job.axis = AxisChoice::X,
        Some("y") => job.axis = AxisChoice::Y,
        Some("z") => job.axis = AxisChoice::Z,
        Some(_) => job.axis = AxisChoice::Auto,
        None => {}
    }
    if arguments.unit.is_some() {
        job.unit.clone_from(&arguments.unit);
    }
    job.validate()?;
    Ok(job)
}

/// Reads a job file; paths in it are relative to its folder.
fn job_of_file(file: &Path) -> Result<Job> {
    let text =
        std::fs::read_to_string(file).map_err(|error| Error::io(format!("reading {}", file.display()), error))?;
    let is_json = file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("json"));
    let job = if is_json { Job::from_json(&text) } else { Job::from_toml(&text) };
    let mut job = job.map_err(|error| error.at(file.display()))?;
    let folder = file.parent().map_or_else(PathBuf::new, Path::to_path_buf);
    for geometry in &mut job.geometries {
        geometry.file = folder.join(&geometry.file).to_string_lossy().into_owned();
    }
    Ok(job)
}

fn set_cells(job: &mut Job, arguments: &JobArgs) -> Result<()> {
    let given = arguments.cells.is_some()
        || arguments.dims.is_some()
        || arguments.cell_size.is_some()
        || arguments.max_cell_size.is_some();
    if given {
        (job.cells, job.dims, job.cell_size, job.max_cell_size) = (None, None, None, None);
        job.tolerance = job.tolerance.filter(|_| arguments.max_cell_size.is_some());
    }
    job.cells = arguments.cells.or(job.cells);
    job.dims = arguments.dims.or(job.dims);
    if let Some(sizes) = &arguments.cell_size {
        job.cell_size = Some(per_axis("--cell-size", sizes)?);
    }
    job.max_cell_size = arguments.max_cell_size.or(job.max_cell_size);
    job.tolerance = arguments.tolerance.or(job.tolerance);
    Ok(())
}

fn per_axis<T: Copy>(option: &str, numbers: &[T]) -> Result<PerAxis<T>> {
    match *numbers {
        [all] => Ok(PerAxis::All(all)),
        [x, y, z] => Ok(PerAxis::Each([x, y, z])),
        _ => {
            let message = format!("{option} has {} numbers", numbers.len());
            Err(Error::new("job-value", message, "give one number for all axes, or three for x, y, z"))
        }
    }
}
