//! The pipeline: from the files that were read to a mesh and the facts of its report. The only place that chooses a backend.
//!
//! # Theory
//! [`Prepared`] -> [`Surfaces`], what the snap finds -> [`Cut`], the facets that are cast -> [`Meshed`], the columns -> [`Measured`], what the job
//! asks for beside the cells, and [`Borders`], what is known of cells beside these -> the mesh and its facts ([`Stages`]).
//!
//! Sources -> geometries -> domain -> lines -> frame -> (lattice -> crossings -> columns). Everything up to the frame runs on
//! the host; the rest on the GPU or the CPU, with equal results. A device that is lost is opened again up to three times,
//! and the mesh continues with the band at which it stopped, in bands of half the size; where that fails, and the CPU is
//! allowed to, it continues there.
//!
//! Before a ray is cast the estimate is compared with the memory allowed. Columns that exceed it spill to a store, if the
//! caller gives one; from a resumable store an interrupted mesh continues.
//!
//! # Practice
//! [`Engine`] holds the device: open one, mesh many times. [`mesh`] is async because a browser cannot block.

use crate::meshing::report::{CallerFacts, InputReport, MeshFacts, Report, Seconds};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::input::job::Job;
use hexcast_core::input::sources::Source;
use hexcast_core::set;
use hexcast_derived::mesh::Mesh;

mod backend;
mod borders;
mod cut;
mod cut_cells;
mod engine;
mod facts;
mod halo;
mod measured;
mod memory_budget;
mod merge;
mod meshed;
#[cfg(feature = "gpu")]
mod on_device;
mod options;
mod plates;
pub mod points;
mod prepare;
mod remedies;
mod shell_checks;
mod staggered;
mod surfaces;
mod tensors;
mod warnings;

use backend::Backend;
use borders::Borders;
use cut::Cut;
use engine::Instant;
pub use engine::{Engine, Used};
use facts::Stages;
use measured::Measured;
use memory_budget::{memory_budget, memory_of};
pub use merge::merge;
use meshed::Meshed;
#[cfg(feature = "gpu")]
pub use on_device::mesh_on_device;
pub use options::{DEFAULT_MAX_BYTES, MeshOptions, SpillTarget};
use prepare::Task;
pub use prepare::{Prepared, part_step, prepare};
use surfaces::Surfaces;
pub(crate) use warnings::findings_without_cells;

/// Meshes a job: `sources[i]` is the file of `job.geometries[i]`. The caller makes the report from the facts, when all is done.
///
/// # Errors
/// Those of [`prepare`], [`Frame::new`](hexcast_core::grid::frame::Frame::new), [`Engine::columns`],
/// [`crate::meshing::estimate::Estimate::needed_bytes`] and
/// [`ColumnsBuilder::resume`](hexcast_core::cells::columns::ColumnsBuilder::resume).
pub async fn mesh(
    job: &Job,
    sources: Vec<Source>,
    options: &MeshOptions,
    engine: &mut Engine,
    control: &Control,
) -> Result<(Mesh, MeshFacts)> {
    mesh_if(job, sources, (options, &|_| Ok(())), engine, control).await
}

/// Looks at what a job became, and may refuse it.
pub type Check<'a> = dyn Fn(&Prepared) -> Result<()> + Sync + 'a;

/// Like [`mesh`], for callers who look at what the job became before the long work: `check` may refuse it.
///
/// # Errors
/// Those of [`mesh`] and of `check`.
pub async fn mesh_if(
    job: &Job,
    sources: Vec<Source>,
    (options, check): (&MeshOptions, &Check<'_>),
    engine: &mut Engine,
    control: &Control,
) -> Result<(Mesh, MeshFacts)> {
    let bare = match options.lone_report {
        true => None,
        false => bare_report(job, &sources, check, engine, control).await?,
    };
    let (mesh, mut facts) = meshed(job, sources, (options, check, true), engine, control).await?;
    if let (Some(window), Some((report, seconds))) = (&mut facts.window, bare) {
        window.without_halo = Some(report);
        facts.seconds.columns += seconds;
    }
    Ok((mesh, facts))
}

/// What the report of a part with a halo would be without it, and how long that took; None without a halo, or where the columns do
/// not fit in memory.
async fn bare_report(
    job: &Job,
    sources: &[Source],
    check: &Check<'_>,
    engine: &mut Engine,
    control: &Control,
) -> Result<Option<(serde_json::Value, f64)>> {
    if job.part.is_none() || job.halo.is_none_or(|halo| halo == 0) {
        return Ok(None);
    }
    let mut clock = Instant::now();
    check(&prepare(job, sources.to_vec())?)?;
    let bare = set!(Job { halo: None, halo_edge: None, ..job.clone() });
    let (options, control) = (MeshOptions::default(), control.without_progress());
    match meshed(&bare, sources.to_vec(), (&options, &|_| Ok(()), false), engine, &control).await {
        Ok((_, facts)) => {
            // as text and back: less code in wasm than a second form
            let text = Report::new(facts, CallerFacts::default()).to_json();
            let report = serde_json::from_str(&text).unwrap_or_default();
            Ok(Some((report, lap(&mut clock))))
        }
        Err(error) if error.code() == "memory" => Ok(None),
        Err(error) => Err(error),
    }
}

/// Meshes a job; what it asks for beside the cells only if that shall be measured.
async fn meshed(
    job: &Job,
    sources: Vec<Source>,
    (options, check, is_measured): (&MeshOptions, &Check<'_>, bool),
    engine: &mut Engine,
    control: &Control,
) -> Result<(Mesh, MeshFacts)> {
    let inputs: Vec<InputReport> = sources.iter().map(InputReport::new).collect();
    let n_solids: Vec<usize> = sources.iter().map(|source| source.contents.solids.len()).collect();
    let mut clock = Instant::now();
    let prepared = prepare(job, sources)?.halved(job, options.halved)?;
    check(&prepared)?;
    let lines = lap(&mut clock);
    control.rest().await?;
    let memory = memory_of(job, options, &prepared, control)?;
    let task = Task { job, options, prepared: &prepared, inputs: &inputs, memory: &memory, control, is_measured };
    let (frame, mut surfaces) = Surfaces::new(&task).await?;
    let mut cut = Cut::new(&task, frame, &mut surfaces).await?;
    let budget = memory_budget(job, options, &prepared, (engine, &cut.frame, cut.parts_bytes(&task)), control).await?;
    control.rest().await?;
    let snap = lap(&mut clock);
    let mut backend = Backend { engine, budget: &budget, control };
    let meshed = Meshed::new(&task, &mut cut, &mut backend).await?;
    let columns = lap(&mut clock);
    let uncut = surfaces.uncut.take();
    let measured = Measured::new(&task, uncut.as_ref(), (&cut, &meshed), &mut backend).await?;
    let measured_seconds = uncut.map(|_| lap(&mut clock));
    let borders = Borders::new(&task, &mut surfaces, (&cut, &meshed), &mut backend).await?;
    let stages = Stages { task, surfaces, cut, meshed, measured, borders };
    let (mesh, mut facts) = stages.facts(engine, &n_solids).await?;
    let (measured, device, report) = (measured_seconds, engine.seconds, lap(&mut clock));
    facts.seconds = Seconds { lines, snap, columns, measured, device, report, ..Seconds::default() };
    Ok((mesh, facts))
}

/// Seconds since the last call.
fn lap(clock: &mut Instant) -> f64 {
    let now = Instant::now();
    now.duration_since(std::mem::replace(clock, now)).as_secs_f64()
}
