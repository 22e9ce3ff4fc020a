//! Mesh lines: where the planes between cells stand on each axis.
//!
//! Input: a box and a cell size or count per axis -> output: [`Lines`]. Uniform: line i of an axis is
//! `origin + i * spacing`, i = 0 ..= n cells. Source: the paper, Eq. 7-9.

use crate::error::{Error, Result};

/// Uniform mesh lines on three axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Lines {
    /// Coordinate of line 0 on each axis, in the unit of the file.
    pub origin: [f64; 3],
    /// Cell size on each axis, in the unit of the file; positive.
    pub spacing: [f64; 3],
    /// Number of cells on each axis; at least 1.
    pub dims: [u32; 3],
}

impl Lines {
    /// Builds uniform lines.
    ///
    /// # Errors
    /// `domain-empty` where a cell size is not a positive finite number or there are no cells; `job-value` where the
    /// origin is not finite.
    pub fn new(origin: [f64; 3], spacing: [f64; 3], dims: [u32; 3]) -> Result<Lines> {
        for axis in 0..3 {
            let name = ["x", "y", "z"][axis];
            if !(spacing[axis] > 0.0 && spacing[axis].is_finite()) || dims[axis] == 0 {
                let message = format!("{} cells of size {} along {name}", dims[axis], spacing[axis]);
                return Err(Error::new("domain-empty", message, "give the domain an extent along every axis"));
            }
            if !origin[axis].is_finite() {
                return Err(Error::new("job-value", format!("the domain starts at {} along {name}", origin[axis]), ""));
            }
        }
        Ok(Lines { origin, spacing, dims })
    }

    /// Coordinate of line `index` (0 ..= dims) of an axis.
    pub fn line(&self, axis: usize, index: u32) -> f64 {
        self.origin[axis] + f64::from(index) * self.spacing[axis]
    }

    /// Number of cells of the box.
    pub fn n_cells(&self) -> u64 {
        self.dims.iter().map(|&n| u64::from(n)).product()
    }

    /// Volume of one cell, in cubed file units.
    pub fn cell_volume(&self) -> f64 {
        self.spacing.iter().product()
    }
}
