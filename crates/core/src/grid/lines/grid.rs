//! The lines of a box: equally spaced, or a list an axis.
//!
//! Equally spaced lines are `origin + i * spacing`. Of listed ones the *unit* is the smallest cell of the axis: the frame counts in it, so
//! that it stays affine and edges stay straight. Lists that are equally spaced to the last bit on all axes are no lists: they are
//! the lines that some origin and spacing give, and mesh as these do.

use std::sync::Arc;

use crate::base::error::{Error, Result};

/// Most lines of a list: those of the most cells along an axis.
pub const MAX_LISTED: usize = (1 << 18) - 1;
/// Names of the axes.
#[doc(hidden)]
pub const AXES: [&str; 3] = ["x", "y", "z"];

/// Mesh lines on three axes.
#[derive(Debug, Clone, PartialEq)]
pub struct Lines {
    dims: [u32; 3],
    origin: [f64; 3],
    /// Size of the cells where they are equal; else that of the smallest cell of the whole box.
    unit: [f64; 3],
    /// All lines of each axis, where they are not equally spaced.
    lists: Option<Arc<[Vec<f64>; 3]>>,
}

impl Lines {
    /// Builds uniform lines.
    ///
    /// # Errors
    /// `domain-empty` where a cell size is not a positive finite number or there are no cells; `job-value` where the
    /// origin is not finite, or where lengths are beyond 1e38 or cells below 1e-38.
    pub fn new(origin: [f64; 3], spacing: [f64; 3], dims: [u32; 3]) -> Result<Lines> {
        for axis in 0..3 {
            let name = AXES[axis];
            if !(spacing[axis] > 0.0 && spacing[axis].is_finite()) || dims[axis] == 0 {
                let message = format!("{} cells of size {:?} along {name}", dims[axis], spacing[axis]);
                return Err(Error::new("domain-empty", message, "give the domain an extent along every axis"));
            }
            if !origin[axis].is_finite() {
                return Err(Error::new("job-value", format!("the domain starts at {} along {name}", origin[axis]), ""));
            }
            let end = origin[axis] + f64::from(dims[axis]) * spacing[axis];
            check_lengths(name, [origin[axis], end], spacing[axis])?;
        }
        Ok(Lines { origin, unit: spacing, dims, lists: None })
    }

    /// Builds lines from all coordinates of each axis, which increase. Where all are equally spaced to the last bit, these are the uniform
    /// lines.
    ///
    /// # Errors
    /// `lines-wrong` where an axis has fewer than two lines or more than [`MAX_LISTED`], one is not finite, or not
    /// greater than the one before; `job-value` as [`Lines::new`].
    pub fn from_lists(lists: [Vec<f64>; 3]) -> Result<Lines> {
        for axis in 0..3 {
            check(&lists[axis], AXES[axis])?;
            let list = &lists[axis];
            check_lengths(AXES[axis], [list[0], list[list.len() - 1]], smallest(list))?;
        }
        let even = [0, 1, 2].map(|axis| even_spacing(&lists[axis]));
        let origin = [0, 1, 2].map(|axis: usize| lists[axis][0]);
        let dims = [0, 1, 2].map(|axis: usize| lists[axis].len() as u32 - 1);
        if let [Some(x), Some(y), Some(z)] = even {
            return Lines::new(origin, [x, y, z], dims);
        }
        let unit = [0, 1, 2].map(|axis| even[axis].unwrap_or_else(|| smallest(&lists[axis])));
        Ok(Lines { origin, dims, unit, lists: Some(Arc::new(lists)) })
    }

    /// The same lines as lists, even where they are equally spaced.
    #[doc(hidden)]
    pub fn as_lists(&self) -> Lines {
        let lists = [0, 1, 2].map(|axis| self.list(axis));
        Lines { lists: Some(Arc::new(lists)), ..self.clone() }
    }

    /// The lines of cells that are halved so often along each axis; all of these lines are among them.
    ///
    /// # Errors
    /// `too-many-cells` where an axis would have 2^32 cells; those of [`Lines::new`] and [`Lines::from_lists`].
    pub fn halved(&self, times: u32) -> Result<Lines> {
        let times_more = 1_u32.checked_shl(times).unwrap_or(0);
        let dims = self.dims.map(|n| n.checked_mul(times_more).filter(|n| *n > 0));
        let [Some(nx), Some(ny), Some(nz)] = dims else {
            let message = format!("{:?} cells that are halved {times} times along each axis", self.dims);
            return Err(Error::new("too-many-cells", message, "halve them less often, or begin with fewer"));
        };
        let parts = f64::from(times_more);
        let Some(lists) = self.lists() else {
            return Lines::new(self.origin, self.unit.map(|size| size / parts), [nx, ny, nz]);
        };
        Lines::from_lists([0, 1, 2].map(|axis: usize| {
            let within = |ends: &[f64]| {
                let [low, size] = [ends[0], ends[1] - ends[0]];
                (0..times_more).map(move |part| low + size * f64::from(part) / parts)
            };
            lists[axis].windows(2).flat_map(within).chain(lists[axis].last().copied()).collect()
        }))
    }

    /// Every second line of each axis. Of an odd number of equal cells the last reaches beyond these lines, by one cell; of listed ones it ends with them.
    ///
    /// # Errors
    /// Those of [`Lines::new`] and [`Lines::from_lists`].
    pub fn doubled(&self) -> Result<Lines> {
        let Some(lists) = self.lists() else {
            return Lines::new(self.origin, self.unit.map(|size| 2.0 * size), self.dims.map(|n| n.div_ceil(2)));
        };
        let doubled = |list: &Vec<f64>| -> Vec<f64> {
            let last = list.last().filter(|_| list.len().is_multiple_of(2));
            list.iter().step_by(2).chain(last).copied().collect()
        };
        Lines::from_lists(lists.each_ref().map(doubled))
    }

    /// Whether the cells of an axis differ in size.
    pub fn is_graded(&self) -> bool {
        self.lists().is_some()
    }

    fn lists(&self) -> Option<&[Vec<f64>; 3]> {
        self.lists.as_deref()
    }

    /// Number of cells on each axis; at least 1.
    pub fn dims(&self) -> [u32; 3] {
        self.dims
    }

    /// Coordinate of line 0 on each axis, in the unit of the file.
    pub fn origin(&self) -> [f64; 3] {
        self.origin
    }

    /// Cell size on each axis, in the unit of the file; None where cells differ.
    pub fn spacing(&self) -> Option<[f64; 3]> {
        (!self.is_graded()).then_some(self.unit)
    }

    /// Cell size on each axis; where cells differ that of the smallest of the box that these are lines of.
    pub fn smallest(&self) -> [f64; 3] {
        self.unit
    }

    /// All lines of an axis, ascending: cells + 1 coordinates.
    pub fn list(&self, axis: usize) -> Vec<f64> {
        (0..=self.dims[axis]).map(|index| self.line(axis, index)).collect()
    }

    /// Coordinate of line `index` of an axis; lines beyond the last are as far from each other as the last two.
    pub fn line(&self, axis: usize, index: u32) -> f64 {
        match self.lists() {
            None => self.origin[axis] + f64::from(index) * self.unit[axis],
            Some(lists) => match lists[axis].get(index as usize) {
                Some(line) => *line,
                None => self.at(axis, f64::from(index)),
            },
        }
    }

    /// Length of a cell along an axis.
    pub fn cell_size(&self, axis: usize, cell: u32) -> f64 {
        match self.lists() {
            None => self.unit[axis],
            Some(_) => self.line(axis, cell.saturating_add(1)) - self.line(axis, cell),
        }
    }

    /// Coordinate of the middle of a cell along an axis.
    pub fn centre(&self, axis: usize, cell: u32) -> f64 {
        self.at(axis, f64::from(cell) + 0.5)
    }

    /// The coordinate of a place counted in cells from line 0: whole numbers are lines. Beyond the ends cells go on with the size of
    /// the last.
    pub fn at(&self, axis: usize, cells: f64) -> f64 {
        let Some(lists) = self.lists() else { return self.origin[axis] + cells * self.unit[axis] };
        let lines = &lists[axis];
        let whole = cells.floor().max(0.0) as usize;
        if let Some(line) = lines.get(whole).filter(|_| whole as f64 == cells) {
            return *line;
        }
        let cell = whole.min(lines.len() - 2);
        lines[cell] + (cells - cell as f64) * (lines[cell + 1] - lines[cell])
    }

    /// The place of a coordinate, counted in cells from line 0: the inverse of [`Lines::at`].
    // always: each corner of each facet is placed by it, some times
    #[inline(always)]
    pub fn position(&self, axis: usize, coordinate: f64) -> f64 {
        match self.lists() {
            None => (coordinate - self.origin[axis]) / self.unit[axis],
            Some(lists) => position_in(&lists[axis], coordinate),
        }
    }

    /// Number of cells of the box.
    pub fn n_cells(&self) -> u64 {
        self.dims.iter().map(|&n| u64::from(n)).product()
    }

    /// Volume of each cell, in cubed file units; None where they differ.
    pub fn cell_volume(&self) -> Option<f64> {
        self.spacing().map(|spacing| spacing.iter().product())
    }

    /// World coordinates of the corners of a box of cells; its end is exclusive.
    #[doc(hidden)]
    pub fn corners(&self, cells: [[u32; 3]; 2]) -> [[f64; 3]; 2] {
        cells.map(|cell| [0, 1, 2].map(|axis| self.line(axis, cell[axis])))
    }

    /// The lines of some of the cells: the first, and the end, exclusive.
    #[doc(hidden)]
    pub fn window(&self, [first, end]: [[u32; 3]; 2]) -> Lines {
        let part = |axis: usize| (first[axis]..=end[axis]).map(|index| self.line(axis, index)).collect();
        Lines {
            origin: [0, 1, 2].map(|axis| self.line(axis, first[axis])),
            dims: [0, 1, 2].map(|axis| end[axis] - first[axis]),
            unit: self.unit,
            lists: self.lists().map(|_| Arc::new([0, 1, 2].map(part))),
        }
    }

    /// The lines of some of the cells, and of so many more on both sides, also beyond these lines.
    #[doc(hidden)]
    pub fn with_halo(&self, [first, end]: [[u32; 3]; 2], halo: u32) -> Lines {
        let dims = [0, 1, 2].map(|axis| end[axis] - first[axis] + 2 * halo);
        let start = first.map(|cell| f64::from(cell) - f64::from(halo));
        let list = |axis: usize| (0..=dims[axis]).map(|index| self.at(axis, start[axis] + f64::from(index))).collect();
        Lines {
            origin: [0, 1, 2].map(|axis| self.at(axis, start[axis])),
            dims,
            unit: self.unit,
            lists: self.lists().map(|_| Arc::new([0, 1, 2].map(list))),
        }
    }

    /// A place in world coordinates as text, to a thousandth of the smallest cell.
    #[doc(hidden)]
    pub fn text_of(&self, place: [f64; 3]) -> String {
        let text = |axis: usize| {
            let decimals = (3.0 - libm::log10(self.unit[axis])).ceil().clamp(0.0, 300.0) as usize;
            let number = format!("{:.decimals$}", place[axis]);
            let short = if decimals > 0 { number.trim_end_matches('0').trim_end_matches('.') } else { &number };
            if short == "-0" { "0".into() } else { short.to_string() }
        };
        format!("({}, {}, {})", text(0), text(1), text(2))
    }
}

fn check(lines: &[f64], name: &str) -> Result<()> {
    let wrong = |message: String, hint: &str| Err(Error::new("lines-wrong", message, hint));
    if lines.len() < 2 {
        let message = format!("lines.{name} has {} lines: two are the ends of one cell", lines.len());
        return wrong(message, "give at least two lines along every axis");
    }
    if lines.len() > MAX_LISTED {
        let message = format!("lines.{name} has {} lines: at most {} fit", lines.len(), MAX_LISTED);
        return wrong(message, "use fewer cells along this axis");
    }
    if let Some(index) = lines.iter().position(|line| !line.is_finite()) {
        return wrong(format!("lines.{name}[{index}] is {}", lines[index]), "give finite numbers");
    }
    if let Some(index) = lines.windows(2).position(|two| two[1] <= two[0]) {
        let (before, after) = (lines[index], lines[index + 1]);
        let message =
            format!("lines.{name}[{}] is {after:?} and lines.{name}[{index}] before it {before:?}", index + 1);
        return wrong(message, "give the lines of an axis in ascending order, each once");
    }
    Ok(())
}

/// The smallest cell and the largest coordinate: what files of 32-bit numbers hold, and volumes are neither 0 nor infinite.
const LENGTHS: [f64; 2] = [1e-38, 1e38];

/// Refuses an axis whose numbers are too small or too large to be computed with.
fn check_lengths(name: &str, [first, last]: [f64; 2], smallest: f64) -> Result<()> {
    let [least, most] = LENGTHS;
    if smallest >= least && first.abs() <= most && last.abs() <= most {
        return Ok(());
    }
    let message = format!(
        "cells of {smallest:?} along {name}, from {first:?} to {last:?}: cells can have {least:?} and more, and coordinates up to {most:?}"
    );
    Err(Error::new(
        "job-value",
        message,
        "check sizes and domain against the unit of the files, or use another unit of length",
    ))
}

fn smallest(lines: &[f64]) -> f64 {
    lines.windows(2).map(|two| two[1] - two[0]).fold(f64::INFINITY, f64::min)
}

/// The spacing with which `first + i * spacing` gives all lines to the last bit, the shortest number that does; None if there is none.
fn even_spacing(lines: &[f64]) -> Option<f64> {
    let n = lines.len() - 1;
    let mean = (lines[n] - lines[0]) / n as f64;
    let gives =
        |spacing: &f64| lines.iter().enumerate().all(|(index, line)| lines[0] + index as f64 * *spacing == *line);
    // rounded to so many digits: a quotient or product of two numbers without rounding
    let exponent = libm::floor(libm::log10(mean)) as i32;
    let short = (0..17).map(|digits| {
        let power = libm::pow(10.0, f64::from((digits - exponent).abs()));
        if digits >= exponent { libm::round(mean * power) / power } else { libm::round(mean / power) * power }
    });
    let bits = mean.to_bits();
    let near = (-4i64..=4).map(|off| f64::from_bits(bits.wrapping_add_signed(off)));
    short.chain(near).chain([lines[1] - lines[0]]).find(gives)
}

/// The place of a coordinate between lines, counted in cells from line 0.
fn position_in(lines: &[f64], coordinate: f64) -> f64 {
    let cell = lines[1..lines.len() - 1].partition_point(|&line| line <= coordinate);
    cell as f64 + (coordinate - lines[cell]) / (lines[cell + 1] - lines[cell])
}

#[cfg(test)]
mod tests;
