//! The report as text: aligned lines for a terminal.

use std::fmt::{Display, Write};

use hexcast::lines::Grading;
use hexcast::report::{BadEdge, BadEdges, ColumnsReport, MeshFacts, Report};
use indicatif::{BinaryBytes, HumanCount};

use crate::files::output_file::OutputFile;
use crate::screen::terminal::one_line;

/// What else to show.
#[derive(Clone, Copy)]
pub(crate) struct Shown {
    /// End points that lie off the lines.
    pub(crate) ends: bool,
    /// Everything.
    pub(crate) verbose: bool,
}

/// Lines of a label and a text; a repeated label is left out.
#[derive(Default)]
pub(crate) struct Table {
    text: String,
    last: String,
}

impl Table {
    /// Adds a line.
    pub(crate) fn line(&mut self, label: &str, text: impl Display) {
        let shown = if self.last == label { "" } else { label };
        // writing to a String cannot fail
        let _ = writeln!(self.text, "{shown:<11} {}", one_line(&text.to_string()));
        self.last = label.to_string();
    }

    /// All lines.
    pub(crate) fn finish(self) -> String {
        self.text
    }
}

/// Describes a mesh.
pub(crate) fn of_mesh(report: &Report, is_software: bool, files: &[OutputFile], shown: Shown) -> String {
    let (mesh, mut table) = (&report.mesh, Table::default());
    table.line("backend", backend(mesh, is_software));
    if let Some(why) = mesh.fallback.as_ref().filter(|_| shown.verbose) {
        table.line("backend", why);
    }
    for input in &mesh.inputs {
        let facts = format!("{}, {} facets, {}", input.format, HumanCount(input.facets), BinaryBytes(input.bytes));
        let unit = input.unit.unwrap_or_default();
        let converted = input.deviation.map(|of| format!(", at most {} {unit} from its surfaces", short(of)));
        table.line("input", format!("{}: {facts}{}", input.file, converted.unwrap_or_default()));
    }
    if shown.verbose {
        geometries(&mut table, mesh);
    }
    bad_edges(&mut table, mesh);
    grid(&mut table, mesh);
    if shown.ends || shown.verbose {
        end_points(&mut table, mesh, shown.verbose);
    }
    flags(&mut table, mesh);
    for filled in &mesh.filled {
        let kind = if filled.shell { "a shell of" } else { "with" };
        let cells = HumanCount(filled.added_cells);
        table.line(
            "filled",
            format!("\"{}\", {kind} {} fill: {cells} cells added", filled.geometry, filled.fill.name()),
        );
    }
    gaps(&mut table, mesh);
    measured(&mut table, mesh);
    for overlap in mesh.certificate.iter().flat_map(|certificate| &certificate.overlaps) {
        let cells = HumanCount(overlap.cells);
        table.line(
            "overlap",
            format!("{cells} cells of \"{}\" lie in \"{}\", which wins", overlap.loser, overlap.winner),
        );
    }
    stages(&mut table, report, shown.verbose);
    if let Some(hash) = &mesh.flags_hash {
        table.line("flags", format!("hash {hash}"));
    }
    if let Some(hash) = &report.flags_sha256 {
        table.line("flags", format!("sha256 {hash}"));
    }
    for file in files {
        table.line("written", format!("{} ({})", file.path.display(), BinaryBytes(file.n_bytes)));
    }
    table.finish()
}

/// The report of a column file.
pub(crate) fn of_columns(file: &str, n_bytes: Option<u64>, report: &ColumnsReport) -> String {
    let mut table = Table::default();
    let size = n_bytes.map_or(String::new(), |n_bytes| format!(" ({})", BinaryBytes(n_bytes)));
    table.line("file", format!("{file}{size}"));
    table.line("format", "column file");
    let unit = report.unit.map_or(String::new(), |unit| format!(" {unit}"));
    let [nx, ny, nz] = report.dims;
    table.line("cells", format!("{nx} x {ny} x {nz} = {}", HumanCount(report.cells)));
    table.line(
        "lines",
        format!("from {}, {}{unit}", three(report.origin), sizes(report.spacing, report.grading.as_ref())),
    );
    let (rays, crossings) = (HumanCount(report.rays), HumanCount(report.crossings));
    table.line(
        "rays",
        format!("{rays} along {}, {crossings} crossings, {} runs", report.ray_axis, HumanCount(report.runs)),
    );
    if report.odd_rays > 0 {
        table.line("odd rays", HumanCount(report.odd_rays));
    }
    let cubic = report.unit.map_or(String::new(), |unit| format!(" {unit}^3"));
    for flag in &report.flags {
        let name = if flag.name.is_empty() { String::new() } else { format!(" \"{}\"", flag.name) };
        let volume = flag.volume.map_or("unknown".into(), |volume| short(volume) + &cubic);
        table.line("flag", format!("{}{name}: {} cells, volume {volume}", flag.flag, HumanCount(flag.cells)));
    }
    table.finish()
}

fn backend(mesh: &MeshFacts, is_software: bool) -> String {
    match (&mesh.adapter, &mesh.driver) {
        (Some(adapter), driver) => {
            let kind = if is_software { "a GPU in software" } else { "GPU" };
            format!("{kind}: {adapter}, driver {}", driver.as_deref().unwrap_or("unknown"))
        }
        _ => format!("CPU, {} threads", rayon::current_num_threads()),
    }
}

fn geometries(table: &mut Table, mesh: &MeshFacts) {
    for geometry in &mesh.geometries {
        let [low, high] = geometry.bounding_box.map(three);
        let facts = format!("flag {}, priority {}, box {low} to {high}", geometry.flag, geometry.priority);
        table.line("geometry", format!("\"{}\": {facts}", geometry.name));
    }
    for input in &mesh.inputs {
        input.blake3.iter().for_each(|hash| table.line("blake3", format!("{hash} {}", input.file)));
    }
}

/// Groups of bad edges of a geometry that are listed for people; JSON lists more.
const MAX_GROUPS: usize = 3;

fn bad_edges(table: &mut Table, mesh: &MeshFacts) {
    for geometry in &mesh.geometries {
        let BadEdges { open, flipped, nonmanifold, worst } = &geometry.bad_edges;
        if open + flipped + nonmanifold > 0 {
            let [open, flipped, nonmanifold] = [open, flipped, nonmanifold].map(|n| HumanCount(*n));
            let counts =
                format!("{open} open, {flipped} between flipped facets, {nonmanifold} of more than two facets");
            table.line("edges", format!("\"{}\": {counts}", geometry.name));
        }
        for group in worst.iter().take(MAX_GROUPS) {
            let kind = match group.kind {
                BadEdge::Open => "open",
                BadEdge::Flipped => "flipped",
                BadEdge::Nonmanifold => "of more than two facets",
                _ => "bad",
            };
            let ([low, high], n) = (group.bounds.map(three), HumanCount(group.edges));
            table.line(
                "edges",
                format!("{n} {kind} from {low} to {high}, facets {:?} of the file, from 0", group.facets),
            );
        }
    }
}

fn grid(table: &mut Table, mesh: &MeshFacts) {
    let unit = unit(mesh);
    let high = match (&mesh.grading, mesh.spacing) {
        (Some(Grading { x, y, z, .. }), _) => [x, y, z].map(|lines| lines.last().copied().unwrap_or_default()),
        (None, spacing) => {
            let spacing = spacing.unwrap_or_default();
            [0, 1, 2].map(|axis| mesh.origin[axis] + f64::from(mesh.dims[axis]) * spacing[axis])
        }
    };
    table.line("domain", format!("{} to {}{unit}", three(mesh.origin), three(high)));
    let [nx, ny, nz] = mesh.dims;
    let cells = HumanCount(mesh.cells);
    table.line("cells", format!("{nx} x {ny} x {nz} = {cells}, {}{unit}", sizes(mesh.spacing, mesh.grading.as_ref())));
    let (rays, crossings) = (HumanCount(mesh.rays), HumanCount(mesh.crossings));
    table.line("rays", format!("{rays} along {}, {crossings} crossings", mesh.ray_axis));
    if mesh.rays_kept > 0 {
        table.line("rays", format!("{} resumed from the interrupted run", HumanCount(mesh.rays_kept)));
    }
}

fn end_points(table: &mut Table, mesh: &MeshFacts, verbose: bool) {
    for (axis, residuals) in ["x", "y", "z"].into_iter().zip(&mesh.end_points) {
        for residual in residuals.iter().filter(|residual| verbose || residual.cells.abs() > 1e-6) {
            let text = format!("{axis} = {} lies {:.3e} cells off its line", residual.end_point, residual.cells);
            table.line("end point", text);
        }
    }
}

fn flags(table: &mut Table, mesh: &MeshFacts) {
    let cubic = mesh.unit.as_ref().map_or(String::new(), |unit| format!(" {unit}^3"));
    for flag in &mesh.flags {
        let of_surface = flag.mesh_volume.filter(|surface| *surface > 0.0).map_or(String::new(), |surface| {
            let percent = |volume: f64| 100.0 * volume / surface;
            let found = flag.volume - surface;
            let verdict = flag.volume_bound.map_or(String::new(), |bound| {
                let is_within = found.abs() <= bound;
                let verdict = if is_within { "bound" } else { "geometries or shells overlap: beyond the bound of" };
                format!(" ({verdict} {:.3} %)", percent(bound))
            });
            format!(", of the surface {}, {:+.3} %{verdict}", short(surface), percent(found))
        });
        let volumes = format!("volume {}{cubic}{of_surface}", short(flag.volume));
        table.line("flag", format!("{} \"{}\": {} cells, {volumes}", flag.flag, flag.name, HumanCount(flag.cells)));
    }
}

/// Gaps that are listed for people; JSON lists more.
const MAX_GAPS: usize = 5;

fn measured(table: &mut Table, mesh: &MeshFacts) {
    if let Some(links) = &mesh.links_report {
        let [n, cells, through, without] =
            [links.links, links.cells, links.through_walls, links.without_facet].map(HumanCount);
        table.line("links", format!("{n} of {:?} from {cells} cells; {through} through thin walls", links.stencil));
        if links.without_facet > 0 {
            table.line("links", format!("{without} without a facet: their q is 1/2"));
        }
    }
    if let Some(fractions) = &mesh.fractions_report {
        let cells = HumanCount(fractions.cut_cells);
        let how = match (fractions.rays, fractions.sampled_cells) {
            (0, 0) => "measured exactly".into(),
            (0, sampled) => {
                format!("measured exactly, but for {} in which a surface passes through itself", HumanCount(sampled))
            }
            (rays, _) => format!("by {rays} x {rays} rays per cell"),
        };
        table.line("cut cells", format!("{cells}, {how}"));
    }
    if let Some(staggered) = &mesh.staggered_report {
        let flagged = staggered.components.iter().map(|component| {
            let n = component.flags.iter().filter(|of| of.flag != 0).map(|of| of.points).sum();
            format!("{} {}", component.name, HumanCount(n))
        });
        let (flagged, faces) = (flagged.collect::<Vec<String>>().join(", "), HumanCount(staggered.sheet_faces));
        table.line("staggered", format!("points with a flag: {flagged}; {faces} faces of sheets"));
    }
    if let Some(of) = &mesh.conformal_report {
        let [edges, faces, enlarged, sampled] =
            [of.cut_edges, of.cut_faces, of.enlarged_faces, of.sampled_cells].map(HumanCount);
        let dt = of.dt.map_or(String::new(), |dt| format!(", {dt:.4e} s in vacuum"));
        table.line("conformal", format!("{edges} edges and {faces} faces cut by metal, {enlarged} enlarged"));
        table.line("step", format!("at most {:.3} of that without metal{dt}", of.dt_factor));
        if of.sampled_cells > 0 {
            table.line("conformal", format!("{sampled} cells by rays, as a surface passes through itself there"));
        }
    }
    if let Some(of) = &mesh.distance_report {
        let known = of.width.map_or("everywhere".to_string(), |width| format!("up to {width}"));
        table.line("distance", format!("to {} facets, exact {known}", HumanCount(of.facets)));
    }
    if let Some(of) = &mesh.tensors_report {
        let [cut, without, sampled] = [of.cut_points, of.without_normal, of.sampled_points].map(HumanCount);
        let by_rays = if of.sampled_points > 0 { format!(", {sampled} by rays") } else { String::new() };
        table.line("tensors", format!("{cut} points of E between substances, {without} without a normal{by_rays}"));
    }
}

fn gaps(table: &mut Table, mesh: &MeshFacts) {
    let Some(gaps) = &mesh.gaps else { return };
    let (n, cells, width, flag) = (HumanCount(gaps.gaps), HumanCount(gaps.cells), gaps.width, gaps.flag);
    table.line("gaps", format!("{n} narrower than {width} cells closed, {cells} cells got flag {flag}"));
    for gap in gaps.largest.iter().take(MAX_GAPS) {
        let [low, high] = gap.bounds.map(three);
        table.line("gaps", format!("{} cells from {low} to {high}", HumanCount(gap.cells)));
    }
    if let Some(n_more @ 1..) = gaps.gaps.checked_sub(MAX_GAPS as u64) {
        table.line("gaps", format!("{} more; --json lists the largest", HumanCount(n_more)));
    }
}

fn stages(table: &mut Table, report: &Report, verbose: bool) {
    let seconds = &report.seconds;
    let rate = report.cells_per_second;
    table.line("time", format!("{:.3} s from files to {}, {rate:.3e} cells/s", seconds.total, goal(report)));
    let stages = [
        ("read", Some(seconds.read)),
        ("lines", Some(seconds.lines).filter(|_| verbose)),
        ("snap", Some(seconds.snap).filter(|_| verbose)),
        ("columns", Some(seconds.columns)),
        ("flags", seconds.flags),
        ("| device", Some(seconds.device)),
        ("report", Some(seconds.report).filter(|_| verbose)),
        ("hash", seconds.hash),
        ("write", seconds.write),
    ];
    let texts = stages.iter().filter_map(|(name, time)| time.map(|time| format!("{name} {time:.3}")));
    table.line("time", texts.collect::<Vec<_>>().join("  "));
    let host = report.peak_bytes.host.map_or("unknown".into(), |bytes| BinaryBytes(bytes).to_string());
    table.line("peak memory", format!("{host}, on the device {}", BinaryBytes(report.peak_bytes.device)));
    if report.peak_bytes.spilled > 0 {
        table.line("peak memory", format!("columns on disk {}", BinaryBytes(report.peak_bytes.spilled)));
    }
}

fn goal(report: &Report) -> &'static str {
    if report.seconds.flags.is_some() { "flags" } else { "columns" }
}

fn unit(mesh: &MeshFacts) -> String {
    mesh.unit.as_ref().map_or(String::new(), |unit| format!(" {unit}"))
}

/// A point, short.
pub(crate) fn three(point: [f64; 3]) -> String {
    let [x, y, z] = point.map(short);
    format!("({x}, {y}, {z})")
}

/// The sizes of all cells: that of each, or from the smallest to the largest on each axis.
pub(crate) fn sizes(spacing: Option<[f64; 3]>, grading: Option<&Grading>) -> String {
    match (spacing, grading) {
        (None, Some(Grading { smallest, largest, .. })) => {
            let axis = |axis: usize| format!("{} to {}", short(smallest[axis]), short(largest[axis]));
            format!("{} x {} x {}", axis(0), axis(1), axis(2))
        }
        (spacing, _) => format!("each {}", size(spacing.unwrap_or_default())),
    }
}

/// A cell size: one number for cubes.
pub(crate) fn size([x, y, z]: [f64; 3]) -> String {
    if x == y && y == z { short(x) } else { [x, y, z].map(short).join(" x ") }
}

/// Seven significant digits, as f32 files hold, without trailing zeros.
pub(crate) fn short(value: f64) -> String {
    let rounded: f64 = format!("{value:.6e}").parse().unwrap_or(value);
    if rounded != 0.0 && !(1e-4..1e9).contains(&rounded.abs()) { format!("{rounded:e}") } else { rounded.to_string() }
}
