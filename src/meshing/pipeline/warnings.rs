//! Findings about a mesh: what was read of files otherwise than it stands there, rays that found an open surface, surfaces that are inside out,
//! flags that two geometries have, shells that overlap, and geometries without cells.

use serde_json::json;

use super::prepare::Prepared;
use super::remedies::add_remedies;
use crate::meshing::report::{GeometryReport, InputReport, ShellsReport, WithoutCells};
use hexcast_core::base::error::Result;
use hexcast_core::base::finding::{Finding, NamedGeometry, Remedy};
use hexcast_core::cells::columns::run_cell;
use hexcast_core::grid::frame::{Frame, SnappedFacet};
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::rays::Rays;
use hexcast_core::input::edges::BadEdge;
use hexcast_core::input::geometry::{Facet, Fill, Geometry, Open};
use hexcast_core::input::job::{Job, Rule};
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::cpu::{self, Window, window_of_rows};
use hexcast_derived::certificate::shells::{n_rays_looked_at, overlapping_shells};
use hexcast_derived::mesh::Mesh;

const AXES: [&str; 3] = ["x", "y", "z"];

/// What readers say of each file, once.
pub(super) fn about_inputs(inputs: &[InputReport]) -> Vec<Finding> {
    let mut findings: Vec<Finding> = Vec::new();
    for sentence in inputs.iter().flat_map(|of| of.warnings.iter().map(|text| format!("{}: {text}", of.file))) {
        if findings.iter().all(|said| said.sentence != sentence) {
            findings.push(Finding::new("file-changed", sentence));
        }
    }
    findings
}

/// Part of its box that a closed surface encloses at least if its volume is no rounding.
const LEAST_VOLUME: f64 = 1e-9;

/// A finding for every closed surface whose facets face inwards.
pub(super) fn about_inside_out(reports: &[GeometryReport]) -> Vec<Finding> {
    let finding = |(index, of): (usize, &GeometryReport)| {
        let [low, high] = of.bounding_box;
        let of_box: f64 = (0..3).map(|axis| high[axis] - low[axis]).product();
        let is_closed = of.bad_edges.open == 0 && of.bad_edges.flipped == 0;
        (is_closed && of.mesh_volume < -LEAST_VOLUME * of_box).then(|| {
            let sentence = format!(
                "geometry \"{}\" is inside out: its facets face inwards, and its volume is {}; its cells are those within its surface all the \
                 same; turn the facets of the file for programs that read their sides",
                of.name, of.mesh_volume as f32
            );
            let finding = Finding::new("surface-inside-out", sentence).of_geometry(index, &of.name).of_flag(of.flag);
            finding.with_value("mesh_volume", of.mesh_volume)
        })
    };
    reports.iter().enumerate().filter_map(finding).collect()
}

/// A finding about rays that do not leave every geometry they enter, if there are any.
pub(super) fn about_odd_rays(odd_rays: u64, n_rays: u64) -> Option<Finding> {
    (odd_rays > 0).then(|| {
        let sentence = format!(
            "{odd_rays} of {n_rays} rays do not leave every geometry they enter: a surface is not closed there. Their cells \
             are flagged up to the last matched pair of crossings; `hexcast info` counts the open edges of a file"
        );
        Finding::new("rays-odd", sentence).with_count("odd_rays", odd_rays).with_count("rays", n_rays)
    })
}

/// A finding for every geometry that is not closed and whose cells the rays of one axis decide as they are.
pub(super) fn about_edges_of_rays(
    geometries: &[Geometry],
    reports: &[GeometryReport],
    rule: Rule,
    lines: &Lines,
) -> Vec<Finding> {
    let finding = |(index, (geometry, report)): (usize, (&Geometry, &GeometryReport))| {
        let kind = if report.bad_edges.open == 0 { BadEdge::Flipped } else { BadEdge::Open };
        let (n, what, value) = match kind {
            BadEdge::Flipped if rule == Rule::Nonzero => {
                (report.bad_edges.flipped, "edges between facets that face opposite ways", "flipped_edges")
            }
            BadEdge::Flipped => (0, "", ""),
            _ => (report.bad_edges.open, "open edges", "open_edges"),
        };
        (n > 0 && geometry.open == Open::Parity && !geometry.shell).then(|| {
            let (name, worst) = (&geometry.name, report.worst_edges(kind, lines));
            let sentence = format!(
                "geometry \"{name}\" is not closed: {what} {n}, {worst}; the rays of one axis decided its cells, as open = \"parity\" says"
            );
            let found = Finding::new("surface-open-parity", sentence).of_geometry(index, name).of_flag(geometry.flag);
            report.within_worst_edges(found.with_count(value, n), kind)
        })
    };
    geometries.iter().zip(reports).enumerate().filter_map(finding).collect()
}

/// A finding about perfect conductors of which on a staggered grid only the edges within them conduct.
pub(super) fn about_thin_conductors(job: &Job, geometries: &[Geometry]) -> Option<Finding> {
    let thin = |geometry: &&Geometry| geometry.material.pec && !job.conductors.contains(&geometry.flag);
    let names: Vec<&str> = geometries.iter().filter(thin).map(|geometry| &geometry.name[..]).collect();
    if !job.staggered || names.is_empty() {
        return None;
    }
    let mut flags = job.conductors.clone();
    flags.extend(geometries.iter().filter(thin).map(|geometry| geometry.flag));
    flags.sort_unstable();
    flags.dedup();
    let listed = flags.iter().map(u8::to_string).collect::<Vec<_>>().join(",");
    let sentence = format!(
        "on the staggered grid only the edges within {} conduct, which makes metal half a cell too thin on average; name the flags of conductors",
        quoted(&names)
    );
    let (label, patch) = ("Let all edges of their cells conduct", json!({ "conductors": flags }));
    Some(Finding::new("conductor-thin", sentence).with_remedy(Remedy::new(
        label,
        patch,
        format!("--conductors {listed}"),
    )))
}

/// Names in quotes, of many the first.
fn quoted(names: &[&str]) -> String {
    const MOST: usize = 5;
    let first = names.iter().take(MOST).map(|name| format!("\"{name}\"")).collect::<Vec<_>>().join(", ");
    if names.len() > MOST { format!("{first} and {} more", names.len() - MOST) } else { first }
}

/// A finding for every two geometries that have one flag although nobody gave it to one of them.
pub(super) fn about_shared_flags(geometries: &[Geometry]) -> Vec<Finding> {
    let shares = |(index, geometry): (usize, &Geometry)| {
        let all = || geometries.iter().enumerate();
        let mut others = all().filter(|(other, of)| *other != index && of.flag == geometry.flag);
        // of two that nobody chose the later says it
        let (other, of) = others.find(|(other, of)| *other < index || !of.has_default_flag)?;
        geometry.has_default_flag.then(|| {
            let (name, flag) = (&geometry.name, geometry.flag);
            let free = (1..=255u8).find(|flag| geometries.iter().all(|of| of.flag != *flag));
            let sentence = format!(
                "geometries \"{}\" and \"{name}\" both have the flag {flag}, which nobody gave to \"{name}\": it is its position in the \
                 job; give it a flag, for example {}",
                of.name,
                free.unwrap_or(flag),
            );
            let found = Finding::new("flag-shared", sentence).of_geometry(index, name).and_geometry(other, &of.name);
            let found = found.of_flag(flag);
            free.map_or(found.clone(), |free| found.with_count("free_flag", free.into()))
        })
    };
    geometries.iter().enumerate().filter_map(shares).collect()
}

/// Geometries whose shells overlap in some cells of the box, where two of them are outside by the rule; `agrees` says of a position whether the
/// facets do.
pub(super) fn shells(cast: &Cast, agrees: &dyn Fn(usize) -> bool, cells: [[u32; 3]; 2]) -> Vec<ShellsReport> {
    if cast.rule != Rule::Parity {
        return Vec::new();
    }
    let geometry = |position: u16| cast.frame.ranks.geometry_at[usize::from(position)];
    overlapping_shells(cast, agrees, cells)
        .into_iter()
        .map(|of| ShellsReport::new(geometry(of.position), of.n_cells))
        .collect()
}

/// A finding for each of them; `rays` are those of the box.
pub(super) fn about_shells(
    shells: &[ShellsReport],
    geometries: &[GeometryReport],
    rays: &Rays,
    cells: [[u32; 3]; 2],
) -> Vec<Finding> {
    let n_rays = n_rays_looked_at(rays, cells);
    shells.iter().filter_map(|of| Some(of.finding(&geometries.get(of.geometry)?.name, n_rays))).collect()
}

/// Every geometry that is known to have no cell, with a finding that says the cause, unless that lies in cells that were not meshed;
/// `cast` is that of the whole box, `cells` counts those of each flag.
///
/// A geometry whose box holds no centre of a cell has none. Where the box does hold one, only the cells of its flag tell, and
/// only if no other geometry has the same flag. `ends` are those at each position as they were snapped, None of one that is decided apart.
///
/// # Errors
/// Those of reading spilled columns.
pub(super) fn geometries_without_cells(
    prepared: &Prepared,
    (cast, ends): (&Cast, &[Option<[[i32; 3]; 2]>]),
    mesh: &Mesh,
    cells: &[u64; 256],
) -> Result<Vec<WithoutCells>> {
    let mut all = Vec::new();
    let mut n_of_flag = [0; 256];
    prepared.geometries.iter().for_each(|geometry| n_of_flag[usize::from(geometry.flag)] += 1);
    let mut position_of = vec![None; prepared.geometries.len()];
    for (position, &index) in cast.frame.ranks.geometry_at.iter().enumerate() {
        position_of[index] = Some(position);
    }
    for (index, geometry) in prepared.geometries.iter().enumerate() {
        let Some(bounding_box) = geometry.bounding_box() else { continue };
        let has_cells = n_of_flag[usize::from(geometry.flag)] > 1 || cells[usize::from(geometry.flag)] > 0;
        let position = position_of[index];
        let ends = position.and_then(|position| ends[position]);
        let thin_axis = ends.and_then(|ends| axis_without_centre(ends, cast.frame));
        if has_cells && (thin_axis.is_none() || geometry.fill != Fill::Centre) {
            continue;
        }
        let cause = if let Some(cause) = outside(bounding_box, &prepared.whole) {
            Some(cause)
        } else if has_no_area(geometry)? {
            Some(Cause::new("no-cell-no-area", "none of its facets has an area; repair the file"))
        } else if geometry.fill != Fill::Centre {
            cause_of_filled(geometry, prepared, mesh)?
        } else if let Some(axis) = thin_axis {
            let [low, high] = bounding_box.map(|corner| corner[axis]);
            Some(thin(high - low, size_at(&prepared.whole, axis, 0.5 * (low + high)), axis))
        } else if let Some(axis) = (0..3).find(|&axis| bounding_box[0][axis] == bounding_box[1][axis]) {
            let name = AXES[axis];
            let text = format!(
                "it lies in a plane across {name}, with no inside; files for openEMS and gprMax have its faces if it is a perfect \
                 conductor; for others take those of a staggered grid (staggered), {KEEP}"
            );
            Some(Cause { axis: Some(axis), ..Cause::new("no-cell-flat", text) })
        } else if ends.is_none() {
            let text = format!("its surface is not closed and encloses no centre of a cell; close it, {KEEP}");
            Some(Cause::new("no-cell-open", text))
        } else if is_far(bounding_box, prepared) {
            None
        } else {
            cause_by_place(
                place_alone(position.map_or(&[], |position| cast.frame.facets_at(position)), cast),
                prepared,
                mesh,
            )?
        };
        all.push(WithoutCells::new(index, cause.map(|cause| cause.finding(index, geometry, bounding_box))));
    }
    Ok(all)
}

/// Findings about the geometries of a whole box that have no cell, with what to do about each; what is given is as above.
///
/// # Errors
/// `io` where the columns are in a store that fails.
pub(crate) fn findings_without_cells(
    (job, prepared): (&Job, &Prepared),
    (cast, ends): (&Cast, &[Option<[[i32; 3]; 2]>]),
    mesh: &Mesh,
    cells: &[u64; 256],
) -> Result<Vec<Finding>> {
    let found = geometries_without_cells(prepared, (cast, ends), mesh, cells)?;
    let mut findings: Vec<Finding> = found.into_iter().filter_map(|of| of.finding).collect();
    add_remedies(&mut findings, job, &prepared.geometries);
    Ok(findings)
}

/// Why a geometry has no cell: the code of the finding, the rest of its sentence, and what else it has.
struct Cause {
    code: &'static str,
    text: String,
    axis: Option<usize>,
    values: Vec<(&'static str, f64)>,
    winner: Option<NamedGeometry>,
}

impl Cause {
    fn new(code: &'static str, text: impl Into<String>) -> Cause {
        Cause { code, text: text.into(), axis: None, values: Vec::new(), winner: None }
    }

    fn finding(self, index: usize, geometry: &Geometry, bounds: [[f64; 3]; 2]) -> Finding {
        let (name, flag) = (&geometry.name, geometry.flag);
        let sentence = format!("geometry \"{name}\" (flag {flag}) got no cell: {}", self.text);
        let mut found = Finding::new(self.code, sentence).of_geometry(index, name).of_flag(flag).within(bounds);
        found.other = self.winner;
        if let Some(axis) = self.axis {
            found = found.along(axis);
        }
        self.values.into_iter().fold(found, |found, (name, value)| found.with_value(name, value))
    }
}

/// It is thinner along an axis than the cells there.
fn thin(thick: f64, size: f64, axis: usize) -> Cause {
    // with as many digits as files hold
    let ([thick_text, size_text], name) = ([thick, size].map(|length| length as f32), AXES[axis]);
    let text = format!("it is {thick_text:?} thick along {name}, a cell is {size_text:?}; use smaller cells, {KEEP}");
    let values = vec![("thickness", thick), ("cell_size", size)];
    Cause { axis: Some(axis), values, ..Cause::new("no-cell-thin", text) }
}

/// Size of the cell at a place along an axis, or of the nearest.
fn size_at(lines: &Lines, axis: usize, place: f64) -> f64 {
    let last = f64::from(lines.dims()[axis] - 1);
    lines.cell_size(axis, lines.position(axis, place).clamp(0.0, last) as u32)
}

/// What keeps a wall that is thinner than a cell.
const KEEP: &str = "or keep it with fill = \"separating\" or \"conservative\"";

/// How a box lies outside of the domain, if it does.
fn outside([low, high]: [[f64; 3]; 2], lines: &Lines) -> Option<Cause> {
    let ends_of = |axis: usize| [lines.line(axis, 0), lines.line(axis, lines.dims()[axis])];
    let axis = (0..3).find(|&axis| high[axis] <= ends_of(axis)[0] || low[axis] >= ends_of(axis)[1])?;
    let ([start, end], name, [from, to]) = (ends_of(axis), AXES[axis], [low[axis], high[axis]]);
    let text = format!("it reaches from {from:?} to {to:?} along {name}, the domain from {start:?} to {end:?}");
    let values = vec![("from", from), ("to", to), ("domain_from", start), ("domain_to", end)];
    Some(Cause { axis: Some(axis), values, ..Cause::new("no-cell-outside", text) })
}

fn has_no_area(geometry: &Geometry) -> Result<bool> {
    let mut has_none = true;
    geometry.facets.for_each(|facet| has_none &= is_degenerate(facet))?;
    Ok(has_none)
}

fn is_degenerate([a, b, c]: &Facet) -> bool {
    let side = |to: &[f32; 3]| [0, 1, 2].map(|axis| f64::from(to[axis]) - f64::from(a[axis]));
    let ([ux, uy, uz], [vx, vy, vz]) = (side(b), side(c));
    [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx] == [0.0; 3]
}

/// Rows of rays that are cast to find a cell of a geometry, at most.
const N_ROWS: u32 = 64;

/// Whether a box lies outside of the cells that were meshed, by a cell at least.
fn is_far([low, high]: [[f64; 3]; 2], prepared: &Prepared) -> bool {
    let lines = &prepared.lines;
    (0..3).any(|axis| {
        let n = lines.dims()[axis];
        let ends = [(0, 0, -1.0), (n, n - 1, 1.0)]
            .map(|(line, cell, side)| lines.line(axis, line) + side * lines.cell_size(axis, cell));
        high[axis] < ends[0] || low[axis] > ends[1]
    })
}

/// Why a geometry has no cell that would have this cell of the box alone, or none; None where this is not among those that were meshed.
fn cause_by_place(place: Option<[u32; 3]>, prepared: &Prepared, mesh: &Mesh) -> Result<Option<Cause>> {
    let encloses_none =
        || Some(Cause::new("no-cell-small", format!("it encloses no centre of a cell; use smaller cells, {KEEP}")));
    let Some(place) = place else { return Ok(encloses_none()) };
    let flag = flag_of_box(place, prepared, mesh)?;
    Ok(flag.and_then(|flag| covered_by(flag, prepared, mesh).or_else(encloses_none)))
}

/// Flag of a cell of the box; None where it is not among those that were meshed.
fn flag_of_box(place: [u32; 3], prepared: &Prepared, mesh: &Mesh) -> Result<Option<u8>> {
    let [first, end] = prepared.window.unwrap_or([[0; 3], prepared.whole.dims()]);
    let is_here = (0..3).all(|axis| (first[axis]..end[axis]).contains(&place[axis]));
    is_here.then(|| mesh.flag([0, 1, 2].map(|axis| place[axis] - first[axis]))).transpose()
}

/// Facets of a geometry whose cells are looked at, at most.
const N_FACETS: usize = 64;

/// Why a geometry with the cells along its surface has none: others have them. The first of its facets whose middle is in another geometry's cell
/// says which; None where all that are looked at lie beyond the cells that were meshed.
fn cause_of_filled(geometry: &Geometry, prepared: &Prepared, mesh: &Mesh) -> Result<Option<Cause>> {
    let lines = &prepared.whole;
    let mut is_here = false;
    let facets = geometry.facets.in_memory("the cells along a surface")?;
    for corners in facets.iter().step_by(facets.len() / N_FACETS + 1) {
        let place = [0, 1, 2].map(|axis| {
            let middle = corners.iter().map(|corner| f64::from(corner[axis])).sum::<f64>() / 3.0;
            lines.position(axis, middle).floor()
        });
        if place.iter().any(|&cell| cell < 0.0) {
            continue;
        }
        if let Some(flag) = flag_of_box(place.map(|cell| cell as u32), prepared, mesh)? {
            is_here = true;
            if let Some(cause) = covered_by(flag, prepared, mesh) {
                return Ok(Some(cause));
            }
        }
    }
    let text = "the cells along its surface are those of geometries that win; give it a higher priority";
    Ok(is_here.then(|| Cause::new("no-cell-covered", text)))
}

/// The geometry whose flag this is has the cells; None where no geometry has it.
fn covered_by(flag: u8, prepared: &Prepared, mesh: &Mesh) -> Option<Cause> {
    let named = mesh.names().iter().find(|named| named.flag == flag && flag > 0)?;
    let text =
        format!("its cells are those of \"{}\" (flag {flag}), which wins; give it a higher priority", named.name);
    // of several with its flag that of the highest rank
    let all = prepared.geometries.iter().enumerate().filter(|(_, geometry)| geometry.flag == flag);
    let winner = all.max_by_key(|(_, geometry)| geometry.priority);
    let winner = winner.map(|(index, geometry)| NamedGeometry::new(index, &geometry.name));
    Some(Cause { winner, ..Cause::new("no-cell-covered", text) })
}

/// The first cell that was looked at that a geometry would have alone, if it would have one.
fn place_alone(facets: &[SnappedFacet], cast: &Cast) -> Option<[u32; 3]> {
    let alone = cast.frame.with_facets(facets.to_vec());
    let (rays, down) = (cast.rays, cast.rays.across[1]);
    let along = facets.as_flattened().iter().map(|corner| cast.frame.n_below(down, corner[down], true) as i32 - 1);
    let last_row = rays.counts[1] as i32 - 1;
    let [first, last] = [along.clone().min(), along.max()].map(|row| row.unwrap_or(0).clamp(0, last_row) as u32);
    let step = (last - first) / N_ROWS + 1;
    let rows = (first..=last).step_by(step as usize);
    let windows: Vec<Window> = rows.map(|row| window_of_rows(rays, row..row + 1)).collect();
    for band in cpu::windows(&Cast { frame: &alone, ..*cast }, &windows) {
        for ray in 0..band.ends.len() {
            if let Some(run) = band.ray(ray).first() {
                let index = band.first_ray + ray as u64;
                let n_across = u64::from(rays.counts[0]);
                let place = [(index % n_across) as u32, (index / n_across) as u32, run_cell(*run)];
                return Some(rays.cell(place));
            }
        }
    }
    None
}

/// The first axis along which a box, from its least to its greatest coordinates, holds no centre of a cell.
fn axis_without_centre([low, high]: [[i32; 3]; 2], frame: &Frame) -> Option<usize> {
    (0..3).find(|&axis| {
        // cell i is inside only if low < i <= high in centres
        frame.n_below(axis, low[axis], true) >= frame.n_below(axis, high[axis], true)
    })
}
