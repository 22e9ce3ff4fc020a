//! The pipeline: the line of data from read files to a mesh and the facts of its report, and the only choice of backend.
//!
//! # Theory
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

use web_time::Instant;

use crate::cast::Cast;
use crate::certificate::{Certificate, DEFAULT_THIN_CELLS};
use crate::closed::{BadEdges, Closed};
use crate::columns::Columns;
use crate::control::Control;
use crate::doubt::Doubt;
use crate::error::{Error, Result};
use crate::fingerprint::{flags_hash, flags_sum};
use crate::frame::Frame;
use crate::gaps::{self, Gaps, NAME};
use crate::geometry::{Fill, Geometry};
use crate::job::Job;
use crate::lines::{Lines, about_fine_cells, residuals};
use crate::mesh::{Mesh, Named};
use crate::overlay::{self, Overlay};
use crate::report::{
    CertificateReport, DeviceCheck, DoubtReport, FillReport, FlagReport, GeometryReport, InputReport, MAX_BOXES,
    MeshFacts, OpenReport, PeakBytes, Seconds, WindowReport, flag_reports, is_cut,
};
use crate::snapping::Snapped;
use crate::sources::Source;
use crate::volume_bound::BoundSums;

mod effective;
mod engine;
mod halo;
mod memory_budget;
mod merge;
mod options;
mod prepare;
mod snapped;
mod warnings;

use effective::effective;
pub use engine::{Engine, Used};
use halo::{Beyond, lines_with_halo};
use memory_budget::{columns_builder, memory_budget};
pub use merge::merge;
pub use options::{DEFAULT_MAX_BYTES, MeshOptions, SpillTarget};
pub use prepare::{Prepared, part_step, prepare};
use snapped::snapped;

/// Meshes a job: `sources[i]` is the file of `job.geometries[i]`. The caller makes the report from the facts, when all is done.
///
/// # Errors
/// Those of [`prepare`], [`Frame::new`], [`Engine::columns`], [`crate::estimate::MemoryBudget::new`] and
/// [`crate::columns::ColumnsBuilder::resume`].
pub async fn mesh(
    job: &Job,
    sources: Vec<Source>,
    options: &MeshOptions,
    engine: &mut Engine,
    control: &Control,
) -> Result<(Mesh, MeshFacts)> {
    let inputs: Vec<InputReport> = sources.iter().map(InputReport::new).collect();
    let n_solids: Vec<usize> = sources.iter().map(|source| source.contents.solids.len()).collect();
    let mut clock = Instant::now();
    let prepared = prepare(job, sources)?;
    let lines_seconds = lap(&mut clock);
    control.rest().await?;
    let Snapped { frame, closed, mut ends, bound_sums } = snapped(job, &prepared, control).await?;
    let flags = frame.ranks.flag_of_rank.clone();
    let (whole, is_for_window) = (&prepared.whole, prepared.window.is_some());
    let bad_edges = BadEdges::of_geometries(&frame, &closed, whole, &prepared.geometries);
    control.rest().await?;
    let (mut frame, mut parts) = overlay::split(frame, &closed, job.rule, whole, &prepared.geometries, is_for_window)?;
    if !parts.is_empty() {
        let apart = (0..ends.len()).filter(|&rank| frame.range_of_rank(rank).is_empty());
        apart.for_each(|rank| ends[rank] = None);
    }
    let volume_bounds = |lines| volume_bounds((&frame, &closed, &bound_sums), &prepared.geometries, lines);
    // of the whole box, where a part's report shall be merged with others
    let bounds_of_whole = job.part.map(|_| volume_bounds(whole));
    let bounds = volume_bounds(&prepared.lines);
    if let Some(cells) = prepared.window {
        parts = parts.into_iter().map(|part| part.window(cells, frame.fraction_bits)).collect();
        frame = frame.window(cells);
    }
    let parts_bytes = parts.iter().map(|part| part.n_bytes(&prepared.rays, frame.fraction_bits)).sum();
    let budget = memory_budget(job, options, &prepared, (engine, parts_bytes), control).await?;
    control.rest().await?;
    let snap_seconds = lap(&mut clock);
    let names = names(&prepared.geometries);
    // half of it for the mask
    let columns_bytes = if options.doubt_mask { budget.columns / 2 } else { budget.columns };
    let mut builder = columns_builder(job, &options.spill, columns_bytes, &prepared, (&names, &inputs))?;
    let rays_resumed = builder.n_rays();
    let cast = Cast { frame: &frame, rays: &prepared.rays, rule: job.rule };
    let (mut decided, mut used) = (Vec::with_capacity(parts.len()), Used::default());
    for part in parts {
        let (crossings, more) = engine.axis_crossings(&part.casts(&cast), cast.rays, budget.bands, control).await?;
        decided.push((part, crossings));
        used = used.and(more);
    }
    let doubt = || Doubt::new(prepared.rays, MAX_BOXES, options.doubt_mask.then_some(columns_bytes));
    let mut overlay = Overlay::new(decided, &cast, &flags, &prepared.lines, doubt());
    overlay.iter_mut().try_for_each(|overlay| overlay.pass(rays_resumed))?;
    let overlay_bytes = overlay.as_ref().map_or(0, Overlay::n_bytes);
    used = used.and(engine.build(&cast, &budget, &mut builder, &mut overlay, control).await?);
    let columns_peak = builder.peak_bytes;
    let mut columns = builder.finish()?;
    let gaps = close_gaps(job, &prepared, &mut columns, budget.columns, control)?;
    let beyond = Beyond::new(&prepared);
    let columns = beyond.around(columns)?;
    let columns_seconds = lap(&mut clock);

    let (lines, rays) = (lines_with_halo(&prepared), columns.rays);
    let mut geometries: Vec<GeometryReport> =
        prepared.geometries.iter().zip(bad_edges).map(|(geometry, bad)| GeometryReport::new(geometry, bad)).collect();
    let cells = columns.cells_per_flag();
    let (found, along, doubtful) = match overlay {
        Some(overlay) => overlay.found()?,
        None => (Vec::new(), Vec::new(), doubt().finish()?),
    };
    let doubtful = beyond.around_doubtful(doubtful)?;
    let open: Vec<OpenReport> = found.iter().map(|found| OpenReport::new(found, &geometries)).collect();
    let filled: Vec<FillReport> = along.iter().map(|found| FillReport::new(found, &geometries)).collect();
    geometries.iter_mut().zip(bounds).for_each(|(report, bound)| report.volume_bound = bound);
    let mut flags = flag_reports(&geometries, &cells, &lines);
    for report in flags.iter_mut().filter(|report| gaps.as_ref().is_some_and(|gaps| gaps.flag == report.flag)) {
        (report.mesh_volume, report.volume_bound) = (None, None);
    }
    let mut names = names;
    if let Some(gaps) = gaps.as_ref().filter(|gaps| geometries.iter().all(|geometry| geometry.flag != gaps.flag)) {
        let volume = gaps.cells as f64 * lines.cell_volume();
        let (mesh_volume, volume_bound) = (None, None);
        let name = NAME.into();
        let place = flags.partition_point(|report| report.flag < gaps.flag);
        flags.insert(place, FlagReport { flag: gaps.flag, name, cells: gaps.cells, volume, mesh_volume, volume_bound });
        names.push(Named { flag: gaps.flag, name: NAME.into() });
    }
    let mut warnings: Vec<String> = engine.fallback.iter().map(|why| format!("meshed on the CPU: {why}")).collect();
    warnings.extend(about_fine_cells(job, &prepared.domain, &prepared.whole));
    warnings.extend(open.iter().zip(&found).map(|(open, found)| open.warning(&geometries[found.geometry], &lines)));
    warnings.extend(warnings::about_odd_rays(columns.odd_rays(), rays.n_rays()));
    warnings.extend(warnings::about_edges_of_rays(&prepared.geometries, &geometries, job.rule, &lines));
    warnings.extend(warnings::about_shared_flags(&prepared.geometries));
    // of a window some facets are not there
    let agrees = |rank: usize| match prepared.window {
        None => closed[rank].nonzero,
        Some(_) => Closed::new(frame.facets_of_rank(rank)).nonzero,
    };
    warnings.extend(warnings::about_overlapping_shells(&cast, &agrees, &prepared.geometries));
    let mask_mesh = |mask| Mesh::new(lines, mask, vec![Named { flag: 1, name: "doubtful".into() }], job.unit.clone());
    let certify = || {
        let thin_cells = job.thin_cells.unwrap_or(DEFAULT_THIN_CELLS);
        let found = Certificate::new(&cast, &columns, &lines, &prepared.geometries, thin_cells)?;
        Ok(CertificateReport::new(&found, &geometries, &names, &lines))
    };
    let certificate = job.certify.then(certify).transpose()?;
    warnings.extend(certificate.iter().flat_map(|certificate| certificate.warnings(&lines)));
    let mesh = Mesh::new(lines, columns, names, job.unit.clone())?;
    let columns = &mesh.columns;
    // a geometry may well have no cell in a window
    if prepared.window.is_none() {
        warnings.extend(warnings::about_geometries_without_cells(&prepared, (&cast, &ends), &mesh, &cells)?);
    }
    // spilled columns would be read back for it
    let flags_hash = (!columns.is_spilled()).then(|| flags_hash(columns)).transpose()?;
    let window = prepared.asked.map(|cells| window_report(cells, &prepared, columns, bounds_of_whole)).transpose()?;
    let (adapter, driver) = engine.adapter().map(|(name, driver)| (name.into(), driver.into())).unzip();
    let n_facets: usize = prepared.geometries.iter().map(|geometry| geometry.facets.len()).sum();
    let facet_bytes = 36 * (n_facets + frame.facets.capacity()) + frame.rank_of_facet.capacity();
    let facts = MeshFacts {
        version: env!("CARGO_PKG_VERSION"),
        backend: engine.backend(),
        adapter,
        driver,
        device_check: used.checked.map(|[rays, differing]| DeviceCheck { rays, differing }),
        unit: job.unit.clone(),
        inputs,
        dims: lines.dims,
        origin: lines.origin,
        spacing: lines.spacing,
        whole: prepared.whole,
        window,
        end_points: residuals(&prepared.whole, &prepared.domain),
        snap_in_cells: frame.snap_in_cells(),
        rule: job.rule,
        ray_axis: ["x", "y", "z"][rays.axis],
        rays: rays.n_rays(),
        rays_kept: rays_resumed,
        crossings: columns.n_crossings(),
        runs: columns.n_runs(),
        odd_rays: columns.odd_rays(),
        open,
        filled,
        cells: lines.n_cells(),
        flags,
        flags_hash,
        certificate,
        doubtful: DoubtReport::new(&doubtful),
        doubt: doubtful.mask.map(mask_mesh).transpose()?,
        job: effective(job, &prepared, &n_solids, gaps.as_ref()),
        gaps,
        geometries,
        warnings,
        peak_bytes: PeakBytes {
            host: None,
            meshing: facet_bytes as u64 + used.host_bytes + overlay_bytes + columns_peak,
            device: used.device_bytes,
            spilled: columns.spilled_bytes(),
        },
        seconds: Seconds {
            lines: lines_seconds,
            snap: snap_seconds,
            columns: columns_seconds,
            device: engine.seconds,
            report: lap(&mut clock),
            ..Seconds::default()
        },
    };
    Ok((mesh, facts))
}

/// For each geometry how far the volume of its cells can be from that of its surface, where both are of the same body.
fn volume_bounds(
    (frame, closed, sums): (&Frame, &[Closed], &[BoundSums]),
    geometries: &[Geometry],
    lines: &Lines,
) -> Vec<Option<f64>> {
    let mut bounds = vec![None; geometries.len()];
    for (rank, &index) in frame.ranks.geometry_of_rank.iter().enumerate() {
        let geometry = &geometries[index];
        let is_within = geometry.fill == Fill::Centre && !geometry.invert && closed[rank].nonzero;
        let ends = geometry.bounding_box().unwrap_or_default();
        if is_within && !is_cut(ends, lines) {
            let volume = geometry.signed_volume().abs();
            bounds[index] = Some(sums[rank].bound(frame.fraction_bits, lines, volume));
        }
    }
    bounds
}

/// Says which cells were meshed.
fn window_report(
    [first, end]: [[u32; 3]; 2],
    prepared: &Prepared,
    columns: &Columns,
    volume_bounds: Option<Vec<Option<f64>>>,
) -> Result<WindowReport> {
    let Prepared { whole, halo, .. } = prepared;
    let has_sum = *halo == 0 && !columns.is_spilled();
    let flags_sum = has_sum.then(|| flags_sum(columns, first, whole.dims)).transpose()?;
    Ok(WindowReport { first, end, of: whole.dims, origin: whole.origin, halo: *halo, flags_sum, volume_bounds })
}

/// Closes gaps in columns, if the job asks for it.
fn close_gaps(
    job: &Job,
    prepared: &Prepared,
    columns: &mut Columns,
    max_bytes: u64,
    control: &Control,
) -> Result<Option<Gaps>> {
    let Some(width) = job.close_gaps else { return Ok(None) };
    let greatest = prepared.geometries.iter().map(|geometry| geometry.flag).max().unwrap_or(0);
    let Some(flag) = job.gap_flag.or_else(|| greatest.checked_add(1)) else {
        let message = "a geometry has flag 255, so that none follows for the closed gaps";
        return Err(Error::new("job-value", message, "give gap_flag (--gap-flag), which may be that of a geometry"));
    };
    let (closed, gaps) = gaps::close(columns, &prepared.lines, (width, flag), max_bytes, control)?;
    *columns = closed;
    Ok(Some(gaps))
}

/// Seconds since the last call.
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
