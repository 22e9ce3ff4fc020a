//! The facts: what all stages found, as a mesh and what its report says of it.

use super::borders::Borders;
use super::cut::Cut;
use super::engine::Engine;
use super::halo::Beyond;
use super::measured::Measured;
use super::meshed::Meshed;
use super::prepare::{Prepared, Task};
use super::remedies::add_remedies;
use super::shell_checks::Checked;
use super::surfaces::Surfaces;
use super::warnings;
use crate::meshing::report::{
    CertificateReport, ConformalReport, DeviceCheck, DistanceReport, DoubtReport, FillReport, FlagReport,
    FractionsReport, GeometryReport, LinksReport, MeshFacts, OpenReport, PeakBytes, Seconds, ShellsReport,
    StaggeredReport, TensorsReport, WindowReport, WindowSums, WithoutCells, flag_reports, thick_flags,
};
use hexcast_core::base::error::Result;
use hexcast_core::base::finding::{Finding, in_order_of_codes, sentences};
use hexcast_core::cells::columns::Columns;
use hexcast_core::cells::fingerprint::{flags_hash, flags_sum};
use hexcast_core::cells::volumes::Volumes;
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::lines::{Grading, Lines, about_fine_cells, residuals};
use hexcast_core::grid::rays::Rays;
use hexcast_core::input::job::{AxisChoice, DEFAULT_CELLS, DEFAULT_GROWTH, DEFAULT_TOLERANCE, HaloEdge, Job};
use hexcast_core::set;
use hexcast_core::stages::cast::Cast;
use hexcast_derived::certificate::{Certificate, DEFAULT_THIN_CELLS};
use hexcast_derived::cut_cells::conformal::Conformal;
use hexcast_derived::gaps::{Gaps, NAME};
use hexcast_derived::mesh::{Mesh, Named};
use hexcast_derived::staggered::Staggered;

/// All that the stages of a mesh made.
pub(super) struct Stages<'a> {
    pub(super) task: Task<'a>,
    pub(super) surfaces: Surfaces,
    pub(super) cut: Cut,
    pub(super) meshed: Meshed,
    pub(super) measured: Measured,
    pub(super) borders: Borders,
}

/// What findings are about.
struct Known<'a> {
    geometries: &'a [GeometryReport],
    flags: &'a [FlagReport],
    open: &'a [OpenReport],
    filled: &'a [FillReport],
    shells: &'a [ShellsReport],
    certificate: Option<&'a CertificateReport>,
    covered: Vec<Finding>,
    /// Of the mesh.
    lines: &'a Lines,
    odd_rays: u64,
    n_rays: u64,
}

impl Stages<'_> {
    /// The mesh and its facts, but for the seconds; `n_solids` has the number of solids of each file.
    ///
    /// # Errors
    /// `memory` and `io` of columns in a store; those of [`Checked::all`].
    pub(super) async fn facts(self, engine: &Engine, n_solids: &[usize]) -> Result<(Mesh, MeshFacts)> {
        let peak_bytes = self.peak_bytes();
        let Stages { task, surfaces, cut, meshed, measured, borders } = self;
        let &Task { job, prepared, .. } = &task;
        let (whole, beyond, cells) = (&prepared.whole, Beyond::new(prepared), prepared.cast_cells());
        let (gaps, used) = (meshed.gaps, meshed.used);
        let columns = beyond.around(meshed.columns)?;
        let (lines, rays) = (prepared.mesh_lines(), *columns.rays());
        let n_cells = columns.cells_per_flag();
        let Volumes { of_flags: volumes, totals } = Volumes::new(&columns, &lines, whole)?;
        let geometries = geometry_reports(&task, &surfaces, &cut, (&columns, &volumes)).await?;
        let (found, along, doubtful) = match meshed.overlay {
            Some(overlay) => overlay.found()?,
            None => (Vec::new(), Vec::new(), meshed.no_doubt.finish()?),
        };
        let doubtful = beyond.around_doubtful(doubtful)?;
        let open: Vec<OpenReport> = found.iter().map(|found| OpenReport::new(found, &geometries)).collect();
        let filled: Vec<FillReport> = along.iter().map(|found| FillReport::new(found, &geometries)).collect();
        let (mut flags, mut names) = (flag_reports(&geometries, &n_cells, &volumes, &lines), prepared.names.clone());
        if let Some(gaps) = &gaps {
            add_gaps(gaps, &volumes, (&mut flags, &mut names));
        }
        let shells = cut.shells(&task, &surfaces);
        let whole_rays = Rays::new(prepared.rays.axis, whole.dims());
        let cast = Cast { frame: cut.frame_of_whole(), rays: &whole_rays, rule: job.rule };
        let certificate = borders.gaps.map(|gaps| {
            let asked = (&prepared.geometries[..], job.thin_cells.unwrap_or(DEFAULT_THIN_CELLS));
            let found = Certificate::new(&cast, cells, whole, asked, gaps);
            (CertificateReport::new(&found, &geometries, &names, whole), found.overlaps)
        });
        let (certificate, overlaps) = certificate.unzip();
        let mut findings = task.findings(
            engine,
            Known {
                geometries: &geometries,
                flags: &flags,
                open: &open,
                filled: &filled,
                shells: &shells,
                certificate: certificate.as_ref(),
                covered: borders.covered,
                lines: &lines,
                odd_rays: columns.odd_rays(),
                n_rays: rays.n_rays(),
            },
        );
        let (plates, walls) = (borders.plates, borders.walls);
        let mesh =
            Mesh::new(lines.clone(), columns, names, prepared.unit.clone())?.with_plates(plates).with_walls(walls);
        let mesh = mesh.with_outline(measured.outline);
        let columns = mesh.columns();
        // a geometry may well have no cell in a window
        let has_whole = prepared.window.is_none();
        let without_cells = match has_whole || job.part.is_some() && prepared.halo == 0 {
            true => Some(warnings::geometries_without_cells(prepared, (&cast, &surfaces.ends), &mesh, &n_cells)?),
            false => None,
        };
        let without_cells = task.with_remedies(&mut findings, without_cells);
        if has_whole {
            findings.retain(|finding| finding.code != "shell-lost" || !is_without_cells(finding, &without_cells));
            findings.extend(without_cells.iter().flatten().filter_map(|of| of.finding.clone()));
        }
        let findings = in_order_of_codes(findings);
        // spilled columns would be read back for it
        let flags_hash = (!columns.is_spilled()).then(|| flags_hash(columns)).transpose()?;
        let window = prepared.asked.map(|asked| window_report(asked, prepared, (columns, measured.staggered.as_ref())));
        let overlaps = overlaps.as_deref().unwrap_or_default();
        let sums = WindowSums::new(totals.as_ref(), measured.fractions.as_ref(), overlaps);
        let (volume_bounds, runs) = (cut.bounds_of_whole, borders.runs);
        let window =
            window.transpose()?.map(|of| WindowReport { sums, volume_bounds, runs, shells, without_cells, ..of });
        let (adapter, driver) = engine.adapter().map(|(name, driver)| (name.into(), driver.into())).unzip();
        let mask_mesh = |mask| Mesh::new(lines.clone(), mask, vec![Named::new(1, "doubtful")], prepared.unit.clone());
        let of_conformal = |of: &Conformal| ConformalReport::new(of, whole, prepared.unit.as_deref());
        let facts = MeshFacts {
            version: env!("CARGO_PKG_VERSION"),
            backend: engine.backend(),
            adapter,
            driver,
            fallback: engine.fallback.clone(),
            device_check: used.checked.map(|[rays, differing]| DeviceCheck { rays, differing }),
            unit: prepared.unit.clone(),
            inputs: task.inputs.to_vec(),
            dims: lines.dims(),
            origin: lines.origin(),
            spacing: lines.spacing(),
            grading: Grading::of(&lines, prepared.unit.as_deref()),
            whole: whole.clone(),
            window,
            end_points: residuals(whole, &prepared.domain),
            snap_in_cells: cut.frame.snap_in_cells(),
            rule: job.rule,
            ray_axis: ["x", "y", "z"][rays.axis],
            rays: rays.n_rays(),
            rays_kept: meshed.rays_kept,
            crossings: columns.n_crossings(),
            runs: columns.n_runs(),
            odd_rays: columns.odd_rays(),
            open,
            filled,
            cells: lines.n_cells(),
            flags,
            flags_hash,
            certificate,
            links_report: measured.links.as_ref().map(LinksReport::new),
            links: measured.links,
            fractions_report: measured.fractions.as_ref().map(FractionsReport::new),
            fractions: measured.fractions,
            staggered_report: measured.staggered.as_ref().map(StaggeredReport::new).transpose()?,
            staggered: measured.staggered,
            conformal_report: measured.conformal.as_ref().map(of_conformal),
            conformal: measured.conformal,
            distance_report: measured.distance.as_ref().map(DistanceReport::new),
            distance: measured.distance,
            tensors_report: measured.tensors.as_ref().map(TensorsReport::new),
            tensors: measured.tensors,
            doubtful: DoubtReport::new(&doubtful),
            doubt: doubtful.mask.map(mask_mesh).transpose()?,
            job: effective(job, prepared, n_solids, gaps.as_ref()),
            gaps,
            geometries,
            warnings: sentences(&findings),
            findings,
            peak_bytes: PeakBytes { spilled: columns.spilled_bytes(), ..peak_bytes },
            seconds: Seconds::default(),
        };
        Ok((mesh, facts))
    }

    /// What meshing took of memory.
    fn peak_bytes(&self) -> PeakBytes {
        let Stages { task, cut, meshed, .. } = self;
        let read: u64 = task.prepared.geometries.iter().map(|geometry| geometry.facets.n_bytes()).sum();
        let snapped = |frame: &Frame| 36 * frame.facets.capacity() + 2 * frame.position_of_facet.capacity();
        let of_uncut = cut.uncut.as_ref().map_or(0, |(_, uncut)| snapped(uncut));
        let facet_bytes = read + (snapped(&cut.frame) + of_uncut) as u64;
        let meshing = facet_bytes + meshed.used.host_bytes + meshed.overlay_bytes + meshed.columns_peak;
        PeakBytes { host: None, meshing, device: meshed.used.device_bytes, spilled: 0 }
    }
}

impl Task<'_> {
    /// What the reader should know, but for geometries without cells.
    fn findings(&self, engine: &Engine, known: Known<'_>) -> Vec<Finding> {
        let &Task { job, prepared, inputs, .. } = self;
        let Known { geometries, flags, open, filled, shells, certificate, covered, lines, odd_rays, n_rays } = known;
        let (whole, cells) = (&prepared.whole, prepared.cast_cells());
        let of_failed = |why| Finding::new("gpu-failed", format!("meshed on the CPU: {why}"));
        let mut findings: Vec<Finding> = engine.fallback.iter().filter(|_| engine.has_failed).map(of_failed).collect();
        findings.extend(warnings::about_inputs(inputs));
        findings.extend(prepared.notices.iter().cloned());
        findings.extend(warnings::about_thin_conductors(job, &prepared.geometries));
        findings.extend(about_fine_cells(job, &prepared.domain, whole));
        findings.extend(open.iter().map(|open| open.finding(&geometries[open.index], lines)));
        findings.extend(warnings::about_odd_rays(odd_rays, n_rays));
        findings.extend(warnings::about_edges_of_rays(&prepared.geometries, geometries, job.rule, lines));
        findings.extend(warnings::about_inside_out(geometries));
        findings.extend(warnings::about_shared_flags(&prepared.geometries));
        let whole_rays = Rays::new(prepared.rays.axis, whole.dims());
        findings.extend(warnings::about_shells(shells, geometries, &whole_rays, cells));
        findings.extend(geometries.iter().enumerate().flat_map(|(index, of)| of.shell_findings(index, whole)));
        findings.extend(thick_flags(flags, filled, geometries));
        findings.extend(certificate.iter().flat_map(|certificate| certificate.findings(lines)));
        findings.extend(covered);
        findings
    }

    /// Says what to do about findings, and about geometries without cells.
    fn with_remedies(
        &self,
        findings: &mut [Finding],
        mut without_cells: Option<Vec<WithoutCells>>,
    ) -> Option<Vec<WithoutCells>> {
        let geometries = &self.prepared.geometries;
        add_remedies(findings, self.job, geometries);
        let of_empty = without_cells.iter_mut().flatten().filter_map(|of| of.finding.as_mut());
        of_empty.for_each(|finding| add_remedies(std::slice::from_mut(finding), self.job, geometries));
        without_cells
    }
}

/// What is known of each geometry.
///
/// # Errors
/// Those of [`Checked::all`].
async fn geometry_reports(
    task: &Task<'_>,
    surfaces: &Surfaces,
    cut: &Cut,
    (columns, volumes): (&Columns, &[f64; 256]),
) -> Result<Vec<GeometryReport>> {
    let &Task { job, prepared, memory, control, .. } = task;
    let Surfaces { closed, bound_sums, .. } = surfaces;
    let with_edges = prepared.geometries.iter().zip(surfaces.bad_edges.iter().cloned());
    let mut reports: Vec<GeometryReport> =
        with_edges.map(|(geometry, bad)| GeometryReport::new(geometry, bad)).collect();
    let frame = cut.frame_of_whole();
    let checked = Checked { job, prepared, memory, frame, closed, bound_sums, columns, volumes };
    let checks = if job.quick { Vec::new() } else { checked.all(control).await? };
    reports.iter_mut().zip(checks).for_each(|(report, check)| report.shells = check);
    reports.iter_mut().zip(&cut.bounds).for_each(|(report, bound)| report.volume_bound = *bound);
    for (position, &index) in frame.ranks.geometry_at.iter().enumerate() {
        let geometry = &prepared.geometries[index];
        reports[index].has_volume = closed[position].nonzero && !geometry.shell && !geometry.invert;
    }
    Ok(reports)
}

/// Adds the flag of closed gaps; one that a geometry has, too, has no volume to compare with.
fn add_gaps(gaps: &Gaps, volumes: &[f64; 256], (flags, names): (&mut Vec<FlagReport>, &mut Vec<Named>)) {
    let (mesh_volume, volume_bound) = (None, None);
    let place = flags.partition_point(|report| report.flag < gaps.flag);
    match flags.get_mut(place).filter(|report| report.flag == gaps.flag) {
        Some(report) => (report.mesh_volume, report.volume_bound) = (mesh_volume, volume_bound),
        None => {
            let (flag, name, cells, volume) = (gaps.flag, NAME.into(), gaps.cells, volumes[usize::from(gaps.flag)]);
            flags.insert(place, FlagReport { flag, name, cells, volume, mesh_volume, volume_bound });
            names.push(Named::new(flag, NAME));
        }
    }
}

/// Whether a finding is about a geometry of which is said that it has no cell at all.
fn is_without_cells(finding: &Finding, without_cells: &Option<Vec<WithoutCells>>) -> bool {
    let mut known = without_cells.iter().flatten();
    known.any(|of| of.finding.is_some() && finding.geometry.as_ref().is_some_and(|named| named.index == of.geometry))
}

/// The job with all that it left to defaults filled in; `n_solids` has the number of solids of each file.
///
/// What chooses the cells stays as it is: the numbers of the lines would be rounded again.
fn effective(job: &Job, prepared: &Prepared, n_solids: &[usize], gaps: Option<&Gaps>) -> Job {
    let mut job = set!(Job { max_memory: None, unit: prepared.unit.clone(), ..job.clone() });
    let is_sized = job.dims.is_some() || job.cell_size.is_some() || job.max_cell_size.is_some();
    if job.cells.is_none() && !is_sized && job.lines.is_none() && job.graded.is_none() {
        job.cells = Some(DEFAULT_CELLS);
    }
    if job.max_cell_size.is_some() {
        job.tolerance = job.tolerance.or(Some(DEFAULT_TOLERANCE));
    }
    if let Some(graded) = &mut job.graded {
        graded.growth = graded.growth.or(Some(DEFAULT_GROWTH));
    }
    if job.certify {
        job.thin_cells = job.thin_cells.or(Some(DEFAULT_THIN_CELLS));
    }
    if job.halo.is_some() {
        job.halo_edge = job.halo_edge.or(Some(HaloEdge::default()));
    }
    job.gap_flag = gaps.map(|gaps| gaps.flag);
    job.axis = [AxisChoice::X, AxisChoice::Y, AxisChoice::Z][prepared.rays.axis];
    let (split, invert) = (std::mem::take(&mut job.split), std::mem::take(&mut job.invert));
    let mut first = 0;
    for (entry, n_solids) in job.geometries.iter_mut().zip(n_solids) {
        if let Some(geometry) = prepared.geometries.get(first) {
            entry.flag = Some(geometry.flag);
            (entry.open, entry.fill) = (Some(geometry.open), Some(geometry.fill));
            (entry.split, entry.invert) = (entry.split || split, entry.invert || invert);
            entry.name = (!entry.split).then(|| geometry.name.clone());
        }
        first += if entry.split { *n_solids } else { 1 };
    }
    job
}

/// Says which cells were meshed.
fn window_report(
    [first, end]: [[u32; 3]; 2],
    prepared: &Prepared,
    (columns, staggered): (&Columns, Option<&Staggered>),
) -> Result<WindowReport> {
    let Prepared { whole, halo, .. } = prepared;
    let has_sum = *halo == 0 && !columns.is_spilled();
    let flags_sum = has_sum.then(|| flags_sum(columns, first, whole.dims())).transpose()?;
    let (of, origin, halo, shells) = (whole.dims(), whole.origin(), *halo, Vec::new());
    let staggered = staggered.map(|points| StaggeredReport::of_window(points, end, of)).transpose()?;
    let (volume_bounds, runs, without_cells) = (None, None, None);
    let (sums, without_halo) = (WindowSums::default(), None);
    Ok(WindowReport {
        first,
        end,
        of,
        origin,
        halo,
        flags_sum,
        sums,
        volume_bounds,
        runs,
        staggered,
        shells,
        without_cells,
        without_halo,
    })
}
