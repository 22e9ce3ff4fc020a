//! The traditional algorithm that the paper's speed-up is relative to: one core, ray after ray, f64.
//!
//! A ray loops over the facets of its bin (the same lattice, 8 x 8 rays), tests three orientations of each (Eq. 16) with the
//! cases of a point and an edge, sorts the points of intersection, keeps equal ones once, and then walks through all its cells and
//! flags them: O(rays * (facets of a bin + cells of a ray)). The flags of a ray lie side by side, which is the order that
//! costs it least. Corners are the snapped ones, so that cells that differ from ours differ by the rules alone.

use crate::cases::Case;
use std::error::Error;
use std::time::Instant;

use hexcast::columns::{Columns, flag_at};
use hexcast::control::Control;
use hexcast::job::Rule;
use hexcast_core::stages::cast::Cast;
use hexcast_core::stages::cpu;
use hexcast_core::stages::lattice::{Lattice, lattice};
use serde::Serialize;

use crate::line::{Ready, lap, ready};

const BIN: u32 = 8;
/// Points of intersection nearer than this, in cells, are the same one.
const SAME: f64 = 1e-6;

/// Seconds of the traditional algorithm, and what it did.
#[derive(Debug, Clone, Serialize)]
pub(crate) struct Serial {
    /// Read, lines and snap.
    pub(crate) before_s: f64,
    /// Lattice.
    pub(crate) lattice_s: f64,
    /// Intersection and flags of all cells.
    pub(crate) rays_s: f64,
    /// From the file to flags in memory.
    pub(crate) to_flags_s: f64,
    /// Pairs of a ray and a facet that were tested.
    pub(crate) n_tests: u64,
    /// Cells.
    pub(crate) n_cells: u64,
    /// Cells with another flag than ours.
    pub(crate) n_differing: u64,
}

/// A facet as three corners, in cells, the ray axis last.
type Corners = [[f64; 3]; 3];

/// Meshes a model of one geometry on one core and compares with our columns.
pub(crate) fn measure(case: &Case) -> Result<Serial, Box<dyn Error>> {
    let one_core = rayon::ThreadPoolBuilder::new().num_threads(1).build()?;
    // errors as text: what crosses threads must be Send
    let measured = one_core.install(|| measure_here(case).map_err(|error| error.to_string()));
    Ok(measured?)
}

fn measure_here(case: &Case) -> Result<Serial, Box<dyn Error>> {
    let start = Instant::now();
    let (ready, before) = ready(case)?;
    let mut clock = Instant::now();
    let rays = &ready.prepared.rays;
    let lattice = lattice(&ready.frame, rays, [BIN; 2], 0..Lattice::n_rows(rays, [BIN; 2]));
    let lattice_s = lap(&mut clock);
    let (flags, n_tests) = cast(&ready, &lattice);
    let rays_s = lap(&mut clock);
    let to_flags_s = start.elapsed().as_secs_f64();
    let columns = cpu::columns(&Cast { frame: &ready.frame, rays, rule: Rule::Parity }, &Control::default())?;
    Ok(Serial {
        before_s: before.iter().sum(),
        lattice_s,
        rays_s,
        to_flags_s,
        n_tests,
        n_cells: flags.len() as u64,
        n_differing: differing(&flags, &columns)?,
    })
}

/// Casts all rays; returns the flags, ray after ray, and the number of tests.
fn cast(ready: &Ready, lattice: &Lattice) -> (Vec<u8>, u64) {
    let (rays, frame) = (&ready.prepared.rays, &ready.frame);
    let cell = f64::from(1_u32 << frame.fraction_bits);
    let facets: Vec<Corners> = frame
        .facets
        .iter()
        .map(|facet| facet.map(|corner| rays.project(corner).map(|u| f64::from(u) / cell)))
        .collect();
    let mut flags = vec![0; (rays.n_rays() * u64::from(rays.depth)) as usize];
    let mut rows = flags.chunks_exact_mut(rays.depth as usize);
    let mut points = Vec::new();
    let mut n_tests = 0;
    for j in 0..rays.counts[1] {
        for i in 0..rays.counts[0] {
            let candidates = lattice.bin_facets(i / BIN, j / BIN);
            n_tests += candidates.len() as u64;
            points.clear();
            let ray = [f64::from(i), f64::from(j)];
            points.extend(candidates.iter().filter_map(|&facet| intersection(&facets[facet as usize], ray)));
            points.sort_by(f64::total_cmp);
            points.dedup_by(|next, kept| *next - *kept < SAME);
            if let Some(row) = rows.next() {
                flag_cells(&points, row);
            }
        }
    }
    (flags, n_tests)
}

/// Where a ray meets a facet, in cells along the ray (Eq. 16-19).
fn intersection(&[a, b, c]: &Corners, ray: [f64; 2]) -> Option<f64> {
    let across =
        |from: [f64; 3], to: [f64; 3]| (to[0] - from[0]) * (ray[1] - from[1]) - (to[1] - from[1]) * (ray[0] - from[0]);
    let orientations = [across(b, c), across(c, a), across(a, b)];
    let none_negative = orientations.iter().all(|&o| o >= 0.0);
    let none_positive = orientations.iter().all(|&o| o <= 0.0);
    // all three 0: in one plane with the ray, no intersection
    if none_negative == none_positive {
        return None;
    }
    let sum: f64 = orientations.iter().sum();
    Some((orientations[0] * a[2] + orientations[1] * b[2] + orientations[2] * c[2]) / sum)
}

/// Walks through the cells of a ray; a centre after an odd number of points is inside.
fn flag_cells(points: &[f64], cells: &mut [u8]) {
    let mut n_passed = 0;
    for (k, flag) in cells.iter_mut().enumerate() {
        while points.get(n_passed).is_some_and(|&point| point < k as f64) {
            n_passed += 1;
        }
        *flag = (n_passed % 2) as u8;
    }
}

/// Counts cells with different flags.
fn differing(flags: &[u8], columns: &Columns) -> hexcast::Result<u64> {
    let rows = flags.chunks_exact(columns.rays().depth as usize);
    let of_row = |(ray, row): (u64, &[u8])| {
        let runs = columns.ray(ray)?;
        Ok((0..).zip(row).filter(|&(cell, &flag)| flag_at(&runs, cell) != flag).count() as u64)
    };
    (0..).zip(rows).map(of_row).sum()
}
