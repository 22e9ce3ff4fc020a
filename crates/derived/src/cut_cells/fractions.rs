//! Fractions of cells as jobs ask for them, measured exactly.

use std::ops::Range;

use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::grid::window::CellWindow;
use hexcast_core::input::job::FractionsJob;

use super::cut_cell::{CellSurface, CutPart, CutWanted};
use super::measure::{CutBy, Measured, PLANES, in_parts};
use crate::fractions::{CutSurface, Fraction, Fractions, Part, rounded_part};

/// Measures the fractions in the cells of a window, exactly but for rounding.
///
/// # Errors
/// `memory` where they would take more than `max_bytes`; `cancelled`.
pub async fn exact_fractions(
    by: CutBy<'_>,
    window: CellWindow,
    job: FractionsJob,
    max_bytes: u64,
    control: &Control,
) -> Result<Fractions> {
    let asked = CutWanted {
        faces: job.faces,
        surfaces: job.surfaces,
        edges: job.edges,
        centroids: job.centroids,
        face_centroids: job.faces && job.centroids,
    };
    let Measured { parts, volumes, areas, totals, n_sampled } =
        in_parts((by, window), asked, max_bytes, control, (rounded, Part::n_bytes)).await?;
    Ok(Fractions {
        rays: 0,
        dims: window.dims(),
        origin: window.origin(),
        halo: window.halo,
        parts,
        planes_of_part: PLANES,
        volumes,
        areas,
        totals,
        has_faces: job.faces,
        has_edges: job.edges,
        has_centroids: job.centroids,
        sampled_cells: n_sampled,
    })
}

/// What was found in some planes, as numbers of 32 bits: without cells in which, and on whose faces and edges, one flag has all.
fn rounded(of: CutPart) -> Part {
    let mut part = Part::default();
    part.fractions.reserve(of.flags.len());
    let mut first = 0;
    for of_cell in of.flags.chunk_by(|one, other| one.cell == other.cell) {
        let all = first..first + of_cell.len();
        first = all.end;
        if of_cell.len() == 1 {
            continue;
        }
        let is_cut = of_cell.iter().filter(|of| of.fraction > 0.0).count() > 1;
        part.n_cut += u64::from(is_cut);
        part.fractions.extend(of_cell.iter().map(|of| {
            let fraction = if is_cut { rounded_part(of.fraction) } else { of.fraction as f32 };
            Fraction { cell: of.cell, fraction, flag: of.flag }
        }));
        add(&mut part.faces, &of.faces, all.clone(), |faces| faces.map(|fraction| fraction as f32));
        add(&mut part.edges, &of.edges, all.clone(), |edges| edges.map(|fraction| fraction as f32));
        add(&mut part.centroids, &of.centroids, all.clone(), |centre| centre.map(|place| place as f32));
        add(&mut part.face_centroids, &of.face_centroids, all, |of| of.map(|centre| centre.map(|place| place as f32)));
    }
    part.surfaces = of.surfaces.iter().map(surface).collect();
    part
}

/// Adds some of what was found, unless it was not asked for.
fn add<T, U>(to: &mut Vec<U>, found: &[T], some: Range<usize>, of: impl Fn(&T) -> U) {
    to.extend(found.get(some).unwrap_or_default().iter().map(of));
}

fn surface(of: &CellSurface) -> CutSurface {
    let &CellSurface { cell, geometry, area, centre, .. } = of;
    let [point, normal] = [centre, of.normal()].map(|three| three.map(|number| number as f32));
    CutSurface { cell, geometry, area: area as f32, point, normal }
}
