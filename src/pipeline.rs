//! The pipeline: the line of data from read files to a mesh and its report, and the only choice of backend.
//!
//! # Theory
//! Sources -> geometries -> domain -> lines -> frame -> (lattice -> crossings -> columns). Everything up to the frame runs on
//! the host; the rest on the GPU or the CPU, with equal results. A device that is lost is opened again up to three times,
//! and the mesh goes on with the band at which it stopped, in bands of half the size; where that fails, and the CPU will do
//! too, it goes on there.
//!
//! Before a ray is cast the estimate is held against the memory allowed. Columns that outgrow it go to a store, if the caller
//! gives one; a store that keeps them lets an interrupted mesh go on.
//!
//! # Practice
//! [`Engine`] holds the device: open one, mesh many times. [`mesh`] is async because a browser cannot block.

use web_time::Instant;

use crate::cast::Cast;
use crate::control::Control;
use crate::error::Result;
use crate::frame::Frame;
use crate::geometry::Geometry;
use crate::job::Job;
use crate::lines::residuals;
use crate::mesh::{Mesh, Named};
use crate::report::{DeviceCheck, GeometryReport, InputReport, PeakBytes, Report, Seconds, flag_reports};
use crate::sources::Source;

mod cellless;
mod engine;
mod room;
mod task;

use cellless::geometries_without_cells;
pub use engine::Engine;
use room::Room;
pub use task::{Aside, DEFAULT_MAX_BYTES, Prepared, Task, prepare};

/// Meshes a job: `sources[i]` is the file of `job.geometries[i]`, read in `read_seconds`.
///
/// # Errors
/// Those of [`mesh_task`].
pub async fn mesh(
    job: &Job,
    sources: Vec<Source>,
    read_seconds: f64,
    engine: &mut Engine,
    control: &Control,
) -> Result<(Mesh, Report)> {
    let task = Task { job, read_seconds, aside: Aside::Nowhere, flags_in_memory: false, program_bytes: 0 };
    mesh_task(task, sources, engine, control).await
}

/// Meshes the job of a task: `sources[i]` is the file of `job.geometries[i]`.
///
/// # Errors
/// Those of [`prepare`], [`Frame::new`], [`Engine::columns`], [`crate::estimate::Plan::new`] and
/// [`crate::columns::Growing::keeping`].
pub async fn mesh_task(
    task: Task<'_>,
    sources: Vec<Source>,
    engine: &mut Engine,
    control: &Control,
) -> Result<(Mesh, Report)> {
    let Task { job, read_seconds, .. } = task;
    let inputs: Vec<InputReport> = sources.iter().map(InputReport::new).collect();
    let mut clock = Instant::now();
    let prepared = prepare(job, sources)?;
    let mut seconds =
        Seconds { read: read_seconds, device: engine.seconds, lines: lap(&mut clock), ..Seconds::default() };
    control.check()?;
    let frame = Frame::new(&prepared.geometries, &prepared.lines)?;
    let room = Room::new(&task, &prepared, engine)?;
    seconds.snap = lap(&mut clock);
    let names = names(&prepared.geometries);
    let mut growing = room.growing(&task, &prepared, &names, &inputs)?;
    let rays_kept = growing.n_rays();
    let casting = room.casting(Cast { frame: &frame, rays: &prepared.rays, rule: job.rule });
    let used = engine.grow(&casting, &mut growing, control).await?;
    growing.close()?;
    let columns_peak = growing.peak_bytes;
    let columns = growing.finish();
    seconds.columns = lap(&mut clock);
    seconds.total = seconds.read + seconds.lines + seconds.snap + seconds.columns;
    let mesh = Mesh::new(prepared.lines, columns, names, job.unit.clone())?;
    let mut report = report(job, &prepared, &frame, &mesh, engine);
    report.inputs = inputs;
    report.rays_kept = rays_kept;
    let facets: usize = prepared.geometries.iter().map(|geometry| 36 * geometry.facets.len()).sum();
    let facets = facets + 36 * frame.facets.capacity() + frame.rank_of_facet.capacity();
    report.peak_bytes.meshing = facets as u64 + used.host_bytes + columns_peak;
    report.peak_bytes.device = used.device_bytes;
    report.device_check = used.checked.map(|[rays, differing]| DeviceCheck { rays, differing });
    report.peak_bytes.spilled = mesh.columns.spilled_bytes();
    report.cells_per_second = report.cells as f64 / seconds.total.max(1e-9);
    seconds.report = lap(&mut clock);
    report.seconds = seconds;
    Ok((mesh, report))
}

/// Seconds since the last lap.
fn lap(clock: &mut Instant) -> f64 {
    let now = Instant::now();
    now.duration_since(std::mem::replace(clock, now)).as_secs_f64()
}

/// One name a flag: those of its geometries.
fn names(geometries: &[Geometry]) -> Vec<Named> {
    let mut names: Vec<Named> = Vec::new();
    for geometry in geometries {
        match names.iter_mut().find(|named| named.flag == geometry.flag) {
            Some(named) => named.name = format!("{} + {}", named.name, geometry.name),
            None => names.push(Named { flag: geometry.flag, name: geometry.name.clone() }),
        }
    }
    names
}

fn report(job: &Job, prepared: &Prepared, frame: &Frame, mesh: &Mesh, engine: &Engine) -> Report {
    let lines = &prepared.lines;
    let geometries: Vec<GeometryReport> = prepared.geometries.iter().map(GeometryReport::new).collect();
    let cells = mesh.columns.cells_per_flag();
    let flags = flag_reports(&geometries, &cells, lines);
    let mut warnings: Vec<String> = engine.fallback.iter().map(|why| format!("meshed on the CPU: {why}")).collect();
    if mesh.columns.odd_rays() > 0 {
        warnings.push(odd_warning(mesh.columns.odd_rays(), prepared.rays.n_rays()));
    }
    warnings.extend(geometries_without_cells(prepared, frame, &cells, job.rule));
    let (adapter, driver) = engine.adapter().map(|(name, driver)| (name.into(), driver.into())).unzip();
    Report {
        version: env!("CARGO_PKG_VERSION"),
        backend: engine.backend(),
        adapter,
        driver,
        device_check: None,
        unit: job.unit.clone(),
        inputs: Vec::new(),
        geometries,
        dims: lines.dims,
        origin: lines.origin,
        spacing: lines.spacing,
        end_points: residuals(lines, &prepared.domain),
        snap_in_cells: frame.snap_in_cells(),
        rule: job.rule,
        ray_axis: ["x", "y", "z"][prepared.rays.axis],
        rays: prepared.rays.n_rays(),
        rays_kept: 0,
        crossings: mesh.columns.n_crossings(),
        runs: mesh.columns.n_runs(),
        odd_rays: mesh.columns.odd_rays(),
        cells: lines.n_cells(),
        flags,
        flags_sha256: None,
        warnings,
        cells_per_second: 0.0,
        peak_bytes: PeakBytes::default(),
        seconds: Seconds::default(),
    }
}

fn odd_warning(odd_rays: u64, n_rays: u64) -> String {
    format!(
        "{odd_rays} of {n_rays} rays do not leave every geometry they enter: a surface is not closed there. Their cells are \
         flagged up to the last matched pair of crossings; `hexcast info` counts the open edges of a file"
    )
}
