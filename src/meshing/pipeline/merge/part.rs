//! The report of a window, read for a merge.

use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use crate::meshing::report::{CertificateReport, DoubtReport, FlagReport, GeometryReport, OpenReport, WindowReport};
use hexcast_core::base::error::{Error, Result};
use hexcast_core::base::finding::Finding;
use hexcast_core::grid::lines::{AXES, Lines, MAX_LISTED};
use hexcast_core::grid::totals::Total;

/// The lines of a report of cells that differ in size.
#[derive(Deserialize)]
pub(super) struct Lists {
    x: Vec<f64>,
    y: Vec<f64>,
    z: Vec<f64>,
}

/// A window and what of its report is merged by its meaning.
pub(super) struct Part<'a> {
    pub(super) report: &'a Value,
    pub(super) window: WindowReport,
    /// All lines of each axis, where cells differ in size.
    pub(super) lists: Option<Lists>,
    pub(super) geometries: Vec<GeometryReport>,
    pub(super) open: Vec<OpenReport>,
    pub(super) flags: Vec<FlagReport>,
    pub(super) doubtful: DoubtReport,
    pub(super) certificate: Option<CertificateReport>,
    pub(super) findings: Vec<Finding>,
}

/// By which geometries of these indices are ranked: by priority, and of equal ones the later is higher.
pub(super) fn rank(index: usize, geometries: &[GeometryReport]) -> (Option<i32>, usize) {
    (geometries.get(index).map(|geometry| geometry.priority), index)
}

pub(super) const HINT: &str = "give reports that `hexcast mesh --part K/N --report FILE` wrote";

pub(super) fn refused(code: &'static str, message: impl Into<String>, hint: &str) -> Error {
    Error::new(code, message, hint)
}

/// Reads a sum.
pub(super) fn total(text: &str) -> Result<Total> {
    Total::of_text(text).ok_or_else(|| refused("job-value", format!("\"{text}\" in window.sums is not a sum"), HINT))
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
        let message = format!(
            "report {number} is of a window with a halo of {} cells, which other reports count, too, and does not say what it has without it",
            window.halo
        );
        let hint = "mesh parts (--part) with `hexcast mesh --halo H --report FILE` in enough memory, or merge reports without halo";
        return Err(refused("job-conflict", message, hint));
    }
    Ok(Part {
        report,
        window,
        lists: key(report, "grading", number)?,
        geometries: key(report, "geometries", number)?,
        open: key(report, "open", number)?,
        flags: key(report, "flags", number)?,
        doubtful: key(report, "doubtful", number)?,
        certificate: key(report, "certificate", number)?,
        findings: key(report, "findings", number)?,
    })
}

/// The lines of the box that windows divide.
///
/// # Errors
/// `job-value` where a report has no lines that go with its window; `job-conflict` where two windows have other lines at the same place.
pub(super) fn lines_of_box(parts: &[Part]) -> Result<Lines> {
    let first = &parts[0];
    if first.lists.is_none() {
        let spacing = serde_json::from_value(first.report["spacing"].clone());
        let spacing = spacing.map_err(|error| refused("job-value", format!("report 1: spacing: {error}"), HINT))?;
        return Lines::new(first.window.origin, spacing, first.window.of).map_err(|error| error.at("report 1"));
    }
    let n_lines = first.window.of.map(|n| n as usize + 1);
    if let Some(axis) = n_lines.iter().position(|&n| n > MAX_LISTED) {
        let message =
            format!("report 1 is of a box of {} lines along {}: at most {MAX_LISTED} fit", n_lines[axis], AXES[axis]);
        return Err(refused("job-value", message, HINT));
    }
    let mut all = n_lines.map(|n| vec![None; n]);
    for (index, Part { window, lists, .. }) in parts.iter().enumerate() {
        for (axis, all) in all.iter_mut().enumerate() {
            let own = lists.as_ref().map(|lists| [&lists.x, &lists.y, &lists.z][axis]);
            let places = window.first[axis] as usize..=window.end[axis] as usize;
            let Some(own) = own.filter(|own| own.len() == places.clone().count()) else {
                let message = format!("report {} has no lines along {} that fit its window", index + 1, AXES[axis]);
                return Err(refused("job-value", message, HINT));
            };
            for (line, known) in own.iter().zip(&mut all[places]) {
                if known.get_or_insert(*line) != line {
                    let message = format!(
                        "report {} has a line at {line:?} along {}, and another has none there",
                        index + 1,
                        AXES[axis]
                    );
                    return Err(refused(
                        "job-conflict",
                        message,
                        "mesh all parts with the same files, job and version",
                    ));
                }
            }
        }
    }
    Lines::from_lists(all.map(|lines| lines.into_iter().flatten().collect()))
}
