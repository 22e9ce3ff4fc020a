//! The overlay: cells that are decided separately are put over the columns of the other geometries.
//!
//! # Theory
//! The rays of the mesh decide closed geometries. The cells of open ones ([`crate::open_surfaces::open`]) and those along surfaces (`sheet`)
//! are found separately, row after row of rays. Of two geometries in a cell the higher rank wins.
//!
//! # Practice
//! `split` takes these geometries out of a frame, and says which rays decide them. A backend casts those rays. It also casts
//! the other geometries as usual, but with rank + 1 for a flag. [`Overlay`] puts the separate cells over these bands, and
//! replaces ranks by the flags of the job. Bands come in the order of their rays, as backends hand them out.
//! Cost: one pass over all runs.

use std::ops::Range;

use crate::base::error::Result;
use crate::base::parallel::*;
use crate::cells::columns::{Band, CellRun, run};
use crate::grid::frame::Frame;
use crate::grid::rays::Rays;
use crate::input::geometry::{Fill, Open};
use crate::input::job::Rule;
use crate::open_surfaces::doubt::{Doubt, Doubtful};
use crate::open_surfaces::open::{Shift, Surface, Through, Votes};
use crate::open_surfaces::sheet::Sheet;
use crate::stages::axis_crossings::AxisCrossings;
use crate::stages::cast::Cast;
use crate::stages::cpu::{self, Window};

mod split;

pub(crate) use split::Apart;
use split::Kind;
pub use split::Part;
pub use split::split;

/// What was found of an open geometry.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Index in the job.
    pub geometry: usize,
    /// How its cells were decided.
    pub policy: Open,
    /// What its surface lacks.
    pub surface: Surface,
    /// Rays along x, y and z that do not leave it as often as they enter.
    pub odd_rays: [u64; 3],
    /// Cells whose three rays are not all even, or do not agree.
    pub doubtful_cells: u64,
}

/// The cells along the surface of a geometry.
#[derive(Debug, Clone, PartialEq)]
pub struct Along {
    /// Index in the job.
    pub geometry: usize,
    /// Which cells.
    pub fill: Fill,
    /// Whether it has no others.
    pub shell: bool,
    /// Cells that it has for no other reason.
    pub added_cells: u64,
}

/// Most rows of rays that a core decides at a time.
const ROWS_OF_PART: u32 = 8;

struct Laid {
    rank: u8,
    invert: bool,
    layer: Layer,
}

enum Layer {
    /// A geometry whose rays decide.
    Cast {
        frame: Frame,
        rays: Rays,
        rule: Rule,
    },
    Open {
        votes: Box<Votes>,
        through: Through,
        found: Found,
    },
    Along {
        sheet: Sheet,
        found: Along,
    },
}

/// Parts of geometries, ready to be put over bands.
pub struct Overlay {
    /// Open and inverted geometries, then the cells along surfaces, highest ranks first, so that each knows what it adds.
    layers: Vec<Laid>,
    /// Cells of open geometries that their rays do not decide.
    doubt: Doubt,
    /// Flag of each code of a run: rank + 1, or 0.
    flags: Vec<u8>,
    n_b: u64,
    depth: u32,
}

impl Overlay {
    /// Decides the parts, if there are any, each by the crossings of its [`Part::casts`] and its [`Part::shifts`]; `cast` is what [`split`] left, `flags` has
    /// the flag of each rank; `doubt` is still without cells.
    pub fn new(
        parts: Vec<(Part, Vec<AxisCrossings>, Vec<Shift>)>,
        cast: &Cast,
        flags: &[u8],
        doubt: Doubt,
    ) -> Option<Overlay> {
        if parts.is_empty() {
            return None;
        }
        let layer = |(part, crossings, shifts): (Part, Vec<AxisCrossings>, Vec<Shift>)| {
            let Part { geometry, rank, invert, kind } = part;
            let layer = match kind {
                Kind::Open(part) => {
                    let votes = Votes::new(&part, crossings, &shifts, cast.rays, cast.rule);
                    let found = Found {
                        geometry,
                        policy: part.policy,
                        surface: part.surface,
                        odd_rays: votes.odd_rays,
                        doubtful_cells: 0,
                    };
                    Layer::Open { through: votes.start(), votes: Box::new(votes), found }
                }
                Kind::Inverted(frame) => Layer::Cast { frame, rays: *cast.rays, rule: cast.rule },
                Kind::Sheet { fill, shell, facets } => {
                    let sheet = Sheet::new(&facets, fill, crossings, cast.frame, cast.rays);
                    Layer::Along { sheet, found: Along { geometry, fill, shell, added_cells: 0 } }
                }
            };
            Laid { rank, invert, layer }
        };
        let mut layers = Vec::new();
        for laid in parts.into_iter().map(layer) {
            insert_by(&mut layers, laid, |laid: &Laid| {
                (matches!(laid.layer, Layer::Along { .. }), u8::MAX - laid.rank)
            });
        }
        let (flags, n_b) = ([&[0], flags].concat(), cast.rays.counts[0].into());
        Some(Overlay { layers, doubt, flags, n_b, depth: cast.rays.depth })
    }

    /// Bytes that it holds.
    pub fn n_bytes(&self) -> u64 {
        let of_layer = |laid: &Laid| match &laid.layer {
            Layer::Cast { frame, .. } => 38 * frame.facets.len() as u64,
            Layer::Open { votes, .. } => votes.n_bytes(),
            Layer::Along { sheet, .. } => sheet.n_bytes(),
        };
        self.layers.iter().map(of_layer).sum()
    }

    /// What was found of open geometries, and of the cells along surfaces, in the order of the job; and the doubtful cells.
    ///
    /// # Errors
    /// Those of [`Overlay::lay`].
    pub fn found(self) -> Result<(Vec<Found>, Vec<Along>, Doubtful)> {
        let (mut open, mut along) = (Vec::new(), Vec::new());
        for laid in self.layers {
            match laid.layer {
                Layer::Cast { .. } => {}
                Layer::Open { found, .. } => insert_by(&mut open, found, |found: &Found| found.geometry),
                Layer::Along { found, .. } => insert_by(&mut along, found, |found: &Along| found.geometry),
            }
        }
        Ok((open, along, self.doubt.finish()?))
    }

    /// Looks for doubtful cells of the first rays, which an interrupted run has kept.
    ///
    /// # Errors
    /// Those of [`Overlay::lay`].
    pub fn pass(&mut self, n_rays: u64) -> Result<()> {
        // a row that is not whole is laid again
        for some in parts_of(0..(n_rays / self.n_b) as u32).chunks(2 * current_num_threads()) {
            self.open_rows(some)?;
        }
        Ok(())
    }

    /// The rows of the open geometries, by layer, of the others none; some parts after the other, so that few doubtful runs are held.
    fn open_rows(&mut self, parts: &[Range<u32>]) -> Result<Vec<Vec<Band>>> {
        let mut decided = vec![Vec::new(); self.layers.len()];
        for group in parts.chunks(2 * current_num_threads()) {
            let mut doubt = vec![Vec::new(); group.len()];
            for (laid, decided) in self.layers.iter_mut().zip(&mut decided) {
                if matches!(laid.layer, Layer::Open { .. }) {
                    decided.extend(laid.rows(group, &mut doubt));
                }
            }
            self.doubt.add(group.iter().cloned().zip(doubt).collect())?;
        }
        Ok(decided)
    }

    /// Puts the parts over the next bands, which follow each other; the first may begin within a row of rays.
    ///
    /// # Errors
    /// `memory` where the mask of the doubtful cells takes more than it may.
    pub fn lay(&mut self, bands: Vec<Band>) -> Result<Vec<Band>> {
        let (Some(first), Some(last)) = (bands.first(), bands.last()) else { return Ok(bands) };
        let end_ray = last.first_ray + last.ends.len() as u64;
        let parts = parts_of((first.first_ray / self.n_b) as u32..end_ray.div_ceil(self.n_b) as u32);
        let mut decided = self.open_rows(&parts)?;
        for (laid, decided) in self.layers.iter_mut().zip(&mut decided).filter(|(_, decided)| decided.is_empty()) {
            *decided = laid.rows(&parts, &mut []);
        }
        let (mut laid, added): (Vec<Band>, Vec<Vec<u64>>) =
            bands.into_par_iter().map(|band| self.lay_one(band, &decided, &parts)).unzip();
        if let Some(first) = laid.first_mut() {
            first.n_crossings += decided.iter().flatten().map(|band| band.n_crossings).sum::<u64>();
            first.odd_rays += decided.iter().flatten().map(|band| band.odd_rays).sum::<u64>();
        }
        for (index, laid) in self.layers.iter_mut().enumerate() {
            if let Layer::Along { found, .. } = &mut laid.layer {
                found.added_cells += added.iter().map(|added| added[index]).sum::<u64>();
            }
        }
        Ok(laid)
    }

    /// A band with all layers over it, and the cells that each changed.
    fn lay_one(&self, band: Band, decided: &[Vec<Band>], parts: &[Range<u32>]) -> (Band, Vec<u64>) {
        let mut laid = Band {
            first_ray: band.first_ray,
            ends: Vec::with_capacity(band.ends.len()),
            runs: Vec::with_capacity(band.runs.len()),
            odd_rays: band.odd_rays,
            n_crossings: band.n_crossings,
        };
        let mut changed = vec![0; self.layers.len()];
        let (mut now, mut next) = (Vec::new(), Vec::new());
        for ray in 0..band.ends.len() {
            let index = band.first_ray + ray as u64;
            let part = parts.partition_point(|planes| planes.end <= (index / self.n_b) as u32);
            now.clear();
            now.extend_from_slice(band.ray(ray));
            for (layer, Laid { rank, .. }) in self.layers.iter().enumerate() {
                let over = &decided[layer][part];
                next.clear();
                let over = over.ray((index - over.first_ray) as usize);
                changed[layer] += u64::from(higher(&now, over, rank + 1, self.depth, &mut next));
                std::mem::swap(&mut now, &mut next);
            }
            let mut flag = 0;
            for &run in &now {
                let own = self.flags[(run & 0xff) as usize];
                if own != flag {
                    laid.runs.push(run & !0xff | u32::from(own));
                    flag = own;
                }
            }
            laid.ends.push(laid.runs.len() as u32);
        }
        (laid, changed)
    }
}

impl Laid {
    /// Its cells on the next rows of rays, with the flag 1, part by part; adds those in doubt.
    fn rows(&mut self, parts: &[Range<u32>], doubt: &mut [Vec<CellRun>]) -> Vec<Band> {
        let rows = self.layer.rows(parts, doubt);
        if self.invert { rows.into_iter().map(|band| inverted(&band)).collect() } else { rows }
    }
}

impl Layer {
    fn rows(&mut self, parts: &[Range<u32>], doubt: &mut [Vec<CellRun>]) -> Vec<Band> {
        match self {
            Layer::Cast { frame, rays, rule } => {
                let windows: Vec<Window> = parts.iter().map(|rows| cpu::window_of_rows(rays, rows.clone())).collect();
                cpu::windows(&Cast { frame, rays, rule: *rule }, &windows)
            }
            Layer::Open { votes, through, found } => {
                let mut starts = Vec::new();
                for planes in parts {
                    votes.go_through(through, planes.start);
                    starts.push((through.clone(), planes.clone()));
                }
                let rows: Vec<_> =
                    starts.into_par_iter().map(|(through, planes)| votes.rows(through, planes)).collect();
                let bands = rows.into_iter().zip(doubt).map(|(mut rows, doubt)| {
                    found.doubtful_cells += rows.doubt.iter().map(|run| u64::from(run.end - run.start)).sum::<u64>();
                    doubt.append(&mut rows.doubt);
                    rows.band
                });
                bands.collect()
            }
            Layer::Along { sheet, .. } => parts.to_vec().into_par_iter().map(|planes| sheet.rows(planes)).collect(),
        }
    }
}

/// Consecutive rows for a core each.
fn parts_of(rows: Range<u32>) -> Vec<Range<u32>> {
    let n_parts = rows.len().div_ceil(ROWS_OF_PART as usize).max(rows.len().min(2 * current_num_threads()));
    let start_of = |part: usize| rows.start + (rows.len() * part / n_parts.max(1)) as u32;
    (0..n_parts).map(|part| start_of(part)..start_of(part + 1)).collect()
}

/// A band with the flag 1 where another has 0, and 0 elsewhere.
fn inverted(band: &Band) -> Band {
    let mut other = Band { ends: Vec::new(), runs: Vec::new(), ..*band };
    for ray in 0..band.ends.len() {
        let runs = band.ray(ray);
        if runs.first().is_none_or(|run| run >> 8 > 0) {
            other.runs.push(run(0, 1));
        }
        // a run after the first cell changes the flag
        let turned = runs.iter().map(|&of| run(of >> 8, (of & 0xff == 0).into()));
        other.runs.extend(turned.filter(|of| of & 0xff != 0 || of >> 8 > 0));
        other.ends.push(other.runs.len() as u32);
    }
    other
}

/// Runs that have, in every cell, the higher code of two lists; the flag 1 of the second stands for `code`. Returns the number of
/// cells in which the second is higher.
fn higher(one: &[u32], other: &[u32], code: u8, depth: u32, out: &mut Vec<u32>) -> u32 {
    let (mut of_one, mut of_other, mut last) = (0, 0, 0);
    let (mut i, mut j) = (0, 0);
    let (mut n_changed, mut since) = (0, 0);
    while i < one.len() || j < other.len() {
        let cell = [one.get(i), other.get(j)].into_iter().flatten().map(|run| run >> 8).min().unwrap_or(0);
        n_changed += if of_other > of_one { cell - since } else { 0 };
        since = cell;
        if let Some(run) = one.get(i).filter(|&&run| run >> 8 == cell) {
            of_one = run & 0xff;
            i += 1;
        }
        if let Some(run) = other.get(j).filter(|&&run| run >> 8 == cell) {
            of_other = (run & 0xff) * u32::from(code);
            j += 1;
        }
        let winner = of_one.max(of_other);
        if winner != last {
            out.push(cell << 8 | winner);
            last = winner;
        }
    }
    n_changed + if of_other > of_one { depth - since } else { 0 }
}

/// Inserts into a list that is in the order of a key, behind equal ones: less code in wasm than a sort, for the few that there are.
fn insert_by<T, K: Ord>(list: &mut Vec<T>, item: T, key: impl Fn(&T) -> K) {
    list.insert(list.partition_point(|other| key(other) <= key(&item)), item);
}
