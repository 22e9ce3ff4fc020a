//! All fractions of a box: rows of cells together, on all cores.

use std::ops::Range;

use super::column::{self, Columns, Sum, parts_of_cell};
use super::cut::cut;
use super::faces::Faces;
use super::fraction::{Fraction, Fractions, Part, Totals, rounded_part};
use super::polygon::FacetRows;
use super::refined::Refined;
use super::surface::Surfaces;
use super::volumes::Volumes;
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::parallel::*;
use hexcast_core::grid::frame::Frame;
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::totals::{Ruler, Total};
use hexcast_core::grid::window::CellWindow;
use hexcast_core::input::job::{FractionsJob, Rule};
use hexcast_core::stages::inside::Kind;

/// Measures the fractions in the cells of a window by so many rays of a cell along each axis. `kinds` says of each rank whether it is inverted.
///
/// # Errors
/// `memory` where the fractions would take more than `max_bytes`; `cancelled`.
pub async fn fractions(
    (frame, lines): (&Frame, &Lines),
    window: CellWindow,
    (rule, kinds): (Rule, &[Kind]),
    (job, rays): (FractionsJob, u32),
    max_bytes: u64,
    control: &Control,
) -> Result<Fractions> {
    let [ny, nz] = [1, 2].map(|axis| window.end[axis] - window.first[axis]);
    // planes of cells that go together: some thousands of rays
    let planes_of_row = (RAYS / (rays * ny).max(1)).clamp(1, 16);
    let facets = FacetRows::new(frame, lines, window, planes_of_row);
    let measure = Measure {
        ruler: Ruler::new(lines, lines),
        window,
        facets: &facets,
        cells: Columns::new(Refined::of_cells(frame, lines, rays, &window), (rule, kinds)),
        faces: job.faces.then(|| Faces::new((frame, lines), window, rays, (rule, kinds))),
        surfaces: job.surfaces.then(|| Surfaces::new(&facets, lines)),
        planes_of_row,
    };
    let (mut parts, mut volumes) = (Vec::new(), vec![Total::default(); 256]);
    let geometry_at = &frame.ranks.geometry_at;
    let mut areas = if job.surfaces { vec![Total::default(); geometry_at.len()] } else { Vec::new() };
    let (n_rows, mut n_bytes) = (nz.div_ceil(planes_of_row), 0);
    for start in (0..n_rows).step_by(ROUND) {
        control.rest().await?;
        let end = (start + ROUND as u32).min(n_rows);
        let found: Vec<Found> = on_all_cores(|| map_within(start..end, |memory, row| measure.of_row(row, memory)));
        n_bytes += found.iter().map(|found| found.part.n_bytes() as u64).sum::<u64>();
        if n_bytes > max_bytes {
            let message = format!(
                "fractions of cells up to plane {} of {nz} take {n_bytes} bytes: {max_bytes} are left of the memory allowed",
                (end * planes_of_row).min(nz)
            );
            let hint = "allow more with max_memory (--max-memory), or use larger cells";
            return Err(Error::new("memory", message, hint));
        }
        for Found { part, volumes: of_rows, areas: of_positions } in found {
            parts.push(part);
            volumes.iter_mut().zip(of_rows).for_each(|(sum, more)| sum.add(more));
            geometry_at.iter().zip(of_positions).for_each(|(&geometry, more)| areas[geometry].add(more));
        }
    }
    let (ruler, of_cell) = (&measure.ruler, parts_of_cell(rays));
    Ok(Fractions {
        rays,
        dims: window.dims(),
        origin: window.origin(),
        halo: window.halo,
        parts,
        planes_of_part: planes_of_row,
        volumes: volumes.iter().map(|&total| ruler.volume(total, of_cell)).collect(),
        areas: job.surfaces.then(|| areas.iter().map(|&total| ruler.area(total)).collect()),
        totals: Totals { volumes, areas },
        has_faces: job.faces,
        has_edges: false,
        has_centroids: false,
        sampled_cells: 0,
    })
}

/// Rays of rows of cells that go together, about.
const RAYS: u32 = 1 << 12;
/// Rows of a round, after which cancel is looked at; wasm has one thread.
const ROUND: usize = if cfg!(target_arch = "wasm32") { 8 } else { 64 };

struct Measure<'a> {
    ruler: Ruler,
    window: CellWindow,
    facets: &'a FacetRows<'a>,
    cells: Columns<'a>,
    faces: Option<Faces<'a>>,
    surfaces: Option<Surfaces<'a>>,
    planes_of_row: u32,
}

/// Memory that a core uses for row after row.
#[derive(Default)]
struct Memory {
    columns: column::Memory,
    fractions: Vec<Fraction>,
}

struct Found {
    part: Part,
    volumes: Vec<Total>,
    /// Of each position.
    areas: Vec<Total>,
}

impl Measure<'_> {
    fn of_row(&self, row: u32, memory: &mut Memory) -> Found {
        let CellWindow { first, end, .. } = self.window;
        let planes = row * self.planes_of_row..((row + 1) * self.planes_of_row).min(end[2] - first[2]);
        let of_cut = cut(self.facets, row, planes.clone());
        let Memory { columns, fractions } = memory;
        let mut faces = self.faces.as_ref().map(|faces| faces.of_planes(planes.clone(), columns));
        let (mut n_cut, mut volumes) = (0, Volumes::new(&self.ruler));
        let whole = self.cells.whole();
        fractions.clear();
        self.cells.rows(planes.clone(), columns, |[y, z], cells, sums| {
            let cells = cells.start.max(first[0])..cells.end.min(end[0]);
            if cells.is_empty() {
                return;
            }
            self.add_volumes([y, z], &cells, sums, &mut volumes);
            if let Some(sum) = sums.iter().find(|sum| sum.length() == whole) {
                let cells = cells.start - first[0]..cells.end - first[0];
                let of_row = [y, z - planes.start];
                let n = of_cut.n_of_row(of_row, cells.clone());
                n_cut += u64::from(n);
                if n == 0 && faces.is_none() {
                    return;
                }
                let listed = match &mut faces {
                    Some(faces) => faces.with_unlike(of_row, cells.clone(), sum.flag, &of_cut),
                    None => &of_cut,
                };
                let index = self.window.index([first[0], first[1] + y, first[2] + z]);
                let fraction = |x: u32| Fraction { cell: index + u64::from(x), fraction: 1.0, flag: sum.flag };
                fractions.extend(listed.of_row(of_row, cells).map(fraction));
            } else {
                n_cut += cells.len() as u64;
                self.add_fractions([y, z], cells, sums, fractions);
            }
        });
        let (fractions, faces) = match faces {
            Some(faces) => faces.with_all_flags(fractions),
            None => (fractions.clone(), Vec::new()),
        };
        let found = self.surfaces.as_ref().map(|surfaces| surfaces.of_row(row, planes, &self.ruler));
        let (surfaces, areas) = found.unwrap_or_default();
        Found { part: Part { fractions, faces, surfaces, n_cut, ..Part::default() }, volumes: volumes.totals(), areas }
    }

    /// Adds what flags have of cells that are alike, whose row is counted from the first of the window.
    fn add_volumes(&self, [y, z]: [u32; 2], cells: &Range<u32>, sums: &[Sum], volumes: &mut Volumes) {
        let some = sums.iter().filter(|sum| sum.length() > 0);
        let [y, z] = [self.window.first[1] + y, self.window.first[2] + z];
        volumes.add(
            &self.ruler,
            [cells.start, y, z],
            cells.len() as u32,
            some.map(|sum| (sum.flag, sum.length() as u64)),
        );
    }

    /// Adds the fractions of cells that are alike.
    fn add_fractions(&self, [y, z]: [u32; 2], cells: Range<u32>, sums: &[Sum], fractions: &mut Vec<Fraction>) {
        let of_whole = 1.0 / self.cells.whole() as f64;
        let first = self.window.index([cells.start, self.window.first[1] + y, self.window.first[2] + z]);
        for cell in (first..).take(cells.len()) {
            let fraction = |length: i64| rounded_part(length as f64 * of_whole);
            let some = sums.iter().filter(|sum| sum.length() > 0);
            fractions.extend(some.map(|sum| Fraction { cell, fraction: fraction(sum.length()), flag: sum.flag }));
        }
    }
}
