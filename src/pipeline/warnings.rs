//! Warnings about a mesh: rays that found an open surface, flags that two geometries have, shells that overlap, and geometries
//! without cells.

use super::prepare::Prepared;
use crate::cast::Cast;
use crate::columns::run_cell;
use crate::cpu::{self, Window, window_of_rows};
use crate::edges::BadEdge;
use crate::error::Result;
use crate::frame::{Frame, SnappedFacet};
use crate::geometry::{Facet, Fill, Geometry, Open};
use crate::job::Rule;
use crate::lines::Lines;
use crate::mesh::Mesh;
use crate::report::GeometryReport;
use crate::shells::{Overlap, overlapping_shells};

const AXES: [&str; 3] = ["x", "y", "z"];

/// A sentence about rays that do not leave every geometry they enter, if there are any.
pub(super) fn about_odd_rays(odd_rays: u64, n_rays: u64) -> Option<String> {
    (odd_rays > 0).then(|| {
        format!(
            "{odd_rays} of {n_rays} rays do not leave every geometry they enter: a surface is not closed there. Their cells \
             are flagged up to the last matched pair of crossings; `hexcast info` counts the open edges of a file"
        )
    })
}

/// A sentence for every geometry that is not closed and whose cells the rays of one axis decide as they are.
pub(super) fn about_edges_of_rays(
    geometries: &[Geometry],
    reports: &[GeometryReport],
    rule: Rule,
    lines: &Lines,
) -> Vec<String> {
    let sentence = |(geometry, report): (&Geometry, &GeometryReport)| {
        let kind = if report.bad_edges.open == 0 { BadEdge::Flipped } else { BadEdge::Open };
        let (n, what) = match kind {
            BadEdge::Flipped if rule == Rule::Nonzero => {
                (report.bad_edges.flipped, "edges between facets that face opposite ways")
            }
            BadEdge::Flipped => (0, ""),
            _ => (report.bad_edges.open, "open edges"),
        };
        (n > 0 && geometry.open == Open::Parity && !geometry.shell).then(|| {
            let (name, worst) = (&geometry.name, report.worst_edges(kind, lines));
            format!("geometry \"{name}\" is not closed: {what} {n}, {worst}; the rays of one axis decided its cells, as open = \"parity\" says")
        })
    };
    geometries.iter().zip(reports).filter_map(sentence).collect()
}

/// A sentence for every two geometries that have one flag although nobody gave it to one of them.
pub(super) fn about_shared_flags(geometries: &[Geometry]) -> Vec<String> {
    let shares = |(index, geometry): (usize, &Geometry)| {
        let others = || geometries.iter().enumerate().filter(|(other, of)| *other != index && of.flag == geometry.flag);
        // of two that nobody chose the later says it
        let other = others().find(|(other, of)| *other < index || !of.has_default_flag).map(|(_, of)| of)?;
        geometry.has_default_flag.then(|| {
            format!(
                "geometries \"{}\" and \"{}\" both have the flag {}, which nobody gave to \"{1}\": it is its position in the job; \
                 give it a flag, for example {}",
                other.name,
                geometry.name,
                geometry.flag,
                (1..=255u8).find(|flag| geometries.iter().all(|of| of.flag != *flag)).unwrap_or(geometry.flag),
            )
        })
    };
    geometries.iter().enumerate().filter_map(shares).collect()
}

/// A sentence for every geometry whose shells overlap, where two of them are outside by the rule; `agrees` says of a rank whether its facets
/// do.
pub(super) fn about_overlapping_shells(
    cast: &Cast,
    agrees: &dyn Fn(usize) -> bool,
    geometries: &[Geometry],
) -> Vec<String> {
    if cast.rule != Rule::Parity {
        return Vec::new();
    }
    let sentence = |overlap: Overlap| {
        let name = &geometries[cast.frame.ranks.geometry_of_rank[usize::from(overlap.rank)]].name;
        format!(
            "shells of geometry \"{name}\" overlap, or a cavity is turned the wrong way: {} cells on {} rays that were looked at lie in \
             two or more shells, and the rule parity takes those in two for outside; rule = \"nonzero\" (--rule nonzero) takes them for \
             inside",
            overlap.n_cells, overlap.n_rays
        )
    };
    overlapping_shells(cast, agrees).into_iter().map(sentence).collect()
}

/// A sentence for every geometry that is known to have no cell, with the cause; `cells` counts those of each flag.
///
/// A geometry whose box holds no centre of a cell has none. Where the box does hold one, only the cells of its flag tell, and
/// only if no other geometry has the same flag. `ends` are those of each rank as it was snapped, None of one that is decided apart.
///
/// # Errors
/// Those of reading spilled columns.
pub(super) fn about_geometries_without_cells(
    prepared: &Prepared,
    (cast, ends): (&Cast, &[Option<[[i32; 3]; 2]>]),
    mesh: &Mesh,
    cells: &[u64; 256],
) -> Result<Vec<String>> {
    let mut sentences = Vec::new();
    for (index, geometry) in prepared.geometries.iter().enumerate() {
        let Some(bounding_box) = geometry.bounding_box() else { continue };
        let n_of_flag = prepared.geometries.iter().filter(|other| other.flag == geometry.flag).count();
        let has_cells = n_of_flag > 1 || cells[usize::from(geometry.flag)] > 0;
        let rank = cast.frame.ranks.geometry_of_rank.iter().position(|&of| of == index);
        let ends = rank.and_then(|rank| ends[rank]);
        let thin_axis = ends.and_then(|ends| axis_without_centre(ends, cast.frame));
        if has_cells && (thin_axis.is_none() || geometry.fill != Fill::Centre) {
            continue;
        }
        let cause = if let Some(cause) = outside(bounding_box, &prepared.lines) {
            cause
        } else if geometry.facets.iter().all(is_degenerate) {
            "none of its facets has an area; repair the file".into()
        } else if let Some(axis) = thin_axis {
            let [low, high] = bounding_box.map(|corner| corner[axis]);
            let (thick, size, name) = (high - low, prepared.lines.spacing[axis], AXES[axis]);
            format!("it is {thick:?} thick along {name}, a cell is {size:?}; use smaller cells, {KEEP}")
        } else if ends.is_none() {
            format!("its surface is not closed and encloses no centre of a cell; close it, {KEEP}")
        } else if let Some(flag) = hidden_by(rank.map_or(&[], |rank| cast.frame.facets_of_rank(rank)), cast, mesh)? {
            let name = mesh.names.iter().find(|named| named.flag == flag).map_or("", |named| &named.name);
            format!("its cells are those of \"{name}\" (flag {flag}), which wins; give it a higher priority")
        } else {
            format!("it encloses no centre of a cell; use smaller cells, {KEEP}")
        };
        sentences.push(format!("geometry \"{}\" (flag {}) got no cell: {cause}", geometry.name, geometry.flag));
    }
    Ok(sentences)
}

/// What keeps a wall that is thinner than a cell.
const KEEP: &str = "or keep it with fill = \"separating\" or \"conservative\"";

/// How a box lies outside of the domain, if it does.
fn outside([low, high]: [[f64; 3]; 2], lines: &Lines) -> Option<String> {
    let ends_of = |axis: usize| [lines.line(axis, 0), lines.line(axis, lines.dims[axis])];
    let axis = (0..3).find(|&axis| high[axis] <= ends_of(axis)[0] || low[axis] >= ends_of(axis)[1])?;
    let ([start, end], name, [from, to]) = (ends_of(axis), AXES[axis], [low[axis], high[axis]]);
    Some(format!("it reaches from {from:?} to {to:?} along {name}, the domain from {start:?} to {end:?}"))
}

fn is_degenerate([a, b, c]: &Facet) -> bool {
    let side = |to: &[f32; 3]| [0, 1, 2].map(|axis| f64::from(to[axis]) - f64::from(a[axis]));
    let ([ux, uy, uz], [vx, vy, vz]) = (side(b), side(c));
    [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx] == [0.0; 3]
}

/// Rows of rays that are cast to find a cell of a geometry, at most.
const N_ROWS: u32 = 64;

/// The flag that a mesh has in a cell that a geometry would have alone, if it would have one.
fn hidden_by(facets: &[SnappedFacet], cast: &Cast, mesh: &Mesh) -> Result<Option<u8>> {
    let alone = cast.frame.with_facets(facets.to_vec());
    let (rays, down) = (cast.rays, cast.rays.across[1]);
    let along = facets.as_flattened().iter().map(|corner| corner[down] >> cast.frame.fraction_bits);
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
                let flag = mesh.flag(rays.cell(place))?;
                return Ok((flag != 0).then_some(flag));
            }
        }
    }
    Ok(None)
}

/// The first axis along which a box, from its least to its greatest coordinates, holds no centre of a cell.
fn axis_without_centre([low, high]: [[i32; 3]; 2], frame: &Frame) -> Option<usize> {
    (0..3).find(|&axis| {
        // cell i is inside only if low < i <= high in centres
        let (first, last) = ((low[axis] >> frame.fraction_bits) + 1, high[axis] >> frame.fraction_bits);
        first.max(0) > last.min(frame.dims[axis] as i32 - 1)
    })
}
