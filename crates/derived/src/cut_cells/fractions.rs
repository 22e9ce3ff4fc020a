//! Fractions of cells as jobs ask for them, measured exactly.

use hexcast_core::base::control::Control;
use hexcast_core::base::error::Result;
use hexcast_core::grid::window::CellWindow;
use hexcast_core::input::job::FractionsJob;

use super::cut_cell::{CellSurface, CutCellsJob, CutPart};
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
    let asked = CutCellsJob { faces: job.faces, surfaces: job.surfaces, ..CutCellsJob::default() };
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
        sampled_cells: n_sampled,
    })
}

/// What was found in some planes, as numbers of 32 bits: without cells in which, and on whose faces, one flag has all.
fn rounded(of: CutPart) -> Part {
    let mut part = Part { fractions: Vec::new(), faces: Vec::new(), surfaces: Vec::new(), n_cut: 0 };
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
        if !of.faces.is_empty() {
            part.faces.extend(of.faces[all].iter().map(|faces| faces.map(|fraction| fraction as f32)));
        }
    }
    part.surfaces = of.surfaces.iter().map(surface).collect();
    part
}

fn surface(of: &CellSurface) -> CutSurface {
    let &CellSurface { cell, geometry, area, centre, .. } = of;
    let [point, normal] = [centre, of.normal()].map(|three| three.map(|number| number as f32));
    CutSurface { cell, geometry, area: area as f32, point, normal }
}
