//! Lines of a job that are not equally spaced: given as lists, or to be generated.

use serde::{Deserialize, Serialize};

use super::PerAxis;
#[cfg(not(target_arch = "wasm32"))]
use super::text::{check_json, of_json_text};
#[cfg(not(target_arch = "wasm32"))]
use crate::base::error::{Error, Result};

/// All lines of each axis, ascending, in the unit of the files. Equally spaced ones are meshed like those of `cell_size`.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
pub struct LinesJob {
    /// Lines across x: cells + 1 of them.
    pub x: Vec<f64>,
    /// Lines across y.
    pub y: Vec<f64>,
    /// Lines across z.
    pub z: Vec<f64>,
}

impl LinesJob {
    /// Reads the lists from JSON, such as `{"x": [0, 0.5, 2], "y": [0, 1], "z": [0, 1]}`.
    ///
    /// # Errors
    /// `job-syntax` where the text is not JSON; `job-value` with the list, line and column.
    #[cfg(not(target_arch = "wasm32"))]
    pub fn from_json(text: &str) -> Result<LinesJob> {
        let hint = "write three lists of numbers: {\"x\": [0, 1, 3], \"y\": [...], \"z\": [...]}";
        // serde would take a list of three lists, too
        if text.trim_start().starts_with('[') {
            return Err(Error::new("job-syntax", "it is a list, not an object of three lists", hint));
        }
        let read = check_json(text).and_then(|()| of_json_text(text, std::marker::PhantomData));
        let said = |error: &Error| error.to_string().replacen("the job: ", "", 1).replacen("the job is", "it is", 1);
        read.map_err(|error| Error::new(error.code(), said(&error), hint))
    }
}

/// Lines that are generated: on every end of every geometry's box, close where geometries are small, far elsewhere.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[cfg_attr(any(test, feature = "testing"), derive(schemars::JsonSchema))]
#[non_exhaustive]
pub struct GradedJob {
    /// Largest size of a cell on all axes or each.
    pub max_size: PerAxis<f64>,
    /// Smallest size of a cell; by default a thousandth of the largest. Of ends that are closer to each other one is left off the lines.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub min_size: Option<f64>,
    /// Largest ratio of neighbouring cells, 1.01 to 10; by default 1.3.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub growth: Option<f64>,
    /// Cells added on both sides of every axis, of the size of the cell at that end, up to 1,024: for absorbing layers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub absorbing: Option<PerAxis<u32>>,
}

/// Growth of cells where the job does not say.
pub const DEFAULT_GROWTH: f64 = 1.3;
/// The smallest cell where the job does not say, as a part of the largest.
const DEFAULT_SMALLEST: f64 = 1e-3;

impl GradedJob {
    /// Lines of cells of at most a size, and everything else by default.
    pub fn new(max_size: PerAxis<f64>) -> GradedJob {
        GradedJob { max_size, min_size: None, growth: None, absorbing: None }
    }

    /// The smallest size on an axis.
    #[doc(hidden)]
    pub fn smallest(&self, axis: usize) -> f64 {
        self.min_size.unwrap_or(self.max_size.each()[axis] * DEFAULT_SMALLEST)
    }
}
