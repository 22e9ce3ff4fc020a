//! The report of a window, read for a merge.

use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::error::{Error, Result};
use crate::lines::Lines;
use crate::report::{CertificateReport, DoubtReport, FlagReport, GeometryReport, OpenReport, WindowReport};

/// A window and what of its report is merged by its meaning.
pub(super) struct Part<'a> {
    pub(super) report: &'a Value,
    pub(super) window: WindowReport,
    pub(super) lines: Lines,
    pub(super) geometries: Vec<GeometryReport>,
    pub(super) open: Vec<OpenReport>,
    pub(super) flags: Vec<FlagReport>,
    pub(super) doubtful: DoubtReport,
    pub(super) certificate: Option<CertificateReport>,
}

impl Part<'_> {
    /// The cells of the box.
    pub(super) fn cells(&self) -> [[u32; 3]; 2] {
        [self.window.first, self.window.end]
    }
}

/// By which geometries of these indices are ranked: by priority, and of equal ones the later is higher.
pub(super) fn rank(index: usize, geometries: &[GeometryReport]) -> (Option<i32>, usize) {
    (geometries.get(index).map(|geometry| geometry.priority), index)
}

pub(super) const HINT: &str = "give reports that `hexcast mesh --part K/N --report FILE` wrote";

pub(super) fn refused(code: &'static str, message: impl Into<String>, hint: &str) -> Error {
    Error::new(code, message, hint)
}

/// Reads what is merged by its meaning.
pub(super) fn part(index: usize, report: &Value) -> Result<Part<'_>> {
    let number = index + 1;
    fn key<T: DeserializeOwned>(report: &Value, key: &str, number: usize) -> Result<T> {
        let wrong = |error| refused("job-value", format!("report {number}: {key}: {error}"), HINT);
        serde_json::from_value(report[key].clone()).map_err(wrong)
    }
    let window: Option<WindowReport> = key(report, "window", number)?;
    let window = window
        .ok_or_else(|| refused("job-value", format!("report {number} is of a whole mesh: its window is null"), HINT))?;
    if window.halo > 0 {
        let message =
            format!("report {number} is of a window with a halo of {} cells, which others have, too", window.halo);
        return Err(refused("job-conflict", message, "merge reports of windows without halo"));
    }
    if !report["grading"].is_null() {
        let message = format!("report {number} is of cells that differ in size, whose reports are not merged");
        return Err(refused("lines-graded", message, "merge reports of equal cells, or mesh the whole box at once"));
    }
    let (origin, spacing, dims) =
        (key(report, "origin", number)?, key(report, "spacing", number)?, key(report, "dims", number)?);
    Ok(Part {
        report,
        window,
        lines: Lines::new(origin, spacing, dims).map_err(|error| error.at(format!("report {number}")))?,
        geometries: key(report, "geometries", number)?,
        open: key(report, "open", number)?,
        flags: key(report, "flags", number)?,
        doubtful: key(report, "doubtful", number)?,
        certificate: key(report, "certificate", number)?,
    })
}
