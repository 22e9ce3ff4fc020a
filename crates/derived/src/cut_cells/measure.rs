//! All cut cells of a box: planes of cells together, on all cores.

use super::cells::{Border, Scene, Share, Shares, State};
use super::cut_cell::{CellSurface, CutCells, CutFlag, CutPart, CutWanted};
use super::edges::{Insides, crossings};
use super::integrals::{WHOLE, below_polygon, fixed, number};
use super::pieces::{Grid, Piece, Pieces};
use super::sheets::{find_sheets, measure_sheet};
use crate::fractions::{Totals, Volumes};
use hexcast_core::base::control::Control;
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::parallel::*;
use hexcast_core::base::sort::by_number;
use hexcast_core::grid::frame::{Frame, normal};
use hexcast_core::grid::lines::Lines;
use hexcast_core::grid::totals::{Ruler, Total};
use hexcast_core::grid::window::CellWindow;
use hexcast_core::input::job::Rule;
use hexcast_core::stages::inside::Kind;

/// Planes that go together.
pub(super) const PLANES: u32 = 4;
/// Such planes of a round, after which cancel is looked at; wasm has one thread.
pub(super) const ROUND: usize = if cfg!(target_arch = "wasm32") { 8 } else { 64 };

/// The surfaces that cut cells: snapped, and closed under the rule.
#[derive(Clone, Copy)]
pub struct CutBy<'a> {
    /// The facets.
    pub frame: &'a Frame,
    /// The lines of the box.
    pub lines: &'a Lines,
    /// What is inside.
    pub rule: Rule,
    /// How the cells of each rank are decided: by rays, or these inverted.
    pub kinds: &'a [Kind],
    /// Whether all facets at each position face the same side, so that each edge is used as often one way as the other. Cells at others are sampled.
    pub is_oriented: &'a [bool],
}

/// Measures the cut cells of a window.
///
/// # Errors
/// `memory` where they would take more than `max_bytes`; `cancelled`.
pub async fn cut_cells(
    by: CutBy<'_>,
    window: CellWindow,
    job: CutWanted,
    max_bytes: u64,
    control: &Control,
) -> Result<CutCells> {
    let Measured { parts, volumes, areas, totals, n_sampled } =
        in_parts((by, window), job, max_bytes, control, (|part| part, CutPart::n_bytes)).await?;
    Ok(CutCells {
        dims: window.dims(),
        origin: window.origin(),
        n_cells: parts.iter().map(|part| part.n_cells).sum(),
        n_sampled,
        parts,
        volumes,
        areas,
        totals,
    })
}

/// What was measured, with what is kept of some planes each.
pub(super) struct Measured<P> {
    pub(super) parts: Vec<P>,
    pub(super) volumes: Vec<f64>,
    pub(super) areas: Option<Vec<f64>>,
    pub(super) totals: Totals,
    pub(super) n_sampled: u64,
}

/// Measures the cut cells of a window and keeps of some planes what `keep` makes of them, which takes so many bytes.
///
/// # Errors
/// As for [`cut_cells`].
pub(super) async fn in_parts<P: Send>(
    (by, window): (CutBy<'_>, CellWindow),
    job: CutWanted,
    max_bytes: u64,
    control: &Control,
    (keep, bytes_of): (impl Fn(CutPart) -> P + Sync, impl Fn(&P) -> usize),
) -> Result<Measured<P>> {
    let CutBy { frame, lines, .. } = by;
    let measure = Measure::new(by, window, job);
    let n_planes = measure.grid.n_planes();
    let n_parts = n_planes.div_ceil(PLANES);
    let (mut parts, mut volumes) = (Vec::new(), vec![Total::default(); 256]);
    let geometry_at = &frame.ranks.geometry_at;
    let mut areas = if job.surfaces { vec![Total::default(); geometry_at.len()] } else { Vec::new() };
    let (mut n_bytes, mut n_sampled) = (0, 0);
    for start in (0..n_parts).step_by(ROUND) {
        control.rest().await?;
        let end = (start + ROUND as u32).min(n_parts);
        let found: Vec<Found<P>> =
            on_all_cores(|| map_within(start..end, |memory, part| measure.part(part, memory).kept(&keep)));
        n_bytes += found.iter().map(|found| bytes_of(&found.part) as u64).sum::<u64>();
        if n_bytes > max_bytes {
            let message = format!(
                "cut cells up to plane {} of {n_planes} take {n_bytes} bytes: {max_bytes} are left of the memory allowed",
                (end * PLANES).min(n_planes)
            );
            let hint = "allow more with max_memory (--max-memory), or use larger cells";
            return Err(Error::new("memory", message, hint));
        }
        for Found { part, volumes: of_part, areas: of_positions, n_sampled: of_planes } in found {
            parts.push(part);
            n_sampled += of_planes;
            volumes.iter_mut().zip(of_part.totals()).for_each(|(sum, more)| sum.add(more));
            geometry_at.iter().zip(of_positions).for_each(|(&geometry, more)| areas[geometry].add(more));
        }
    }
    let ruler = Ruler::new(lines, lines);
    Ok(Measured {
        parts,
        n_sampled,
        volumes: volumes.iter().map(|&total| ruler.volume(total, WHOLE as u64)).collect(),
        areas: job.surfaces.then(|| areas.iter().map(|&total| ruler.area(total)).collect()),
        totals: Totals { volumes, areas },
    })
}

pub(super) struct Measure<'a> {
    pub(super) by: CutBy<'a>,
    job: CutWanted,
    pub(super) grid: Grid<'a>,
    ruler: Ruler,
    /// Of each rank.
    pub(super) is_oriented: Vec<bool>,
    /// Of each position 1, or -1 where its facets face inwards.
    turns: Vec<f64>,
    /// First facet of each part, then the end; the facets that reach into it.
    pub(super) firsts: Vec<u32>,
    pub(super) facets: Vec<u32>,
}

/// Memory that a core uses for part after part.
#[derive(Default)]
struct Memory {
    pieces: Pieces,
    shares: Shares,
}

struct Found<P> {
    part: P,
    volumes: Volumes,
    /// Of each position.
    areas: Vec<Total>,
    n_sampled: u64,
}

impl Found<CutPart> {
    fn kept<P>(self, keep: impl Fn(CutPart) -> P) -> Found<P> {
        let Found { part, volumes, areas, n_sampled } = self;
        Found { part: keep(part), volumes, areas, n_sampled }
    }
}

impl Measure<'_> {
    pub(super) fn new(by: CutBy<'_>, window: CellWindow, job: CutWanted) -> Measure<'_> {
        let CutBy { frame, lines, is_oriented, .. } = by;
        let grid = Grid::new(frame, window);
        let n_parts = grid.n_planes().div_ceil(PLANES) as usize;
        let reach = |facet: u32| {
            let planes = grid.planes_of(facet as usize);
            planes.start / PLANES..planes.end.div_ceil(PLANES)
        };
        let pairs = (0..frame.facets.len() as u32).flat_map(|facet| reach(facet).map(move |part| (part, facet)));
        let (mut firsts, mut facets) = (Vec::new(), Vec::new());
        by_number(pairs, n_parts, &mut firsts, &mut facets);
        let mut of_ranks = vec![true; frame.ranks.flag_of_rank.len()];
        let mut volumes = vec![0i128; frame.ranks.geometry_at.len()];
        for (position, &rank) in frame.ranks.rank_at.iter().enumerate() {
            of_ranks[usize::from(rank)] &= is_oriented[position];
        }
        for (&[a, b, c], &position) in frame.facets.iter().zip(&frame.position_of_facet) {
            let across = normal(&[[0; 3], b, c]);
            volumes[usize::from(position)] += (0..3).map(|axis| i128::from(a[axis]) * across[axis]).sum::<i128>();
        }
        let turns = volumes.iter().map(|&volume| if volume < 0 { -1.0 } else { 1.0 }).collect();
        let ruler = Ruler::new(lines, lines);
        Measure { by, job, grid, ruler, is_oriented: of_ranks, turns, firsts, facets }
    }

    fn part(&self, part: u32, memory: &mut Memory) -> Found<CutPart> {
        let Memory { pieces, shares } = memory;
        let CutBy { frame, rule, kinds, .. } = self.by;
        let CellWindow { first, end, .. } = self.grid.window;
        let [nx, ny] = [0, 1].map(|axis| end[axis] - first[axis]);
        let planes = part * PLANES..((part + 1) * PLANES).min(self.grid.n_planes());
        let facets = self.firsts[part as usize] as usize..self.firsts[part as usize + 1] as usize;
        let facets = &self.facets[facets];
        let are_sheets = self.job == CutWanted::default() && self.is_oriented.iter().all(|of| *of);
        if are_sheets {
            find_sheets(pieces, &self.grid, facets, planes.clone());
        } else {
            pieces.find(&self.grid, facets, planes.clone());
        }
        let insides = Insides { rule, kinds };
        let flag_of_rank = &frame.ranks.flag_of_rank;
        let scene = Scene { insides, flag_of_rank, is_oriented: &self.is_oriented, asked: self.job.asked() };
        let mut state = State::new(insides);
        let volumes = Volumes::new(&self.ruler);
        let areas = if self.job.surfaces { vec![Total::default(); frame.ranks.geometry_at.len()] } else { Vec::new() };
        let mut found = Found { part: CutPart::default(), volumes, areas, n_sampled: 0 };
        // two flags in most cells
        found.part.flags.reserve(2 * pieces.n_cells());
        for row in 0..planes.len() as u32 * ny {
            let [y, z] = [first[1] + row % ny, first[2] + planes.start + row / ny];
            let of_row = pieces.of_row(row as usize);
            let mut next = 0;
            let flag = |state: &State| state.winner(&[0; 4]).map_or(0, |rank| flag_of_rank[usize::from(rank)]);
            for of_cell in of_row.chunk_by(|one, other| one.cell() == other.cell()) {
                if let Some(x) = of_cell[0].cell().checked_sub(1) {
                    if next < x {
                        self.add_volume([first[0] + next, y, z], x - next, (flag(&state), WHOLE), &mut found.volumes);
                    }
                    next = x + 1;
                    let cell = [first[0] + x, y, z];
                    if !are_sheets || !measure_sheet(&scene, (frame, pieces), of_cell, &state, shares) {
                        scene.measure(pieces, of_cell, &state, shares);
                    }
                    self.add(cell, shares, &mut found);
                    if self.job.surfaces {
                        self.add_surfaces(cell, pieces, of_cell, &mut found);
                    }
                }
                for piece in of_cell {
                    if are_sheets {
                        if piece.rise.corners[1] != 0 {
                            state.pass(piece.rank(), -piece.rise.corners[1]);
                        }
                        continue;
                    }
                    crossings(pieces, piece, |crossing| {
                        if crossing.edge == 0 {
                            state.pass(piece.rank(), crossing.sign);
                        }
                    });
                }
            }
            if next < nx {
                self.add_volume([first[0] + next, y, z], nx - next, (flag(&state), WHOLE), &mut found.volumes);
            }
            if !of_row.is_empty() {
                state.begin();
            }
        }
        found
    }

    /// Adds what a flag has of each of some cells of a row.
    fn add_volume(&self, cell: [u32; 3], n: u32, (flag, part): (u8, i64), volumes: &mut Volumes) {
        volumes.add(&self.ruler, cell, n, [(flag, part as u64)].into_iter());
    }

    /// Adds what flags have of a cell.
    fn add(&self, cell: [u32; 3], Shares { flags, is_sampled, .. }: &Shares, found: &mut Found<CutPart>) {
        let index = self.grid.window.index(cell);
        found.part.n_cells += 1;
        found.n_sampled += u64::from(*is_sampled);
        for (at, &Share { flag, cell: sums }) in flags.shares.iter().enumerate() {
            let border = flags.borders.get(at);
            if sums[0] > 0 {
                self.add_volume(cell, 1, (flag, sums[0]), &mut found.volumes);
            } else if border.is_none_or(Border::is_empty) {
                continue;
            }
            let fraction = number(sums[0]);
            found.part.flags.push(CutFlag { cell: index, fraction, flag, is_sampled: *is_sampled });
            if self.job.centroids {
                found.part.centroids.push([1, 2, 3].map(|axis| centre(sums[axis], sums[0])));
            }
            let Some(Border { faces, edges }) = border else { continue };
            if self.job.faces {
                found.part.faces.push(faces.map(|face| number(face[0])));
            }
            if self.job.face_centroids {
                found.part.face_centroids.push(faces.map(|face| [1, 2].map(|axis| centre(face[axis], face[0]))));
            }
            if self.job.edges {
                found.part.edges.push(edges.map(number));
            }
        }
    }

    /// Adds the surfaces in a cell.
    fn add_surfaces(&self, cell: [u32; 3], pieces: &Pieces, of_cell: &[Piece], found: &mut Found<CutPart>) {
        let lines = self.by.lines;
        let size = [0, 1, 2].map(|axis| lines.cell_size(axis, cell[axis]));
        let faces = [size[1] * size[2], size[0] * size[2], size[0] * size[1]];
        // a unit that no piece is much larger than
        let unit = faces[0] + faces[1] + faces[2];
        for of_position in of_cell.chunk_by(|one, other| one.position() == other.position()) {
            let (mut area, mut moments, mut vector) = (0i128, [0i128; 3], [0i128; 3]);
            for piece in of_position {
                let corners = pieces.corners(piece);
                for two in corners[1..].windows(2) {
                    let triangle = [corners[0], two[0], two[1]];
                    let across = below_polygon(&triangle).1;
                    let across = [0, 1, 2].map(|axis| 0.5 * across[axis] * faces[axis]);
                    let of_triangle = across.iter().map(|of| of * of).sum::<f64>().sqrt() / unit;
                    area += i128::from(fixed(of_triangle));
                    for axis in 0..3 {
                        let sum = triangle.iter().map(|corner| corner[axis]).sum::<f64>();
                        moments[axis] += i128::from(fixed(of_triangle * sum / 3.0));
                        vector[axis] += i128::from(fixed(across[axis] / faces[axis]));
                    }
                }
            }
            let position = usize::from(of_position[0].position());
            let (of_all, turn) = (area as f64 / WHOLE as f64 * unit, self.turns[position]);
            found.areas[position].add(self.ruler.of_area(of_all));
            if area > 0 {
                found.part.surfaces.push(CellSurface {
                    cell: self.grid.window.index(cell),
                    geometry: self.by.frame.ranks.geometry_at[position] as i16,
                    area: of_all,
                    centre: moments.map(|moment| (moment as f64 / area as f64).clamp(0.0, 1.0)),
                    area_vector: [0, 1, 2].map(|axis| turn * (vector[axis] as f64 / WHOLE as f64) * faces[axis]),
                });
            }
        }
    }
}

/// The centre of what has a moment: in the middle of nothing.
fn centre(moment: i64, of: i64) -> f64 {
    if of > 0 { (moment as f64 / of as f64).clamp(0.0, 1.0) } else { 0.5 }
}
