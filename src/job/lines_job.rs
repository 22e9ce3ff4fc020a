//! Lines of a job that are not equally spaced: given as lists, or to be generated.

use serde::{Deserialize, Serialize};

use super::quoted::short_number;
use super::validate::out_of_range;
use super::{GeometryJob, Job, Padding, PerAxis};
use crate::error::{Error, Result};
use crate::geometry::Sizing;

/// All lines of each axis, ascending, in the unit of the files. Equally spaced ones are meshed like those of `cell_size`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct LinesJob {
    /// Lines across x: cells + 1 of them.
    pub x: Vec<f64>,
    /// Lines across y.
    pub y: Vec<f64>,
    /// Lines across z.
    pub z: Vec<f64>,
}

/// Lines that are generated: on every end of every geometry's box, close where geometries are small, far elsewhere.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct GradedJob {
    /// Largest size of a cell on all axes or each.
    pub max_size: PerAxis<f64>,
    /// Smallest size of a cell; by default a thousandth of the largest. Of ends that are closer to each other one is left off the lines.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub min_size: Option<f64>,
    /// Most times by which a cell is larger than its neighbour, above 1; by default [`DEFAULT_GROWTH`].
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub growth: Option<f64>,
    /// Cells added on both sides of every axis, of the size of the cell at that end: for absorbing layers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub absorbing: Option<PerAxis<u32>>,
}

/// Growth of cells where the job does not say.
pub const DEFAULT_GROWTH: f64 = 1.3;
/// The smallest cell where the job does not say, as a part of the largest.
const DEFAULT_SMALLEST: f64 = 1e-3;
/// Most cells of an absorbing layer.
const MAX_ABSORBING: u32 = 1024;

impl GradedJob {
    /// The smallest size on an axis.
    pub(crate) fn smallest(&self, axis: usize) -> f64 {
        self.min_size.unwrap_or(self.max_size.each()[axis] * DEFAULT_SMALLEST)
    }

    fn validate(&self) -> Result<()> {
        for value in self.max_size.each() {
            if !(value.is_finite() && value > 0.0) {
                return Err(out_of_range("graded.max_size", short_number(value), "a positive number"));
            }
            if let Some(least) = self.min_size.filter(|least| !(*least > 0.0 && *least <= value)) {
                let allowed = format!("above 0, at most max_size, {}", short_number(value));
                return Err(out_of_range("graded.min_size", short_number(least), &allowed));
            }
        }
        if let Some(growth) = self.growth.filter(|growth| !(*growth >= 1.01 && *growth <= 10.0)) {
            return Err(out_of_range("graded.growth", short_number(growth), "1.01 to 10"));
        }
        let layers = self.absorbing.map_or([0; 3], PerAxis::each);
        if let Some(most) = layers.into_iter().find(|cells| *cells > MAX_ABSORBING) {
            return Err(out_of_range("graded.absorbing", most, &format!("0 to {MAX_ABSORBING} cells")));
        }
        Ok(())
    }
}

impl GeometryJob {
    /// Forgets how lines are generated around it.
    pub fn clear_sizing(&mut self) {
        (self.max_size, self.min_cells, self.metal) = (None, None, false);
    }

    /// How lines are generated around it.
    pub(crate) fn sizing(&self) -> Sizing {
        Sizing { max_size: self.max_size, min_cells: self.min_cells, metal: self.metal }
    }
}

impl Job {
    /// Checks what decides lines that are not equally spaced.
    pub(super) fn validate_lines(&self) -> Result<()> {
        let conflict = |message: &str, hint: &str| Err(Error::new("job-conflict", message, hint));
        if let Some(graded) = &self.graded {
            graded.validate()?;
        }
        for (index, geometry) in self.geometries.iter().enumerate() {
            let key = |name: &str| format!("geometries[{index}].{name}");
            if let Some(size) = geometry.max_size.filter(|size| !(size.is_finite() && *size > 0.0)) {
                return Err(out_of_range(&key("max_size"), short_number(size), "a positive number"));
            }
            if geometry.min_cells == Some(0) {
                return Err(out_of_range(&key("min_cells"), 0, "at least 1"));
            }
            if geometry.sizing() != Sizing::default() && self.graded.is_none() {
                let message =
                    format!("geometries[{index}] has max_size, min_cells or metal, and the job has no graded");
                return conflict(&message, "give graded (--graded), which alone uses them");
            }
        }
        if self.lines.is_some() && (self.domain.is_some() || self.padding.is_some()) {
            let message = "lines are given together with domain or padding: the first and the last line are the domain";
            return conflict(message, "leave out domain and padding");
        }
        if self.graded.is_some() && matches!(self.padding, Some(Padding::Cells(_))) {
            let message = "graded and padding by cells are given together: cells differ in size";
            return conflict(message, "use graded.absorbing for cells of the size at the ends, or padding by length");
        }
        Ok(())
    }
}
