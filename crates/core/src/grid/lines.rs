//! Mesh lines: the planes between cells on each axis.
//!
//! A job, a domain -> [`Lines`]. Uniform: line i of an axis is `origin + i * spacing`, i = 0 ..= n cells, and starts at the
//! domain's minimum. The number of cells is `ceil(extent / spacing)`, where an excess that rounding explains counts as none:
//! a billionth of a cell, and around geometries also the rounding of their f32 coordinates (a cube from 0.1f32 to 1.1f32 is
//! ten cells of 0.1, not eleven). For `max_cell_size` it is `round(extent / spacing)`: the domain's end is on a line, within
//! the tolerance. Source: the paper, Eq. 1-3 and 7-9.

use serde::Serialize;

use crate::base::error::{Error, Result};
use crate::base::finding::Finding;
use crate::grid::domain::Domain;
use crate::input::job::{DEFAULT_CELLS, DEFAULT_TOLERANCE, Job, LinesJob, Padding, short_number};

mod graded;
mod grading;
mod grid;
mod optimum;

pub use graded::{Body, graded};
pub use grading::Grading;
pub use grid::AXES;
pub use grid::{Lines, MAX_LISTED};

use optimum::Intervals;

/// Part of a cell by which a domain may exceed whole cells through rounding of f64 alone.
const ROUNDING: f64 = 1e-9;
/// Part of a cell beyond which an excess is never called rounding, however coarse the coordinates of the files.
const GREATEST_ROUNDING: f64 = 0.01;

/// How far an end point of the domain lies from the nearest mesh line.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct Residual {
    /// The end point, in the unit of the files.
    pub end_point: f64,
    /// Signed distance from the nearest mesh line, in cells: -0.5 to 0.5.
    pub cells: f64,
}

/// Chooses the mesh lines of a job over its domain.
///
/// - `lines`: as given.
/// - `cells` N: cubic cells of the longest extent / N.
/// - `dims`: exactly so many cells; the size per axis is extent / cells.
/// - `cell_size`: as given.
/// - `max_cell_size` S: per axis the largest size of at most S that puts all end points on lines; see the source of
///   `optimum` for the method.
///
/// Padding by cells is added on both sides at the end. Generated lines are those of [`graded`].
///
/// # Errors
/// `lines-wrong`; `lines-no-common-size`; `too-many-cells` where an axis would have more than 2^32 cells; `domain-empty`.
pub fn lines(job: &Job, domain: &Domain) -> Result<Lines> {
    if let Some(LinesJob { x, y, z }) = &job.lines {
        return Lines::from_lists([x.clone(), y.clone(), z.clone()]);
    }
    let spacing = cell_sizes(job, domain)?;
    let mut dims = [0u32; 3];
    let mut origin = domain.low;
    for axis in 0..3 {
        let cells = whole_cells(job, domain, spacing[axis], axis);
        let padding = match job.padding {
            Some(Padding::Cells(cells)) => cells.each()[axis],
            _ => 0,
        };
        let padded = cells + 2.0 * f64::from(padding);
        if padded > f64::from(u32::MAX) {
            let (cells, size) = (short_number(padded.round()), spacing[axis]);
            let message = format!("{cells} cells of size {size:?} along {}", AXES[axis]);
            return Err(Error::new("too-many-cells", message, "use larger cells"));
        }
        dims[axis] = padded as u32;
        origin[axis] -= f64::from(padding) * spacing[axis];
    }
    Lines::new(origin, spacing, dims)
}

/// Checks that the box has no more cells than the job allows.
///
/// # Errors
/// `too-many-cells`.
pub fn check_n_cells(job: &Job, lines: &Lines) -> Result<()> {
    let Some(max) = job.max_cells else { return Ok(()) };
    // 96 bits hold any three numbers of cells
    let n_cells: u128 = lines.dims().iter().map(|&n| u128::from(n)).product();
    if n_cells <= u128::from(max) {
        return Ok(());
    }
    let [nx, ny, nz] = lines.dims();
    let message = format!("{nx} x {ny} x {nz} = {n_cells} cells: at most {max} are allowed");
    let hint =
        "check the cell size against the unit of the files; if it is right, allow more with max_cells (--max-cells)";
    Err(Error::new("too-many-cells", message, hint))
}

/// A finding for every axis along which `max_cell_size` led to cells of less than half that size: what they cost, and the
/// nearest size that costs less.
pub fn about_fine_cells(job: &Job, domain: &Domain, lines: &Lines) -> Vec<Finding> {
    let Some(s_max) = job.max_cell_size else { return Vec::new() };
    let tolerance = job.tolerance.unwrap_or(DEFAULT_TOLERANCE);
    let residuals = residuals(lines, domain);
    let finding = |axis: usize| {
        let (size, name) = (lines.smallest()[axis], AXES[axis]);
        let n_cells = |size: f64| (domain.extent(axis) / size).round();
        // a single cell cannot be larger
        if size >= 0.5 * s_max || n_cells(size) <= 1.0 {
            return None;
        }
        let intervals = Intervals::new(domain, axis);
        let farthest = residuals[axis].iter().map(|of| of.cells.abs()).fold(0.0, f64::max);
        let cause = if intervals.thinnest < 2.0 * size {
            format!("the thinnest geometry is {} thick", intervals.thinnest)
        } else {
            format!("no larger size puts all {} end points on lines within {tolerance} cells", residuals[axis].len())
        };
        let wider = WIDER.into_iter().filter(|&wider| wider > tolerance);
        let cheaper = wider
            .filter_map(|wider| Some((wider, intervals.optimal_cell_size(s_max, wider)?)))
            .find(|(_, cheaper)| n_cells(*cheaper) < n_cells(size));
        let offer = match cheaper {
            Some((wider, cheaper)) => {
                format!("a tolerance of {wider} would give cells of {cheaper}, {} along {name}", n_cells(cheaper))
            }
            None => "no tolerance gives larger ones; cell_size (--cell-size) does, off the end points".into(),
        };
        let sentence = format!(
            "cells are {size} in size along {name}, less than half of {s_max}, which makes {} of them: {cause}. The end points lie at \
             most {farthest:.1e} cells off their lines; {offer}",
            n_cells(size),
        );
        let found = Finding::new("cells-fine", sentence).along(axis).with_value("cell_size", size);
        let found = found.with_value("max_cell_size", s_max).with_count("cells", n_cells(size) as u64);
        Some(match cheaper {
            Some((wider, cheaper)) => found.with_value("tolerance", wider).with_value("cheaper_cell_size", cheaper),
            None => found,
        })
    };
    (0..3).filter_map(finding).collect()
}

/// Tolerances that are offered where the one given leads to no size, or to a small one.
const WIDER: [f64; 6] = [0.05, 0.1, 0.2, 0.3, 0.4, 0.5];

/// Cell size on each axis.
fn cell_sizes(job: &Job, domain: &Domain) -> Result<[f64; 3]> {
    if let Some(dims) = job.dims {
        return Ok([0, 1, 2].map(|axis| domain.extent(axis) / f64::from(dims[axis])));
    }
    if let Some(size) = job.cell_size {
        return Ok(size.each());
    }
    if let Some(s_max) = job.max_cell_size {
        let tolerance = job.tolerance.unwrap_or(DEFAULT_TOLERANCE);
        let mut sizes = [0.0; 3];
        for axis in 0..3 {
            let intervals = Intervals::new(domain, axis);
            let optimum = intervals.optimal_cell_size(s_max, tolerance);
            sizes[axis] = optimum.ok_or_else(|| no_size(axis, &intervals, s_max, tolerance))?;
        }
        return Ok(sizes);
    }
    Ok([domain.longest_extent() / f64::from(job.cells.unwrap_or(DEFAULT_CELLS)); 3])
}

/// Number of cells that cover the domain along an axis, before padding; at least 1.
fn whole_cells(job: &Job, domain: &Domain, size: f64, axis: usize) -> f64 {
    if let Some(dims) = job.dims {
        return f64::from(dims[axis]);
    }
    let ratio = domain.extent(axis) / size;
    let cells = if job.max_cell_size.is_some() {
        ratio.round()
    } else {
        // the numbers of a given domain are the caller's, not a file's
        let rounding = if job.domain.is_some() { 0.0 } else { domain.file_rounding(axis) };
        (ratio - ROUNDING - (rounding / size).min(GREATEST_ROUNDING)).ceil()
    };
    cells.max(1.0)
}

fn no_size(axis: usize, intervals: &Intervals, s_max: f64, tolerance: f64) -> Error {
    let name = AXES[axis];
    let [least, greatest] = intervals.searched(s_max, tolerance);
    let [greatest_size, least_size, within] = [greatest, least, tolerance];
    let message = format!(
        "no cell size from {greatest_size} down to {least_size} puts the {} end points along {name} on mesh lines within {within} cells",
        intervals.distances.len() + 1,
    );
    let wider = WIDER.into_iter().filter(|&wider| wider > tolerance);
    let found = wider.filter_map(|wider| Some((wider, intervals.optimal_cell_size(s_max, wider)?))).next();
    let offer = found.map_or(String::new(), |(wider, size)| {
        let [wider, size] = [wider, size];
        format!("a tolerance of {wider} would give cells of {size} along {name}; ")
    });
    let hint = format!("{offer}allow a larger tolerance or a smaller max_cell_size, or give cell_size");
    Error::new("lines-no-common-size", message, hint)
}

/// Distances of all end points from their nearest mesh lines.
pub fn residuals(lines: &Lines, domain: &Domain) -> [Vec<Residual>; 3] {
    [0, 1, 2].map(|axis| {
        let residual = |&end_point: &f64| {
            let position = lines.position(axis, end_point);
            Residual { end_point, cells: position - position.round() }
        };
        domain.end_points[axis].iter().map(residual).collect()
    })
}

#[cfg(test)]
mod tests;
