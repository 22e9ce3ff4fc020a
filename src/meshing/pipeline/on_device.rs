//! A mesh that stays on the GPU: the stages before the rays as for every mesh, then the bands, whose runs no one reads back.
//!
//! Job, sources -> [`DeviceMesh`]. What a mesh needs beside its rays, such as votes of open surfaces, is done on the host and refused here: a
//! mesh for the host, then [`Gpu::upload`](hexcast_gpu::Gpu::upload), comes to the same buffers. There is no report: its numbers come from the runs.

use super::engine::Engine;
use super::memory_budget::memory_of;
use super::options::MeshOptions;
use super::prepare::{Prepared, Task, prepare};
use super::surfaces::snapped;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::input::job::Job;
use hexcast_core::input::sources::Source;
use hexcast_core::open_surfaces::overlay;
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::snapping::Snapped;
use hexcast_gpu::{DeviceMesh, Options};

/// Meshes a job, and leaves its runs on the GPU of the engine, with the cells of [`super::mesh`]. The host reads counts, and of one ray in 256 the
/// runs, which the CPU casts again; of `options` the limits of memory count.
///
/// # Errors
/// Those of [`super::prepare`] and [`Frame::new`](hexcast_core::grid::frame::Frame::new), and
/// - `no-adapter`: the engine is the CPU.
/// - `job-conflict`: the job asks for what the host makes of the cells, or has a geometry whose cells more than its rays decide.
/// - `memory`: the runs are more than a buffer of the device holds; or facets more than the memory allowed.
/// - `too-many-crossings`: a ray has more runs than a kernel puts in order.
/// - `device-failed`, `device-lost`, `device-wrong`. No CPU takes over, and no other device: the buffers would not be where they are needed.
pub async fn mesh_on_device(
    job: &Job,
    sources: Vec<Source>,
    options: &MeshOptions,
    engine: &Engine,
    control: &Control,
) -> Result<DeviceMesh> {
    let Some(gpu) = engine.gpu() else {
        let message = "a mesh on a device needs a GPU, and the backend is the CPU";
        return Err(Error::new("no-adapter", message, "open the mesher with a device, or with the GPU backend"));
    };
    check(job)?;
    let prepared = prepare(job, sources)?;
    let memory = memory_of(job, options, &prepared, control)?;
    control.rest().await?;
    let (prepared, memory) = (&prepared, &memory);
    let task = Task { job, options, prepared, inputs: &[], memory, control, is_measured: false };
    let Snapped { frame, closed, .. } = snapped(&task).await?;
    let Prepared { whole, geometries, window, rays, .. } = prepared;
    let (frame, parts) =
        overlay::split(frame, &closed, (job.rule, window.is_some()), (whole, geometries), control).await?;
    if let Some(part) = parts.first() {
        let name = &geometries[part.geometry()].name;
        let message = format!(
            "geometry \"{name}\" is open, inverted, a shell or filled along its surface: more than its rays decide its cells"
        );
        return Err(Error::new("job-conflict", message, ON_HOST));
    }
    let frame = match *window {
        Some(cells) => frame.window(cells),
        None => frame,
    };
    let cast = Cast { frame: &frame, rays, rule: job.rule };
    let limits = Options { max_bytes: options.max_device_bytes, ..Options::default() };
    let runs = gpu.resident(&cast, &limits, control).await?;
    Ok(DeviceMesh::new(gpu, runs, prepared.mesh_lines(), prepared.names.clone(), prepared.unit.clone()))
}

const ON_HOST: &str = "mesh it for the host, and upload the mesh to the device (Gpu::upload)";

/// Refuses what a job asks for that is made of the cells on the host.
fn check(job: &Job) -> Result<()> {
    let asked = [
        ("close_gaps", job.close_gaps.is_some()),
        ("halo", job.halo.is_some_and(|halo| halo > 0)),
        ("certify", job.certify),
        ("links", job.links.is_some()),
        ("fractions", job.fractions.is_some()),
        ("staggered", job.staggered),
        ("conformal", job.conformal.is_some()),
        ("distance", job.distance.is_some()),
        ("tensors", job.tensors.is_some()),
        ("cut_cells", job.cut_cells.is_some()),
    ];
    match asked.into_iter().find(|(_, is_asked)| *is_asked) {
        None => Ok(()),
        Some((name, _)) => {
            let message = format!("{name} is made of the cells on the host, and this mesh stays on the device");
            Err(Error::new("job-conflict", message, ON_HOST))
        }
    }
}
