//! What helps against findings: patches of the job, and the options of the command line that do the same.

use serde_json::{Value, json};

use crate::finding::{Finding, Remedy};
use crate::geometry::{Fill, Geometry};
use crate::job::Job;

/// Adds to findings what helps; `geometries` are those of the job.
pub(super) fn add_remedies(findings: &mut [Finding], job: &Job, geometries: &[Geometry]) {
    for finding in findings {
        let remedy = remedy(finding, job, geometries);
        finding.remedies.extend(remedy);
    }
}

/// What helps against a finding, if a change of the job does.
fn remedy(finding: &Finding, job: &Job, geometries: &[Geometry]) -> Option<Remedy> {
    let number = |key: &str| finding.values.get(key);
    let geometry = finding.geometry.as_ref().and_then(|of| geometries.get(of.index));
    match finding.code {
        "end-without-line" => smaller_cells(finding),
        "cells-fine" => {
            let tolerance = number("tolerance")?;
            let patch = json!({ "tolerance": tolerance });
            Some(Remedy::new("Allow a larger tolerance", patch, format!("--tolerance {tolerance}")))
        }
        "surface-open-parity" => setting(job, geometry?, "Use the winding number", ("open", "winding")),
        "flag-shared" => own_flag(job, geometry?, number("free_flag")?.as_u64()?),
        "shells-overlap" => Some(Remedy::new("Use the winding number", json!({ "rule": "nonzero" }), "--rule nonzero")),
        "wall-thin" if number("lost")?.as_u64() == Some(0) => None,
        "wall-thin" | "no-cell-thin" | "no-cell-flat" | "no-cell-open" | "no-cell-small" => {
            let is_filled = geometry?.fill != Fill::Centre;
            if is_filled { None } else { setting(job, geometry?, "Keep thin walls", ("fill", "separating")) }
        }
        "no-cell-covered" => win(job, geometry?, geometries.get(finding.other.as_ref()?.index)?),
        _ => None,
    }
}

/// Smallest cells of a generated grid that leave room for a line of its own; not for ends that all but meet.
fn smaller_cells(finding: &Finding) -> Option<Remedy> {
    let of = |key: &str| finding.values.get(key).and_then(serde_json::Number::as_f64);
    let (distance, smallest) = (of("distance")?, of("smallest_cell")?);
    let patch = json!({ "graded": { "min_size": distance } });
    (distance >= 0.01 * smallest).then(|| Remedy::new("Allow smaller cells", patch, format!("--min-size {distance}")))
}

/// Sets a key that the job and its entries have: for all geometries, unless the entry of this one has the key itself.
fn setting(job: &Job, geometry: &Geometry, label: &str, (key, value): (&str, &str)) -> Option<Remedy> {
    let entry = job.geometries.get(geometry.entry)?;
    let has_own = if key == "fill" { entry.fill.is_some() } else { entry.open.is_some() };
    let of_entry = Remedy::of_entry(label, (geometry.entry, &entry.file), key, value.into());
    if has_own {
        return Some(of_entry);
    }
    // the job of a report has the key in its entries, too
    let mut patch = json!({ key: value });
    patch["geometries"] = of_entry.patch["geometries"].clone();
    Some(Remedy::new(label, patch, format!("--{key} {value}")))
}

/// Gives a geometry that nobody gave a flag one that is free; solids of a file have flags that count up.
fn own_flag(job: &Job, geometry: &Geometry, free: u64) -> Option<Remedy> {
    let entry = job.geometries.get(geometry.entry).filter(|entry| !entry.split)?;
    Some(Remedy::of_entry(format!("Give it flag {free}"), (geometry.entry, &entry.file), "flag", free.into()))
}

/// Gives a geometry a higher priority than another; solids of one entry have the same.
fn win(job: &Job, geometry: &Geometry, winner: &Geometry) -> Option<Remedy> {
    let entry = job.geometries.get(geometry.entry).filter(|_| geometry.entry != winner.entry)?;
    let priority = Value::from(winner.priority.checked_add(1)?);
    Some(Remedy::of_entry("Let it win", (geometry.entry, &entry.file), "priority", priority))
}
