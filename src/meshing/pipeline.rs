//! The pipeline: from the files that were read to a mesh and the facts of its report. The only place that chooses a backend.
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

use crate::meshing::report::{
    CallerFacts, CertificateReport, DeviceCheck, DoubtReport, FillReport, FlagReport, FractionsReport, GeometryReport,
    InputReport, LinksReport, MAX_BOXES, MeshFacts, OpenReport, PeakBytes, Report, Seconds, StaggeredReport,
    WindowReport, WindowSums, WithoutCells, flag_reports, is_cut, thick_flags,
};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::finding::{Finding, in_order_of_codes, sentences};
use hexcast_core::cells::columns::Columns;
use hexcast_core::cells::fingerprint::flags_hash;
use hexcast_core::cells::volumes::Volumes;
use hexcast_core::derived::certificate::{Certificate, DEFAULT_THIN_CELLS};
use hexcast_core::derived::gaps::{self, Gaps, NAME};
use hexcast_core::derived::mesh::{Mesh, Named};
use hexcast_core::derived::walls::Candidates;
use hexcast_core::grid::closed::{BadEdges, Closed};
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::lines::{Grading, Lines, about_fine_cells, residuals};
use hexcast_core::grid::rays::Rays;
use hexcast_core::grid::volume_bound::BoundSums;
use hexcast_core::input::geometry::{Fill, Geometry};
use hexcast_core::input::job::Job;
use hexcast_core::input::sources::Source;
use hexcast_core::open_surfaces::doubt::Doubt;
use hexcast_core::open_surfaces::overlay::{self, Overlay};
use hexcast_core::set;
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::snapping::Snapped;

mod borders;
mod effective;
mod engine;
mod halo;
mod measured;
mod memory_budget;
mod merge;
mod names;
#[cfg(feature = "gpu")]
mod on_device;
mod options;
mod plates;
mod prepare;
mod remedies;
mod shell_checks;
mod snapped;
mod staggered;
mod warnings;
mod window_report;

use borders::Whole;
use effective::effective;
use engine::Instant;
pub use engine::{Engine, Used};
use halo::Beyond;
use measured::Uncut;
use memory_budget::{check_copies, columns_builder, memory_budget, memory_of};
pub use merge::merge;
#[cfg(feature = "gpu")]
pub use on_device::mesh_on_device;
pub use options::{DEFAULT_MAX_BYTES, MeshOptions, SpillTarget};
use plates::Plates;
pub use prepare::{Prepared, part_step, prepare};
use remedies::add_remedies;
use shell_checks::Checked;
use snapped::snapped;
pub(crate) use warnings::findings_without_cells;
use window_report::window_report;

/// Meshes a job: `sources[i]` is the file of `job.geometries[i]`. The caller makes the report from the facts, when all is done.
///
/// # Errors
/// Those of [`prepare`], [`Frame::new`], [`Engine::columns`], [`crate::meshing::estimate::Estimate::needed_bytes`] and
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
    let prepared = prepare(job, sources)?;
    check(&prepared)?;
    let lines_seconds = lap(&mut clock);
    control.rest().await?;
    let memory = memory_of(job, options, &prepared, control)?;
    let Snapped { frame, closed, mut ends, bound_sums } = snapped((job, options), &prepared, &memory, control).await?;
    let flags = frame.ranks.flag_of_rank.clone();
    let (whole, is_for_window) = (&prepared.whole, prepared.window.is_some());
    let bad_edges = BadEdges::of_geometries(&frame, &closed, whole, &prepared.geometries, (&memory, control))?;
    check_copies(job, (&frame, &closed), &prepared, &memory)?;
    control.rest().await?;
    let plates = Plates::new(&frame, &ends, &prepared, (memory.left(), control))?;
    let walls = match options.walls {
        true => {
            let cells = prepared.window.unwrap_or([[0; 3], whole.dims()]);
            Some(Candidates::new(&frame, &prepared.geometries, cells, (memory.left(), control))?)
        }
        false => None,
    };
    let uncut_frame = Uncut::new(job, &frame, &closed, &prepared.geometries)?.filter(|_| is_measured);
    let (how, insides) = ((job.rule, is_for_window), &prepared.geometries[..]);
    let (mut frame, mut parts) = overlay::split(frame, &closed, how, (whole, insides), control).await?;
    if !parts.is_empty() {
        let apart = (0..ends.len()).filter(|&position| frame.range_at(position).is_empty());
        apart.for_each(|position| ends[position] = None);
    }
    let volume_bounds = |lines| volume_bounds((&frame, &closed, &bound_sums), &prepared.geometries, lines);
    // of the whole box, where a part's report shall be merged with others
    let bounds = volume_bounds(&prepared.lines);
    let volume_bounds = job.part.map(|_| volume_bounds(whole));
    let whole_rays = Rays::new(prepared.rays.axis, whole.dims());
    let cells = prepared.window.unwrap_or([[0; 3], whole.dims()]);
    let agrees = |position: usize| closed[position].nonzero;
    let shells_of =
        |frame: &Frame| warnings::shells(&Cast { frame, rays: &whole_rays, rule: job.rule }, &agrees, cells);
    let (mut kept, mut shells) = (None, None);
    if is_for_window {
        shells = Some(shells_of(&frame));
        control.rest().await?;
        let near = parts.iter().map(|part| part.window(cells, &frame)).collect();
        let near_frame = frame.window(cells);
        let uncut = (std::mem::replace(&mut parts, near), std::mem::replace(&mut frame, near_frame));
        let is_kept =
            job.certify || job.part.is_some() || job.links.is_some() || !job.conductors.is_empty() || plates.is_some();
        kept = is_kept.then_some(uncut);
    }
    let parts_bytes = parts.iter().map(|part| part.n_bytes(&prepared.rays, &frame)).sum();
    let budget = memory_budget(job, options, &prepared, (engine, parts_bytes), control).await?;
    control.rest().await?;
    let snap_seconds = lap(&mut clock);
    let mut names = prepared.names.clone();
    // half of it for the mask
    let columns_bytes = if options.doubt_mask { budget.columns / 2 } else { budget.columns };
    let mut builder = columns_builder(job, &options.spill, columns_bytes, &prepared, (&names, &inputs))?;
    let rays_resumed = builder.n_rays();
    let cast = Cast { frame: &frame, rays: &prepared.rays, rule: job.rule };
    let doubt = || Doubt::new(prepared.rays, MAX_BOXES, options.doubt_mask.then_some(columns_bytes));
    let decided = (&flags[..], &prepared.lines, doubt());
    let (mut overlay, mut used) = borders::overlay(parts, &cast, decided, (engine, &budget, control)).await?;
    overlay.iter_mut().try_for_each(|overlay| overlay.pass(rays_resumed))?;
    let overlay_bytes = overlay.as_ref().map_or(0, Overlay::n_bytes);
    used = used.and(engine.build(&cast, &budget, &mut builder, &mut overlay, control).await?);
    let columns_peak = builder.peak_bytes;
    let mut columns = builder.finish()?;
    let gaps = close_gaps(job, &prepared, &mut columns, budget.columns, control)?;
    let columns_seconds = lap(&mut clock);
    let bytes_left = budget.columns.saturating_sub(columns_peak);
    let (frame_of_whole, parts_of_whole) = kept.as_ref().map_or((&frame, &[][..]), |(parts, frame)| (frame, parts));
    let uncut = Whole { frame: frame_of_whole, parts: parts_of_whole, flags: &flags, lines: whole, rule: job.rule };
    let (links, fractions, staggered) = match &uncut_frame {
        Some(of) => of.all(job, (&prepared, &columns, &uncut), (bytes_left, (engine, &budget, control))).await?,
        None => (None, None, None),
    };
    let measured_seconds = uncut_frame.map(|_| lap(&mut clock));
    let is_merged = job.part.is_some() && prepared.halo == 0;
    let begins_rays = prepared.halo == 0 && cells[0][columns.rays().axis] == 0;
    let runs = match is_merged || begins_rays {
        true => Some(uncut.runs(&columns, cells, (engine, &budget, control)).await?),
        false => None,
    };
    let gaps_between = match job.certify {
        true => Some(uncut.gaps(&columns, cells, (engine, &budget, control)).await?),
        false => None,
    };
    let beyond = Beyond::new(&prepared);
    let (plates, covered) = match plates {
        Some(plates) => {
            let near = [
                cells[0].map(|cell| cell.saturating_sub(1)),
                [0, 1, 2].map(|axis| (cells[1][axis] + 1).min(whole.dims()[axis])),
            ];
            let meshed = match near == cells {
                true => None,
                false => {
                    Some(uncut.columns((near, columns.rays().axis), bytes_left, (engine, &budget, control)).await?)
                }
            };
            plates.uncovered((meshed.as_ref().unwrap_or(&columns), near[0]), &prepared, &beyond)?
        }
        None => Default::default(),
    };
    let walls = walls.map(|walls| walls.walls(&columns, |face| beyond.moved(face))).transpose()?;
    let columns = beyond.around(columns)?;
    let (lines, rays) = (prepared.mesh_lines(), *columns.rays());
    let mut geometries: Vec<GeometryReport> =
        prepared.geometries.iter().zip(bad_edges).map(|(geometry, bad)| GeometryReport::new(geometry, bad)).collect();
    let n_cells = columns.cells_per_flag();
    let Volumes { of_flags: volumes, totals } = Volumes::new(&columns, &lines, whole)?;
    let checked = Checked {
        job,
        prepared: &prepared,
        memory: &memory,
        frame: frame_of_whole,
        closed: &closed,
        bound_sums: &bound_sums,
        columns: &columns,
        volumes: &volumes,
    };
    let checks = if job.quick { Vec::new() } else { checked.all(control).await? };
    geometries.iter_mut().zip(checks).for_each(|(report, check)| report.shells = check);
    let (found, along, doubtful) = match overlay {
        Some(overlay) => overlay.found()?,
        None => (Vec::new(), Vec::new(), doubt().finish()?),
    };
    let doubtful = beyond.around_doubtful(doubtful)?;
    let open: Vec<OpenReport> = found.iter().map(|found| OpenReport::new(found, &geometries)).collect();
    let filled: Vec<FillReport> = along.iter().map(|found| FillReport::new(found, &geometries)).collect();
    geometries.iter_mut().zip(bounds).for_each(|(report, bound)| report.volume_bound = bound);
    for (position, &index) in frame_of_whole.ranks.geometry_at.iter().enumerate() {
        let geometry = &prepared.geometries[index];
        geometries[index].has_volume = closed[position].nonzero && !geometry.shell && !geometry.invert;
    }
    let mut flags = flag_reports(&geometries, &n_cells, &volumes, &lines);
    for report in flags.iter_mut().filter(|report| gaps.as_ref().is_some_and(|gaps| gaps.flag == report.flag)) {
        (report.mesh_volume, report.volume_bound) = (None, None);
    }
    if let Some(gaps) = gaps.as_ref().filter(|gaps| geometries.iter().all(|geometry| geometry.flag != gaps.flag)) {
        let volume = volumes[usize::from(gaps.flag)];
        let (mesh_volume, volume_bound) = (None, None);
        let name = NAME.into();
        let place = flags.partition_point(|report| report.flag < gaps.flag);
        flags.insert(place, FlagReport { flag: gaps.flag, name, cells: gaps.cells, volume, mesh_volume, volume_bound });
        names.push(Named::new(gaps.flag, NAME));
    }
    let of_failed = |why| Finding::new("gpu-failed", format!("meshed on the CPU: {why}"));
    let mut findings: Vec<Finding> = engine.fallback.iter().filter(|_| engine.has_failed).map(of_failed).collect();
    findings.extend(warnings::about_inputs(&inputs));
    findings.extend(prepared.notices.iter().cloned());
    findings.extend(warnings::about_thin_conductors(job, &prepared.geometries));
    findings.extend(about_fine_cells(job, &prepared.domain, &prepared.whole));
    findings.extend(open.iter().map(|open| open.finding(&geometries[open.index], &lines)));
    findings.extend(warnings::about_odd_rays(columns.odd_rays(), rays.n_rays()));
    findings.extend(warnings::about_edges_of_rays(&prepared.geometries, &geometries, job.rule, &lines));
    findings.extend(warnings::about_inside_out(&geometries));
    findings.extend(warnings::about_shared_flags(&prepared.geometries));
    let shells = shells.unwrap_or_else(|| shells_of(&frame));
    findings.extend(warnings::about_shells(&shells, &geometries, &whole_rays, cells));
    findings.extend(geometries.iter().enumerate().flat_map(|(index, of)| of.shell_findings(index, whole)));
    findings.extend(thick_flags(&flags, &filled, &geometries));
    let mask_mesh = |mask| Mesh::new(lines.clone(), mask, vec![Named::new(1, "doubtful")], prepared.unit.clone());
    let cast = Cast { frame: frame_of_whole, rays: &whole_rays, rule: job.rule };
    let certificate = gaps_between.map(|gaps| {
        let asked = (&prepared.geometries[..], job.thin_cells.unwrap_or(DEFAULT_THIN_CELLS));
        let found = Certificate::new(&cast, cells, whole, asked, gaps);
        (CertificateReport::new(&found, &geometries, &names, whole), found.overlaps)
    });
    let (certificate, overlaps) = certificate.unzip();
    findings.extend(certificate.iter().flat_map(|certificate| certificate.findings(&lines)));
    findings.extend(covered);
    let mesh = Mesh::new(lines.clone(), columns, names, prepared.unit.clone())?.with_plates(plates).with_walls(walls);
    let columns = mesh.columns();
    // a geometry may well have no cell in a window
    let has_whole = prepared.window.is_none();
    let mut without_cells = match has_whole || is_merged {
        true => Some(warnings::geometries_without_cells(&prepared, (&cast, &ends), &mesh, &n_cells)?),
        false => None,
    };
    add_remedies(&mut findings, job, &prepared.geometries);
    let of_empty = without_cells.iter_mut().flatten().filter_map(|of| of.finding.as_mut());
    of_empty.for_each(|finding| add_remedies(std::slice::from_mut(finding), job, &prepared.geometries));
    if has_whole {
        findings.retain(|finding| finding.code != "shell-lost" || !is_without_cells(finding, &without_cells));
        findings.extend(without_cells.iter().flatten().filter_map(|of| of.finding.clone()));
    }
    let findings = in_order_of_codes(findings);
    // spilled columns would be read back for it
    let flags_hash = (!columns.is_spilled()).then(|| flags_hash(columns)).transpose()?;
    let window =
        prepared.asked.map(|asked| window_report(asked, &prepared, (columns, staggered.as_ref()))).transpose()?;
    let sums = WindowSums::new(totals.as_ref(), fractions.as_ref(), overlaps.as_deref().unwrap_or_default());
    let window = window.map(|of| WindowReport { sums, volume_bounds, runs, shells, without_cells, ..of });
    let backend = engine.backend();
    let (adapter, driver) = engine.adapter().map(|(name, driver)| (name.into(), driver.into())).unzip();
    let n_facets: usize = prepared.geometries.iter().map(|geometry| geometry.facets.len()).sum();
    let snapped = |frame: &Frame| 36 * frame.facets.capacity() + 2 * frame.position_of_facet.capacity();
    let facet_bytes = 36 * n_facets + snapped(&frame) + kept.as_ref().map_or(0, |(_, uncut)| snapped(uncut));
    let facts = MeshFacts {
        version: env!("CARGO_PKG_VERSION"),
        backend,
        adapter,
        driver,
        fallback: engine.fallback.clone(),
        device_check: used.checked.map(|[rays, differing]| DeviceCheck { rays, differing }),
        unit: prepared.unit.clone(),
        inputs,
        dims: lines.dims(),
        origin: lines.origin(),
        spacing: lines.spacing(),
        grading: Grading::of(&lines, prepared.unit.as_deref()),
        whole: prepared.whole.clone(),
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
        links_report: links.as_ref().map(LinksReport::new),
        links,
        fractions_report: fractions.as_ref().map(FractionsReport::new),
        fractions,
        staggered_report: staggered.as_ref().map(StaggeredReport::new).transpose()?,
        staggered,
        doubtful: DoubtReport::new(&doubtful),
        doubt: doubtful.mask.map(mask_mesh).transpose()?,
        job: effective(job, &prepared, &n_solids, gaps.as_ref()),
        gaps,
        geometries,
        warnings: sentences(&findings),
        findings,
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
            measured: measured_seconds,
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
    for (position, &index) in frame.ranks.geometry_at.iter().enumerate() {
        let geometry = &geometries[index];
        let is_within = geometry.fill == Fill::Centre && !geometry.invert && closed[position].nonzero;
        let ends = geometry.bounding_box().unwrap_or_default();
        if is_within && !is_cut(ends, lines) {
            let volume = geometry.signed_volume().abs();
            let bound = |cell| sums[position].bound(frame.fraction_bits, cell, volume);
            bounds[index] = lines.cell_volume().map(bound);
        }
    }
    bounds
}

/// Whether a finding is about a geometry of which is said that it has no cell at all.
fn is_without_cells(finding: &Finding, without_cells: &Option<Vec<WithoutCells>>) -> bool {
    let mut known = without_cells.iter().flatten();
    known.any(|of| of.finding.is_some() && finding.geometry.as_ref().is_some_and(|named| named.index == of.geometry))
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
